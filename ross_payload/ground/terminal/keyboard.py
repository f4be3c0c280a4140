"""The keys of a terminal, one by one, and the terminal as it was before."""

from __future__ import annotations

import asyncio
import os
import termios
from collections.abc import Callable, Iterator
from typing import Any, Self

from ross_payload.transport.byte_stream import hung_up

ARROWS = {b"A": "up", b"B": "down", b"C": "right", b"D": "left"}
ESCAPE = b"\x1b"
INPUT, LOCAL, CONTROL = 0, 3, 6  # places in what termios tells


def keys(data: bytes) -> Iterator[str]:
    r"""Return the keys that a terminal sent; sequences that mean nothing here are left out.

    >>> list(keys(b"s\x1b[C\x1bOA\x1b[3~q"))
    ['s', 'right', 'up', 'q']
    """
    while data:
        if data[:1] != ESCAPE:
            yield chr(data[0])
            data = data[1:]
            continue
        end = next(
            (place for place in range(2, len(data)) if data[place : place + 1].isalpha() or data[place] == 126), 0
        )
        if data[1:2] in (b"[", b"O") and end:
            arrow = ARROWS.get(data[end : end + 1])
            if arrow is not None:
                yield arrow
            data = data[end + 1 :]
        else:
            data = data[1:]


class Keyboard:
    """Calls ``press`` for every key, while it is entered; ``gone`` when the terminal is.

    Ctrl-Z and Ctrl-S are only keys: a program that stands still obeys none, not even a stop.
    """

    def __init__(self, file: int, press: Callable[[str], None], gone: Callable[[], None]) -> None:
        self._file, self._press, self._gone = file, press, gone
        self._before: list[Any] = []

    def __enter__(self) -> Self:
        """Let keys come one by one, unseen; no read waits, as Ctrl-C takes away what has been typed before it."""
        self._before = termios.tcgetattr(self._file)
        now = termios.tcgetattr(self._file)
        now[INPUT] &= ~termios.IXON
        now[LOCAL] &= ~(termios.ICANON | termios.ECHO)
        for place in (termios.VSUSP, termios.VMIN, termios.VTIME):
            now[CONTROL][place] = b"\0"
        termios.tcsetattr(self._file, termios.TCSADRAIN, now)
        asyncio.get_running_loop().add_reader(self._file, self._read)
        return self

    def __exit__(self, *error: object) -> None:
        """Leave the terminal as it was."""
        asyncio.get_running_loop().remove_reader(self._file)
        try:
            termios.tcsetattr(self._file, termios.TCSADRAIN, self._before)
        except termios.error:  # it has gone
            return

    def _read(self) -> None:
        try:
            data = os.read(self._file, 1024)
            gone = not data and hung_up(self._file)
        except OSError:
            data, gone = b"", True
        if gone:
            asyncio.get_running_loop().remove_reader(self._file)
            self._gone()
        for key in keys(data):
            self._press(key)
