"""The tables of the mission: explore, informed, exploit."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from ross_payload.config.table import Degrees, Table

Azimuths = Annotated[tuple[Degrees, ...], Field(min_length=1, max_length=6)]
Elevation = Annotated[float, Field(ge=-90, le=90)]

ROUNDING = 1e-9  # of a number of periods
APART_DEG = 1.0  # sources told from outside that are nearer than this are one


class Explore(Table):
    """[explore]: find K and every azimuth."""

    method: str = "joint"  # explorer: `joint`, `markov`, or `markov-plain`, the paper's own histograms
    options: dict[str, Any] = Field(default_factory=dict)  # a table of the explorer's own
    frame: Annotated[int, Field(ge=128, le=8192, multiple_of=2)] | None = (
        None  # STFT frame [samples]; absent: a power of two near 43 ms
    )
    overlap: Annotated[float, Field(ge=0.25, le=0.9)] = 0.75  # of these frames, as a share of the frame
    lead_in_s: Annotated[float, Field(ge=0, le=60)] = 2.0  # listening time before the first turn, to measure the noise
    unit_s: Annotated[float, Field(ge=0.5, le=60)] = 3.0  # listening time at one orientation, T_unit [s]
    step_deg: Annotated[float, Field(ge=1, le=90)] = 15.0  # one rotation, from one orientation to the next
    min_rotations: Annotated[int, Field(ge=1, le=24)] = 4  # rotations at least, even if the explorer is certain earlier
    max_rotations: Annotated[int, Field(ge=1, le=24)] = 12  # rotations at most
    pipelined: bool = False  # try promising alignments before the exploration ends
    continuous: bool = False  # turn without a pause and listen meanwhile, not step by step: explorers that can
    rate_deg_s: Annotated[float, Field(ge=5, le=90)] = 20.0  # how fast it turns then
    turn_deg: Annotated[float, Field(ge=90, le=3600)] = 540.0  # how far at most, back and forth

    @property
    def periods(self) -> int:
        """T_unit that are listened to at most while it turns without a pause; 0: it turns step by step.

        >>> Explore(continuous=True, rate_deg_s=20, turn_deg=360).periods, Explore().periods
        (6, 0)
        """
        return math.ceil(self.turn_deg / (self.rate_deg_s * self.unit_s) - ROUNDING) if self.continuous else 0

    @property
    def last_rotation(self) -> int:
        """The largest number of an orientation, or of a period; the first is 0."""
        return self.periods - 1 if self.continuous else self.max_rotations

    @model_validator(mode="after")
    def _ordered(self) -> Explore:
        if self.min_rotations > self.max_rotations:
            raise ValueError(
                f"expected min_rotations <= max_rotations, got {self.min_rotations} and {self.max_rotations}"
            )
        return self


class Informed(Table):
    """[informed]: given directions of the sources; the mission begins without exploring."""

    azimuths_deg: Azimuths  # frame of the mount, as in a scenario
    elevations_deg: tuple[Elevation, ...] | None = None  # one for each azimuth; absent: level with the array
    sigma_deg: Annotated[float, Field(gt=0, le=45)] = 2.0  # one standard deviation of every azimuth
    target: Annotated[int, Field(ge=0)] | None = None  # which of them is visited first, counted from 0

    @model_validator(mode="after")
    def _possible(self) -> Informed:
        count, heights = len(self.azimuths_deg), self.elevations_deg or (0.0,) * len(self.azimuths_deg)
        if len(heights) != count:
            raise ValueError(f"elevations_deg: expected {count}, one for each of azimuths_deg, got {len(heights)}")
        if self.target is not None and self.target >= count:
            raise ValueError(f"target: expected a number below {count}, counted from 0, got {self.target}")
        for i, j in combinations(range(count), 2):
            apart = abs((self.azimuths_deg[i] - self.azimuths_deg[j] + 180) % 360 - 180)
            if apart < APART_DEG and abs(heights[i] - heights[j]) < APART_DEG:
                raise ValueError(
                    f"azimuths_deg {i} and {j}: expected at least {APART_DEG:g} deg between them, got {apart:g}"
                )
        return self


class VoicePrints(Table):
    """[voice_print]: how voices are compared."""

    model: str = "auto"  # built-in, or a network that `ross voice-model add` keeps; auto: that network, if there is one


class Exploit(Table):
    """[exploit]: turn, separate, recognise, keep listening."""

    separator: str = "auto"  # `auto`, or one of the separators
    rules: Literal["best", "paper"] = "best"  # where to turn: best predicted gain, or the paper's equations
    check_s: Annotated[float, Field(ge=0.5, le=60)] = 3.0  # listening time to check a voice, T_check [s]
    run_s: Annotated[float, Field(ge=1, le=600)] = 10.0  # listening time until the voice is checked again, T_run [s]
    runs: Annotated[int, Field(ge=0, le=1_000_000)] = (
        1  # how many periods of run_s until the mission is done; 0: until stopped
    )
    criterion: Annotated[float, Field(ge=-1e6, le=1e6)] = 0.5  # accept a voice above this score
    max_restarts: Annotated[int, Field(ge=0, le=1_000_000)] = 2  # number of restarts when the target is lost
    track: bool = True  # follow talkers who move while the array listens, and turn a little where that helps
