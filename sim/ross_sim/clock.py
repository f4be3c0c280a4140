"""A clock that moves only when somebody reads audio or sleeps, and what drives it by the clock of the wall."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable

from ross_payload.interfaces import Clock

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


BEHIND = 0.030  # [s]; so long may what a payload sends be on its way
LATE = 0.1  # [s] beyond that before it is worth a word
SILENCE = 5.0  # [s] between two words


class RealTimeDriver:
    """Advances a simulated clock in quanta of 10 ms, each `BEHIND` after it is over on the wall's clock.

    A world that cannot keep up skips nothing: it is late, says by how much, and catches up when it can.

    Parameters
    ----------
    simulated
        Driven.
    wall
        Drives; the simulated time 0 is now.
    warn
        Takes a line for the user.
    """

    def __init__(self, simulated: SimClock, wall: Clock, warn: Callable[[str], None]) -> None:
        self._simulated = simulated
        self._wall = wall
        self._warn = warn
        self._silent_until = -SILENCE
        self.epoch = wall.now() - simulated.now()  # of simulated time 0, on the wall's clock [s]
        self.worst = 0.0  # lateness so far [s]

    def step(self, before: Callable[[float], None], after: Callable[[], None]) -> None:
        """Wait for one quantum and live it; ``before`` is told when it begins [s]."""
        begin = self._simulated.now()
        due = self.epoch + begin + QUANTUM + BEHIND
        self._wall.sleep(due - self._wall.now())
        before(begin)
        self._simulated.advance()
        after()
        self._judge(self._wall.now() - due)

    def _judge(self, late: float) -> None:
        self.worst = max(self.worst, late)
        if late > LATE and self._wall.now() > self._silent_until:
            self._silent_until = self._wall.now() + SILENCE
            self._warn(f"the world is {late:.2f} s late: this computer does not keep up")
