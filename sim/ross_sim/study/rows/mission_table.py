"""The table of a study of missions, with intervals of 95 %."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ross_sim.study.rows.intervals import mean_cell, median_cell, rate_cell
from ross_sim.study.rows.mission_rows import ABSENT, MISSED_DEG, NEAR_DEG, PRESENT, MissionRow
from ross_sim.study.rows.tables import Table, grouped

HEADER = (
    "",
    "K right",
    f"all within {NEAR_DEG:g} deg",
    "error [deg]",
    "found, K right",
    "target found",
    "absent: no target",
    "heard from [s]",
    "right from [s]",
    "SI-SDRi [dB]",
    "explored again",
    "CPU [s/s]",
)
ABOUT = (
    "Rates with their Wilson intervals, means with those of Student's t, medians with those of their ranks, 95 % each. "
    "K and azimuths: all missions; the error is the median over all talkers who were found. Target found: the target "
    "is in the room, and what is heard as the target's holds it alone; found, K right: and K is right, too. Heard "
    "from, the median time of the mission from which on it is heard, and SI-SDRi are those of the missions that found "
    "it; right from, when its voice was heard first, is that of all who ever heard it. Explored again: how often, in "
    "the mean. CPU: what the mission itself computes per second of audio, median."
)


def missions(rows: Sequence[MissionRow]) -> Table:
    """One line for every scenario and K.

    >>> missions([]).rows
    ()
    """
    lines = []
    for (scenario, k), group in grouped(rows, lambda row: (row.scenario, row.k)).items():
        lines.append((f"{scenario}, K = {k}", *_cells(group)))
    return Table("Whole missions", HEADER, tuple(lines), ABOUT)


def _cells(rows: Sequence[MissionRow]) -> tuple[str, ...]:
    present = [row for row in rows if row.target_is == PRESENT]
    right = [row for row in present if row.ended_right]
    absent = [row for row in rows if row.target_is == ABSENT]
    errors = [error for row in rows for error in row.errors_deg if error < MISSED_DEG]
    costs = [row.cpu_s / row.mission_s for row in rows if row.mission_s]
    return (
        rate_cell(sum(row.k_estimated == row.k for row in rows), len(rows)),
        rate_cell(sum(row.placed for row in rows), len(rows)),
        f"{np.median(errors):.1f}" if errors else "-",
        rate_cell(sum(row.succeeded for row in present), len(present)),
        rate_cell(len(right), len(present)),
        rate_cell(sum(row.target_right for row in absent), len(absent)),
        median_cell([row.heard_from_s for row in right if row.heard_from_s is not None]),
        median_cell([row.right_from_s for row in present if row.right_from_s is not None]),
        mean_cell([row.si_sdri_db for row in right if row.si_sdri_db is not None]),
        f"{np.mean([row.restarts for row in rows]):.1f}",
        f"{np.median(costs):.3f}" if costs else "-",
    )
