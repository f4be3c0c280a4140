"""What one target gains at the headings of every rule, and the table of what the rules lose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ross_sim.study.rows.intervals import mean_cell
from ross_sim.study.rows.tables import Table, grouped

LOSSES = ("gain_db", "paper_db", "isolation_db", "mean_db")
HEADER = ("", "best SI-SDRi", "predicted gain", "paper", "isolation alone", "any", "rank")


@dataclass(frozen=True, slots=True)
class HeadingRow:
    """One target of one layout."""

    setting: str
    k: int
    layout: int
    target: int
    seed: int
    best_db: float  # SI-SDRi at the best of all headings that were heard
    gain_db: float  # what is lost against it by the heading of the predicted gain
    paper_db: float  # of the paper's rules
    isolation_db: float  # of the best isolation
    mean_db: float  # and in the mean of the headings all around
    rank: float  # Spearman's coefficient of predicted and measured gains


def headings(rows: Sequence[HeadingRow]) -> Table:
    """A line for every room and K."""
    lines = [
        (
            f"{setting}, K = {k}",
            mean_cell([row.best_db for row in group]),
            *(mean_cell([getattr(row, name) for row in group], 2) for name in LOSSES),
            f"{np.mean([row.rank for row in group]):.2f}",
        )
        for (setting, k), group in grouped(rows, lambda row: (row.setting, row.k)).items()
    ]
    about = "dB: the best of all headings, and what the heading of every rule loses against it; 95 % intervals."
    return Table("Headings", HEADER, tuple(lines), about)
