"""A flight in one picture: a row per payload, the scene at its end and what went on over time."""

from __future__ import annotations

import math
from pathlib import Path
from textwrap import wrap
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from ross_payload.atomic_files import replacing
from ross_payload.errors import refused_as
from ross_payload.ground.errors import GroundError
from ross_payload.ground.flights.mission_timeline import MissionTimeline
from ross_payload.ground.flights.plot_style import COLOURS, STYLE, compass_rose
from ross_payload.ground.flights.summary import FlightContent
from ross_payload.ground.model.payload_state import Moment
from ross_payload.ground.model.status_text import PREFIX
from ross_payload.ground.model.view import word
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.field_converters import compass
from ross_protocols.mavlink.values import Source

QUIET, HEARING, TURNING, MOVING, CHECKING, RUNNING, ENDED = (
    "#dddddd", "#e8f2f9", "#cfe3f1", "#f6ddc7", "#fdf3d8", "#d5ecdf", "#f2c6c6",
)  # fmt: skip
STATES = {
    "lead_in": QUIET, "noise": QUIET, "explore_turn": TURNING, "explore_listen": HEARING, "turn": MOVING,
    "align_turn": MOVING, "check": CHECKING, "run": RUNNING, "stopped": ENDED, "fault": ENDED,
}  # fmt: skip
MOST_ROWS = 6  # payloads in one picture
MOST_TEXTS = 14
WIDTH = 62  # of an event's line [characters]
MOST_POINTS = 4000  # of one line
TURN = 360.0  # [deg]


def draw(content: FlightContent, path: Path) -> None:
    """Write a picture of a flight, PNG or SVG by its ending; the same bytes for the same flight.

    Raises
    ------
    GroundError
        When there is no payload, or the file cannot be written.
    """
    if not content.payloads:
        raise GroundError(f"{content.flight.name}: expected a payload for a picture, got none")
    with mpl.rc_context(STYLE), refused_as(GroundError, f"{path}: cannot be written"), replacing(path) as aside:
        form = path.suffix.lower().removeprefix(".")
        software = {"png": {"Software": None}, "svg": {"Date": None, "Creator": None}}
        figure_of(content).savefig(aside, format=form, dpi=110, metadata=software[form])


def figure_of(content: FlightContent) -> Figure:
    """Return the picture of a flight, not written yet."""
    shown = content.payloads[:MOST_ROWS]
    figure = Figure(figsize=(13, 0.6 + 4.4 * len(shown)), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(_title(content, len(shown)), fontsize=12, fontweight="bold")
    rows = figure.subfigures(len(shown), 1, squeeze=False)[:, 0]
    for row, who in zip(rows, shown, strict=True):
        _row(row, content, who)
    return figure


def _title(content: FlightContent, shown: int) -> str:
    left = len(content.payloads) - shown
    return _plain(content.flight.name) + (f" (and {left} more payloads: select one with --payload)" if left else "")


def _row(row: Any, content: FlightContent, who: ComponentId) -> None:
    timeline = content.timelines[who]
    grid = row.add_gridspec(3, 3, width_ratios=(1.25, 1.6, 1.0))
    _scene(row.add_subplot(grid[:, 0], projection="polar"), timeline)
    k, score, heading = (row.add_subplot(grid[place, 1]) for place in range(3))
    for axes in (k, score, heading):
        for stay in timeline.states:
            colour = STATES.get(str(word("ROSS_STATE", stay.state)))
            if colour is not None:
                axes.axvspan(stay.at, stay.until, color=colour, lw=0)
        axes.set_xlim(0, max(content.flight.duration, 1e-3))
    _curve(k, timeline, "K", lambda moment: moment.k, drawstyle="steps-post")
    _curve(score, timeline, "score", lambda moment: moment.score)
    _curve(score, timeline, "score", lambda moment: moment.criterion, color="0.5", ls="--")
    _headings(heading, timeline)
    heading.set_xlabel("time [s]")
    k.set_title("sources, score and heading over time")
    k.set_ylim(0, 1 + max((moment.k or 0 for moment in timeline.moments), default=0))
    k.yaxis.set_major_locator(MaxNLocator(integer=True))
    for axes in (k, score):
        axes.tick_params(labelbottom=False)
    side = row.add_subplot(grid[:, 2])
    _events(side, content, who)
    _legend(side, timeline)


def _scene(axes: Any, timeline: MissionTimeline) -> None:
    """Draw the last estimate as on a compass: wedges of three sigma, mirrors dashed, the axis both ways."""
    compass_rose(axes, f"{timeline.who} at the end", earth=timeline.status is not None and timeline.status.earth)
    axes.set_ylim(0, 1.15)
    for index, source in sorted(timeline.sources.items()):
        _wedge(axes, source, COLOURS[index % len(COLOURS)])
    heading = timeline.status.heading if timeline.status else None
    if heading is not None:
        axes.plot([-heading, math.pi - heading], [0.5, 0.5], color="black", lw=1.5)
        axes.plot([-heading], [0.5], marker="o", ms=5, color="black")


def _wedge(axes: Any, source: Source, colour: str) -> None:
    width = min(max(6 * source.sigma, math.radians(2)), 2 * math.pi)
    alpha = 0.35 + min(max(source.confidence, 0.0), 1.0) / 2  # a sender may say anything
    axes.bar([-source.azimuth], [1.0], width=width, color=colour, alpha=alpha)
    if source.mirror is not None:
        axes.plot([-source.mirror] * 2, [0, 1.0], color=colour, ls="--", lw=1)
    name = f"{source.source}{' target' if source.target else ''}"
    axes.annotate(name, (-source.azimuth, 1.08), ha="center", va="center", fontweight="bold", color=colour)


def _legend(axes: Any, timeline: MissionTimeline) -> None:
    """Name the colours of the states that there were."""
    seen = dict.fromkeys(str(word("ROSS_STATE", stay.state)) for stay in timeline.states)
    patches = [Patch(color=STATES[state], label=state.replace("_", " ")) for state in seen if state in STATES]
    if patches:
        axes.legend(handles=patches, loc="lower left", ncols=2, frameon=False)


def _curve(axes: Any, timeline: MissionTimeline, name: str, number: Any, **style: Any) -> None:
    moments = _thin(timeline.moments)
    numbers = [math.nan if number(moment) is None else number(moment) for moment in moments]
    axes.plot([moment.at for moment in moments], numbers, **{"color": COLOURS[0], "lw": 1.4, **style})
    axes.set_ylabel(name)


def _headings(axes: Any, timeline: MissionTimeline) -> None:
    """Draw headings of a compass; the line is broken where it passes north."""
    moments = _thin(timeline.moments)
    times = [moment.at for moment in moments]
    degrees = [math.nan if moment.heading is None else compass(moment.heading) for moment in moments]
    breaks = [i for i in range(1, len(degrees)) if abs(degrees[i] - degrees[i - 1]) > TURN / 2]
    for place in reversed(breaks):
        times.insert(place, times[place])
        degrees.insert(place, math.nan)
    axes.plot(times, degrees, color=COLOURS[0], lw=1.4)
    axes.set_ylim(0, TURN)
    axes.set_yticks(range(0, 361, 90))
    axes.set_ylabel("heading [deg]")


def _plain(text: str) -> str:
    """Keep what every font has."""
    return "".join(letter if letter.isprintable() and letter.isascii() else "?" for letter in text)


def _thin(moments: list[Moment]) -> list[Moment]:
    return moments[:: max(len(moments) // MOST_POINTS, 1)]


def _events(axes: Any, content: FlightContent, who: ComponentId) -> None:
    axes.axis("off")
    axes.set_title("events")
    texts = content.texts[who]
    lines = [f"{text.at:8.1f} s  {text.text.removeprefix(PREFIX)}" for text in texts[-MOST_TEXTS:]]
    left = len(texts) - len(lines)
    earlier = [f"{left} earlier ones: --json lists all"] if left else []
    words = "\n".join(_plain(part) for line in [*earlier, *lines] for part in wrap(line, WIDTH)) or "none"
    axes.text(0, 1, words, va="top", ha="left", transform=axes.transAxes, linespacing=1.6)
