"""Clocks that a test moves."""

from __future__ import annotations

from collections.abc import Callable

from ross_payload.clock import SystemClock


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
