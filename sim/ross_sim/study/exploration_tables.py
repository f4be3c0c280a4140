"""Tables of how well talkers are counted, and of how far the confidence of a source is a probability."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.optimize import linear_sum_assignment

from ross_payload.angles import difference
from ross_payload.interfaces import Real
from ross_sim.study.exploration import NEAR_DEG
from ross_sim.study.intervals import rate_cell
from ross_sim.study.result_rows import Exploration
from ross_sim.study.tables import Table, grouped

EDGES = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 1.0)  # of the confidence


def last(rows: Sequence[Exploration]) -> list[Exploration]:
    """The rows after the last rotation of every exploration."""
    tasks = grouped(rows, lambda row: (row.seed, row.task)).values()
    return [max(task, key=lambda row: row.rotations) for task in tasks]


def counts(rows: Sequence[Exploration]) -> Table:
    """How often K is right after the last rotation, by room and K."""
    found = last(rows)
    numbers = sorted({row.k for row in found})
    lines = [
        (name, *(_right([row for row in group if row.k == k]) for k in numbers), _right(group))
        for name, group in grouped(found, lambda row: row.setting).items()
    ]
    lines.append(("all", *(_right([row for row in found if row.k == k]) for k in numbers), _right(found)))
    fewer = [f"{sum(row.k_estimated < row.k for row in found if row.k == k)}" for k in numbers]
    more = [f"{sum(row.k_estimated > row.k for row in found if row.k == k)}" for k in numbers]
    both = [rate_cell(sum(row.right for row in found if row.k == k), sum(row.k == k for row in found)) for k in numbers]
    lines.append(("all right", *both, rate_cell(sum(row.right for row in found), len(found))))
    lines.append(("K too small", *fewer, str(sum(map(int, fewer)))))
    lines.append(("K too large", *more, str(sum(map(int, more)))))
    about = "Scenes in which K is right after the last rotation, and the interval in which the rate lies with 95 %."
    return Table("K right", ("", *(f"K = {k}" for k in numbers), "all"), tuple(lines), about)


def _right(rows: Sequence[Exploration]) -> str:
    return rate_cell(sum(row.k_estimated == row.k for row in rows), len(rows))


def reliability(rows: Sequence[Exploration]) -> Table:
    """Mean confidence and share of sources that are talkers, by confidence, after the last rotation."""
    told, true = sources(last(rows))
    lines = []
    for low, high in pairwise(EDGES):
        here = (told >= low) & ((told < high) | (high == EDGES[-1]))
        if here.any():
            lines.append(
                (f"{low:g} to {high:g}", f"{told[here].mean():.3f}", rate_cell(int(true[here].sum()), int(here.sum())))
            )
    lines.append(("all", f"{told.mean():.3f}", rate_cell(int(true.sum()), len(true))))
    about = f"Sources by confidence; a source counts as a talker when one of its own is within {NEAR_DEG:g} deg."
    return Table("Confidence", ("confidence", "mean", "a talker there"), tuple(lines), about)


def sources(rows: Sequence[Exploration]) -> tuple[Real, Real]:
    """Confidence of every source of some rows, and whether a talker of its own is near, (n,) each."""
    told: list[float] = []
    true: list[bool] = []
    for row in rows:
        apart = np.abs(difference(np.deg2rad(row.azimuths_deg)[:, None], np.deg2rad(row.azimuths_true_deg)))
        near = np.zeros(len(row.azimuths_deg), dtype=bool)
        mine, theirs = linear_sum_assignment(np.minimum(apart, np.deg2rad(60.0)))
        near[mine] = apart[mine, theirs] <= np.deg2rad(NEAR_DEG)
        told.extend(row.confidences)
        true.extend(near.tolist())
    return np.array(told), np.array(true)
