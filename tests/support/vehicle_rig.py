"""The guarded driver of a vehicle that yaws, in simulated time, and the autopilot and the pilot at its far end."""

from __future__ import annotations

import math

from ross_payload.actuators.registry import open_actuator
from ross_payload.config import Config
from ross_payload.interfaces import ActuatorState, Services
from ross_sim.autopilot.flight_modes import Copter, Px4
from ross_sim.autopilot.yaw_dynamics import Airframe, YawDynamics
from ross_sim.clock import QUANTUM, SimClock
from ross_sim.devices.vehicle_far_end import VehicleFarEnd

AIRFRAME = Airframe(max_speed=math.radians(60), max_acceleration=math.radians(90), torque=math.radians(300))
KINDS = ("ardupilot", "hold", "offboard")
LATENCY = 0.02  # of the link, each way [s]


class Bench:
    """A guarded driver, its far end, and what both have said."""

    def __init__(
        self,
        kind: str = "ardupilot",
        *,
        airframe: Airframe = AIRFRAME,
        latency: float = 0.0,
        wait: float = 1.5,
        **options: object,
    ) -> None:
        body = YawDynamics(airframe)
        self.modes = Copter(body) if kind == "ardupilot" else Px4(body)
        self.far_end = VehicleFarEnd(self.modes, offboard=kind == "offboard", latency=latency)
        told = {"turn_vehicle": True, "px4_mode": "offboard" if kind == "offboard" else "hold"} | options
        self.config = Config.model_validate({"actuator": {"kind": "vehicle_yaw", "options": told}})
        self.clock = SimClock()
        self.clock.before_calls(self.far_end.advance)
        self.actuator = open_actuator(self.config, Services(self.clock, lambda url: self.far_end.port))
        self.actuator.__enter__()
        self.cancel = self.clock.every(QUANTUM, lambda: self.actuator.poll(self.clock.now()))
        self.clock.sleep(wait)

    @property
    def state(self) -> ActuatorState:
        return self.actuator.state()

    @property
    def yaw_deg(self) -> float:
        """The true yaw, counter-clockwise from north."""
        return math.degrees(self.far_end.angle())

    def turn(self, goal_deg: float, within: float = 15.0) -> None:
        """Go somewhere and wait until it is there."""
        self.actuator.command(math.radians(goal_deg))
        end = self.clock.now() + within
        while not self.state.settled:
            assert self.state.healthy, self.state
            assert self.clock.now() < end, self.state
            self.clock.sleep(QUANTUM)

    def fault(self, within: float) -> float:
        """Wait for a fault; how long that took [s]."""
        begin = self.clock.now()
        while self.state.healthy:
            assert self.clock.now() - begin < within, self.state
            self.clock.sleep(QUANTUM)
        return self.clock.now() - begin

    def orders(self, since: float = -math.inf) -> list[str]:
        """Orders to turn and to stop that have come to the autopilot."""
        return [what for when, what in self.far_end.orders if when > since]


def in_a_turn(kind: str, phase: float, *, ignores_stick: bool = False) -> Bench:
    """A bench whose vehicle turns, ``phase`` [s] later than it is fast, over a link that takes its time."""
    bench = Bench(kind, latency=LATENCY, wait=1.2 if kind == "offboard" else 0.6)
    bench.modes.ignores_stick = ignores_stick
    bench.actuator.command(math.radians(190))
    bench.clock.sleep(1.0 + phase)
    assert bench.state.rate > 0.3
    return bench
