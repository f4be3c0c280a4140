"""The paper's three figures, for its columns: readable in grey, and the same bytes for the same rows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ross_sim.study.rows.result_rows import ALIGNED, ESTIMATED, UNALIGNED, Exploration, Separation
from ross_sim.study.rows.tables import grouped

COLUMN, PAGE = 3.5, 7.16  # widths of one and of two columns [inch]
STYLE: dict[Any, Any] = {
    "text.parse_math": False,
    "font.size": 7,
    "axes.titlesize": 7,
    "axes.linewidth": 0.6,
    "lines.linewidth": 1.0,
    "lines.markersize": 3,
    "legend.fontsize": 6,
    "legend.frameon": False,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "hatch.linewidth": 0.5,
    "pdf.fonttype": 42,
}
SOLID: tuple[dict[str, Any], ...] = ({"marker": "o", "color": "black"},)
HOLLOW: tuple[dict[str, Any], ...] = (  # of several explorers
    {"marker": "o", "facecolors": "none", "edgecolors": "black"},
    {"marker": "x", "color": "0.45"},
    {"marker": "s", "facecolors": "none", "edgecolors": "0.6"},
)
LOOKS = (("0.25", ""), ("0.60", "////"), ("0.88", ""), ("1.0", "...."), ("0.45", "xx"))  # of bars, by K
MOST = 6  # columns of panels


def draw(folder: Path, separations: Sequence[Separation], explorations: Sequence[Exploration]) -> list[str]:
    """Write every figure that the rows allow as PDF and PNG; returns their names."""
    made: list[str] = []
    with mpl.rc_context(STYLE):
        if explorations:
            _save(folder, "aoa", _aoa(explorations), made)
        if len({row.start for row in separations if row.how == UNALIGNED}) > 1:
            for name, rows in _of_paper_layout(separations).items():
                _save(folder, f"orientation-{name}", _orientation(name, rows), made)
        if any(row.how == ALIGNED for row in separations):
            _save(folder, "methods", _methods([row for row in separations if row.noise == "known"]), made)
    return made


def _save(folder: Path, name: str, figure: Figure, made: list[str]) -> None:
    figure.savefig(folder / f"{name}.pdf", metadata={"CreationDate": None, "Creator": None, "Producer": None})
    figure.set_layout_engine("none")  # both have one layout: to find it takes longer than to draw
    figure.savefig(folder / f"{name}.png", dpi=200, metadata={"Software": None})
    made.extend((f"{name}.pdf", f"{name}.png"))


def _figure(width: float, height: float) -> Figure:
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


# ------------------------------------------------------------------------------------------ AoA over rotations


def _aoa(rows: Sequence[Exploration]) -> Figure:
    """Estimates after every rotation against the true azimuths: a row per setting, a column per K and T_unit."""
    first = rows[0]
    rows = [row for row in rows if row.layout == first.layout and row.start == first.start]
    settings = list(dict.fromkeys(row.setting for row in rows))
    combinations = sorted({(row.k, row.unit_s) for row in rows})[:MOST]
    explorers = list(dict.fromkeys(row.explorer for row in rows))
    figure = _figure(PAGE if len(combinations) > 2 else COLUMN, 0.5 + 1.25 * len(settings))
    panels = figure.subplots(len(settings), len(combinations), sharex=True, sharey=True, squeeze=False)
    for line, setting in zip(panels, settings, strict=True):
        for axes, (k, unit) in zip(line, combinations, strict=True):
            chosen = [row for row in rows if (row.setting, row.k, row.unit_s) == (setting, k, unit)]
            _trace(axes, chosen, explorers)
            axes.set_title(f"{setting}, K = {k}, T = {unit:g} s")
        line[0].set_ylabel("azimuth [deg]")
    for axes in panels[-1]:
        axes.set_xlabel("rotations")
    if len(explorers) > 1:
        _legend(figure, panels[0][0])
    return figure


def _trace(axes: Any, rows: Sequence[Exploration], explorers: Sequence[str]) -> None:
    for azimuth in rows[0].azimuths_true_deg if rows else ():
        axes.axhline(azimuth, color="0.35", lw=0.8, ls=":")
    looks = HOLLOW if len(explorers) > 1 else SOLID
    for index, (explorer, look) in enumerate(zip(explorers, looks, strict=False)):
        points = [(row.rotations, angle) for row in rows if row.explorer == explorer for angle in row.azimuths_deg]
        x, y = np.array(points).reshape(-1, 2).T
        axes.scatter(x + 0.3 * (index - (len(explorers) - 1) / 2), y, s=9, lw=0.7, label=explorer, **look)
    axes.set_ylim(-190, 190)
    axes.set_yticks([-180, -90, 0, 90, 180])
    axes.xaxis.get_major_locator().set_params(integer=True)


# ----------------------------------------------------------------------------- SI-SDRi over initial orientation


def mean(rows: Sequence[Separation]) -> float:
    """Mean SI-SDRi [dB]; not a number when there is no row."""
    return float(np.mean([row.si_sdri_db for row in rows])) if rows else math.nan


def _of_paper_layout(rows: Sequence[Separation]) -> dict[str, list[Separation]]:
    """Rows of the first layout by separator, noise known."""
    first = min(row.layout for row in rows)
    chosen = [row for row in rows if row.layout == first and row.noise == "known"]
    return grouped(chosen, lambda row: row.separator)


def _orientation(name: str, rows: Sequence[Separation]) -> Figure:
    """Gain over the initial orientation, a dotted line for the aligned one: a row per K, a column per setting."""
    settings, counts = list(dict.fromkeys(row.setting for row in rows)), sorted({row.k for row in rows})
    figure = _figure(PAGE if len(settings) > 2 else COLUMN, 0.55 + 1.25 * len(counts))
    panels = figure.subplots(len(counts), len(settings), sharex=True, sharey=True, squeeze=False)
    for line, k in zip(panels, counts, strict=True):
        for axes, setting in zip(line, settings, strict=True):
            _gain(axes, [row for row in rows if (row.setting, row.k) == (setting, k)])
            axes.set_title(f"{setting}, K = {k}")
        line[0].set_ylabel("SI-SDRi [dB]")
    for axes in panels[-1]:
        axes.set_xlabel("initial orientation [deg]")
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3, title=name)
    return figure


def _gain(axes: Any, rows: Sequence[Separation]) -> None:
    unaligned = grouped([row for row in rows if row.how == UNALIGNED], lambda row: row.start_heading_deg)
    headings = sorted(heading for heading in unaligned if heading is not None)
    values = np.array([mean(unaligned[heading]) for heading in headings])
    x, y = np.append(headings, 180.0), np.append(values, values[0])  # half a turn further is the same axis
    reached = mean([row for row in rows if row.how == ALIGNED])
    axes.fill_between(x, y, reached, where=y <= reached, color="0.85", lw=0, interpolate=True, label="gain")
    axes.axhline(reached, color="black", ls=":", lw=1.2, label="aligned")
    axes.plot(x, y, "-o", color="black", label="not aligned")
    axes.set_xticks([0, 45, 90, 135, 180])


# ------------------------------------------------------------------------------------- means: methods, settings


def _methods(rows: Sequence[Separation]) -> Figure:
    """Mean SI-SDRi (a) per method over all settings, (b) per setting of the best method; crosses: informed."""
    names, settings = (list(dict.fromkeys(getattr(row, key) for row in rows)) for key in ("separator", "setting"))
    ranked = {name: mean([row for row in rows if row.separator == name and row.how == ALIGNED]) for name in names}
    oracles = {"irm", "mwf", "tvmwf"}
    best = max([name for name in names if name not in oracles] or names, key=lambda name: ranked[name])
    figure = _figure(PAGE, 2.2)
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=[max(len(names), 2), max(len(settings), 2)])
    _bars(left, rows, "separator", names)
    _bars(right, [row for row in rows if row.separator == best], "setting", settings)
    left.set_title("(a) mean over the settings")
    right.set_title(f"(b) {best}")
    left.set_ylabel("SI-SDRi [dB]")
    _legend(figure, left)
    return figure


def _legend(figure: Figure, axes: Any) -> None:
    """One legend above all panels, the bars first."""
    handles, labels = axes.get_legend_handles_labels()
    order = sorted(range(len(labels)), key=lambda i: not labels[i].startswith("K ="))
    figure.legend(
        [handles[i] for i in order], [labels[i] for i in order], loc="outside upper center", ncols=len(labels)
    )


def _bars(axes: Any, rows: Sequence[Separation], key: str, values: Sequence[str]) -> None:
    counts = sorted({row.k for row in rows})
    width = 0.8 / len(counts)
    for index, k in enumerate(counts):
        groups = [[row for row in rows if getattr(row, key) == value and row.k == k] for value in values]
        x = np.arange(len(values)) + width * (index - (len(counts) - 1) / 2)
        aligned, estimated, unaligned = (
            np.array([mean([row for row in group if row.how == how]) for group in groups])
            for how in (ALIGNED, ESTIMATED, UNALIGNED)
        )
        explored = bool(np.isfinite(estimated).any())
        face, hatch = LOOKS[index % len(LOOKS)]
        heights = np.nan_to_num(np.where(np.isfinite(estimated), estimated, aligned))
        axes.bar(x, heights, 0.92 * width, color=face, hatch=hatch, edgecolor="black", lw=0.5, label=f"K = {k}")
        last = index == len(counts) - 1
        axes.plot(x, unaligned, ls="", marker="_", ms=5, mec="white", mew=2.4)
        axes.plot(x, unaligned, ls="", marker="_", ms=5, mec="black", mew=1.2, label="not aligned" if last else None)
        if explored:
            axes.plot(x, aligned, ls="", marker="x", ms=4.5, mec="white", mew=2.0)
            axes.plot(x, aligned, ls="", marker="x", ms=4, mec="black", mew=0.9, label="informed" if last else None)
    axes.axhline(0, color="black", lw=0.5)
    axes.set_xticks(range(len(values)), values, rotation=30 if len(values) > 6 else 0)
