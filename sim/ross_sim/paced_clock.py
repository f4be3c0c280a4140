"""Simulated time at the pace of the wall's clock: faster or slower by a factor that may change on the way."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from typing import Self

from ross_payload.clock import SystemClock, hurry
from ross_payload.interfaces import Clock
from ross_sim.clock import QUANTUM, SimClock

LAST_CALL_S = 1.0  # that a cancelled call may take, and the thread at the end
YIELD_S = 5e-5  # between two quanta, however late it is: else nobody who waits for the pump has a turn
NAP_S = 0.1  # at most between two looks at whether the pace has changed, or all is over

Speed = Callable[[], float]  # times real time; inf: nothing is waited for


class Pacer:
    """Tells when simulated time should be where; it goes on from where it is when the speed changes.

    One thread calls `delay`; `now` is for all.

    >>> class Wall:
    ...     time = 100.0
    ...     now = lambda self: self.time
    >>> wall, speed = Wall(), [4.0]
    >>> pacer = Pacer(lambda: speed[0], wall)
    >>> pacer.delay(2.0)
    0.5
    >>> wall.time, speed[0] = 100.5, 1.0
    >>> pacer.delay(2.0), pacer.delay(3.0)
    (0.0, 1.0)
    """

    def __init__(self, speed: Speed, wall: Clock, begin: float = 0.0) -> None:
        self._wanted = speed
        self._wall = wall
        self._anchor = (wall.now(), begin, speed())  # on the wall's clock [s], simulated [s], from there on at
        self._latest = begin  # that was asked for [s]

    def delay(self, time: float) -> float:
        """Return how long to wait until the simulated ``time`` [s], on the wall's clock; negative: it is late."""
        self._latest, speed = time, self._wanted()
        if speed != self._anchor[2]:
            self._anchor = (self._wall.now(), min(time, self.now()), speed)
        since, begin, _ = self._anchor
        return since + (time - begin) / speed - self._wall.now()

    def now(self) -> float:
        """Return the simulated time that it should be [s]; when nothing is waited for, that it is."""
        since, begin, speed = self._anchor
        return self._latest if math.isinf(speed) else begin + (self._wall.now() - since) * speed


class RealTimeClock:
    """A Clock that a thread of its own moves on, as the pump of `ross run` does: nobody who computes delays it.

    Everything that is called periodically, and what lives on the simulated clock, runs on that thread; what fails there
    ends it, and comes out of `check` and `sleep`. It skips no quantum: what is late is made up for. A context manager.

    Parameters
    ----------
    simulated
        Moved on; nobody else may do that.
    speed
        Times real time, finite.
    ahead
        Time by which what `on_progress` reports may be behind before it is waited for [s].
    """

    def __init__(self, simulated: SimClock, speed: Speed, ahead: float = math.inf) -> None:
        self._simulated = simulated
        self._wall = SystemClock()
        self._pacer = Pacer(speed, self._wall, simulated.now())
        self._ahead = ahead
        self._progress: float | None = None
        self._moved = threading.Condition(threading.RLock())  # held while time moves on
        self._failure: Exception | None = None
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._work, name="pump", daemon=True)

    def now(self) -> float:
        """Return the simulated time [s]."""
        return self._simulated.now()

    def on_progress(self, time: float) -> None:
        """Learn how far those are who must not miss anything [s]."""
        self._progress = time

    def sleep(self, duration: float) -> None:
        """Wait for ``duration`` [s] of simulated time.

        Raises
        ------
        RuntimeError
            When time does not move on any more.
        """
        end = self.now() + duration - QUANTUM * 1e-6
        with self._moved:
            while self.now() < end:
                self.check()
                self._moved.wait(NAP_S)

    def every(self, period: float, call: Callable[[], None]) -> Callable[[], None]:
        """Call ``call`` every ``period`` [s] until the returned function is called, which waits for a call."""
        with self._moved:
            stop = self._simulated.every(period, call)

        def cancel() -> None:
            stop()
            if self._moved.acquire(timeout=LAST_CALL_S):
                self._moved.release()

        return cancel

    def check(self) -> None:
        """Raise when time does not move on any more.

        Raises
        ------
        RuntimeError
            From the exception of a periodic call, or since the simulation has ended.
        """
        if self._failure is not None:
            raise RuntimeError(f"a periodic call failed: {self._failure!r}") from self._failure
        if self._over.is_set():
            raise RuntimeError("the simulation has ended")

    def __enter__(self) -> Self:
        """Let time move on."""
        self._thread.start()
        return self

    def __exit__(self, *exception: object) -> None:
        """Let it stand still."""
        self._over.set()
        self._thread.join(LAST_CALL_S)

    def _work(self) -> None:
        hurry()
        while not self._over.is_set():
            wait = self._wait()
            if wait > 0:
                self._over.wait(min(wait, NAP_S))
                continue
            try:
                with self._moved:
                    self._simulated.advance()
                    self._moved.notify_all()
            except Exception as error:  # for whoever waits
                self._failure = error
                return
            self._over.wait(YIELD_S)

    def _wait(self) -> float:
        """How long the next quantum has to wait, at least [s]."""
        progress = self._progress
        if progress is not None and self.now() - progress > self._ahead:
            return QUANTUM
        return self._pacer.delay(self.now() + QUANTUM)
