"""From sample counts to the Clock: a slow loop on the earliest arrivals, without a jump.

A sample can arrive late but never early, so the lower envelope of arrival times is what carries the sound card's
clock. Once a second a loop of second order (F. Adriaensen, "Using a DLL to filter time", LAC 2005) takes what the
earliest arrival of that second was off, and spreads its correction over the next one: time is continuous and grows.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

WINDOW_S = 1.0  # [s] of samples between two corrections
BANDWIDTH = 0.02  # of the loop [Hz]: it follows a crystal that warms up, not a thread that is late
OMEGA = 2 * math.pi * BANDWIDTH * WINDOW_S
PROPORTIONAL, INTEGRAL = math.sqrt(2) * OMEGA, OMEGA**2
LATE_START_S = 0.005  # [s]: what a window is off by more tells of a late start, not of the rate
FASTEST = 0.01  # share by which time may run fast or slow to catch up
SETTLING = 10  # windows until the loop tells the rate's beginning
MEASURED = 30  # windows more until the rate is worth telling


@dataclass(frozen=True, slots=True)
class _Line:
    index: int
    time: float
    period: float  # [s] per sample


class SampleClock:
    """When each sample was heard, by the Clock.

    Parameters
    ----------
    rate
        As requested from the sound card [Hz].
    time
        Of sample 0 [s].
    """

    def __init__(self, rate: int, time: float) -> None:
        self._rate = rate
        self._drift = 0.0  # share by which a sample takes longer than it should
        self._lines: deque[_Line] = deque([_Line(0, time, 1 / rate)])
        self._earliest = math.inf  # residual of this window [s]
        self._windows = 0
        self._origin = (0, time)  # from which the rate is measured
        self._measured: float | None = None  # before the last gap [Hz]

    def time(self, index: int) -> float:
        """Return when a sample was heard [s]; samples are asked for in their order."""
        while len(self._lines) > 1 and self._lines[1].index <= index:
            self._lines.popleft()
        return _at(self._lines[0], index)

    def ahead(self, index: int) -> float:
        """Return when a sample that is still to come will be heard, as far as is known [s]."""
        return _at(self._lines[-1], index)

    def observe(self, end: int, arrived: float) -> None:
        """Learn that the samples before ``end`` had arrived at a time [s]."""
        self._earliest = min(self._earliest, arrived - self.ahead(end))
        if end - self._lines[-1].index >= WINDOW_S * self._rate:
            self._correct(end)

    def coast(self, end: int) -> None:
        """Go on from ``end`` without corrections: what follows is a gap, known only by the time that it takes."""
        self._measured, self._windows = self.rate, 0
        self.ignore(end)

    def ignore(self, end: int) -> None:
        """Go on from ``end`` without a correction by what was observed since the last: it was late."""
        self._lines.append(_Line(end, self.ahead(end), (1 + self._drift) / self._rate))
        self._earliest = math.inf

    @property
    def rate(self) -> float | None:
        """Samples per second of the Clock [Hz]; None until it is known."""
        if self._windows < SETTLING + MEASURED:
            return self._measured
        index, time = self._origin
        last = self._lines[-1]
        return (last.index - index) / (last.time - time)

    def _correct(self, end: int) -> None:
        error = self._earliest
        self._drift += INTEGRAL * max(-LATE_START_S, min(error, LATE_START_S)) / WINDOW_S
        wanted = self._drift + PROPORTIONAL * error / WINDOW_S
        slew = max(-FASTEST, min(wanted, FASTEST))
        self._lines.append(_Line(end, self.ahead(end), (1 + slew) / self._rate))
        self._earliest = math.inf
        self._windows += 1
        if slew != wanted:  # time does not follow: its rate is not that of the samples
            self._measured, self._windows = None, 0
        if self._windows == SETTLING:
            self._origin = (end, self._lines[-1].time)


def _at(line: _Line, index: int) -> float:
    return line.time + (index - line.index) * line.period
