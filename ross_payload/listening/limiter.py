"""Level and limiter: what leaves the payload stays below full scale, and is told how loud it is."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from ross_payload.interfaces import Real, Samples

CEILING = 10 ** (-1 / 20)  # 1 dB below full scale
RELEASE_S = 0.2  # in which the gain comes back to within 1/e
LEVEL_S = 1.0  # over which the level is told
FLOOR_DB = -120.0


class Limiter:
    """Turns down at once what would exceed the ceiling, and back slowly; no delay, nothing is changed below it.

    The attenuation a(n) is the largest of what sample n needs and a(n - 1) faded by exp(-1 / (release rate)).

    Parameters
    ----------
    rate
        Sampling rate [Hz].

    >>> np.abs(Limiter(16000).limited(np.array([0.5, 4.0, -4.0], np.float32))).astype(float).round(3).tolist()
    [0.5, 0.891, 0.891]
    """

    def __init__(self, rate: int) -> None:
        self._fade = math.exp(-1 / (RELEASE_S * rate))
        self._attenuation = 0.0  # of the last sample, log of a factor

    def limited(self, samples: Samples) -> Samples:
        """Return the next samples (n,), within the ceiling."""
        needed = np.log(np.maximum(np.abs(samples, dtype=np.float64), CEILING) / CEILING)
        if self._attenuation < 1e-6 and not needed.any():
            self._attenuation = 0.0
            return samples
        faded = self._fade ** np.arange(1, len(samples) + 1)
        attenuation = np.maximum(np.maximum.accumulate(needed / faded), self._attenuation) * faded
        self._attenuation = float(attenuation[-1])
        return np.asarray(samples * np.exp(-attenuation), np.float32)


class LevelMeter:
    """Root mean square of the last second.

    Parameters
    ----------
    rate
        Sampling rate [Hz].
    """

    def __init__(self, rate: int) -> None:
        self._most = round(LEVEL_S * rate)
        self._parts: deque[tuple[int, float]] = deque()
        self._count = 0

    def add(self, samples: Real) -> None:
        """Take the next samples (n,)."""
        self._parts.append((len(samples), float(np.square(samples, dtype=np.float64).sum())))
        self._count += len(samples)
        while self._count - self._parts[0][0] >= self._most:
            self._count -= self._parts.popleft()[0]

    @property
    def level_db(self) -> float | None:
        """The level [dB re full scale], at least -120; None before anything was taken."""
        if not self._count:
            return None
        return max(10 * math.log10(sum(power for _, power in self._parts) / self._count + 1e-20), FLOOR_DB)
