"""A guarded device that fails as told, in simulated time."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from ross_payload import config
from ross_payload.actuators.guard import Guard
from ross_payload.errors import LinkError
from ross_payload.interfaces import ActuatorState, Capabilities, Feedback
from ross_sim.clock import SimClock

ABLE = Capabilities(-2.0, 2.0, 10.0, math.radians(100), 1e-6, False, Feedback.MEASURED)


class Device:
    """Teleports to its goal one poll after it was told; fails as told."""

    def __init__(self, capabilities: Capabilities = ABLE) -> None:
        self.capabilities = capabilities
        self.now = ActuatorState(0.0, 0.0, True, True, True, -math.inf)
        self.goal: float | None = None
        self.asked: list[str] = []
        self.jammed = self.silent = self.broken_wire = self.buggy = False
        self.raises: dict[str, Exception] = {}  # by the method that does

    def command(self, angle: float, rate: float | None = None) -> None:
        self._ask("command", f"go {angle:.2f} at {rate:.2f}")
        self.goal = angle

    def state(self) -> ActuatorState:
        if "state" in self.raises:
            raise self.raises["state"]
        return self.now

    def stop(self) -> None:
        self._ask("stop", "stop")
        self.goal = None

    def home(self) -> None:
        self._ask("home", "home")

    def release(self) -> None:
        self._ask("release", "release")

    def poll(self, now: float) -> None:
        if self.broken_wire:
            raise LinkError("the wire is broken")
        if self.buggy:
            raise ZeroDivisionError
        if not self.silent:
            angle = self.now.angle if self.goal is None or self.jammed else self.goal
            self.now = replace(self.now, angle=angle, settled=not self.jammed, time=now)

    def __enter__(self) -> Device:
        return self

    def __exit__(self, *_: object) -> None:
        self.asked.append("close")

    def _ask(self, method: str, what: str) -> None:
        if self.broken_wire:
            raise LinkError("the wire is broken")
        if method in self.raises:
            raise self.raises[method]
        self.asked.append(what)


@dataclass
class Bench:
    clock: SimClock
    device: Device
    guard: Guard


def bench(device: Device | None = None, **rules: Any) -> Bench:
    clock, device = SimClock(), device or Device()
    guard = Guard(device, config.Guard.model_validate(rules), clock)
    guard.__enter__()
    clock.every(0.01, lambda: guard.poll(clock.now()))
    clock.sleep(0.05)
    return Bench(clock, device, guard)
