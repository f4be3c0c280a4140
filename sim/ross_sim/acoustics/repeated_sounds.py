"""Sounds that repeat for ever, as sample by sample signals: what fills a `TalkerSignals` beside talk."""

from __future__ import annotations

import math
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
    """A sound that moves at a constant speed, again and again, heard from one of the places of its way.

    The loudness is 1 while it is there, 0 while it is at a neighbour and straight in between, so that the signals of
    all places add up to the sound. Several may be on their way at once; each then has another part of the sound.

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
        index, heard = np.arange(first, last), np.zeros(last - first)
        there = np.zeros(self.along.size)
        there[self.here] = 1.0
        at_once = max(math.ceil((self.along[-1] - self.along[0]) / (self.speed * self.every)), 1)
        for number in self._present(first, last):
            ahead = (index - self.nearest - number * self.every) * self.speed
            loudness = np.interp(ahead, self.along, there, left=0.0, right=0.0)
            part = number % at_once * self.sound.size // at_once
            heard += self.sound[(index + part) % self.sound.size] * loudness
        return heard.astype(np.float32)

    def _present(self, first: int, last: int) -> range:
        """Numbers of those that are between the neighbours of this place within these samples."""
        begin, end = self.along[max(self.here - 1, 0)], self.along[min(self.here + 1, self.along.size - 1)]
        earliest = math.ceil((first - self.nearest - end / self.speed) / self.every)
        latest = math.floor((last - self.nearest - begin / self.speed) / self.every)
        return range(max(earliest, 0), latest + 1)
