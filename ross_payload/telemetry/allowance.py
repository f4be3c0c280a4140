"""How often something may be done, whoever asks for it."""

from __future__ import annotations


class Allowance:
    """``burst`` times at once, and ``rate`` [1/s] times in the long run.

    >>> allowance = Allowance(burst=1, rate=0.5)
    >>> [allowance.take(now) for now in (0.0, 1.0, 2.5)]
    [True, False, True]
    """

    def __init__(self, burst: float, rate: float) -> None:
        self._burst = burst
        self._rate = rate
        self._left = burst
        self._last: float | None = None

    def take(self, now: float) -> bool:
        """Tell whether it may be done at ``now`` [s], and count it."""
        gained = 0.0 if self._last is None else max(now - self._last, 0.0) * self._rate
        self._left = min(self._left + gained, self._burst)
        self._last = now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True
