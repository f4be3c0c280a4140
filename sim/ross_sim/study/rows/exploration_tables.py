"""Tables of who was found where explorations end, and of how far the confidence of a source is a probability."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ross_sim.study.rows.exploration_ends import FOUND_DEG, EndRow, SigmaRow
from ross_sim.study.rows.intervals import rate_cell
from ross_sim.study.rows.tables import Table, grouped
from ross_sim.study.scenes.exploration import NEAR_DEG

EDGES = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 1.0)  # of the confidence


def finds(rows: Sequence[EndRow]) -> Table:
    """How well the explorer counts and places talkers after every schedule."""
    counts = sorted({row.k for row in rows})
    lines = [
        (f"{setting}, {explorer}, {unit:g} s, {f'{rate:g} deg/s, ' if rate else ''}{schedule}", *_found(group, counts))
        for (explorer, unit, setting, rate, schedule), group in grouped(
            rows, lambda row: (row.explorer, row.unit_s, row.setting, row.turning_deg_s, row.schedule)
        ).items()
    ]
    by_k = tuple(f"K = {k}" for k in counts)
    header = ("", "rotations", "K right", "all right", "recall", "error [deg]", *by_k)
    about = (
        f"All right: K is right and every talker is within {NEAR_DEG:g} deg, with the interval in which the rate lies "
        "with 95 %; the columns by K are scenes all right."
    )
    return Table("Finding the talkers", header, tuple(lines), about)


def _found(rows: Sequence[EndRow], counts: Sequence[int]) -> tuple[str, ...]:
    errors = np.concatenate([row.errors_deg for row in rows])
    near = errors <= NEAR_DEG
    right = [[row.right for row in rows if row.k == k] for k in counts]
    return (
        f"{np.mean([row.rotations for row in rows]):.1f}",
        f"{np.mean([row.k_estimated == row.k for row in rows]):.2f}",
        rate_cell(sum(row.right for row in rows), len(rows)),
        f"{near.mean():.3f}",
        f"{errors[near].mean():.2f}" if near.any() else "-",
        *(f"{sum(part)}/{len(part)}" if part else "-" for part in right),
    )


def last(rows: Sequence[EndRow]) -> list[EndRow]:
    """Of every exploration the row with the most rotations."""
    explorations = grouped(rows, lambda row: row.exploration).values()
    return [max(ends, key=lambda row: row.rotations) for ends in explorations]


def counts(rows: Sequence[EndRow]) -> Table:
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


def _right(rows: Sequence[EndRow]) -> str:
    return rate_cell(sum(row.k_estimated == row.k for row in rows), len(rows))


def reliability(rows: Sequence[EndRow]) -> Table:
    """Mean confidence and share of sources that are talkers, by confidence, after the last rotation."""
    ends = last(rows)
    told = np.array([confidence for row in ends for confidence in row.confidences])
    true = np.array([there for row in ends for there in row.there], dtype=bool)
    lines = []
    for low, high in pairwise(EDGES):
        here = (told >= low) & ((told < high) | (high == EDGES[-1]))
        if here.any():
            lines.append(
                (f"{low:g} to {high:g}", f"{told[here].mean():.3f}", rate_cell(int(true[here].sum()), int(here.sum())))
            )
    lines.append(("all", f"{told.mean():.3f}" if told.size else "-", rate_cell(int(true.sum()), len(true))))
    about = f"Sources by confidence; a source counts as a talker when one of its own is within {NEAR_DEG:g} deg."
    return Table("Confidence", ("confidence", "mean", "a talker there"), tuple(lines), about)


def sigmas(rows: Sequence[SigmaRow]) -> Table:
    """How many azimuths are within one and two of their standard deviations, by room, after the last rotation."""
    most = max(row.rotations for row in rows)
    ends = [row for row in rows if row.rotations == most]
    lines = [(name, *_within(group)) for name, group in grouped(ends, lambda row: row.setting).items()]
    about = (
        f"Talkers with a source of their own within {FOUND_DEG:g} deg. Of normal errors 68 % are within one standard "
        "deviation and 95 % within two."
    )
    header = ("", "talkers", "error [deg]", "sigma [deg]", "within one", "within two")
    return Table("Standard deviations", header, (*lines, ("all", *_within(ends))), about)


def _within(rows: Sequence[SigmaRow]) -> tuple[str, ...]:
    errors, told = (np.concatenate([getattr(row, name) for row in rows]) for name in ("errors_deg", "sigmas_deg"))
    if not errors.size:
        return ("0", "-", "-", "-", "-")
    shares = (rate_cell(int((errors <= n * told).sum()), errors.size) for n in (1, 2))
    return (str(errors.size), f"{np.median(errors):.1f}", f"{np.median(told):.1f}", *shares)
