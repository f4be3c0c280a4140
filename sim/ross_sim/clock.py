"""A clock that moves only when somebody reads audio or sleeps; single-threaded and identical on a rerun."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable

QUANTUM = 0.010  # [s]


class SimClock:
    """Simulated time in quanta of 10 ms.

    Every quantum runs in the same order: the world (far ends, plant, audio) advances, then the periodic calls that
    are due run in time order, ties by registration. Time is counted in whole quanta, so it never drifts.

    >>> clock = SimClock()
    >>> heard = []
    >>> cancel = clock.every(0.02, lambda: heard.append(round(clock.now(), 3)))
    >>> clock.sleep(0.05)
    >>> heard
    [0.02, 0.04]
    """

    def __init__(self) -> None:
        self._quanta = 0
        self._order = itertools.count()
        self._due: list[tuple[int, int, int, Callable[[], None]]] = []  # (due, order, period, call)
        self._cancelled: set[int] = set()
        self._worlds: list[Callable[[float], None]] = []

    def now(self) -> float:
        """Return the simulated time [s]."""
        return self._quanta * QUANTUM

    def sleep(self, duration: float) -> None:
        """Advance by ``duration`` [s], rounded up to whole quanta."""
        for _ in range(-int(-duration / QUANTUM * (1 - 1e-9) // 1)):
            self.advance()

    def every(self, period: float, call: Callable[[], None]) -> Callable[[], None]:
        """Call ``call`` every ``period`` [s], at least one quantum, until the returned function is called."""
        quanta = max(round(period / QUANTUM), 1)
        order = next(self._order)
        heapq.heappush(self._due, (self._quanta + quanta, order, quanta, call))
        return lambda: self._cancelled.add(order)

    def before_calls(self, world: Callable[[float], None]) -> None:
        """Register what advances first in each quantum, called with the time at the quantum's end [s]."""
        self._worlds.append(world)

    def advance(self) -> None:
        """Advance by one quantum."""
        self._quanta += 1
        for world in self._worlds:
            world(self.now())
        while self._due and self._due[0][0] <= self._quanta:
            due, order, period, call = heapq.heappop(self._due)
            if order in self._cancelled:
                self._cancelled.discard(order)
                continue
            heapq.heappush(self._due, (due + period, order, period, call))
            call()
