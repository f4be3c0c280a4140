"""Tables and lists on a terminal: a line that is too long is broken between words, never within one."""

from __future__ import annotations

import shutil
import sys
import textwrap

from rich.cells import cell_len
from rich.table import Table
from rich.text import Text

LONGEST_WORD = 24  # characters: a name of a file may be longer and is broken


def with_whole_words(table: Table) -> Table:
    """Keep every column of a filled table as wide as its longest word; return the table.

    >>> table = Table("confidence", "x")
    >>> table.add_row("1.0", "two words")
    >>> [column.min_width for column in with_whole_words(table).columns]
    [10, 5]
    """
    for column in table.columns:
        texts = [column.header, *column.cells]
        words = [word for text in texts for word in _plain(text).split()]
        longest = max(map(cell_len, words), default=0)
        column.min_width = max(column.min_width or 0, min(longest, LONGEST_WORD))
    return table


def _plain(cell: object) -> str:
    return Text.from_markup(cell).plain if isinstance(cell, str) else str(cell)


def listed(head: str, text: str, width: int | None = None) -> str:
    """Return a row of a list: a head, and a text that continues below its own beginning where the line ends.

    Parameters
    ----------
    head
        What stands before the text, padded.
    text
        Words.
    width
        Of the line [characters]; None: of the terminal, or without an end on a pipe.

    >>> print(listed("name  ", "a text of some words", 16))
    name  a text of
          some words
    """
    if width is None:
        width = shutil.get_terminal_size().columns if sys.stdout.isatty() else sys.maxsize
    indent = " " * len(head)
    wrap = textwrap.TextWrapper(width, initial_indent=head, subsequent_indent=indent, break_long_words=False)
    wrap.break_on_hyphens = False
    return wrap.fill(text) if text else head.rstrip()
