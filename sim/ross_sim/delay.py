"""A MAVLink wire within one process that takes its time."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np

from ross_payload.interfaces import Clock
from ross_payload.links import Counts


class End:
    """One end of the wire: a port of `Links`, or of a simulated autopilot."""

    def __init__(self, clock: Clock, latency: float, jitter: float, generator: np.random.Generator) -> None:
        self._clock = clock
        self._latency = latency
        self._jitter = jitter
        self._generator = generator
        self._other = self
        self._coming: deque[tuple[float, bytes]] = deque()  # when it arrives [s], what
        self.counts = Counts()

    def join(self, other: End) -> None:
        """Lead to another end, and back."""
        self._other, other._other = other, self

    def send(self, frame: bytes) -> None:
        """Send one frame; none overtakes another."""
        due = self._clock.now() + self._latency + self._jitter * self._generator.random()
        coming = self._other._coming
        coming.append((max(due, coming[-1][0]) if coming else due, frame))
        self.counts = replace(self.counts, sent=self.counts.sent + 1)

    def receive(self) -> list[bytes]:
        """Return what has arrived."""
        arrived, now = [], self._clock.now()
        while self._coming and self._coming[0][0] <= now:
            arrived.append(self._coming.popleft()[1])
        self.counts = replace(self.counts, received=self.counts.received + sum(map(len, arrived)))
        return arrived

    def close(self) -> None:
        """Return at once: an in-process wire holds nothing."""


def wire(clock: Clock, latency: float, jitter: float, seed: int) -> tuple[End, End]:
    """Make a wire that delays by ``latency`` [s] at least and up to ``jitter`` [s] more; return both its ends."""
    one, other = (
        End(clock, latency, jitter, np.random.Generator(np.random.PCG64(own)))
        for own in np.random.SeedSequence(seed).spawn(2)  # what one says does not change how the other is delayed
    )
    one.join(other)
    return one, other
