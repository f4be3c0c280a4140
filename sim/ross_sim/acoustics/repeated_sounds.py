"""Sounds that repeat for ever, as sample by sample signals: what fills a `TalkerSignals` beside talk."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ross_payload.interfaces import Real, Samples


@dataclass(frozen=True, slots=True, eq=False)
class Repeated:
    """A sound that repeats without a seam of its own making.

    >>> Repeated(np.arange(3, dtype=np.float32)).between(2, 7).tolist()
    [2.0, 0.0, 1.0, 2.0, 0.0]
    """

    sound: Samples  # (n,)

    def between(self, first: int, last: int) -> Samples:
        """Return the samples from ``first`` to before ``last``, (last - first,)."""
        return np.asarray(self.sound[np.arange(first, last) % self.sound.size], dtype=np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class Passing:
    """A sound that moves at a constant speed, heard from one of the places of its way.

    The loudness is 1 while it is there, 0 while it is at a neighbour and straight in between, so that the signals of
    all places add up to the sound.

    Parameters
    ----------
    along
        Places of the way [m], rising, (n_places,).
    here
        Which of them this is.
    speed
        [m per sample].
    nearest
        When it is at 0 m for the first time [samples].
    every
        From one time to the next [samples].
    """

    sound: Samples
    along: Real
    here: int
    speed: float
    nearest: float
    every: float

    def between(self, first: int, last: int) -> Samples:
        """Return the samples from ``first`` to before ``last``, (last - first,)."""
        index = np.arange(first, last)
        since = (index - self.nearest + self.every / 2) % self.every - self.every / 2
        since = np.where(index < self.nearest, index - self.nearest, since)
        there = np.zeros(self.along.size)
        there[self.here] = 1.0
        loudness = np.interp(since * self.speed, self.along, there, left=0.0, right=0.0)
        if not loudness.any():
            return np.zeros(index.size, dtype=np.float32)
        return np.asarray(self.sound[index % self.sound.size] * loudness, dtype=np.float32)
