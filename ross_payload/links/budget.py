"""How much a link may say: a bucket that fills at a steady rate."""

from __future__ import annotations

import math

BURST = 0.5  # [s] of the rate that may go out at once
LARGEST_FRAME = 293  # signed, with a full payload [bytes]


class Budget:
    """So many bytes per second, saved up for half a second; without a rate there is always room.

    >>> budget = Budget(rate=1000, now=0.0)
    >>> budget.spend(400, now=0.0), budget.spend(400, now=0.0), budget.room(now=0.2)
    (True, False, 300.0)
    """

    def __init__(self, rate: float, now: float) -> None:
        self.rate = rate or math.inf  # [bytes/s]
        self._size = max(self.rate * BURST, LARGEST_FRAME)
        self._room = self._size
        self._filled = now

    def room(self, now: float) -> float:
        """Return how many bytes may go out at ``now`` [s]."""
        if now > self._filled and math.isfinite(self.rate):
            self._room = min(self._room + (now - self._filled) * self.rate, self._size)
        self._filled = max(now, self._filled)
        return self._room

    def spend(self, size: int, now: float) -> bool:
        """Take ``size`` bytes if there is room for all of them; tell whether there was."""
        if self.room(now) < size:
            return False
        self._room -= size
        return True
