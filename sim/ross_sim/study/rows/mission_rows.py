"""What a study of missions writes down: one row for every mission."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

PRESENT, ABSENT = "present", "absent"
NEAR_DEG = 5.0  # an azimuth is found within this
GAIN_DB = 12.0  # wanted SI-SDRi
MISSED_DEG = 180.0  # the error of a talker for whom no source was found


@dataclass(frozen=True, slots=True)
class MissionRow:
    """One mission and what became of it; docs/reference/study.md says what the columns mean."""

    task: str
    scenario: str
    k: int
    draw: int
    seed: int
    version: str
    target_is: str  # present or absent
    talkers: tuple[str, ...]
    azimuths_true_deg: tuple[float, ...]
    target: str
    outcome: str
    target_right: bool
    k_estimated: int
    errors_deg: tuple[float, ...]
    rotations: int
    restarts: int
    heard_from_s: float | None
    right_from_s: float | None
    si_sdri_db: float | None
    mission_s: float | None
    cpu_s: float

    @property
    def placed(self) -> bool:
        """Whether every talker was found where he or she is."""
        return max(self.errors_deg, default=0.0) <= NEAR_DEG

    @property
    def ended_right(self) -> bool:
        """Whether the target alone is heard to the end, or nobody where he or she is absent."""
        return self.target_right and (self.target_is == ABSENT or self.outcome == "target_found")

    @property
    def succeeded(self) -> bool:
        """Whether it ends right, and K is right."""
        return self.ended_right and self.k_estimated == self.k

    @property
    def reason(self) -> str:
        """Why a mission with the target present does not succeed; empty when it does."""
        if self.k_estimated != self.k:
            return f"K = {self.k_estimated}"
        if not self.placed:
            return "azimuth"
        if self.outcome != "target_found":
            return self.outcome
        if not self.target_right:
            return "wrong voice"
        return "" if self.si_sdri_db is not None and self.si_sdri_db > GAIN_DB else "gain"


@dataclass(frozen=True, slots=True)
class MissionResult:
    """All missions of one draw."""

    task: str
    missions: tuple[MissionRow, ...] = ()


def decode_missions(values: dict[str, Any]) -> MissionResult:
    """Turn the plain values of `dataclasses.asdict` back into a result.

    >>> from dataclasses import asdict
    >>> row = MissionRow("t", "demo", 1, 0, 1, "0.1", "present", ("a",), (40.0,), "a", "target_found", True, 1,
    ...                  (0.5,), 4, 0, 20.0, 20.0, 15.0, 60.0, 3.0)
    >>> decode_missions(asdict(MissionResult("t", (row,)))).missions == (row,)
    True
    """
    return MissionResult(values["task"], tuple(map(_row, values["missions"])))


def _row(values: dict[str, Any]) -> MissionRow:
    plain: dict[str, Any] = {name: tuple(value) if isinstance(value, list) else value for name, value in values.items()}
    return MissionRow(**plain)
