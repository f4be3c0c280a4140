"""What systemd is told: ready, what we do, that we live, that we stop; the protocol of sd_notify(3). And its signals.

Without ``$NOTIFY_SOCKET`` nothing is sent. A word that cannot be sent is lost: nobody's mission ends for it.
"""

from __future__ import annotations

import os
import signal
import socket
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future, wait
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import TypeVar

from ross_payload.end_signals import caught_signal, end_signals
from ross_payload.events import Event, StateChanged
from ross_payload.interfaces import Cancel, Clock, Input

T = TypeVar("T")

SIGNAL_LATENCY_S = 0.1  # [s] within which a signal is heard, whichever thread the system gave it to
SEND_TIMEOUT_S = 0.1  # [s] that a full socket of the manager may hold us up
PINGS = 4  # in one period of the manager's watchdog: three may be late
MISSION = "mission"  # its mark in `Watchdog`


@dataclass(frozen=True, slots=True)
class Manager:
    """The service manager; each word is one datagram.

    >>> Manager("").ready("idle")  # not started by systemd: nobody is told
    False
    """

    address: str  # of $NOTIFY_SOCKET; "@" stands for the zero byte of an abstract socket
    period: float | None = None  # [s] after which it takes silence for death; None: never

    @classmethod
    def of(cls, environment: Mapping[str, str] = os.environ) -> Manager:
        """Return the manager that started this process; one that nobody can be told of otherwise."""
        text = environment.get("WATCHDOG_USEC", "")
        meant = environment.get("WATCHDOG_PID", "") in ("", str(os.getpid()))
        period = int(text) * 1e-6 if text.isdecimal() and int(text) and meant else None
        return cls(environment.get("NOTIFY_SOCKET", ""), period)

    def ready(self, status: str) -> bool:
        """Say that everything is open and orders are welcome."""
        return self._send(f"READY=1\nSTATUS={_line(status)}")

    def status(self, status: str) -> bool:
        """Say in one line what we do."""
        return self._send(f"STATUS={_line(status)}")

    def alive(self) -> bool:
        """Ping the watchdog."""
        return self._send("WATCHDOG=1")

    def stopping(self, status: str) -> bool:
        """Say that the end has begun."""
        return self._send(f"STOPPING=1\nSTATUS={_line(status)}")

    def _send(self, text: str) -> bool:
        if not self.address:
            return False
        where = "\0" + self.address[1:] if self.address.startswith("@") else self.address
        try:
            with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as wire:
                wire.settimeout(SEND_TIMEOUT_S)
                wire.sendto(text.encode(), where)
        except OSError:
            return False
        return True


class Watchdog:
    """Pings the manager only while everybody who must make progress does; an observer of the mission.

    `mark` is called by whoever makes progress, on its own thread; `poll` belongs to the pump, so a pump that hangs
    pings no more either.

    Parameters
    ----------
    manager, clock
        Whom to tell, and the time.
    limits : mapping
        How long each may take from one mark to the next [s]; a name that is not in it is not watched.
    """

    def __init__(self, manager: Manager, clock: Clock, limits: Mapping[str, float]) -> None:
        self._manager = manager
        self._clock = clock
        self._limits = dict(limits)
        self._marks = dict.fromkeys(limits, clock.now())

    def mark(self, name: str) -> None:
        """Note that ``name`` makes progress."""
        self._marks[name] = self._clock.now()

    def late(self) -> tuple[str, ...]:
        """Return who has made no progress for too long."""
        now = self._clock.now()
        return tuple(name for name, limit in self._limits.items() if now - self._marks[name] > limit)

    def silent(self, name: str) -> float:
        """Return for how long ``name`` has made no progress [s]."""
        return self._clock.now() - self._marks[name]

    def poll(self) -> None:
        """Ping, or say who is late."""
        late = self.late()
        if late:
            self._manager.status(f"no progress: {', '.join(late)}")
        else:
            self._manager.alive()

    def start(self) -> Cancel | None:
        """Poll on the pump as often as the manager's period asks; None when nobody watches."""
        period = self._manager.period
        return None if period is None else self._clock.every(period / PINGS, self.poll)

    def on_input(self, hop: Input) -> None:
        """One hop was heard: the mission makes progress."""
        self.mark(MISSION)

    def on_event(self, event: Event, hop: Input) -> None:
        """Tell the manager what the mission does."""
        if isinstance(event, StateChanged):
            state = event.state.name.lower().replace("_", " ")
            self._manager.status(f"{state}: {event.detail}" if event.detail else state)


def _line(text: str) -> str:
    """One line of printable text: a line break would begin another assignment."""
    return "".join(char if char.isprintable() else " " for char in text)


@contextmanager
def on_signal(call: Callable[[str], object]) -> Iterator[None]:
    """Call ``call`` with the name of every signal to end; afterwards they mean what they meant before.

    One that has come before, and has interrupted nobody, counts.
    """
    missed = caught_signal()

    def handle(number: int, frame: FrameType | None) -> None:
        call(signal.Signals(number).name)

    before = {number: signal.signal(number, handle) for number in end_signals()}
    try:
        if missed is not None:
            call(missed.name)
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def beside(call: Callable[[], T], name: str) -> Future[T]:
    """Call on a thread of its own, which dies with the process; return where the result will be."""
    future: Future[T] = Future()

    def perform() -> None:
        try:
            future.set_result(call())
        except BaseException as error:  # whoever waits for the result handles it
            future.set_exception(error)

    threading.Thread(target=perform, name=name, daemon=True).start()
    return future


def hearing_signals(future: Future[T]) -> T:
    """Return the result of a future, on the main thread, which goes on hearing signals.

    Python calls what handles a signal on the main thread. The system may give the signal to any other one, which does
    not wake the main thread where that waits for a lock without a limit.
    """
    while not wait([future], SIGNAL_LATENCY_S).done:
        pass
    return future.result()
