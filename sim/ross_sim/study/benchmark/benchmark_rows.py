"""What the benchmark writes down, one row for every scene and method, and the tables that are made of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ross_sim.study.rows.intervals import mean_cell, rate_cell
from ross_sim.study.rows.tables import Table, grouped
from ross_sim.study.scenes.exploration import NEAR_DEG


@dataclass(frozen=True, slots=True)
class BenchmarkSeparation:
    """One target, separated by one method."""

    method: str
    scene: str
    room: str
    k: int
    orientation: str
    si_sdr_in_db: float  # of microphone 1
    si_sdr_out_db: float  # of the estimate; of microphone 1 when it is missing
    missing: bool = False

    @property
    def si_sdri_db(self) -> float:
        """Improvement [dB]; 0 when the estimate is missing."""
        return self.si_sdr_out_db - self.si_sdr_in_db


@dataclass(frozen=True, slots=True)
class BenchmarkLocalization:
    """One turn, and where a method finds talkers."""

    method: str
    scene: str
    room: str
    k: int
    k_estimated: int
    errors_deg: tuple[float, ...]  # of every talker; 180 for one who was not found
    missing: bool = False

    @property
    def right(self) -> bool:
        """K is right and every talker is near."""
        return self.k_estimated == self.k and max(self.errors_deg) <= NEAR_DEG


def separation_table(rows: Sequence[BenchmarkSeparation]) -> Table:
    """Mean SI-SDRi with its interval for every room, K, orientation and method.

    >>> rows = [BenchmarkSeparation("a", str(n), "S1", 3, "aligned", -3.0, out) for n, out in enumerate((4.0, 6.0))]
    >>> separation_table(rows).rows
    (('S1, K = 3, aligned', '2', '-3.0', '8.0 ± 12.7'),)
    """
    methods = tuple(grouped(rows, lambda row: row.method))
    lines = []
    for (room, k, orientation), group in grouped(rows, lambda row: (row.room, row.k, row.orientation)).items():
        heard = {row.scene: row.si_sdr_in_db for row in group}
        by_method = grouped(group, lambda row: row.method)
        cells = [mean_cell([row.si_sdri_db for row in by_method.get(method, [])]) for method in methods]
        lines.append((f"{room}, K = {k}, {orientation}", str(len(heard)), f"{np.mean([*heard.values()]):.1f}", *cells))
    about = "Mean SI-SDRi of the target [dB] and its interval of 95 %; mixture: mean SI-SDR of microphone 1 [dB]."
    return Table("Separation", ("", "scenes", "mixture", *methods), tuple(lines), about + _missing(rows))


def localization_table(rows: Sequence[BenchmarkLocalization]) -> Table:
    """How often K and all azimuths are right for every room, K and method, and the error of the talkers found."""
    lines = []
    for (room, k, method), group in grouped(rows, lambda row: (row.room, row.k, row.method)).items():
        errors = [error for row in group for error in row.errors_deg]
        near = [error for error in errors if error <= NEAR_DEG]
        lines.append((
            f"{room}, K = {k}, {method}", rate_cell(sum(row.k_estimated == k for row in group), len(group)),
            rate_cell(sum(row.right for row in group), len(group)), f"{len(near) / len(errors):.3f}",
            f"{np.mean(near):.2f}" if near else "-",
        ))  # fmt: skip
    about = (
        f"All right: K is right and every talker is within {NEAR_DEG:g} deg; recall: the share of talkers within that; "
        "error: mean of those."
    )
    header = ("", "K right", "all right", "recall", "error [deg]")
    return Table("Localization", header, tuple(lines), about + _missing(rows))


def _missing(rows: Sequence[BenchmarkSeparation] | Sequence[BenchmarkLocalization]) -> str:
    """Who left scenes out."""
    left: dict[str, int] = {}
    for row in rows:
        if row.missing:
            left[row.method] = left.get(row.method, 0) + 1
    return "".join(f" No estimate of {n} scenes by {method}: they count as 0." for method, n in left.items())
