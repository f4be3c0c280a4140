"""A scenario: one TOML file that says who talks where and when, in which room, and how the payload is set up."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from ross_payload.angles import wrap
from ross_payload.config import Config, Degrees, Positive, Table, read_toml, validated
from ross_payload.errors import ConfigError, unknown
from ross_payload.interfaces import Real
from ross_sim.acoustics.room import RoomSpec
from ross_sim.devices.far_end import FarEnd, Fault, far_end_of
from ross_sim.microphone_table import Microphones
from ross_sim.noise_tables import FARTHEST, Decibels, Distance, Noise, NoiseSource
from ross_sim.talkers.path import Path as Walk
from ross_sim.talkers.speech import TalkerVoice
from ross_sim.vehicle_table import Seconds, Vehicle

MOUTH = 1.6  # height of a talker's mouth above the floor, unless the file says so [m]
LEAD_IN = 2.0  # at least so long does nobody talk, unless the file says so [s]

Finite = Annotated[float, Field(allow_inf_nan=False)]
Place = tuple[Finite, Finite] | tuple[Finite, Finite, Finite]


class Room(Table):
    """[room]: a shoebox and the array in it; its axes are those of the mount."""

    size_m: Place = (10.0, 10.0)  # two numbers: a plane, as in the paper
    t60_s: Annotated[float, Field(ge=0, le=5)] = 0.0  # nominal; 0: no walls
    array_m: Place | None = None  # absent: the middle, 1.2 m high
    turns_heard: bool = True  # false: while the array turns, what is heard at its last heading goes on

    @field_validator("size_m")
    @classmethod
    def _bounded(cls, size: Place) -> Place:
        if max(size) > 2 * FARTHEST:
            raise ValueError(f"expected sides of at most {2 * FARTHEST:g} m, got {max(size):g} m")
        return size


CountedOn = Annotated[float, Field(allow_inf_nan=False)]  # an azimuth of somebody who may walk round and round [deg]


class WayPoint(Table):
    """[[talkers.path]]: where a talker is at one time; on a straight line in these numbers in between."""

    at_s: Annotated[float, Field(gt=0, allow_inf_nan=False)]  # the talker leaves the place before as that is reached
    azimuth_deg: CountedOn  # 190 is reached past 180, -170 the other way round
    distance_m: Distance | None = None  # absent: as before
    height_m: Positive | None = None  # absent: as before


class Talker(Table):
    """[[talkers]]: who talks where and when."""

    name: str | Annotated[int, Field(ge=0)] | None = None  # whose voice: a name, a number among all, or the next unused
    azimuth_deg: Degrees  # counter-clockwise, in the frame of the mount
    distance_m: Distance = 2.5  # from the centre of the array, along the floor
    height_m: Positive | None = None  # above the floor; three dimensions only; absent: 1.6 m
    level_db: Decibels = 0.0  # at microphone 1, relative to the others
    start_s: Seconds | None = None  # absent: when the lead-in of the payload ends, but 2 s at least
    end_s: Positive | None = None  # absent: never
    pauses: tuple[tuple[Seconds, Seconds], ...] = ()  # [[from, to], ...]
    path: tuple[WayPoint, ...] = Field(default=(), exclude_if=lambda path: not path)  # from there on; absent: stays

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        start = self.start_s or 0.0
        for before, after in pairwise(self.path):
            if after.at_s <= before.at_s:
                raise ValueError(f"path: expected at_s to rise, got {after.at_s:g} after {before.at_s:g}")
        if self.end_s is not None and self.end_s <= start:
            raise ValueError(f"end_s: expected a time after start_s = {start:g}, got {self.end_s:g}")
        for begin, end in self.pauses:
            if end <= begin:
                raise ValueError(f"pauses: expected a pause that ends after it begins, got [{begin:g}, {end:g}]")
        return self


class Trouble(Table):
    """[[troubles]]: what goes wrong with the actuator, and when."""

    fault: Fault
    at_s: Seconds
    end_s: Positive | None = None  # absent: never

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.end_s is not None and self.end_s <= self.at_s:
            raise ValueError(f"end_s: expected a time after at_s = {self.at_s:g}, got {self.end_s:g}")
        return self


class Scenario(Table):
    """The whole file."""

    title: str
    target: str | Annotated[int, Field(ge=0)] = 0  # a name, or a number: talkers first, then voices not in the room
    payload: Config = Config()
    room: Room = Room()
    talkers: tuple[Talker, ...]
    noise: Noise = Noise()
    microphones: Microphones | None = Field(default=None, exclude_if=lambda value: value is None)
    vehicle: Vehicle | None = None  # absent: the mount stands still
    troubles: tuple[Trouble, ...] = ()

    @model_validator(mode="after")
    def _flown_by_one(self) -> Self:
        if self.vehicle is not None:
            self.vehicle.check(self.payload)
        return self

    @model_validator(mode="after")
    def _possible(self) -> Self:
        try:
            self.spec()
            with _named([f"noise source '{source.name}'" for source in self.noise.of("place")]):
                self.spec_of_noise()
            for index, (talker, walk) in enumerate(zip(self.talkers, self.walks(), strict=True)):
                if talker.path:
                    with _named([f"talkers.{index}.path"] * walk.n_nodes):
                        self.spec_of(walk)
                if talker.end_s is not None and talker.end_s <= self.start(talker):
                    begins = f"{self.start(talker):g} s, when the talker begins"
                    raise ConfigError(f"talkers.{index}.end_s: expected a time after {begins}, got {talker.end_s:g}")
        except ConfigError as error:
            raise ValueError(str(error)) from error
        return self

    @property
    def spacing(self) -> float:
        """The true distance between the microphones [m]."""
        return (self.microphones or Microphones()).spacing(self.payload.array)

    @property
    def offset(self) -> float:
        """The true offset of the array's axis [rad]."""
        return (self.microphones or Microphones()).offset(self.payload.array)

    def far_end(self) -> FarEnd:
        """Make the simulated device for the payload's actuator, in the wind of the scenario.

        Raises
        ------
        ConfigError
            When there is none, or an option is wrong.
        """
        far_end = far_end_of(self.payload)
        return far_end if self.vehicle is None else self.vehicle.in_wind(far_end, self.payload.seed)

    def spec(self) -> RoomSpec:
        """Return the room with every talker in place.

        Raises
        ------
        ConfigError
            When something lies outside the room or on top of the array.
        """
        return self._spec([self._position(talker) for talker in self.talkers])

    def spec_of_noise(self) -> RoomSpec:
        """Return the room with every noise source in place.

        Raises
        ------
        ConfigError
            When something lies outside the room or on top of the array.
        """
        return self._spec([self._position_of_noise(source) for source in self.noise.of("place")])

    def spec_of(self, walk: Walk, node: int | None = None) -> RoomSpec:
        """Return the room with one talker at one position on the grid of its path, or at all of them.

        Raises
        ------
        ConfigError
            When one of them lies outside the room or on top of the array.
        """
        nodes = np.arange(walk.n_nodes) if node is None else [node]
        return self._spec([self._position_at(place) for place in walk.node(nodes).tolist()])

    def walks(self) -> tuple[Walk, ...]:
        """Where every talker walks, or stays."""
        return tuple(Walk.through(self._points(talker)) for talker in self.talkers)

    def centre(self) -> tuple[float, ...]:
        """Where the centre of the array is [m]."""
        width, depth, *height = self.room.size_m
        return self.room.array_m or (width / 2, depth / 2, *(min(1.2, side / 2) for side in height))

    def start(self, talker: Talker) -> float:
        """When a talker begins [s]."""
        return max(LEAD_IN, self.payload.explore.lead_in_s) if talker.start_s is None else talker.start_s

    def azimuths(self) -> tuple[float, ...]:
        """The true azimuth of every talker in the frame of the mount [rad], in (-pi, pi]."""
        return tuple(wrap(math.radians(talker.azimuth_deg)) for talker in self.talkers)

    def azimuths_at(self, times: Real) -> Real:
        """The true azimuth of every talker in the frame of the mount [rad], not wrapped, (n_talkers, n_times)."""
        walks = [walk.place(times)[:, 0] for walk in self.walks()]
        return np.stack(walks) if walks else np.zeros((0, len(times)))

    def elevations(self) -> tuple[float, ...]:
        """The true elevation of every talker as seen from the array [rad]; 0 in a plane."""
        centre = self.centre()
        return tuple(
            math.atan2(sum(self._position(talker)[2:]) - sum(centre[2:]), talker.distance_m) for talker in self.talkers
        )

    def cast(self, voices: Sequence[TalkerVoice]) -> Cast:
        """Give every talker a voice and find the target's.

        Raises
        ------
        ConfigError
            When there are fewer voices than talkers, a name is unknown, or a voice is wanted twice.
        """
        if len(voices) < len(self.talkers):
            raise ConfigError(f"{len(self.talkers)} talkers but only {len(voices)} voices: {_names(voices)}")
        named = [None if talker.name is None else _find(talker.name, voices) for talker in self.talkers]
        taken = [voice for voice in named if voice is not None]
        twice = next((voice.name for index, voice in enumerate(taken) if voice in taken[:index]), None)
        if twice is not None:
            raise ConfigError(f"talkers: expected each voice once, got '{twice}' twice")
        free = iter([voice for voice in voices if voice not in taken])
        talkers = tuple(next(free) if voice is None else voice for voice in named)
        target = _find(self.target, [*talkers, *free])
        return Cast(talkers, target)

    def _spec(self, sources: Sequence[tuple[float, ...]]) -> RoomSpec:
        return RoomSpec(
            size=self.room.size_m,
            t60=self.room.t60_s,
            rate=self.payload.audio.rate_hz,
            array_centre=self.centre(),
            spacing=self.spacing,
            sources=tuple(sources),
            speed_of_sound=self.payload.array.speed_of_sound_m_s,
        )

    def _position(self, talker: Talker) -> tuple[float, ...]:
        azimuth = math.radians(talker.azimuth_deg)
        x, y, *height = self.centre()
        told = [talker.height_m, *(point.height_m for point in talker.path)]
        if any(value is not None for value in told) and not height:
            raise ConfigError("height_m: expected a room with three sides")
        above = [] if not height else [MOUTH if talker.height_m is None else talker.height_m]
        return (x + talker.distance_m * math.cos(azimuth), y + talker.distance_m * math.sin(azimuth), *above)

    def _position_of_noise(self, source: NoiseSource) -> tuple[float, ...]:
        azimuth, (x, y, *height) = math.radians(source.azimuth_deg or 0.0), self.centre()
        if source.height_m is not None and not height:
            raise ConfigError("height_m: expected a room with three sides")
        above = height if source.height_m is None else [source.height_m]
        return (x + source.away * math.cos(azimuth), y + source.away * math.sin(azimuth), *above)

    def _position_at(self, place: Sequence[float]) -> tuple[float, ...]:
        azimuth, distance, height = place
        x, y, *up = self.centre()
        at = (x + distance * math.cos(azimuth), y + distance * math.sin(azimuth), *([height] if up else []))
        return tuple(round(value, 6) for value in at)  # on the way back as on the way there

    @staticmethod
    def _points(talker: Talker) -> list[tuple[float, float, float, float]]:
        points = [(0.0, math.radians(talker.azimuth_deg), talker.distance_m, talker.height_m or MOUTH)]
        for point in talker.path:
            _, _, distance, height = points[-1]
            azimuth = math.radians(point.azimuth_deg)
            points.append((point.at_s, azimuth, point.distance_m or distance, point.height_m or height))
        return points


@dataclass(frozen=True, slots=True)
class Cast:
    """Whose voices are heard."""

    talkers: tuple[TalkerVoice, ...]
    target: TalkerVoice


def names() -> tuple[str, ...]:
    """Names of the scenarios that come with the simulator."""
    return tuple(sorted(path.stem for path in _folder().glob("*.toml")))


def load(name: str | Path) -> Scenario:
    """Load a scenario by the name of one that comes with the simulator, or by its path.

    Raises
    ------
    ConfigError
        When there is none of that name, or the file is wrong (names the first wrong key).
    """
    path = Path(name)
    if path.suffix != ".toml":
        path = _folder() / f"{name}.toml"
        if str(name) not in names():
            raise ConfigError(f"{unknown('scenario', str(name), names())} (a .toml file will do, too)")
    return validated(Scenario, read_toml(path), str(name))


def _folder() -> Path:
    installed = Path(str(files("ross_sim"))) / "data" / "scenarios"
    return installed if installed.is_dir() else Path(__file__).parents[1] / "scenarios"


def _find(wanted: str | int, voices: Sequence[TalkerVoice]) -> TalkerVoice:
    if isinstance(wanted, int):
        if wanted < len(voices):
            return voices[wanted]
        raise ConfigError(f"voice number: expected 0 to {len(voices) - 1}, got {wanted}")
    for voice in voices:
        if voice.name == wanted:
            return voice
    raise ConfigError(unknown("voice", wanted, [voice.name for voice in voices]))


@contextmanager
def _named(sources: Sequence[str]) -> Iterator[None]:
    """Call each source of a room by its name where something is wrong with it."""
    try:
        yield
    except ConfigError as error:
        raise ConfigError(re.sub(r"^source (\d+)", lambda found: sources[int(found[1])], str(error))) from error


def _names(voices: Sequence[TalkerVoice]) -> str:
    return ", ".join(voice.name for voice in voices) or "none"
