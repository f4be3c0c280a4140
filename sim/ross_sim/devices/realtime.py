"""A simulated clock driven by the wall's, a little behind it."""

from __future__ import annotations

from collections.abc import Callable

from ross_payload.interfaces import Clock
from ross_sim.clock import QUANTUM, SimClock

BEHIND = 0.030  # [s]; so long may what a payload sends be on its way
LATE = 0.1  # [s] beyond that before it is worth a word
SILENCE = 5.0  # [s] between two words


class RealTime:
    """Advances a simulated clock in quanta of 10 ms, each `BEHIND` after it is over on the wall's clock.

    A world that cannot keep up skips nothing: it is late, says by how much, and catches up when it can.

    Parameters
    ----------
    simulated
        Driven.
    wall
        Drives; the simulated time 0 is now.
    say
        Takes a line for the user.
    """

    def __init__(self, simulated: SimClock, wall: Clock, say: Callable[[str], None]) -> None:
        self._simulated = simulated
        self._wall = wall
        self._say = say
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
            self._say(f"the world is {late:.2f} s late: this computer does not keep up")
