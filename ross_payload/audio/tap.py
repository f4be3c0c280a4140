"""Which microphone was tapped: the only way to see that two of them are swapped."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from ross_payload.interfaces import Real, Samples

BACKGROUND = 100  # blocks whose median is the background
LEARNT = 30  # blocks until the background is known
SUDDEN = 8.0  # a tap is so many times louder than the background
LEAST = 0.01  # and at least so loud, re full scale
LENGTH = 10  # blocks that a tap rings
CLEAR_DB = 3.0  # between both microphones


@dataclass(frozen=True, slots=True)
class Tap:
    """One tap."""

    microphone: int  # 1 or 2
    margin_db: float  # by how much it was louder there

    @property
    def clear(self) -> bool:
        """Whether it tells one microphone from the other."""
        return self.margin_db >= CLEAR_DB


class TapFinder:
    """Takes blocks of equal length, about 10 ms each, and tells of every tap."""

    def __init__(self) -> None:
        self._background: deque[float] = deque(maxlen=BACKGROUND)
        self._peaks: list[Real] = []
        self._last = np.zeros((2, 1), np.float32)

    def listen(self, samples: Samples) -> Tap | None:
        """Take the next block (2, n); returns a tap when one is over."""
        steps = np.diff(samples, axis=1, prepend=self._last)  # a tap is sharp; hum and rumble are not
        self._last = samples[:, -1:]
        peaks = np.abs(steps).max(axis=1).astype(np.float64)
        known = len(self._background) >= LEARNT
        sudden = max(LEAST, SUDDEN * float(np.median(self._background))) if known else np.inf
        if not self._peaks and peaks.max() < sudden:
            self._background.append(float(peaks.max()))
            return None
        self._peaks.append(peaks)
        return self._end() if len(self._peaks) == LENGTH else None

    def _end(self) -> Tap:
        peaks = np.maximum(np.max(self._peaks, axis=0), 1e-9)
        self._peaks.clear()
        louder = int(np.argmax(peaks))
        return Tap(louder + 1, float(20 * np.log10(peaks[louder] / peaks[1 - louder])))
