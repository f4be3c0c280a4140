"""What went through a link lately."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

PERIOD = 0.25  # [s] between two readings
SPAN = 3.0  # [s] over which rates are taken
LOSS_SPAN = 10.0  # [s] over which the share of lost frames is taken


@dataclass(frozen=True, slots=True)
class Reading:
    """Totals at a time."""

    at: float  # [s]
    frames: int
    size: int  # [bytes]
    lost: int | None  # frames; None: nobody can tell


class Meter:
    """Remembers readings for as long as they are needed.

    >>> meter = Meter(Reading(0.0, 0, 0, 0))
    >>> for second in range(1, 11):
    ...     meter.note(Reading(float(second), 20 * second, 500 * second, 5 * second))
    >>> meter.rates(Reading(10.0, 200, 5000, 50)), meter.loss(Reading(10.0, 200, 5000, 50))
    ((20.0, 500.0), 0.2)
    """

    def __init__(self, first: Reading) -> None:
        self._readings = deque([first])

    def note(self, reading: Reading) -> None:
        """Take a reading, unless the last one is fresh."""
        if reading.at - self._readings[-1].at < PERIOD:
            return
        self._readings.append(reading)
        while reading.at - self._readings[1].at >= LOSS_SPAN:
            self._readings.popleft()

    def rates(self, now: Reading) -> tuple[float, float]:
        """Return frames and bytes per second over the last `SPAN`."""
        before = self._before(now.at - SPAN)
        span = max(now.at - before.at, PERIOD)
        return (now.frames - before.frames) / span, (now.size - before.size) / span

    def loss(self, now: Reading) -> float | None:
        """Return the share of frames that were lost over the last `LOSS_SPAN`, 0 to 1; None: nobody can tell."""
        before = self._before(now.at - LOSS_SPAN)
        if now.lost is None or before.lost is None:
            return None
        lost, frames = max(now.lost - before.lost, 0), now.frames - before.frames  # some of before may have come late
        return lost / (lost + frames) if lost else 0.0

    def _before(self, time: float) -> Reading:
        """Return the latest reading that is not after a time, or the first one."""
        return next((each for each in reversed(self._readings) if each.at <= time), self._readings[0])
