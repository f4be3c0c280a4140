"""Ctrl-C and SIGTERM as a call, so that what is open is closed in order."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def on_signal(call: Callable[[], None]) -> Iterator[None]:
    """Call ``call`` for every SIGINT and SIGTERM; afterwards they mean what they meant before."""

    def handle(number: int, frame: FrameType | None) -> None:
        call()

    before = {number: signal.signal(number, handle) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
