"""What separating gains in every layout, the mean of its targets: all that the tables of gains need."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from dataclasses import dataclass

import numpy as np

from ross_sim.study.rows.result_rows import Separation, number
from ross_sim.study.rows.tables import grouped


@dataclass(frozen=True, slots=True)
class GainRow:
    """One layout, separated once."""

    setting: str
    k: int
    layout: int
    seed: int
    version: str
    how: str
    separator: str
    noise: str
    start: int | None
    explorer: str | None
    unit_s: float | None
    turning_deg_s: float  # while it was explored; 0: step by step
    schedule: str | None
    all_found: bool | None
    targets: int
    si_sdri_db: float  # mean of the targets

    @property
    def scene(self) -> Hashable:
        """Who talks where, and what separates them."""
        return self.setting, self.k, self.layout, self.seed, self.separator, self.noise


def gain_rows(rows: Iterable[Separation]) -> list[GainRow]:
    """One row for every layout, in the order in which they come."""
    return [
        GainRow(*case, targets=len(group), si_sdri_db=number(float(np.mean([row.si_sdri_db for row in group]))))
        for case, group in grouped(
            rows,
            lambda row: (
                row.setting, row.k, row.layout, row.seed, row.version, row.how, row.separator, row.noise, row.start,
                row.explorer, row.unit_s, row.turning_deg_s, row.schedule, row.all_found,
            ),
        ).items()
    ]  # fmt: skip
