"""A drawing in characters: dots, eight to a cell, and labels over them."""

from __future__ import annotations

import math

from rich.text import Text

DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))  # of a braille character, by row and column
BRAILLE = 0x2800
HEAVY = 4  # dots, from which on a cell looks filled without braille


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
        plain = "#" if bits.bit_count() >= HEAVY else "."
        return chr(BRAILLE + bits) if self._braille else plain, self._styles[column, row]
