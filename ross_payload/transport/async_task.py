"""Work that crosses threads, and signals that reach an event loop.

What takes a while (looking up a host, saving a file) goes to a thread of its own; who polls looks in again. What other
threads leave in a queue is taken out by whoever polls it.
"""

from __future__ import annotations

import errno
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, TypeVar

from ross_payload.end_signals import caught_signal, end_signals

if TYPE_CHECKING:
    import asyncio

T = TypeVar("T")


def begin(work: Callable[[], T]) -> Future[T]:
    """Do something once on a thread that dies with the process; return where its result will be.

    An `OSError` is there when the system has no thread left.
    """
    future: Future[T] = Future()

    def run() -> None:
        try:
            future.set_result(work())
        except Exception as error:
            future.set_exception(error)

    try:
        threading.Thread(target=run, daemon=True, name="links").start()
    except RuntimeError as error:  # who polls goes on, and asks again
        future.set_exception(OSError(errno.EAGAIN, str(error)))
    return future


def set_by_signal() -> asyncio.Event:
    """Return an event of the running loop that every signal to end sets."""
    import asyncio  # noqa: PLC0415 - a payload has no event loop

    event, missed = asyncio.Event(), caught_signal() is not None
    for number in end_signals():
        asyncio.get_running_loop().add_signal_handler(number, event.set)
    if missed:
        event.set()
    return event


def drained(queue: SimpleQueue[T]) -> Iterator[T]:
    """Take out one after the other until nothing waits."""
    try:
        while True:
            yield queue.get_nowait()
    except Empty:
        return


class Backoff:
    """How long to wait before the next attempt: longer every time, up to a limit.

    >>> backoff = Backoff(first_s=0.5, longest_s=8.0)
    >>> [backoff.wait() for _ in range(6)]
    [0.5, 1.0, 2.0, 4.0, 8.0, 8.0]
    """

    def __init__(self, first_s: float = 0.5, longest_s: float = 8.0) -> None:
        self._first, self._longest = first_s, longest_s
        self.reset()

    def reset(self) -> None:
        """Start again: it went well."""
        self._next = self._first

    def wait(self) -> float:
        """Return the time until the next attempt [s]."""
        now, self._next = self._next, min(2 * self._next, self._longest)
        return now
