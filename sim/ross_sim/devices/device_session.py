"""One simulated device that lives by the wall's clock, and suffers when it is told to."""

from __future__ import annotations

import json
import math
import os
import re
import select
import threading
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any

from ross_payload.clock import SystemClock
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Clock
from ross_payload.notify import on_signal
from ross_sim.devices.connections import Coupling
from ross_sim.devices.far_end import FarEnd, Fault, checked

TICK = 0.004  # [s] between two looks at the wire; a whole number of every far end's own steps
ONCE = (Fault.SLIP, Fault.REBOOT)  # over as soon as they happen
MOST = 4096  # of what is typed in, at once [bytes]
_PLANNED = re.compile(r"(?P<fault>[a-z]+) at (?P<at>\d+(\.\d+)?)( for (?P<time>\d+(\.\d+)?))?")


@dataclass(frozen=True, slots=True, order=True)
class Turn:
    """A fault begins or ends."""

    time: float  # since the device began to live [s]
    fault: Fault
    on: bool


def planned(text: str, faults: frozenset[Fault]) -> list[Turn]:
    """Read ``FAULT at SECONDS`` or ``FAULT at SECONDS for SECONDS``.

    >>> [(turn.time, turn.on) for turn in planned("stall at 3 for 0.5", frozenset(Fault))]
    [(3.0, True), (3.5, False)]

    Raises
    ------
    ConfigError
        When it is anything else, or the device does not know the fault.
    """
    found = _PLANNED.fullmatch(text)
    if found is None:
        raise ConfigError(f'--fault: expected "FAULT at SECONDS" or "FAULT at SECONDS for SECONDS", got "{text}"')
    fault, at = _fault(found["fault"], faults), float(found["at"])
    end = [] if found["time"] is None else [Turn(at + float(found["time"]), fault, False)]
    return [Turn(at, fault, True), *end]


@dataclass(slots=True)
class Console:
    """Lines from a file descriptor, without waiting for them."""

    descriptor: int | None
    _held: str = ""

    def lines(self) -> list[str]:
        """Return the whole lines that have come; none any more after the end of the file."""
        if self.descriptor is None or not select.select([self.descriptor], [], [], 0)[0]:
            return []
        data = os.read(self.descriptor, MOST).decode(errors="replace")
        if not data:
            self.descriptor = None
        *lines, self._held = (self._held + data).split("\n")
        return lines


@dataclass(slots=True)
class DeviceSession:
    """A far end, what connects it, and what is going to happen to it."""

    far_end: FarEnd
    lead: Coupling
    turns: list[Turn]
    console: Console
    print_line: Callable[[str], None]
    _lasting: set[Fault] = field(default_factory=set)
    _now: float = 0.0
    _ticks: int = 0

    def live(self, clock: Clock, epoch: float, ended: Callable[[], bool]) -> None:
        """Live tick by tick until ``ended``; what was missed is made up for."""
        self.turns.sort()
        while not ended():
            self._ticks += 1
            self._now = self._ticks * TICK
            clock.sleep(epoch + self._now - clock.now())
            while self.turns and self.turns[0].time <= self._now:
                turn = self.turns.pop(0)
                self._turn(turn.fault, turn.on)
            for line in self.console.lines():
                self.print_line(json.dumps(self._answer(line.split())))
            self.lead.exchange(self._now)
            self.far_end.advance(self._now)
            self.lead.exchange(self._now)

    def status(self) -> dict[str, Any]:
        """Return what is true."""
        return {
            "time_s": round(self._now, 3),
            "angle_deg": round(math.degrees(self.far_end.angle()), 4),
            "faults": sorted(self._lasting),
            "complaints": self.far_end.complaints(),
        }

    def _answer(self, words: Sequence[str]) -> dict[str, Any]:
        """Obey ``FAULT``, ``FAULT off`` or ``status``."""
        try:
            match words:
                case ["status"]:
                    pass
                case [name]:
                    self._turn(_fault(name, self.far_end.faults), True)
                case [name, "off"]:
                    self._turn(_fault(name, self.far_end.faults), False)
                case _:
                    raise ConfigError(f'expected FAULT, FAULT off, or status, got "{" ".join(words)}"')
        except ConfigError as error:
            return {"error": str(error)}
        return self.status()

    def _turn(self, fault: Fault, on: bool) -> None:
        self.far_end.afflict(fault, on)
        if fault not in ONCE:
            (self._lasting.add if on else self._lasting.discard)(fault)


def live(
    far_end: FarEnd,
    connect: Callable[[float, ExitStack], Coupling],
    turns: list[Turn],
    print_line: Callable[[str], None],
) -> None:
    """Let a device live until SIGINT or SIGTERM; ``connect`` is told its time 0 on the monotonic clock [s]."""
    ended, clock = threading.Event(), SystemClock()
    with on_signal(lambda _: ended.set()), ExitStack() as stack:
        epoch = clock.now()
        session = DeviceSession(far_end, connect(epoch, stack), turns, Console(_descriptor()), print_line)
        session.live(clock, epoch, ended.is_set)


def _fault(name: str, faults: frozenset[Fault]) -> Fault:
    try:
        return checked(Fault(name), faults)
    except ValueError as error:
        there = ", ".join(sorted(faults)) or "none"
        raise ConfigError(f"fault: expected one of {there}, got '{name}'") from error


def _descriptor() -> int | None:
    """Descriptor of the standard input; None when it is closed."""
    try:
        os.fstat(0)
    except OSError:
        return None
    return 0
