"""Exploring step by step and without a pause, compared over the same scenes: how soon either is right.

One row is one exploration over time. An exploration ends where its explorer is certain, else with its last row. The
issue is how soon the array that turns without a pause is right as often as the one that pauses is where it ends.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ross_payload.interfaces import Real
from ross_sim.study.rows.exploration_ends import Explored, stopped
from ross_sim.study.rows.intervals import mean_cell, rate_cell
from ross_sim.study.rows.result_rows import Exploration
from ross_sim.study.rows.tables import Table, grouped

RESAMPLED = 2000  # times, of the scenes
TAILS = (2.5, 97.5)  # percent
ROUNDING = 1e-9  # of a share
HEADER = (
    "",
    "step by step: until certain [s]",
    "all right",
    "without a pause: until certain [s]",
    "all right",
    "ratio of the times",
    "as often right after [s]",
    "ratio",
)
ABOUT = "Times are means, rates have Wilson intervals, ratios those of 2000 resamplings of the scenes; all 95 %."


@dataclass(frozen=True, slots=True)
class MotionRow(Explored):
    """One exploration over time."""

    times_s: tuple[float, ...]  # since it began
    right: tuple[bool, ...]  # K and every azimuth, then
    certain: tuple[bool, ...]  # the explorer, then

    @property
    def scene(self) -> tuple[str, int, int, int, int]:
        """Who talks, where, and what is heard of them."""
        return self.setting, self.k, self.layout, self.seed, self.start

    @property
    def method(self) -> tuple[str, float]:
        """Who explores, and T_unit [s]."""
        return self.explorer, self.unit_s

    @property
    def end_s(self) -> float:
        """When it ends [s]."""
        return self.times_s[stopped(self.certain)]

    @property
    def right_at_end(self) -> bool:
        """Whether it is right then."""
        return self.right[stopped(self.certain)]

    def right_after(self, seconds: float) -> bool:
        """Whether what is believed after some seconds is right; before the first belief it is not."""
        past = [right for time, right in zip(self.times_s, self.right, strict=True) if time <= seconds]
        return bool(past) and past[-1]


def motion_rows(rows: Iterable[Exploration]) -> list[MotionRow]:
    """One row for every exploration, in the order in which they come."""
    found = []
    for task in grouped(rows, lambda row: (row.seed, row.task)).values():
        ordered = sorted(task, key=lambda row: row.rotations)
        first = ordered[0]
        found.append(
            MotionRow(
                first.setting, first.k, first.layout, first.seed, first.version, first.start, first.explorer,
                first.unit_s, first.turning_deg_s,
                tuple(row.time_s or 0.0 for row in ordered),
                tuple(row.right for row in ordered),
                tuple(row.certain for row in ordered),
            )
        )  # fmt: skip
    return found


def motions(rows: Sequence[MotionRow]) -> Table:
    """A line for every room and rate, and one for all rooms; of every explorer and T_unit where there are several."""
    lines, several = [], len({row.method for row in rows}) > 1
    for rate in sorted({row.turning_deg_s for row in rows if row.turning_deg_s}):
        for (explorer, unit), pairs in grouped(paired(rows, rate), lambda pair: pair[0].method).items():
            label = f"{explorer}, {unit:g} s, {rate:g} deg/s" if several else f"{rate:g} deg/s"
            rooms = grouped(pairs, lambda pair: pair[0].setting)
            for name, group in [*rooms.items(), ("all", pairs)]:
                lines.append((f"{name}, {label}", *_cells(group)))
    return Table("Exploring without a pause", HEADER, tuple(lines), ABOUT)


def paired(rows: Sequence[MotionRow], rate: float) -> list[tuple[MotionRow, MotionRow]]:
    """The scenes that one explorer explored, with one T_unit, both step by step and at a rate [deg/s]."""
    stepping = {(row.scene, row.method): row for row in rows if not row.turning_deg_s}
    turning = [row for row in rows if row.turning_deg_s == rate]
    return [(stepping[key], row) for row in turning if (key := (row.scene, row.method)) in stepping]


def _cells(pairs: Sequence[tuple[MotionRow, MotionRow]]) -> tuple[str, ...]:
    steps, turns = ([pair[index] for pair in pairs] for index in (0, 1))
    ends = np.array([[row.end_s for row in pair] for pair in pairs])
    soon = as_soon(steps, turns)
    drawn = np.random.default_rng(0).integers(len(pairs), size=(RESAMPLED, len(pairs)))
    ratios = ends[drawn, 1].mean(axis=1) / ends[drawn, 0].mean(axis=1)
    return (
        mean_cell(ends[:, 0].tolist()),
        rate_cell(sum(row.right_at_end for row in steps), len(steps)),
        mean_cell(ends[:, 1].tolist()),
        rate_cell(sum(row.right_at_end for row in turns), len(turns)),
        _ratio_cell(ends[:, 1].mean() / ends[:, 0].mean(), ratios),
        "never" if soon is None else f"{soon:g}",
        "-" if soon is None else _ratio_cell(soon / ends[:, 0].mean(), _soon_ratios(steps, turns, drawn)),
    )


def as_soon(steps: Sequence[MotionRow], turns: Sequence[MotionRow]) -> float | None:
    """After how many seconds the second explorations are right as often as the first are where they end; None: never.

    One moment may be good luck: the share of those that are right is taken to rise with time (`rising`).
    """
    times = _times(turns)
    shares = np.array([np.mean([row.right_after(time) for row in turns]) for time in times])
    return _first(times, rising(shares), float(np.mean([row.right_at_end for row in steps])))


def rising(values: Real) -> Real:
    """The sequence that never falls and is nearest to some values: isotonic regression by pooling adjacent violators.

    >>> rising(np.array([1.0, 3.0, 2.0, 4.0])).tolist()
    [1.0, 2.5, 2.5, 4.0]
    """
    pools: list[tuple[float, int]] = []  # mean, and how many
    for value in values.tolist():
        mean, count = value, 1
        while pools and pools[-1][0] > mean:
            before, many = pools.pop()
            mean, count = (mean * count + before * many) / (count + many), count + many
        pools.append((mean, count))
    return np.repeat([mean for mean, _ in pools], [count for _, count in pools])


def _times(rows: Sequence[MotionRow]) -> list[float]:
    return sorted({time for row in rows for time in row.times_s})


def _first(times: Sequence[float], shares: Real, least: float) -> float | None:
    enough = np.flatnonzero(shares >= least - ROUNDING)
    return times[int(enough[0])] if enough.size else None


def _soon_ratios(steps: Sequence[MotionRow], turns: Sequence[MotionRow], drawn: NDArray[np.int64]) -> Real:
    """Time after which turning is right as often over the time until stepping ends, for every draw of scenes.

    A draw in which it never is counts as infinite.
    """
    times = _times(turns)
    right = np.array([[row.right_after(time) for time in times] for row in turns], dtype=float)
    at_end, ends = (np.array(values, float) for values in zip(*((r.right_at_end, r.end_s) for r in steps), strict=True))
    found = []
    for scenes in drawn:
        soon = _first(times, rising(right[scenes].mean(axis=0)), float(at_end[scenes].mean()))
        found.append(np.inf if soon is None else soon / ends[scenes].mean())
    return np.array(found)


def _ratio_cell(ratio: float, resampled: Real) -> str:
    low, high = np.percentile(resampled, TAILS, method="nearest")
    return f"{ratio:.2f} ({low:.2f}-" + (f"{high:.2f})" if np.isfinite(high) else "never)")
