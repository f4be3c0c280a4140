"""Keeps a feed of audio open: what has vanished is opened again, less and less often, until it is back.

Opening can take seconds (PortAudio looks at every device), so that all but the first time it has a thread of its own:
the mission goes on meanwhile.
"""

from __future__ import annotations

import logging
import math
import threading
from collections.abc import Callable
from typing import Protocol

from ross_payload.errors import PLUGIN_RAISES, RossError
from ross_payload.interfaces import Clock

log = logging.getLogger(__name__)

FIRST_WAIT, LONGEST_WAIT = 0.5, 10.0  # [s] between two attempts
CLOSE_TIMEOUT_S = 5.0  # [s] that a driver which hangs may take at the end
MOST_TEXT = 120  # characters of what a feed of others has raised
STALE_AFTER_S = 2.0  # [s] without a frame: a feed that calls itself alive is not


class Feed(Protocol):
    """An open device or connection that hands frames on until it is closed or dies."""

    @property
    def alive(self) -> bool:
        """Whether frames may still come."""

    def close(self) -> None:
        """Give the device back; idempotent. Nothing is handed on afterwards."""


class Worker(Protocol):
    """Something that runs elsewhere."""

    def join(self, timeout: float) -> None:
        """Wait until it is over, at most so long [s]."""


def in_thread(call: Callable[[], None]) -> Worker:
    """Run a call in a thread of its own."""
    thread = threading.Thread(target=call, name="reopen", daemon=True)
    thread.start()
    return thread


class ReconnectingFeed:
    """Owns the feed; everything but the attempt itself belongs to the reader."""

    def __init__(self, opener: Callable[[], Feed], clock: Clock, start: Callable[[Callable[[], None]], Worker]) -> None:
        self._opener = opener
        self._clock = clock
        self._start = start
        self._feed: Feed | None = None
        self._worker: Worker | None = None
        self._busy = False
        self._wait = FIRST_WAIT
        self._due = 0.0  # when to try next [s]
        self._progress = (0, 0.0)  # frames, and when there were more than before [s]
        self.reopened = 0
        self.trouble = ""  # why nothing can be heard, in words

    def open(self) -> None:
        """Open it for the first time.

        Raises
        ------
        RossError
            When it cannot be opened.
        """
        self._feed = self._opener()
        self._progress = (0, self._clock.now())

    def check(self, frames: int, resumed: float = -math.inf) -> None:
        """See whether the feed lives, by the frames that have come from it so far, and else try to open it again.

        Whoever looks was held up until ``resumed`` [s], and so may have been the feed.
        """
        now = self._clock.now()
        if frames != self._progress[0]:
            self._progress = (frames, now)
            self._wait = FIRST_WAIT
            self._report("")
        if self._busy or now < self._due:
            return
        if now - max(self._progress[1], resumed) < STALE_AFTER_S and self._is_alive():
            return
        self._report(self.trouble or "the microphones were disconnected")
        self._busy = True
        try:
            self._worker = self._start(self._attempt)
        except RuntimeError as error:  # the system has no thread left
            self._report(f"the microphones cannot be opened again: {error}")
            self._put_off(now)

    def close(self) -> None:
        """Close for good."""
        if self._worker is not None:
            self._worker.join(CLOSE_TIMEOUT_S)
        self._drop()

    def _is_alive(self) -> bool:
        try:
            return self._feed is not None and self._feed.alive
        except PLUGIN_RAISES:  # of others: it may raise anything
            return False

    def _attempt(self) -> None:
        try:
            self._drop()
            self._feed = self._opener()
            self.reopened += 1
        except PLUGIN_RAISES as error:  # of others: it may raise anything
            self._report(_in_words("opened", error))
        finally:
            now = self._clock.now()
            self._progress = (self._progress[0], now)
            self._put_off(now)

    def _put_off(self, now: float) -> None:
        self._due, self._wait = now + self._wait, min(2 * self._wait, LONGEST_WAIT)
        self._busy = False

    def _report(self, trouble: str) -> None:
        """Log what changes, not what goes on."""
        before, self.trouble = self.trouble, trouble
        if trouble and trouble != before:
            log.warning("%s", trouble)
        elif before and not trouble:
            log.info("the microphones recovered")

    def _drop(self) -> None:
        feed, self._feed = self._feed, None
        try:
            if feed is not None:
                feed.close()
        except PLUGIN_RAISES as error:  # of others: it may raise anything, and what it was is gone
            log.warning("%s", _in_words("closed", error))


def _in_words(what: str, error: BaseException) -> str:
    if isinstance(error, RossError):
        return str(error)
    return f"the microphones cannot be {what}: {type(error).__name__}: {' '.join(str(error).split())[:MOST_TEXT]}"
