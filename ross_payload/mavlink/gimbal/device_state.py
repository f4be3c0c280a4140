"""The state of the gimbal device: where the array points, what it can do, what ails it."""

from __future__ import annotations

import math

from ross_payload import __version__
from ross_payload.angles import wrap
from ross_payload.config import Config
from ross_payload.interfaces import Actuator, ActuatorState, Capabilities, Input, Mount
from ross_payload.pointing import Pointing
from ross_protocols.mavlink.gimbal_device import AT_YAW_LIMIT, COMMS, ENCODER, MOTOR, Aim, Axis, Pose


class DeviceState:
    """The actuator and the base under it. ``on_input`` belongs to the mission's thread, the rest to the pump."""

    def __init__(self, config: Config, actuator: Actuator, mount: Mount) -> None:
        self._config = config
        self._actuator = actuator
        self._mount = mount
        self._latest: Pointing | None = None

    def on_input(self, hop: Input) -> None:
        """Keep what was heard last: it tells how the joint stands to the base, also after a slip."""
        self._latest = hop.pointing

    @property
    def park(self) -> float:
        """Joint angle of the parking position [rad]."""
        return math.radians(self._config.guard.park_deg)

    def offset(self) -> float:
        """Return where the array points at joint angle 0, from the nose of the vehicle [rad]."""
        return wrap(self._config.offset if self._latest is None else self._latest.offset)

    def axis(self) -> Axis:
        """Return what the gimbal is."""
        mount = self._config.mount
        earth = mount.source == "autopilot" or mount.yaw_deg is not None
        travel, model = self._actuator.capabilities, self._config.actuator.kind
        return axis_of(travel, wrap(self._config.offset), model, __version__, earth=earth)

    def pose(self, now: float, aim: Aim | None, failures: int) -> Pose:
        """Return where the array points; ``failures`` are known from elsewhere."""
        state, failures = self._actuator.state(), failures | self.failures(now)
        return pose_of(state, self._mount, now, self.offset(), aim=aim, failures=failures)

    def failures(self, now: float) -> int:
        """Return the failure flags of the actuator."""
        max_age = self._config.guard.watchdog_s
        return failures_of(self._actuator.state(), self._actuator.capabilities, now, max_age)

    def unable(self, aim: Aim, now: float) -> str:
        """Return why the array cannot follow an aim at present; empty when it can."""
        state = self._actuator.state()
        if not state.healthy:
            return state.fault or "the actuator reports a fault"
        if not state.homed:
            return "the zero is not known: home first"
        unknown = aim.earth and not self._mount.attitude(now).known
        return "the attitude of the vehicle is not known" if unknown else ""


SPAN = 0.1  # [s] over which the rate of the base is taken
NEAR = math.radians(0.2)  # a limit: at it [rad]


def pose_of(state: ActuatorState, mount: Mount, now: float, offset: float, *, aim: Aim | None, failures: int) -> Pose:
    """Return where the array points at ``now`` [s]; ``offset`` is its yaw at joint angle 0 [rad].

    The base is asked at present: the Pointing of the latest hop grows old while the mission computes.
    """
    here, before = mount.attitude(now), mount.attitude(now - SPAN)
    return Pose(
        yaw=state.angle + offset,
        rate=state.rate,
        vehicle=here.yaw if here.known else None,
        turning=wrap(here.yaw - before.yaw) / SPAN if here.known and before.known else None,
        locked=aim is not None and aim.earth,
        rest=None if aim is None else aim.rest,
        failures=failures,
    )


def failures_of(state: ActuatorState, travel: Capabilities, now: float, max_age: float) -> int:
    """Return the failure flags; a report that is older than ``max_age`` [s] is none.

    >>> from ross_payload.interfaces import Feedback
    >>> travel = Capabilities(-1.0, 1.0, 1.0, 1.0, 0.01, continuous=False, feedback=Feedback.MEASURED)
    >>> well = ActuatorState(0.0, 0.0, settled=True, homed=True, healthy=True, time=5.0)
    >>> failures_of(well, travel, now=5.1, max_age=0.5), failures_of(well, travel, now=9.0, max_age=0.5)
    (0, 128)
    """
    flags = AT_YAW_LIMIT if not travel.lower + NEAR < state.angle < travel.upper - NEAR else 0
    if now - state.time > max_age:
        return flags | COMMS
    if not state.homed:
        return flags | ENCODER
    return flags if state.healthy else flags | MOTOR


def axis_of(travel: Capabilities, offset: float, model: str, version: str, *, earth: bool) -> Axis:
    """Return what the gimbal is: its travel from the nose of the vehicle."""
    lower, upper = travel.lower + offset, travel.upper + offset
    if travel.continuous:
        lower, upper = -math.inf, math.inf
    return Axis(lower, upper, earth=earth, model=model, version=version)
