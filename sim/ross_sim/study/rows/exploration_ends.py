"""Explorations where they end: of every one a row per schedule, with what the tables of who was found need."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from ross_payload.angles import difference
from ross_payload.interfaces import Real
from ross_sim.study.rows.result_rows import Exploration
from ross_sim.study.rows.tables import grouped
from ross_sim.study.scenes.exploration import NEAR_DEG

FAR_DEG = 60.0  # to match sources and talkers nothing is farther apart
FOUND_DEG = 15.0  # a source that is farther from every talker has no error: it is nobody
STOP = "stop"  # the schedule that ends where the explorer is certain


@dataclass(frozen=True, slots=True)
class Explored:
    """Which exploration a row is about."""

    setting: str
    k: int
    layout: int
    seed: int
    version: str
    start: int
    explorer: str
    unit_s: float
    turning_deg_s: float  # 0: step by step


@dataclass(frozen=True, slots=True)
class End(Explored):
    """Where a schedule of an exploration ends."""

    schedule: str  # a number of rotations, or stop
    rotations: int


@dataclass(frozen=True, slots=True)
class EndRow(End):
    """What is believed there."""

    errors_deg: tuple[float, ...]  # of every talker's own estimate; 180 for a talker without one
    confidences: tuple[float, ...]  # of every source
    there: tuple[bool, ...]  # whether a talker of its own is near

    @property
    def k_estimated(self) -> int:
        """How many sources were found."""
        return len(self.confidences)

    @property
    def right(self) -> bool:
        """K is right and every azimuth is near."""
        return self.k_estimated == self.k and max(self.errors_deg, default=0.0) <= NEAR_DEG

    @property
    def exploration(self) -> Hashable:
        """Of which exploration it is."""
        return (
            self.setting, self.k, self.layout, self.seed, self.start, self.explorer, self.unit_s, self.turning_deg_s
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class SigmaRow(End):
    """What is believed there of the azimuths of every talker who was found."""

    directness: float | None
    errors_deg: tuple[float, ...]
    sigmas_deg: tuple[float, ...]


def stopped(certain: Sequence[bool]) -> int:
    """The rotation after which an explorer stops: the first at which it is certain, else the last.

    >>> stopped([False, False, True, False]), stopped([False, False])
    (2, 1)
    """
    return next((r for r, enough in enumerate(certain) if enough), len(certain) - 1)


def end_rows(schedules: Sequence[int | str], rows: Iterable[Exploration]) -> list[EndRow]:
    """The rows at which the schedules end, exploration by exploration; none for more rotations than there were."""
    return [_end(schedule, row) for schedule, row in _ends(schedules, rows)]


def sigma_rows(schedules: Sequence[int | str], rows: Iterable[Exploration]) -> list[SigmaRow]:
    """The same explorations, each with the errors of its azimuths and their standard deviations."""
    return [_sigmas(schedule, row) for schedule, row in _ends(schedules, rows)]


def _ends(schedules: Sequence[int | str], rows: Iterable[Exploration]) -> Iterator[tuple[int | str, Exploration]]:
    for task in grouped(rows, lambda row: (row.seed, row.task)).values():
        ordered = sorted(task, key=lambda row: row.rotations)
        for schedule in schedules:
            end = stopped([row.certain for row in ordered]) if schedule == STOP else int(schedule)
            yield from ((schedule, row) for row in ordered if row.rotations == end)


def _end(schedule: int | str, row: Exploration) -> EndRow:
    return EndRow(
        row.setting, row.k, row.layout, row.seed, row.version, row.start, row.explorer, row.unit_s, row.turning_deg_s,
        str(schedule), row.rotations, row.errors_deg, row.confidences, _there(row),
    )  # fmt: skip


def _sigmas(schedule: int | str, row: Exploration) -> SigmaRow:
    sources, errors = _matched(row)
    found = errors <= FOUND_DEG
    return SigmaRow(
        row.setting, row.k, row.layout, row.seed, row.version, row.start, row.explorer, row.unit_s, row.turning_deg_s,
        str(schedule), row.rotations, row.directness, tuple(errors[found].round(3).tolist()),
        tuple(row.sigmas_deg[source] for source in sources[found]),
    )  # fmt: skip


def _there(row: Exploration) -> tuple[bool, ...]:
    """Whether a talker of its own is near every source."""
    near = np.zeros(len(row.azimuths_deg), dtype=bool)
    sources, errors = _matched(row)
    near[sources] = errors <= NEAR_DEG
    return tuple(near.tolist())


def _matched(row: Exploration) -> tuple[NDArray[np.intp], Real]:
    """Sources, (n,), each with a talker of its own, and their errors [deg]: matched so that these are least in all."""
    apart = np.rad2deg(np.abs(difference(np.deg2rad(row.azimuths_deg)[:, None], np.deg2rad(row.azimuths_true_deg))))
    sources, talkers = linear_sum_assignment(np.minimum(apart, FAR_DEG))
    return sources, apart[sources, talkers]
