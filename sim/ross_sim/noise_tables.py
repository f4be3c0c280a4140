"""[noise] of a scenario: what is heard beside the talkers."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from ross_payload.config import Degrees, Positive, Table
from ross_sim.acoustics.far_noise import REACH

FARTHEST = 1000.0  # from the array [m]: sound takes 3 s from there, and as many samples have to be rendered
Distance = Annotated[float, Field(gt=0, le=FARTHEST)]
Decibels = Annotated[float, Field(ge=-100, le=100)]
Finite = Annotated[float, Field(allow_inf_nan=False, ge=-100, le=100)]
Kind = Literal["place", "rotor", "wind", "babble", "passing_car"]
FAN = "fan"  # the sound that is made for a place
SYNTHETIC = ""  # what is made for every other kind
ARM, ABOVE = 0.25, 0.15  # of the rotors of a small quadrotor [m]
QUADROTOR = tuple((x, y, ABOVE) for x in (ARM, -ARM) for y in (ARM, -ARM))
DISTANCE = {"place": 2.5, "babble": 20.0, "passing_car": 15.0}  # [m], unless the file says so
KEYS = {  # that make sense for a kind, beside name, kind, sound and snr_db
    "place": {"azimuth_deg", "distance_m", "height_m"},
    "rotor": {"rotors_m", "rpm", "blades"},
    "wind": {"gusts", "windscreen"},
    "babble": {"distance_m"},
    "passing_car": {"azimuth_deg", "distance_m", "speed_m_s", "at_s", "every_s"},
}


class NoiseSource(Table):
    """[[noise.sources]]: what sounds beside the talkers, all the time or again and again.

    ===========  =======================================================  =============================
    kind         where                                                    frame
    ===========  =======================================================  =============================
    place        one place of the room, with its walls                    room
    rotor        any number of places near the array; no walls            vehicle: stays while it turns
    wind         at each microphone on its own                            none
    babble       many voices all around, far away; no walls               room
    passing_car  on a straight line, far away; no walls                   room
    ===========  =======================================================  =============================
    """

    name: str
    kind: Kind = "place"
    sound: str = SYNTHETIC  # made here ("fan" for a place); or a recording, or a folder of them; repeated
    azimuth_deg: Degrees | None = None  # counter-clockwise, frame of the mount; of a car where it is nearest
    distance_m: Distance | None = None  # from the centre of the array, along the floor; of a car where it is nearest
    height_m: Positive | None = None  # above the floor; three dimensions only; absent: that of the array
    rotors_m: tuple[tuple[Finite, Finite, Finite], ...] = QUADROTOR  # ahead, to the left and above the array's centre
    rpm: Annotated[float, Field(ge=600, le=30000)] = 5400.0  # mean of all rotors
    blades: Annotated[int, Field(ge=1, le=8)] = 2
    gusts: bool = True  # else the wind is even
    windscreen: bool = False
    speed_m_s: Annotated[float, Field(ge=1, le=100)] = 14.0
    at_s: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 10.0  # when a car is nearest for the first time
    every_s: Annotated[float, Field(ge=5, le=3600)] = 30.0  # from one car to the next
    snr_db: Decibels  # of the reference over this source alone, at microphone 1, joint angle 0; see `Noise`

    @model_validator(mode="after")
    def _of_its_kind(self) -> Self:
        others = self.model_fields_set - KEYS[self.kind] - {"name", "kind", "sound", "snr_db"}
        if wrong := sorted(key for key in others if getattr(self, key) != type(self).model_fields[key].default):
            raise ValueError(f"{wrong[0]}: expected one of {', '.join(sorted(KEYS[self.kind]))} for '{self.kind}'")
        if "azimuth_deg" in KEYS[self.kind] and self.azimuth_deg is None:
            raise ValueError("azimuth_deg: expected where it is, got nothing")
        if self.kind == "passing_car" and self._cars > MOST_CARS:
            raise ValueError(f"every_s: expected at most {MOST_CARS} cars to be heard at once, got {self._cars:.0f}")
        if self.kind == "rotor":
            near = [place for place in self.rotors_m if sum(x * x for x in place) < NEAREST**2]
            if near or not self.rotors_m:
                raise ValueError(f"rotors_m: expected places at least {NEAREST:g} m from the array, got {near}")
        return self

    @property
    def away(self) -> float:
        """Distance from the centre of the array [m]."""
        return self.distance_m or DISTANCE[self.kind]

    @property
    def _cars(self) -> float:
        """How many are heard at once."""
        return 2 * self.away * math.sqrt(REACH**2 - 1) / (self.speed_m_s * self.every_s)


MOST_CARS = 30
NEAREST = 0.1  # a rotor to the centre of the array [m]


class Noise(Table):
    """[noise]: sensor noise, white and independent at each microphone, the motor, and what sounds beside the talkers.

    The reference "mixture" is the power that all talkers together have at microphone 1 while all of them talk, joint
    angle 0; "talker" is the same for one talker of level 0 dB. The power of a source is the mean over its whole sound:
    of all rotors of a table together, of wind over its gusts and without the windscreen, which takes from it what a
    windscreen takes; of a car where it is nearest.
    """

    snr_db: Decibels = 15.0
    snr_reference: Literal["mixture", "talker"] = "mixture"
    motor_db: Decibels = -20.0  # while turning, relative to the mixture
    sources: Annotated[tuple[NoiseSource, ...], Field(exclude_if=lambda sources: not sources)] = ()

    def of(self, *kinds: Kind) -> tuple[NoiseSource, ...]:
        """Sources of some kinds, in order."""
        return tuple(source for source in self.sources if source.kind in kinds)
