"""Faults of the page itself: whoever watches keeps watching, and the terminal says it, one line a second at most."""

from __future__ import annotations

import asyncio
import logging
import select
import sys
import time
import traceback
from collections.abc import Callable
from typing import Any

PERIOD = 1.0  # [s] between two lines
MOST_TRACEBACKS = 20  # of different faults; a fault is shown with its place once


def report(error: Exception) -> None:
    """Tell of a fault of the program on the terminal."""
    words = {"message": "an internal error of the page; please report it", "exception": error, "ours": True}
    asyncio.get_running_loop().call_exception_handler(words)


def write_line(text: str) -> None:
    """Write a line to the terminal that must not be left out, unless the terminal takes nothing."""
    show(f"ross ground: {' '.join(text.split())}\n")


def show(text: str) -> None:
    """Write to the terminal what it takes: one that is held, by Ctrl-S for one, must not hold up the page."""
    for line in text.splitlines(keepends=True):  # it may take a line, and not all of a traceback
        if not _takes_something():
            return
        print(line, end="", file=sys.stderr, flush=True)  # noqa: T201


def _takes_something() -> bool:
    try:
        return bool(select.select((), (sys.stderr,), (), 0.0)[1])
    except (OSError, ValueError):  # no file behind it
        return True


class Reporter:
    """Writes lines to the terminal, at most one in `PERIOD`, and how many were left out.

    >>> lines = []
    >>> reporter = Reporter(lines.append, clock=iter([0.0, 0.1, 0.2, 1.5]).__next__)
    >>> for _ in range(4):
    ...     _ = reporter("no room")
    >>> lines
    ['ross ground: no room', 'ross ground: no room (2 more lines were left out)']
    """

    def __init__(
        self,
        write: Callable[[str], object] = lambda line: show(f"{line}\n"),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._write, self._clock = write, clock
        self._written = -PERIOD
        self._left_out = 0

    def __call__(self, text: str) -> bool:
        """Write a line, or count it; return whether it was written."""
        now = self._clock()
        if now - self._written < PERIOD:
            self._left_out += 1
            return False
        left = f" ({self._left_out} more lines were left out)" if self._left_out else ""
        self._written, self._left_out = now, 0
        self._write(f"ross ground: {' '.join(text.split())}{left}")
        return True


class FaultLog(logging.Handler):
    """Takes what the loop and the web server complain of: one line, with the traceback of a fault of ours once."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self._reporter = Reporter()
        self._shown: set[str] = set()

    def of_loop(self, loop: asyncio.AbstractEventLoop, words: dict[str, Any]) -> None:
        """Take what an event loop tells its exception handler."""
        error = words.get("exception")
        written = self._reporter(f"{words['message']}: {error!r}" if error is not None else str(words["message"]))
        if written and words.get("ours") and isinstance(error, Exception):
            text = "".join(traceback.format_exception(error))
            if text not in self._shown and len(self._shown) < MOST_TRACEBACKS:
                self._shown.add(text)
                show(text)

    def emit(self, record: logging.LogRecord) -> None:
        """Take what the web server logs."""
        error = record.exc_info[1] if record.exc_info else None
        self._reporter(record.getMessage() + (f": {error!r}" if error is not None else ""))

    def logger(self) -> logging.Logger:
        """Return a logger that writes here and nowhere else."""
        logger = logging.Logger("ross ground", logging.ERROR)
        logger.addHandler(self)
        return logger
