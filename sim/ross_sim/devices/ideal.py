"""An actuator without faults: follows the ideal trapezoid exactly and measures where it is.

Driver and device speak over an in-process wire like any other pair, so that the guard, the watchdog and the contract
see a report that can be late or missing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, Self

from pydantic import Field

from ross_payload.actuators.motion import Trapezoid
from ross_payload.config import Degrees, Positive, Table
from ross_payload.interfaces import Actuator, ActuatorState, Capabilities, Feedback, Port, Services
from ross_sim.devices.far_end import SLIP, Fault, WireEnd, checked

RESOLUTION = 1e-6  # [rad]


class Options(Table):
    """[actuator.options] of ``ideal``."""

    port: str = "ideal:"
    max_speed_deg_s: Positive = 225.0
    max_acceleration_deg_s2: Positive = 112.5
    lower_deg: Annotated[Degrees, Field(le=0)] = -720.0
    upper_deg: Annotated[Degrees, Field(ge=0)] = 720.0


@dataclass(frozen=True, slots=True)
class Goal:
    """Driver to device: go there."""

    angle: float  # [rad]
    speed: float  # [rad/s]
    acceleration: float  # [rad/s^2]


@dataclass(frozen=True, slots=True)
class Halt:
    """Driver to device: decelerate to rest."""

    acceleration: float  # [rad/s^2]


@dataclass(frozen=True, slots=True)
class Report:
    """Device to driver: where it is."""

    angle: float  # [rad]
    rate: float  # [rad/s]
    time: float  # [s]


class IdealActuator:
    """The driver: sends goals, remembers the last report."""

    def __init__(self, options: Options, services: Services) -> None:
        self._services = services
        self._url = options.port
        self._port: Port | None = None
        self._goal: float | None = None
        self._report = Report(0.0, 0.0, -math.inf)
        self.capabilities = Capabilities(
            lower=math.radians(options.lower_deg),
            upper=math.radians(options.upper_deg),
            max_speed=math.radians(options.max_speed_deg_s),
            max_acceleration=math.radians(options.max_acceleration_deg_s2),
            resolution=RESOLUTION,
            continuous=False,
            feedback=Feedback.MEASURED,
        )

    def command(self, angle: float, rate: float | None = None) -> None:
        """Go to a joint angle [rad], at most at ``rate`` [rad/s]."""
        self._goal = angle
        speed = min(rate or math.inf, self.capabilities.max_speed)
        self._send(Goal(angle, speed, self.capabilities.max_acceleration))

    def state(self) -> ActuatorState:
        """Return the last report."""
        report, goal = self._report, self._goal
        settled = report.rate == 0.0 and (goal is None or abs(report.angle - goal) <= RESOLUTION)
        return ActuatorState(report.angle, report.rate, settled, homed=True, healthy=True, time=report.time)

    def stop(self) -> None:
        """Decelerate to rest and forget the goal."""
        self._goal = None
        self._send(Halt(self.capabilities.max_acceleration))

    def home(self) -> None:
        """Return at once: an ideal encoder knows its zero."""

    def release(self) -> None:
        """Decelerate: an ideal bearing stays where it is without torque."""
        self.stop()

    def poll(self, now: float) -> None:
        """Take in the reports that have arrived."""
        for report in self._port.receive() if self._port else ():
            self._report = report

    def __enter__(self) -> Self:
        """Open the wire."""
        self._port = self._services.open_port(self._url)
        self._report = Report(self._report.angle, 0.0, -math.inf)
        return self

    def __exit__(self, *exception: object) -> None:
        """Stop and close the wire."""
        if self._port is None:
            return
        try:
            self.stop()
        finally:
            port, self._port = self._port, None
            port.close()

    def _send(self, frame: Goal | Halt) -> None:
        if self._port is not None:
            self._port.send(frame)


class IdealFarEnd:
    """The device: moves exactly as planned, reports at every advance."""

    faults = frozenset({Fault.SILENT, Fault.STUCK, Fault.SLIP})

    def __init__(self) -> None:
        self.port = WireEnd()
        self._suffers: set[Fault] = set()
        self._slipped = 0.0  # [rad]
        self._now = 0.0
        self._since = 0.0
        self._plan = Trapezoid(0.0, 0.0, 1.0, 1.0)

    def advance(self, now: float) -> None:
        """Obey what has arrived since the last advance, then live until ``now`` [s] and report."""
        frames, self.port.sent = self.port.sent, []
        for frame in frames:
            position, velocity = self._plan.at(self._now - self._since)
            self._since = self._now
            if isinstance(frame, Goal) and Fault.STUCK not in self._suffers:
                self._plan = Trapezoid(position, frame.angle, frame.speed, frame.acceleration, velocity)
            else:
                self._plan = Trapezoid.to_rest(position, velocity, frame.acceleration)
        self._now = now
        if Fault.SILENT not in self._suffers:
            self.port.arrived.append(Report(*self._plan.at(now - self._since), now))

    def angle(self) -> float:
        """Return the true joint angle [rad]."""
        return self._plan.at(self._now - self._since)[0] + self._slipped

    def afflict(self, fault: Fault, on: bool = True) -> None:
        """Fall silent, stick where it is, or slip: its sensor is on the motor's side."""
        if checked(fault, self.faults) is Fault.SLIP:
            self._slipped += SLIP if on else 0.0
            return
        if fault is Fault.STUCK and on:
            here = self._plan.at(self._now - self._since)[0]
            self._plan = Trapezoid(here, here, 1.0, 1.0)
        (self._suffers.add if on else self._suffers.discard)(fault)

    def complaints(self) -> list[str]:
        """Return nothing: nothing ever goes wrong."""
        return []

    @classmethod
    def make(cls, config: Options) -> IdealFarEnd:
        """Make the device at joint angle 0."""
        return cls()


class IdealBackend:
    """Ideal turntable for simulations: follows the trapezoid exactly and measures where it is."""

    Config: type[Any] = Options

    def open(self, config: Options, services: Services) -> Actuator:
        """Make the driver."""
        return IdealActuator(config, services)


backend = IdealBackend()
far_end = IdealFarEnd
