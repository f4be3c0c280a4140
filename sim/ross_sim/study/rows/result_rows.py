"""What a study writes down: one frozen row per case, and JSON for the journal."""

from __future__ import annotations

import dataclasses
import sys
from dataclasses import dataclass
from typing import Any, overload

import numpy as np

ALIGNED, ESTIMATED, UNALIGNED = "aligned", "estimated", "unaligned"
DIGITS = 6  # of every number that is written down


@dataclass(frozen=True, slots=True)
class Scene:
    """Whom a row is about: the first columns of every table."""

    task: str
    setting: str
    k: int
    layout: int
    seed: int
    version: str


@dataclass(frozen=True, slots=True)
class Separation(Scene):
    """One target, separated once; docs/reference/study.md says what the columns mean."""

    how: str
    target: int
    talker: str
    azimuth_true_deg: float
    separator: str = ""
    noise: str = "known"
    start: int | None = None
    start_heading_deg: float | None = None
    explorer: str | None = None
    unit_s: float | None = None
    schedule: str | None = None
    rotations: int | None = None
    azimuth_deg: float | None = None
    k_estimated: int | None = None
    all_found: bool | None = None
    missed: bool = False
    rule: str | None = None
    heading_deg: float | None = None
    isolation_us: float | None = None
    directness: float | None = None
    si_sdr_in_db: float | None = None
    si_sdr_out_db: float | None = None
    si_sdri_db: float = 0.0
    turning_deg_s: float = 0.0  # while it was explored; 0: step by step


@dataclass(frozen=True, slots=True)
class Exploration(Scene):
    """What an explorer believes after some rotations."""

    start: int
    start_heading_deg: float
    explorer: str
    unit_s: float
    rotations: int
    heading_deg: float
    talkers: tuple[str, ...]
    azimuths_true_deg: tuple[float, ...]
    azimuths_deg: tuple[float, ...]
    sigmas_deg: tuple[float, ...]
    confidences: tuple[float, ...]
    errors_deg: tuple[float, ...]
    k_estimated: int
    all_found: bool
    certain: bool
    directness: float | None
    turning_deg_s: float = 0.0  # 0: step by step
    time_s: float | None = None  # since the exploration began, with the turns

    @property
    def right(self) -> bool:
        """K is right and every azimuth is near."""
        return self.all_found and self.k_estimated == self.k


@dataclass(frozen=True, slots=True)
class Timing:
    """CPU time of one step; it differs from run to run."""

    task: str
    setting: str
    k: int
    step: str  # name of the separator or explorer, or "task" for everything
    audio_s: float
    cpu_s: float


Row = Separation | Exploration | Timing


@dataclass(frozen=True, slots=True)
class Result:
    """All rows of one task."""

    task: str
    separations: tuple[Separation, ...] = ()
    explorations: tuple[Exploration, ...] = ()
    timings: tuple[Timing, ...] = ()


def decode(values: dict[str, Any]) -> Result:
    """Turn the plain values of `dataclasses.asdict` back into a result.

    >>> result = Result("t", timings=(Timing("t", "S1", 3, "duet", 10.0, 0.1),))
    >>> decode(dataclasses.asdict(result)) == result
    True
    """
    return Result(
        values["task"],
        tuple(_row(Separation, row) for row in values["separations"]),
        tuple(_row(Exploration, row) for row in values["explorations"]),
        tuple(_row(Timing, row) for row in values["timings"]),
    )


def _row(kind: type[Any], values: dict[str, Any]) -> Any:
    return kind(**{name: _kept(value) for name, value in values.items()})


def _kept(value: Any) -> Any:
    """A value as rows have it; names of rooms and methods are many times the same, and kept once."""
    if isinstance(value, list):
        return tuple(value)
    return sys.intern(value) if isinstance(value, str) else value


def columns(kind: type[Any]) -> tuple[str, ...]:
    """Names of the columns of a kind of row."""
    return tuple(field.name for field in dataclasses.fields(kind))


def degrees(angle: float) -> float:
    """Degrees of an angle [rad], as they are written down."""
    return round(float(np.rad2deg(angle)), DIGITS)


@overload
def number(value: float) -> float: ...
@overload
def number(value: None) -> None: ...
@overload
def number(value: float | None) -> float | None: ...
def number(value: float | None) -> float | None:
    """Round a number to the digits that are written down."""
    return None if value is None else round(float(value), DIGITS)
