"""The mission in one picture: who was found where, how that was heard, where the array turned, and what it gained."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator, MultipleLocator

from ross_payload.dsp.stft import Stft
from ross_payload.events import AlignmentPlanned, Checked, Separated, SourcesEstimated
from ross_payload.ground.flights.plot_style import COLOURS, STYLE, compass_rose
from ross_protocols.angle_text import frame
from ross_sim.sitl.report import EventLog, Truth, orientations

RANGE = 60.0  # [dB] shown in spectrograms
UPPER = [(0.048, 0.511, 0.254, 0.380), (0.370, 0.511, 0.285, 0.380), (0.708, 0.511, 0.285, 0.380)]  # left, bottom,
LOWER = [
    (0.038, 0.051, 0.452, 0.380),
    (0.541, 0.051, 0.452, 0.380),
]  # width, height: to find them takes 0.3 s a picture


def draw(path: Path, log: EventLog, truth: Truth, *, rate: int, unit: float, title: str) -> None:
    """Write the picture of a mission as PNG; the same bytes for the same mission.

    ``unit`` is d / v_p [s]: the largest TDOA there is.
    """
    with mpl.rc_context(STYLE):
        figure = figure_of(log, truth, rate=rate, unit=unit, title=title)
        figure.savefig(path, format="png", dpi=110, metadata={"Software": None})


def figure_of(log: EventLog, truth: Truth, *, rate: int, unit: float, title: str) -> Figure:
    """Return the picture of a mission, not written yet; the arguments are those of `draw`."""
    figure = Figure(figsize=(13, 8.2))
    FigureCanvasAgg(figure)
    figure.suptitle(title, y=0.99, fontsize=12, fontweight="bold")
    _polar(figure.add_axes(UPPER[0], projection="polar"), log, truth)
    _densities(figure.add_axes(UPPER[1]), log, unit)
    _isolation(figure.add_axes(UPPER[2]), log)
    _spectrograms([figure.add_axes(place) for place in LOWER], log, truth, rate)
    return figure


def _polar(axes: Any, log: EventLog, truth: Truth) -> None:
    compass_rose(axes, "where: truth (rings), found (wedges), headings", earth=log.earth)
    axes.set_ylim(0, 1.3)
    for name, azimuth in zip(truth.names, -truth.azimuths, strict=True):
        axes.plot([azimuth], [1.0], "o", ms=13, mfc="none", mec="black", mew=1.4)
        axes.annotate(name, (azimuth, 1.22), ha="center", va="center")
    for event in orientations(log):
        axes.plot([-event.heading, np.pi - event.heading], [0.42, 0.42], color="0.82", lw=0.8)
    estimated: SourcesEstimated | None = log.last(SourcesEstimated)
    for index, source in enumerate(estimated.estimate.sources if estimated else ()):
        width = max(2 * source.sigma, np.deg2rad(1.5))
        axes.bar(
            [-source.azimuth],
            [1.0],
            width=width,
            color=COLOURS[index % len(COLOURS)],
            alpha=0.35 + source.confidence / 2,
        )
        axes.annotate(f"{index}", (-source.azimuth, 0.8), ha="center", va="center", fontweight="bold")
    checked: Checked | None = log.last(Checked)
    if checked is not None:
        heading = -checked.candidate.heading
        arrow = {"arrowstyle": "-|>", "lw": 2, "color": "black"}
        axes.annotate("", (heading, 0.5), (heading + np.pi, 0.5), arrowprops=arrow)


def _densities(axes: Any, log: EventLog, unit: float) -> None:
    axes.set_title("heard: ITD density per orientation")
    axes.set_xlabel("ITD [us]")
    axes.set_ylabel(f"heading {frame(log.earth)} [deg]")
    axes.yaxis.set_major_locator(MaxNLocator(8, steps=[1, 1.5, 3, 4.5, 6, 9, 10]))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda level, place: f"{level % 360:g}"))
    heard = orientations(log)
    if not heard:
        return
    step = np.median(np.abs(np.diff([np.rad2deg(event.heading) for event in heard]))) if len(heard) > 1 else 15.0
    for event in heard:
        level, peak = -np.rad2deg(event.heading), event.density.max()  # not wrapped: the curves go on through 0
        shape = event.density / peak if peak > 0 else event.density
        axes.fill_between(event.grid * 1e6, level, level + 0.9 * step * shape, color="#0072b2", alpha=0.35, lw=0)
    headings = np.linspace(heard[0].heading, heard[-1].heading, 200)
    estimated: SourcesEstimated | None = log.last(SourcesEstimated)
    reach = np.abs(heard[0].grid).max() * 1e6
    for index, source in enumerate(estimated.estimate.sources if estimated else ()):
        tau = unit * np.cos(source.elevation or 0.0) * np.cos(source.azimuth - headings) * 1e6
        axes.plot(tau, -np.rad2deg(headings), color=COLOURS[index % len(COLOURS)], lw=1.4, label=f"source {index}")
    axes.set_xlim(-reach, reach)
    if estimated and estimated.estimate.sources:
        axes.legend(loc="upper right", fontsize=7)


def _isolation(axes: Any, log: EventLog) -> None:
    axes.set_title("where to turn: predicted isolation of each source")
    axes.set_xlabel("heading modulo 180 [deg]")
    axes.xaxis.set_major_locator(MultipleLocator(45))
    axes.set_ylabel("isolation [us]")
    planned: AlignmentPlanned | None = log.last(AlignmentPlanned)
    if planned is None:
        return
    headings = _axis(planned.headings)
    order = np.argsort(headings)
    for index, curve in enumerate(planned.isolation):
        look = {"color": COLOURS[index % len(COLOURS)], "label": f"source {index}"}
        axes.plot(headings[order], curve[order] * 1e6, **look)
    for candidate in planned.candidates:
        colour = COLOURS[candidate.source % len(COLOURS)]
        axes.plot([_axis(candidate.heading)], [candidate.isolation * 1e6], "v", color=colour, ms=7)
    checked: Checked | None = log.last(Checked)
    if checked is not None:
        axes.axvline(_axis(checked.candidate.heading), color="black", lw=1, ls=":", label="array")
    axes.legend(fontsize=7)


def _axis(heading: Any) -> Any:
    """Degrees of a compass in [0, 180) of a heading [rad]: the opposite heading is the same axis."""
    return np.rad2deg(-heading) % 180


def _spectrograms(axes: list[Any], log: EventLog, truth: Truth, rate: int) -> None:
    separated: Separated | None = log.last(Separated)
    for which, title in zip(axes, ("before: microphone 1", "after: the target's voice"), strict=True):
        which.set_title(title)
        which.set_xlabel("time [s]")
        which.set_ylabel("frequency [kHz]")
    if separated is None:
        return
    n = separated.voices.shape[1]
    before = truth.mixture[separated.start : separated.start + n]
    top = None
    for which, signal in zip(axes, (before, separated.voices[separated.target]), strict=True):
        stft = Stft(rate, 512, 128)
        level = np.asarray(20 * np.log10(np.abs(stft.analyse(signal)) + 1e-9))
        top = level.max() if top is None else top
        which.imshow(
            level, origin="lower", aspect="auto", cmap="magma", vmin=top - RANGE, vmax=top,
            extent=(separated.start / rate, (separated.start + n) / rate, 0, rate / 2000), interpolation="nearest",
        )  # fmt: skip
