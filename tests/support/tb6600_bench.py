"""A TB6600 driver and an emulated module with its motor, in simulated time."""

from __future__ import annotations

import math
from typing import Any, Self

import numpy as np

from ross_payload.actuators.guard import Guard
from ross_payload.actuators.registry import checked_options, open_actuator
from ross_payload.actuators.tb6600.pulse_segments import PulseLine
from ross_payload.config import Config
from ross_payload.interfaces import Services
from ross_sim.clock import QUANTUM, SimClock
from ross_sim.devices.stepper import Motor
from ross_sim.devices.tb6600_far_end import Tb6600FarEnd, far_end


class Turning:
    """What is alike in every bench of a stepper: going somewhere, and where it truly stands."""

    clock: SimClock
    guard: Guard
    far: Tb6600FarEnd

    def go(self, goal_deg: float, duration: float = 5.0) -> Self:
        self.guard.command(math.radians(goal_deg))
        self.clock.sleep(duration)
        return self

    @property
    def true_deg(self) -> float:
        return math.degrees(self.far.angle())


class Bench(Turning):
    """A driver in its guard, a module and a motor, in simulated time."""

    def __init__(self, motor: Motor | None = None, guard: dict[str, Any] | None = None, **options: Any) -> None:
        caps = {"max_speed_deg_s": 1e5, "max_acceleration_deg_s2": 1e6} | (guard or {})
        config = Config.model_validate({"actuator": {"kind": "tb6600", "options": options}, "guard": caps})
        self.clock = SimClock()
        self.far: Tb6600FarEnd = far_end.make(checked_options(config), motor)
        self.clock.before_calls(self.far.advance)
        self.guard: Guard = open_actuator(config, Services(self.clock, lambda url: self.far.port))
        self.guard.__enter__()
        self.cancel = self.clock.every(QUANTUM, lambda: self.guard.poll(self.clock.now()))
        self.clock.sleep(0.2)

    def edges(self) -> np.ndarray:
        """All edges sent, times on the clock."""
        parts = [segment.edges.copy() for segment in self.far.port.sent]
        for part, segment in zip(parts, self.far.port.sent, strict=True):
            part["time"] += segment.start
        return np.concatenate(parts)

    def rises(self) -> np.ndarray:
        edges = self.edges()
        times: np.ndarray = edges["time"][(edges["line"] == PulseLine.STEP) & edges["level"]]
        return times
