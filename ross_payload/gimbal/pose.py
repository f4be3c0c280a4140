"""How the gimbal stands, from what the actuator reports and where the base points."""

from __future__ import annotations

import math

from ross_payload.angles import wrap
from ross_payload.interfaces import ActuatorState, Capabilities, Mount
from ross_protocols.own_gimbal import AT_YAW_LIMIT, COMMS, ENCODER, MOTOR, Aim, Axis, Pose

SPAN = 0.1  # [s] over which the rate of the base is taken
NEAR = math.radians(0.2)  # a limit: at it [rad]


def pose_of(state: ActuatorState, mount: Mount, now: float, offset: float, *, aim: Aim | None, failures: int) -> Pose:
    """Return where the array points at ``now`` [s]; ``offset`` is its yaw at joint angle 0 [rad]."""
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


def failures_of(state: ActuatorState, travel: Capabilities, now: float, patience: float) -> int:
    """Return the failure flags; a report that is older than ``patience`` [s] is none.

    >>> from ross_payload.interfaces import Feedback
    >>> travel = Capabilities(-1.0, 1.0, 1.0, 1.0, 0.01, continuous=False, feedback=Feedback.MEASURED)
    >>> well = ActuatorState(0.0, 0.0, settled=True, homed=True, healthy=True, time=5.0)
    >>> failures_of(well, travel, now=5.1, patience=0.5), failures_of(well, travel, now=9.0, patience=0.5)
    (0, 128)
    """
    flags = AT_YAW_LIMIT if not travel.lower + NEAR < state.angle < travel.upper - NEAR else 0
    if now - state.time > patience:
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
