"""The polar view: a compass rose with the axis, its limits, sources with their uncertainty, and where to turn next."""

from __future__ import annotations

import math
from typing import Any

from rich.text import Text

from ross_payload.ground.monitor.canvas import Canvas

COLOURS = ("cyan", "magenta", "yellow", "green", "bright_blue", "bright_red", "bright_cyan", "bright_magenta")
NARROWEST = 1.0  # [deg]: a wedge of which something is seen
WIDEST = 90.0  # [deg]
LETTERS = "abcdefghijklmnopqrstuvwxyz"
INNER, LABEL, OUTER = 0.62, 0.80, 0.93  # of a wedge, as shares of the radius
PLANNED = 0.48  # where candidates are named
LEGEND = "o-O axis (O: microphone 2)  0 source  0? its mirror image  * target  a candidate  x goal  V vehicle's nose"


def colour(source: int) -> str:
    """Return the colour of a source; its number always stands beside it."""
    return COLOURS[source % len(COLOURS)]


def rose(
    picture: dict[str, Any], columns: int, rows: int, *, chosen: int | None = None, braille: bool = True
) -> list[Text]:
    """Draw the sections ``pointing``, ``sources`` and ``plan`` into ``columns`` by ``rows`` characters."""
    drawing = _Rose(Canvas(columns, rows, braille=braille))
    pointing = picture["pointing"]
    drawing.ring(pointing)
    drawing.candidates(picture["plan"])
    for source in picture["sources"]:
        drawing.source(source)
    drawing.axis(pointing)
    for source in picture["sources"]:
        drawing.name(source, chosen=source["source"] == chosen)
    return drawing.canvas.lines()


class _Rose:
    """Angles are degrees, clockwise from the top; distances are shares of the radius."""

    def __init__(self, canvas: Canvas) -> None:
        self.canvas = canvas
        self._x, self._y = canvas.columns - 0.5, canvas.rows * 2 - 0.5
        self._radius = min(self._x, self._y) - 1.5

    def _at(self, angle: float, share: float) -> tuple[float, float]:
        turned, distance = math.radians(angle), share * self._radius
        return self._x + distance * math.sin(turned), self._y - distance * math.cos(turned)

    def _label(self, angle: float, share: float, text: str, style: str) -> None:
        self.canvas.label(*self._at(angle, share), text, style)

    def _arc(self, first: float, last: float, share: float, style: str, every: float = 1.0) -> None:
        """Set dots clockwise, ``every`` so many dots apart."""
        count = max(math.ceil(math.radians(last - first) * share * self._radius / every), 1)
        for index in range(count + 1):
            self.canvas.dot(*self._at(first + index * (last - first) / count, share), style)

    def ring(self, pointing: dict[str, Any]) -> None:
        """Draw the circle, thin where the axis cannot point, with the directions of the compass or of the mount."""
        self._arc(0.0, 360.0, 1.0, "dim", every=5.0)
        limits = pointing["limits"]
        first, last = limits or (0.0, 360.0)
        self._arc(first, first + ((last - first) % 360.0 or 360.0), 1.0, "dim")
        for end in limits or ():
            self.canvas.line(self._at(end, 0.9), self._at(end, 1.0), "dim")
        names = "NESW" if pointing["earth"] else ("000", "090", "180", "270")
        for quarter, name in enumerate(names):
            self._label(90.0 * quarter, 1.0, name, "bold" if not quarter else "")
        if pointing.get("mount_yaw") is not None:
            self._label(pointing["mount_yaw"], 0.9, "V", "bold blue")

    def axis(self, pointing: dict[str, Any]) -> None:
        """Draw the axis both ways, since two microphones have no front, and its goal."""
        if pointing["goal"] is not None:
            self._label(pointing["goal"], 1.0, "x", "bold yellow")
        if pointing["heading"] is None:
            self.canvas.label(self._x, self._y, "heading not known", "dim")
            return
        heading = pointing["heading"]
        self.canvas.line(self._at(heading + 180.0, 0.36), self._at(heading, 0.36), "bold white")
        self._label(heading + 180.0, 0.36, "o", "bold white")
        self._label(heading, 0.36, "O", "bold white")

    def candidates(self, plan: dict[str, Any]) -> None:
        """Draw the headings to try; the one that is tried stands out."""
        for each in plan["candidates"]:
            now = each["candidate"] == plan["current"]
            style = "bold blue" if now else "dim" if each["state"] == "rejected" else "blue"
            for way in (0.0, 180.0):
                heading = each["heading"] + way
                self.canvas.line(self._at(heading, 0.1), self._at(heading, PLANNED), style, step=1.0 if now else 3.0)
            self._label(each["heading"], PLANNED, letter(each["candidate"]), style)

    def source(self, source: dict[str, Any]) -> None:
        """Draw where a source is, as wide as it is uncertain, where it may be instead, and where it was."""
        style = colour(source["source"])
        for _, azimuth in source["trail"]:
            self.canvas.dot(*self._at(azimuth, OUTER + 0.04), style)
        half = min(max(source["sigma"] or NARROWEST, NARROWEST), WIDEST)
        self._wedge(source["azimuth"], half, style, every=1.0)
        if source["mirror"] is not None:
            self._wedge(source["mirror"], half, style, every=3.0)

    def _wedge(self, azimuth: float, half: float, style: str, every: float) -> None:
        depth = max(round((OUTER - INNER) * self._radius), 1)
        for index in range(0, depth + 1, round(every)):
            share = INNER + (OUTER - INNER) * index / depth
            self._arc(azimuth - half, azimuth + half, share, style, every)

    def name(self, source: dict[str, Any], *, chosen: bool) -> None:
        """Write the number of a source on its wedge, and on that of its mirror."""
        style = f"bold {colour(source['source'])}{' reverse' if chosen else ''}"
        self._label(source["azimuth"], LABEL, f"{'*' if source['target'] else ''}{source['source']}", style)
        if source["mirror"] is not None:
            self._label(source["mirror"], LABEL, f"{source['source']}?", style)


def letter(candidate: int) -> str:
    """Return the name of a candidate.

    >>> letter(0), letter(27)
    ('a', 'b')
    """
    return LETTERS[candidate % len(LETTERS)]
