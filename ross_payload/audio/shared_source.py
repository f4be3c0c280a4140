"""One source for two readers: the mission, which computes for seconds, and live listening, which may not wait for it.

A thread reads hop by hop. The listeners get every block at once, the mission when it asks. What the mission is too far
behind to be given becomes silence that is flagged, as if the source had lost it.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from queue import SimpleQueue
from typing import Self

import numpy as np

from ross_payload.audio.live_source import SourceStatus, Watched
from ross_payload.errors import AudioError
from ross_payload.interfaces import AudioBlock, AudioFlag, AudioSource

LAST_CALL_S = 2.0  # that a source which hangs may take at the end

log = logging.getLogger(__name__)
Listener = Callable[[AudioBlock], None]  # never waits, never raises


@dataclass(frozen=True, slots=True)
class Missing:
    """A hop that had no room."""

    index: int  # of its first sample
    time: float  # of that sample [s]


class SharedSource:
    """An AudioSource that is read by a thread of its own from when it is entered until it is left.

    Parameters
    ----------
    source
        What is heard with.
    hop
        Samples of a block; every `read` asks for as many.
    buffer
        Audio that can wait for the mission [s].
    watched
        The source where it tells how it is, else None.
    """

    def __init__(self, source: AudioSource, hop: int, buffer: float, watched: Watched | None = None) -> None:
        self._source = source
        self._hop = hop
        self._most = max(round(buffer * source.rate / hop), 1)
        self._watched = watched
        self._queue: SimpleQueue[AudioBlock | Missing | BaseException] = SimpleQueue()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._work, name="audio", daemon=True)
        self._lost = 0  # samples that had no room
        self.listeners: list[Listener] = []

    @property
    def rate(self) -> int:
        """Sampling rate [Hz]."""
        return self._source.rate

    def status(self) -> SourceStatus:
        """How the source is; from any thread."""
        status = SourceStatus() if self._watched is None else self._watched.status()
        waiting = status.waiting + self._queue.qsize() * self._hop / self.rate
        return replace(status, waiting=waiting, lost=status.lost + self._lost)

    def read(self, n: int) -> AudioBlock:
        """Return the next ``n`` samples, one hop; waits until they were heard.

        Raises
        ------
        AudioError
            When the source has ended or broken, or is not open.
        """
        if n != self._hop:
            raise AudioError(f"expected to be read in hops of {self._hop} samples, got {n}")
        if self._over.is_set() or (not self._thread.is_alive() and self._queue.empty()):
            raise AudioError("the microphones are not open")
        found = self._queue.get()
        if isinstance(found, BaseException):
            raise found
        if isinstance(found, Missing):
            zeros = np.zeros((2, n), np.float32)
            return AudioBlock(zeros, found.index, found.time, flags=AudioFlag.MISSING)
        return found

    def __enter__(self) -> Self:
        """Open the source and begin to read it.

        Raises
        ------
        AudioError
            When it cannot be opened.
        """
        self._source.__enter__()
        self._thread.start()
        return self

    def __exit__(self, *exception: object) -> None:
        """Read no more, and close the source."""
        self._over.set()
        self._thread.join(LAST_CALL_S)
        self._source.__exit__(None, None, None)

    def _work(self) -> None:
        try:
            while not self._over.is_set():
                self._pass_on(self._source.read(self._hop))
        except BaseException as error:  # for who reads
            self._queue.put(error)

    def _pass_on(self, block: AudioBlock) -> None:
        for listener in self.listeners:
            listener(block)
        if self._queue.qsize() < self._most:
            self._queue.put(block)
            return
        if not self._lost:
            log.warning("audio is lost: more than %d hops wait for the mission", self._most)
        self._lost += self._hop
        self._queue.put(Missing(block.index, block.time))
