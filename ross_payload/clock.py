"""The system's clock; the only module of the payload that imports time and starts the pump thread."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

TICK = 0.010  # [s]


@dataclass(slots=True)
class _Periodic:
    period: float
    due: float
    call: Callable[[], None]
    active: bool = field(default=True)


class SystemClock:
    """Monotonic time with one pump thread that runs periodic calls every 10 ms tick."""

    def __init__(self) -> None:
        self._calls: list[_Periodic] = []
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None

    def now(self) -> float:
        """Return the monotonic time [s]."""
        return time.monotonic()

    def sleep(self, duration: float) -> None:
        """Wait for ``duration`` [s]."""
        time.sleep(max(duration, 0.0))

    def every(self, period: float, call: Callable[[], None]) -> Callable[[], None]:
        """Call ``call`` every ``period`` [s] on the pump thread until the returned function is called."""
        periodic = _Periodic(period, self.now() + period, call)
        with self._lock:
            self._calls.append(periodic)
            if self._thread is None:
                self._thread = threading.Thread(target=self._pump, name="pump", daemon=True)
                self._thread.start()

        def cancel() -> None:
            periodic.active = False
            with self._lock:
                if periodic in self._calls:
                    self._calls.remove(periodic)

        return cancel

    def _pump(self) -> None:
        while True:
            with self._lock:
                calls = list(self._calls)
                if not calls:
                    self._thread = None
                    return
            for periodic in calls:
                now = self.now()
                if periodic.active and now >= periodic.due:
                    periodic.due = max(periodic.due + periodic.period, now)
                    periodic.call()
            time.sleep(TICK)
