"""A table of a study: as Markdown, and for the terminal."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass
from typing import TypeVar

from rich.markup import escape
from rich.table import Table as Screen

from ross_payload.terminal_tables import with_whole_words

Row = TypeVar("Row")
Key = TypeVar("Key", bound=Hashable)


@dataclass(frozen=True, slots=True)
class Table:
    """A table in words."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    about: str = ""

    def markdown(self) -> str:
        """Write it as Markdown."""
        return f"## {self.title}\n\n{self.about}\n\n{self.body()}\n"

    def body(self) -> str:
        """Write the cells alone as Markdown."""
        lines = [self.header, tuple("---" if i == 0 else "---:" for i in range(len(self.header))), *self.rows]
        return "\n".join(f"| {' | '.join(map(_cell, cells))} |" for cells in lines)

    def screen(self) -> Screen:
        """Lay it out for a terminal."""
        table = Screen(title=self.title, title_justify="left", caption=self.about or None, caption_justify="left")
        for index, name in enumerate(self.header):
            table.add_column(escape(name), justify="left" if index == 0 else "right")
        for cells in self.rows:
            table.add_row(*map(escape, cells))
        return with_whole_words(table)


def _cell(text: str) -> str:
    """A text as a cell of Markdown: on one line, and a bar in it is no border."""
    return " ".join(text.split()).replace("|", "\\|")


def grouped(rows: Iterable[Row], key: Callable[[Row], Key]) -> dict[Key, list[Row]]:
    """Rows by a key, in the order in which the keys appear."""
    found: dict[Key, list[Row]] = defaultdict(list)
    for row in rows:
        found[key(row)].append(row)
    return dict(found)
