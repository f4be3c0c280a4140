"""[noise] of a scenario: what is heard beside the talkers."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ross_payload.config import Degrees, Positive, Table

Decibels = Annotated[float, Field(ge=-100, le=100)]
FAN = "fan"  # the sound that is made here


class NoiseSource(Table):
    """[[noise.sources]]: what sounds from one place of the room all the time, as a fan does."""

    name: str
    sound: Annotated[str, Field(min_length=1)] = FAN  # "fan", synthetic, or a recording that is repeated
    azimuth_deg: Degrees  # counter-clockwise, in the frame of the mount
    distance_m: Positive = 2.5  # from the centre of the array, along the floor
    height_m: Positive | None = None  # above the floor; three dimensions only; absent: that of the array
    snr_db: Decibels  # of the reference over this source alone, at microphone 1, joint angle 0


class Noise(Table):
    """[noise]: sensor noise, white and independent at each microphone, the motor, and what sounds in the room.

    The reference "mixture" is the power that all talkers together have at microphone 1 while all of them talk, joint
    angle 0; "talker" is the same for one talker of level 0 dB.
    """

    snr_db: Decibels = 15.0
    snr_reference: Literal["mixture", "talker"] = "mixture"
    motor_db: Decibels = -20.0  # while turning, relative to the mixture
    sources: Annotated[tuple[NoiseSource, ...], Field(exclude_if=lambda sources: not sources)] = ()
