"""Tables of what separating gains, from the means of every layout."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ross_sim.study.rows.intervals import half_width
from ross_sim.study.rows.layout_gains import GainRow
from ross_sim.study.rows.result_rows import ALIGNED, ESTIMATED, UNALIGNED
from ross_sim.study.rows.tables import Table, grouped


def gains(rows: Sequence[GainRow]) -> Table:
    """Mean SI-SDRi of every setting, K and separator: aligned / end to end, all found / end to end, all / unaligned."""
    names = tuple(grouped(rows, tool))
    lines = []
    for (setting, k), group in grouped(rows, lambda row: (row.setting, row.k)).items():
        by_name = grouped(group, tool)
        lines.append((f"{setting}, K = {k}", *(_gains(by_name.get(name, [])) for name in names)))
    about = (
        "dB: aligned with true azimuths, and where there are several layouts the interval of this mean over them, 95 % "
        "/ aligned with estimated azimuths where every talker was found / the same everywhere, a missed target counted "
        "as 0 dB / not aligned, at the start headings."
    )
    return Table("Mean SI-SDRi", ("", *names), tuple(lines), about)


def tool(row: GainRow) -> str:
    """A separator and what it knows of the noise, as a column is called."""
    return row.separator if row.noise == "known" else f"{row.separator}, noise unknown"


def _gains(rows: Sequence[GainRow]) -> str:
    by = grouped(rows, lambda row: row.how)
    aligned, estimated = by.get(ALIGNED, []), by.get(ESTIMATED, [])
    half = half_width([row.si_sdri_db for row in aligned])
    parts = [_mean(aligned) + ("" if math.isnan(half) else f" ± {half:.1f}")]
    if estimated:
        parts += [_mean([row for row in estimated if row.all_found]), _mean(estimated)]
    return " / ".join([*parts, _mean(by.get(UNALIGNED, []))])


def _mean(rows: Sequence[GainRow]) -> str:
    """Mean over the targets of some layouts."""
    return f"{_weighted([row.si_sdri_db for row in rows], rows):.1f}" if rows else "-"


def _weighted(values: Sequence[float], rows: Sequence[GainRow]) -> float:
    return float(np.average(values, weights=[row.targets for row in rows]))


def losses(rows: Sequence[GainRow]) -> Table:
    """What estimating the azimuths costs, over the targets of scenes in which every talker was found."""
    true = {row.scene: row.si_sdri_db for row in rows if row.how == ALIGNED}
    estimated = [row for row in rows if row.how == ESTIMATED and row.scene in true]
    names = tuple(grouped(estimated, tool))
    lines = []
    for label, group in grouped(estimated, _effort).items():
        by_name = grouped([row for row in group if row.all_found], tool)
        cells = [_loss(by_name.get(name, []), true) for name in names]
        lines.append((label, f"{_weighted([bool(row.all_found) for row in group], group):.2f}", *cells))
    about = "dB that are lost by estimated instead of true azimuths, over the scenes in which every talker was found."
    return Table("Loss end to end", ("", "all found", *names), tuple(lines), about)


def _loss(rows: Sequence[GainRow], true: dict[object, float]) -> str:
    return f"{_weighted([true[row.scene] - row.si_sdri_db for row in rows], rows):.2f}" if rows else "-"


def _effort(row: GainRow) -> str:
    turning = f"{row.turning_deg_s:g} deg/s, " if row.turning_deg_s else ""
    return f"{row.setting}, K = {row.k}, {row.explorer}, {row.unit_s:g} s, {turning}{row.schedule}"
