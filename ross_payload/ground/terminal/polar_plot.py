"""The polar view: a compass rose with the axis, its limits, sources with their uncertainty, and where to turn next."""

from __future__ import annotations

import math
from typing import Any

from rich.text import Text

COLOURS = ("cyan", "magenta", "yellow", "green", "bright_blue", "bright_red", "bright_cyan", "bright_magenta")
MIN_WEDGE_DEG = 1.0  # a wedge of which something is seen
MAX_WEDGE_DEG = 90.0
LETTERS = "abcdefghijklmnopqrstuvwxyz"
INNER, LABEL, OUTER = 0.62, 0.80, 0.93  # of a wedge, as shares of the radius
PLANNED = 0.48  # where candidates are named
LEGEND = "o-O axis (O: microphone 2)  0 source  0? its mirror image  * target  a candidate  x goal  V vehicle's nose"
DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))  # of a braille character, by row and column
BRAILLE = 0x2800
FILLED_DOTS = 4  # dots, from which on a cell looks filled without braille


class Canvas:
    """``columns`` by ``rows`` characters, each 2 dots wide and 4 high, so that a circle is round in most fonts.

    >>> canvas = Canvas(2, 1)
    >>> canvas.dot(0, 0, "red")
    >>> canvas.label(2, 0, "N", "bold")
    >>> canvas.lines()[0].plain
    '⠁N'
    """

    def __init__(self, columns: int, rows: int, *, braille: bool = True) -> None:
        self.columns, self.rows, self._braille = columns, rows, braille
        self._dots: dict[tuple[int, int], int] = {}
        self._styles: dict[tuple[int, int], str] = {}
        self._labels: dict[tuple[int, int], tuple[str, str]] = {}

    def dot(self, x: float, y: float, style: str) -> None:
        """Set a dot, from the upper left corner; what lies outside is not drawn. The latest style colours its cell."""
        column, row = math.floor(x) // 2, math.floor(y) // 4
        if 0 <= column < self.columns and 0 <= row < self.rows:
            bit = DOTS[math.floor(y) % 4][math.floor(x) % 2]
            self._dots[column, row] = self._dots.get((column, row), 0) | bit
            self._styles[column, row] = style

    def line(self, start: tuple[float, float], end: tuple[float, float], style: str, step: float = 1.0) -> None:
        """Set dots from one place to another, every ``step`` dots."""
        count = max(round(math.dist(start, end) / step), 1)
        for index in range(count + 1):
            share = index / count
            self.dot(start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1]), style)

    def label(self, x: float, y: float, text: str, style: str) -> None:
        """Write over the dots, centred at a dot and kept inside."""
        column = min(max(math.floor(x) // 2 - (len(text) - 1) // 2, 0), self.columns - len(text))
        row = min(max(math.floor(y) // 4, 0), self.rows - 1)
        for place, letter in enumerate(text):
            self._labels[column + place, row] = (letter, style)

    def lines(self) -> list[Text]:
        """Return what was drawn, row by row."""
        return [self._row(row) for row in range(self.rows)]

    def _row(self, row: int) -> Text:
        text = Text(no_wrap=True)
        for column in range(self.columns):
            letter, style = self._labels.get((column, row)) or self._cell(column, row)
            text.append(letter, style)
        return text

    def _cell(self, column: int, row: int) -> tuple[str, str]:
        bits = self._dots.get((column, row), 0)
        if not bits:
            return " ", ""
        plain = "#" if bits.bit_count() >= FILLED_DOTS else "."
        return chr(BRAILLE + bits) if self._braille else plain, self._styles[column, row]


def colour(source: int) -> str:
    """Return the colour of a source; its number always stands beside it."""
    return COLOURS[source % len(COLOURS)]


def polar_plot(
    view: dict[str, Any], columns: int, rows: int, *, chosen: int | None = None, braille: bool = True
) -> list[Text]:
    """Draw the sections ``pointing``, ``sources`` and ``plan`` into ``columns`` by ``rows`` characters."""
    drawing = _PolarPlot(Canvas(columns, rows, braille=braille))
    pointing = view["pointing"]
    drawing.ring(pointing)
    drawing.candidates(view["plan"])
    for source in view["sources"]:
        drawing.source(source)
    drawing.axis(pointing)
    for source in view["sources"]:
        drawing.name(source, chosen=source["source"] == chosen)
    return drawing.canvas.lines()


class _PolarPlot:
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
        half = min(max(source["sigma"] or MIN_WEDGE_DEG, MIN_WEDGE_DEG), MAX_WEDGE_DEG)
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
