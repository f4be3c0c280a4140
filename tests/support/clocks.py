"""Clocks that a test moves."""

from __future__ import annotations

from collections.abc import Callable

from ross_payload.clock import SystemClock
from ross_sim.clock import QUANTUM, SimClock


class FakeClock:
    """Stands still until it is moved: by ``sleep``, or by setting ``time`` [s]."""

    def __init__(self, time: float = 0.0) -> None:
        self.time = time

    def now(self) -> float:
        """Return the time [s]."""
        return self.time

    def sleep(self, duration: float) -> None:
        """Move on."""
        self.time += max(duration, 0.0)

    def every(self, period: float, call: Callable[[], None]) -> Callable[[], None]:
        """Refuse: what is tested with this clock is polled."""
        raise AssertionError("nothing calls itself on a clock that stands still")


class LeapingClock(SystemClock):
    """Real time that can be moved on, so that nobody waits for a pause."""

    def __init__(self) -> None:
        super().__init__()
        self.ahead = 0.0

    def now(self) -> float:
        """Return the monotonic time and what it was moved on [s]."""
        return super().now() + self.ahead


class StallingClock(SimClock):
    """Simulated time on a computer that can stand still; what is simulated makes up for it, a few quanta in one."""

    PORTION = 6  # quanta

    def __init__(self) -> None:
        super().__init__()
        self._late = self._portion = 0  # quanta by which the world is late; which it makes up for in this one

    def before_calls(self, world: Callable[[float], None]) -> None:
        """Register a world that is late after a pause."""

        def live(now: float) -> None:
            for n in range(self._portion, -1, -1):
                world(now - (self._late + n) * QUANTUM)

        super().before_calls(live)

    def advance(self) -> None:
        """Advance by one quantum, the world by more where it is late."""
        self._portion = min(self._late, self.PORTION)
        self._late -= self._portion
        super().advance()

    def stand_still(self, duration: float) -> None:
        """Let time pass [s] in which nothing lives and nobody calls."""
        quanta = round(duration / QUANTUM)
        self._quanta += quanta
        self._late += quanta
        self._due = [(due + quanta, *call) for due, *call in self._due]
