"""Guarded actuators with their simulated far ends, in simulated time: what the contract and the fault tests drive."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from clocks import StallingClock
from examples import in_soak
from ross_payload import plugins
from ross_payload.actuators.guard import Guard
from ross_payload.actuators.registry import checked_options, open_actuator
from ross_payload.config import Config
from ross_payload.interfaces import ActuatorState, Clock, Port, Services
from ross_sim.clock import QUANTUM
from ross_sim.devices.far_end import FarEnd

# Back ends, with their role where they have several.
KINDS = (
    "ideal",
    "tb6600",
    "tb6600:switch",
    "mavlink_gimbal",
    "mavlink_gimbal:manager",
    "dronecan_servo",
    "dronecan_servo:gimbal",
    "grbl",
    "canopen_drive",
    "vehicle_yaw",
    "vehicle_yaw:offboard",
)
NIMBLE = {  # a vehicle that turns as fast as what the contract was written for
    "turn_vehicle": True,
    "max_speed_deg_s": 90.0,
    "max_acceleration_deg_s2": 112.5,
    "resolution_deg": 0.5,
    "settle_ms": 200.0,
}
ROLES: dict[str, dict[str, Any]] = {  # options of each
    "manager": {"role": "manager"},
    "gimbal": {"command": "gimbal"},
    "model": {"feedback": "model"},
    "offboard": {"px4_mode": "offboard"},
    "switch": {"zero": "switch", "home_offset_deg": -9.0, "home_speed_deg_s": 25.0},  # opened quickest
}
SPEED, ACCELERATION = math.radians(225), math.radians(112.5)
LOWER, UPPER = math.radians(-200), math.radians(200)
OPTIONS: dict[str, dict[str, Any]] = {"vehicle_yaw": NIMBLE}  # of every role
SPEEDS = {
    "mavlink_gimbal": math.radians(90),
    "vehicle_yaw": math.radians(90),
}  # of back ends that are slower than the paper's
OPENING = {"canopen_drive": 0.8, "vehicle_yaw": 2.0}  # of what is asked and told a lot before it is ready [s]
LAG = {
    "vehicle_yaw": 0.8,
    "mavlink_gimbal": 0.3,
    "canopen_drive": 0.1,
}  # of what creeps into its goal, or is enabled by it [s]
RIPPLE = {"vehicle_yaw": 0.1, "mavlink_gimbal": 0.04, "canopen_drive": 0.04, "grbl": 0.03}  # of a measured rate [rad/s]
LATE = {
    "vehicle_yaw": 0.1,
    "grbl": 0.02,
}  # of travel beyond 100 ms: steps that grbl has prepared cannot be taken back [s]
SEARCH = 20.0  # for a switch [s]
HOMING = 2.5  # of what does not know where it is [s]
SWING = math.radians(0.5)  # by which a rotor may swing about its windings while it moves


def kinds(*named: str) -> list[object]:
    """Return every back end, and of the roles that one has beside its first those that are named; others in soak."""
    now = [kind for kind in KINDS if ":" not in kind or kind in named]
    return [*now, *in_soak(*(kind for kind in KINDS if kind not in now))]


class CuttableWire:
    """A wire that stops delivering when it is cut, takes nothing when it is one-way, and neither when it is severed."""

    def __init__(self, port: Port | None = None) -> None:
        self._port = port
        self.cut = self.severed = self.one_way = False

    def plug(self, port: Port) -> None:
        self._port = port

    def send(self, frame: Any) -> None:
        assert self._port
        if not (self.severed or self.one_way):
            self._port.send(frame)

    def receive(self) -> list[Any]:
        assert self._port
        arrived = self._port.receive()
        return [] if self.cut or self.severed else arrived

    def close(self) -> None:
        assert self._port
        self._port.close()


@dataclass
class Rig:
    """A guarded actuator, its far end and simulated time."""

    clock: Clock
    far_end: FarEnd
    wire: CuttableWire
    actuator: Guard
    lag: float = 0.0  # [s]
    ripple: float = 0.0  # [rad/s]
    speed: float = SPEED  # [rad/s]
    late: float = 0.0  # [s]
    upper: float = UPPER  # a goal near the end of the travel [rad]
    opening: float = 0.2  # [s]
    patience: float = 1.0  # times what is allowed for settling
    held_up: bool = False  # nobody polls

    def open(self) -> Rig:
        self.actuator.__enter__()
        self.clock.sleep(self.opening)
        if not self.state.homed:
            self.home()
            self.clock.sleep(HOMING)
            self.actuator.command(0.0)
            self.settle(within=5.0)
        return self

    def pause(self, duration: float) -> None:
        """Have the payload do nothing for a while [s], as on a computer that has no time for it."""
        self.held_up = True
        self.clock.sleep(duration)
        self.held_up = False

    def home(self) -> None:
        """Home, and wait until the zero is known and it stands there."""
        self.actuator.home()
        self.clock.sleep(0.5)
        end = self.clock.now() + SEARCH
        while not self.state.homed or (self.state.healthy and not self.state.settled):
            assert self.clock.now() < end, self.state
            self.clock.sleep(QUANTUM)

    @property
    def state(self) -> ActuatorState:
        return self.actuator.state()

    @property
    def tolerance(self) -> float:
        """Half a step, and half of one more at a limit."""
        return self.actuator.capabilities.resolution * 1.01

    def settle(self, within: float) -> float:
        """Wait until settled; how long it took [s]."""
        begin = self.clock.now()
        while not self.state.settled:
            assert self.clock.now() - begin < within * self.patience, self.state
            self.clock.sleep(QUANTUM)
        return self.clock.now() - begin


def options_of(kind: str, role: str) -> dict[str, Any]:
    """The options of a back end in one of its roles."""
    return OPTIONS.get(kind, {}) | ROLES.get(role, {})


def rig_of(kind: str, **guard: Any) -> Rig:
    kind, _, role = kind.partition(":")
    options = options_of(kind, role)
    config = Config.model_validate({"actuator": {"kind": kind, "options": options}, "guard": guard})
    clock = StallingClock()
    plugin = plugins.load("ross_sim.far_ends", kind)
    far_end: FarEnd = plugin.make(checked_options(config))
    clock.before_calls(far_end.advance)
    wire = CuttableWire(far_end.port)
    actuator = open_actuator(config, Services(clock, lambda url: wire))
    told = getattr(plugin, "slack", {})  # of a plug-in: what its device needs
    slack = LAG.get(kind, told.get("lag", 0.0)), RIPPLE.get(kind, told.get("ripple", 0.0))
    late, opening = LATE.get(kind, told.get("late", 0.0)), OPENING.get(kind, told.get("opening", 0.2))
    able = actuator.capabilities
    speed, upper = min(SPEEDS.get(kind, SPEED), able.max_speed), min(UPPER, able.upper)
    rig = Rig(clock, far_end, wire, actuator, *slack, speed=speed, late=late, upper=upper, opening=opening)
    clock.every(QUANTUM, lambda: rig.held_up or actuator.poll(clock.now()))
    return rig
