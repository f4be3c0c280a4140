"""What a person sees while the mission runs: a live view on a terminal, plain lines elsewhere."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from itertools import pairwise

from rich.console import Console, Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from ross_payload import events
from ross_payload.bounded_files import printable
from ross_payload.interfaces import Input, Real
from ross_payload.mission.exploit import HEARD_BEFORE
from ross_payload.telemetry.status_texts import contradicted
from ross_protocols.angle_text import bearing, bearings, frame, rotation
from ross_sim.unread_console import UnreadConsole

BARS = " ▁▂▃▄▅▆▇█"
LINES = 6  # of the log under the live view
REFRESH = 8  # [Hz]
RADIUS = 5  # of the polar view [rows]


class MissionView:
    """Shows a mission while it runs; this one shows nothing, for machines."""

    def on_input(self, hop: Input) -> None:
        """Follow one hop."""

    def on_event(self, event: events.Event, hop: Input) -> None:
        """Follow what the mission says."""

    def on_log(self, words: str) -> None:
        """Show a line that something beside the mission has logged."""

    def close(self) -> None:
        """Give the screen back."""


class PlainLines(MissionView):
    """One line for every event that a person wants to know."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._time = 0.0

    def on_input(self, hop: Input) -> None:
        """Follow the time."""
        self._time = hop.block.time

    def on_event(self, event: events.Event, hop: Input) -> None:
        """Print the event in words."""
        words = in_words(event, earth=hop.pointing.earth)
        if words:
            self._print(event.time, words)

    def on_log(self, words: str) -> None:
        """Print the line with the time of the mission."""
        self._print(self._time, words)

    def _print(self, time: float, words: str) -> None:
        self._console.print(f"{time:7.2f} s  {words}", highlight=False, markup=False, soft_wrap=True)


class LiveView(MissionView):
    """State, progress, level, heading, ITD density and sources, redrawn in place."""

    def __init__(self, console: Console, expected: float) -> None:
        self._expected = expected  # [s] of mission time
        self._time = 0.0
        self._level = -100.0
        self._heading = 0.0
        self._earth = False
        self._state = events.State.IDLE
        self._detail = ""
        self._density = ""
        self._sources: events.SourcesEstimated | None = None
        self._log: list[str] = []
        self._live = Live(self, console=console, refresh_per_second=REFRESH, transient=False)
        self._live.start()

    def on_input(self, hop: Input) -> None:
        """Follow level and heading."""
        samples = hop.block.samples
        power = float((samples * samples).mean()) if samples.size else 0.0
        self._level = max(10 * math.log10(power + 1e-10), self._level - 0.5)
        self._heading, self._earth = hop.pointing.heading, hop.pointing.earth
        self._time = hop.block.time

    def on_event(self, event: events.Event, hop: Input) -> None:
        """Take the event into the picture."""
        if isinstance(event, events.StateChanged):
            self._state, self._detail = event.state, event.detail
        elif isinstance(event, events.OrientationHeard):
            self._density = sparkline(event.density)
        elif isinstance(event, events.SourcesEstimated):
            self._sources = event
        words = in_words(event, earth=hop.pointing.earth)
        if words:
            self._log = [*self._log[-LINES + 1 :], f"{event.time:7.2f} s  {words}"]

    def on_log(self, words: str) -> None:
        """Take the line into the log, with the time of the mission."""
        self._log = [*self._log[-LINES + 1 :], f"{self._time:7.2f} s  {words}"]

    def close(self) -> None:
        """Give the screen back, with the last view left on it."""
        self._live.stop()

    def __rich__(self) -> Group:
        """Draw the latest; called by the library's refresh thread, which only reads."""
        state = Text.assemble((self._state.name.replace("_", " ").lower(), "bold"), f"  {self._detail}")
        facts = f"heading {bearing(self._heading):>5} deg {frame(self._earth)}   level {self._level:6.1f} dBFS"
        bar = Table.grid()
        bar.add_row(ProgressBar(total=self._expected, completed=min(self._time, self._expected), width=60))
        azimuths = [source.azimuth for source in self._sources.estimate.sources] if self._sources else []
        picture = Table.grid(padding=(0, 4))
        picture.add_row(Text(polar_plot(self._heading, azimuths)), self._table())
        return Group(
            state,
            Text(f"{facts}   {self._time:6.1f} s of about {self._expected:.0f} s"),
            bar,
            Text(f"ITD {self._density}", style="cyan"),
            picture,
            *(Text(line, style="dim") for line in self._log),
        )

    def _table(self) -> Table:
        table = Table(box=None, pad_edge=False, header_style="bold")
        for column in ("source", "azimuth", "sigma", "confidence", "front/back"):
            table.add_column(column, justify="right")
        for index, source in enumerate(self._sources.estimate.sources if self._sources else ()):
            table.add_row(
                str(index),
                f"{bearing(source.azimuth)} deg",
                f"{math.degrees(source.sigma):.1f}",
                f"{source.confidence:.2f}",
                "resolved" if source.resolved else "ambiguous",
            )
        return table


def polar_plot(heading: float, azimuths: Sequence[float]) -> str:
    """Draw the array's axis and the sources by number as on a compass: 0 at the top, clockwise; angles in [rad].

    >>> print(polar_plot(-math.pi / 2, [0.0, math.pi / 2]))
              0
    <BLANKLINE>
    <BLANKLINE>
    <BLANKLINE>
    <BLANKLINE>
    1    --------->
    <BLANKLINE>
    <BLANKLINE>
    <BLANKLINE>
    <BLANKLINE>
    <BLANKLINE>
    """
    rows = [[" "] * (4 * RADIUS + 1) for _ in range(2 * RADIUS + 1)]

    def put(angle: float, distance: float, mark: str) -> None:
        row, column = RADIUS - distance * math.cos(angle), 2 * (RADIUS - distance * math.sin(angle))
        rows[round(row)][round(column)] = mark

    stroke = "|\\-/"[round(math.degrees(heading) % 180 / 45) % 4]
    for step in range(-5, 5):
        put(heading, step / 2, stroke)
    put(heading, 2.0, "^<v>"[round(math.degrees(heading) % 360 / 90) % 4])
    for index, azimuth in enumerate(azimuths):
        put(azimuth, RADIUS, str(index % 10))
    return "\n".join("".join(row).rstrip() for row in rows)


def sparkline(values: Real, width: int = 60) -> str:
    """Draw a density as one line of bars.

    >>> import numpy as np
    >>> sparkline(np.array([0.0, 0.5, 1.0]), width=3)
    ' ▄█'
    """
    if not len(values) or values.max() <= 0:
        return ""
    edges = [round(i * len(values) / width) for i in range(width + 1)]
    heights = [max(values[a : max(b, a + 1)]) / values.max() for a, b in pairwise(edges)]
    return "".join(BARS[int(height * (len(BARS) - 1))] for height in heights)


def in_words(event: events.Event, *, earth: bool) -> str:  # noqa: PLR0911, PLR0912 - one line for each kind of event
    """Tell an event in words; empty when it is not worth a line. ``earth``: its headings count from north."""
    match event:
        case events.NoiseMeasured(level_db=None):
            return "no quiet lead-in: the noise level is assumed"
        case events.NoiseMeasured(level_db=level, seconds=seconds):
            return f"quiet lead-in of {seconds:g} s: noise at {level:.1f} dBFS"
        case events.SourcesEstimated(estimate=estimate, rotations=rotations, final=final, informed=informed):
            where = bearings((source.azimuth for source in estimate.sources), earth=earth)
            found = f"K = {estimate.k}{' at ' + where if where else ''}"
            if informed:
                return f"known without exploring: {found}"
            return f"rotation {rotations}: {found}{'; exploration complete' if final else ''}"
        case events.AlignmentPlanned(candidates=candidates):
            plans = ", ".join(f"{bearing(c.heading)} deg for source {c.source} ({c.rule})" for c in candidates)
            return f"headings to try, {frame(earth)}: {plans}" if plans else "no alignment is within the joint's limits"
        case events.TurnStarted(heading=heading, reason=reason):
            return f"turning to {bearings([heading], earth=earth)}: {reason}" if "alignment" in reason else ""
        case events.Checked(groups=groups, method=method, accepted=accepted, why=why):
            scores = ", ".join(f"{_members(group)}: {group.value:+.1f}" for group in groups)
            known = f", {why}" if why == HEARD_BEFORE else ""
            verdict = "no target here" if accepted is None else f"source {_members(groups[accepted])} is the target"
            return f"voice scores by {method}{known} ({scores}): {verdict}"
        case events.Separated(groups=groups, target=target, method=method, why=why):
            return f"separated by {method}, score {groups[target].value:+.1f}" + (f": {why}" if why else "")
        case events.ScoreDropped(value=value, criterion=criterion, other=None):
            return f"the score dropped to {value:+.1f}, below {criterion:.1f}: starting again"
        case events.ScoreDropped(value=value, criterion=criterion, other=other):
            return f"source {other} sounds as much like the target, {criterion:+.1f} beside {value:+.1f}: it comes next"
        case events.Slipped(shift=shift):
            return f"all azimuths shifted by {rotation(shift)}: the array has slipped; corrected"
        case events.ArrayContradicted():
            return f"the array is not as configured: {contradicted(event)}"
        case events.Doubted(reason=reason):
            return f"exploring after all: {reason}"
        case events.Finished(reason=reason):
            return reason
        case _:
            return ""


def waiting(as_json: bool, what: str) -> AbstractContextManager[object]:
    """Show a person at a terminal that something takes a while."""
    console = Console()
    return nullcontext() if as_json or not console.is_terminal else console.status(what)


def view_of(as_json: bool, expected: float, writes: bool = False) -> MissionView:
    """Choose a view: none for machines, a live one on a terminal, lines elsewhere; ``expected`` is in [s].

    A mission that ``writes`` files outlives the reader of its lines.
    """
    console = UnreadConsole("the mission") if writes else Console()
    if as_json:
        return MissionView()
    return LiveView(console, expected) if console.is_terminal else PlainLines(console)


@contextmanager
def showing_streams(view: MissionView) -> Iterator[None]:
    """Show what live listening logs: who begins and ends to be heard, and what is wrong with a stream."""
    logger, handler = logging.getLogger("ross_payload.listening"), _Shown(view)
    before = logger.level, logger.propagate
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    logger.propagate = False
    try:
        yield
    finally:
        logger.setLevel(before[0])
        logger.propagate = before[1]
        logger.removeHandler(handler)


class _Shown(logging.Handler):
    """Gives log lines to a view."""

    def __init__(self, view: MissionView) -> None:
        super().__init__()
        self._view = view

    def emit(self, record: logging.LogRecord) -> None:
        """Give one line."""
        self._view.on_log(printable(record.getMessage()))


def _members(group: events.GroupScore) -> str:
    """The sources of a group.

    >>> _members(events.GroupScore((0, 2), 1.0, accepted=True))
    '0+2'
    """
    return "+".join(map(str, group.members))
