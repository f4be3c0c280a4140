"""The system's clock; the only module of the payload that imports time and starts the pump thread."""

from __future__ import annotations

import ctypes
import logging
import os
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from typing import Generic, ParamSpec, TypeVar

from ross_payload.errors import RossError
from ross_payload.interfaces import Clock

TICK_S = 0.010  # [s]
LAST_CALL_TIMEOUT_S = 1.0  # so long a cancelled call that hangs is waited for [s]
URGENCY = 10  # real-time priority of the pump, above everything ordinary and below the kernel's own threads
TIMEX = 512  # more than the size of Linux's struct timex [bytes]
UNSYNCHRONISED = 5  # TIME_ERROR of adjtimex
RETRY_S = 0.1  # between two attempts to connect

P = ParamSpec("P")
T = TypeVar("T")
log = logging.getLogger(__name__)


@cache
def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None)


def synchronised_time() -> float | None:
    """Return the UNIX time [s] when the kernel's clock is kept right by NTP or the like, else None."""
    asked = ctypes.create_string_buffer(TIMEX)  # all zero: only ask
    try:
        state = _libc().adjtimex(asked)
    except (OSError, AttributeError):  # not Linux
        return None
    return None if state in (-1, UNSYNCHRONISED) else time.time()


def system_time() -> float:
    """Return the UNIX time [s] that the kernel's clock shows, whether anybody keeps it right or not."""
    return time.time()


def suspended_time() -> float:
    """Return for how long this computer was suspended since it was switched on [s], which a `Clock` does not count."""
    boot_time = getattr(time, "CLOCK_BOOTTIME", None)  # of Linux
    return 0.0 if boot_time is None else time.clock_gettime(boot_time) - time.clock_gettime(time.CLOCK_MONOTONIC)


def hurry(urgency: int = URGENCY) -> bool:
    """Give the calling thread this real-time priority, 1 to 99, and return whether the system allows it.

    Where it does not, the thread goes on as it is.
    """
    with suppress(OSError, AttributeError):  # no right to it, not Linux
        os.sched_setscheduler(0, os.SCHED_RR | os.SCHED_RESET_ON_FORK, os.sched_param(urgency))
        return True
    return False


def may_hurry() -> bool:
    """Return whether the system allows real-time priority; the calling thread keeps its own."""
    found: list[bool] = []
    thread = threading.Thread(target=lambda: found.append(hurry()), name="may-hurry")
    thread.start()
    thread.join()
    return found == [True]


@dataclass(slots=True, eq=False)
class _Periodic:
    period: float
    due: float
    call: Callable[[], None]
    active: bool = field(default=True)
    running: threading.RLock = field(default_factory=threading.RLock)


class SystemClock:
    """Monotonic time with one pump thread that runs periodic calls every 10 ms tick.

    A call that raises is not called again and does not keep the others from being called; what it raised comes out of
    `check`, `sleep` and `every`.
    """

    def __init__(self) -> None:
        self._calls: list[_Periodic] = []
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._failure: Exception | None = None

    def now(self) -> float:
        """Return the monotonic time [s]."""
        return time.monotonic()

    def sleep(self, duration: float) -> None:
        """Wait for ``duration`` [s]."""
        time.sleep(max(duration, 0.0))
        self.check()

    @property
    def failed(self) -> bool:
        """Whether a periodic call has raised."""
        return self._failure is not None

    def check(self) -> None:
        """Raise when a periodic call has raised.

        Raises
        ------
        RuntimeError
            From the first exception of a periodic call.
        """
        if self._failure is not None:
            raise RuntimeError(f"a periodic call failed: {self._failure!r}") from self._failure

    def every(self, period: float, call: Callable[[], None]) -> Callable[[], None]:
        """Call ``call`` every ``period`` [s] on the pump thread until the returned function is called.

        When that returns, the last call is over (but for one that hangs), so that what it used can be closed.
        """
        self.check()
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
            if periodic.running.acquire(timeout=LAST_CALL_TIMEOUT_S):
                periodic.running.release()

        return cancel

    def _pump(self) -> None:
        hurry()
        while True:
            with self._lock:
                calls = list(self._calls)
                if not calls:
                    self._thread = None
                    return
            for periodic in calls:
                with periodic.running:
                    now = self.now()
                    if periodic.active and now >= periodic.due:
                        periodic.due = max(periodic.due + periodic.period, now)
                        self._run(periodic)
            time.sleep(TICK_S)

    def _run(self, periodic: _Periodic) -> None:
        try:
            periodic.call()
        except Exception as error:  # a dead pump would leave every motor without its driver
            periodic.active = False
            self._failure = self._failure or error
            with self._lock:
                if periodic in self._calls:
                    self._calls.remove(periodic)


class RetryingOpener(Generic[P, T]):
    """Opens what a server on this network offers, and waits for the server when it is started after us.

    Only a refused connection is waited for, and only until ``wait`` [s] after this object was made. What has been
    opened once is opened again without waiting.

    >>> def refused(): raise RossError("nobody is there") from ConnectionRefusedError()
    >>> RetryingOpener(refused, SystemClock(), wait=0.0)()
    Traceback (most recent call last):
    ...
    ross_payload.errors.RossError: nobody is there
    """

    def __init__(self, opener: Callable[P, T], clock: Clock, wait: float) -> None:
        self._opener = opener
        self._clock = clock
        self._until = clock.now() + wait
        self._opened: set[object] = set()

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> T:
        """Open, with the arguments of the opener.

        Raises
        ------
        RossError
            What the opener raises, at the end of the wait when nobody listens.
        """
        told = False
        while True:
            try:
                opened = self._opener(*args, **kwargs)
            except RossError as error:
                refused = isinstance(error.__cause__, ConnectionRefusedError)
                if not refused or args in self._opened or self._clock.now() >= self._until:
                    raise
                if not told:
                    log.info("%s; waiting for it", error)
                told = True
                self._clock.sleep(RETRY_S)
            else:
                self._opened.add(args)
                return opened


class Every:
    """Tells when something periodic is due; the first time at once, without drift, without catching up.

    >>> second = Every(1.0)
    >>> [second.due(now) for now in (0.0, 0.9, 1.05, 2.0, 7.0, 7.5)]
    [True, False, True, True, True, False]
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._next: float | None = None

    def due(self, now: float) -> bool:
        """Tell whether it is due at ``now`` [s], once."""
        if self._next is not None and now < self._next - 1e-9:
            return False
        upcoming = now if self._next is None else self._next
        self._next = upcoming + self._period if upcoming + self._period > now else now + self._period
        return True
