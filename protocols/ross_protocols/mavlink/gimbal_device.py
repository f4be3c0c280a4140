"""Our side of MAVLink gimbal protocol v2: what is asked of us as a gimbal, and what we say as one.

The gimbal has one axis, yaw. On the wire yaw is clockwise, here it is counter-clockwise; what is asked of the other
axes is left out.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from enum import Enum
from typing import Any

from ross_protocols.mavlink.commands import Command
from ross_protocols.mavlink.component_id import ComponentId, target_of
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.field_converters import clockwise
from ross_protocols.mavlink.gimbal_messages import EARTH_FRAME, INFINITE_YAW, VEHICLE_FRAME, YAW_LOCK, in_earth_frame
from ross_protocols.mavlink.vehicle import euler, quaternion

PITCHYAW = 1000  # command
RETRACT, NEUTRAL = 1, 2  # flags
HAS_RETRACT, HAS_NEUTRAL, HAS_YAW, HAS_FOLLOW, HAS_LOCK, HAS_EARTH_FRAME = 1, 2, 256, 512, 1024, 4096  # capabilities
AT_YAW_LIMIT, ENCODER, MOTOR, COMMS = 4, 8, 32, 128  # failure flags
FAULTS = ENCODER | MOTOR | COMMS
VENDOR = b"RoSS"


class Rest(Enum):
    """A position with a name."""

    RETRACTED = RETRACT
    NEUTRAL = NEUTRAL


@dataclass(frozen=True, slots=True)
class Aim:
    """Where to point: a yaw, a position with a name, or only a rate; angles counter-clockwise."""

    yaw: float | None = None  # [rad]
    earth: bool = False  # from north, and held there; else from the nose of the vehicle
    rate: float | None = None  # [rad/s]: alone signed, with a yaw the most
    rest: Rest | None = None


@dataclass(frozen=True, slots=True)
class SetPoint:
    """An aim, and for whom it is."""

    target: ComponentId  # 0: everybody
    device_id: int  # 0: every gimbal of the target
    aim: Aim | None  # None: it says nothing about yaw


@dataclass(frozen=True, slots=True)
class Axis:
    """What the gimbal is; angles counter-clockwise from the nose of the vehicle."""

    lower: float  # [rad], -inf: it turns without end
    upper: float  # [rad]
    earth: bool  # it can hold a yaw from north
    model: str
    version: str


@dataclass(frozen=True, slots=True)
class Pose:
    """Where the gimbal is; angles counter-clockwise."""

    yaw: float  # from the nose of the vehicle [rad]
    rate: float  # against the vehicle [rad/s]
    vehicle: float | None  # yaw of the vehicle from north [rad]
    turning: float | None  # its rate [rad/s]
    locked: bool  # it holds a yaw from north
    rest: Rest | None  # it stands in a position with a name, or goes there
    failures: int  # flags


def set_point_of(message: Any) -> SetPoint | None:
    """Return what a message asks of a gimbal or of its manager; None: it is another message.

    >>> message = common.MAVLink_gimbal_manager_set_pitchyaw_message(1, 154, 32, 1, 0.0, 0.5, math.nan, math.nan)
    >>> set_point_of(message).aim.yaw
    -0.5
    """
    number = message.get_msgId()
    if number == common.MAVLINK_MSG_ID_GIMBAL_MANAGER_SET_PITCHYAW:
        yaw, rate = message.yaw, message.yaw_rate
    elif number in (
        common.MAVLINK_MSG_ID_GIMBAL_MANAGER_SET_ATTITUDE,
        common.MAVLINK_MSG_ID_GIMBAL_DEVICE_SET_ATTITUDE,
    ):
        yaw, rate = euler(message.q)[0], message.angular_velocity_z
    else:
        return None
    return SetPoint(target_of(message), getattr(message, "gimbal_device_id", 0), aim_of(message.flags, yaw, rate))


def commanded(command: Command) -> Aim | None:
    """Return what a pitch-yaw command asks for; None: nothing about yaw."""
    yaw, rate = (math.radians(number) for number in (command.numbers[1], command.numbers[3]))
    flags = command.numbers[4]
    return aim_of(int(flags), yaw, rate) if math.isfinite(flags) and flags >= 0 else None


def aim_of(flags: int, yaw: float, rate: float) -> Aim | None:
    """Return what flags and a clockwise yaw [rad] and rate [rad/s] ask for, NaN is not told; None: nothing.

    >>> aim_of(VEHICLE_FRAME, math.nan, math.nan), aim_of(RETRACT | NEUTRAL, 0.0, 0.0).rest
    (None, <Rest.RETRACTED: 1>)
    """
    if flags & (RETRACT | NEUTRAL):
        return Aim(rest=Rest.RETRACTED if flags & RETRACT else Rest.NEUTRAL)
    turn = 0.0 - rate if math.isfinite(rate) else None
    if math.isfinite(yaw):
        return Aim(clockwise(yaw), in_earth_frame(flags), rate=abs(turn) if turn else None)
    return None if turn is None else Aim(rate=turn)


def heartbeat(well: bool) -> Any:
    """Return the HEARTBEAT of a gimbal."""
    state = common.MAV_STATE_ACTIVE if well else common.MAV_STATE_CRITICAL
    return common.MAVLink_heartbeat_message(common.MAV_TYPE_GIMBAL, common.MAV_AUTOPILOT_INVALID, 0, 0, state, 3)


def capabilities(axis: Axis) -> int:
    """Return the capability flags of a gimbal that yaws and does nothing else.

    >>> capabilities(Axis(-1.0, 1.0, earth=False, model="", version=""))
    771
    """
    flags = HAS_RETRACT | HAS_NEUTRAL | HAS_YAW | HAS_FOLLOW
    flags |= INFINITE_YAW if math.isinf(axis.upper - axis.lower) else 0
    return flags | (HAS_LOCK | HAS_EARTH_FRAME if axis.earth else 0)


def manager_information(boot: int, device_id: int, axis: Axis) -> Any:
    """Return GIMBAL_MANAGER_INFORMATION; ``boot`` is our clock [ms]."""
    return common.MAVLink_gimbal_manager_information_message(boot, capabilities(axis), device_id, *_limits(axis))


def device_information(boot: int, device_id: int, axis: Axis) -> Any:
    """Return GIMBAL_DEVICE_INFORMATION; nobody knows a number of the hardware."""
    return common.MAVLink_gimbal_device_information_message(
        boot, VENDOR, axis.model.encode("ascii", "replace")[:32], b"", firmware(axis.version), 0, 0,
        capabilities(axis), 0, *_limits(axis), gimbal_device_id=device_id,
    )  # fmt: skip


def manager_status(boot: int, device_id: int, flags: int, primary: ComponentId, secondary: ComponentId) -> Any:
    """Return GIMBAL_MANAGER_STATUS."""
    return common.MAVLink_gimbal_manager_status_message(boot, flags, device_id, *primary, *secondary)


def flags_of(pose: Pose) -> int:
    """Return the flags in force: one frame, never both.

    >>> [flags_of(Pose(0, 0, vehicle, 0, locked=True, rest=None, failures=0)) for vehicle in (None, 1.0)]
    [32, 80]
    """
    frame = EARTH_FRAME | YAW_LOCK if pose.locked and pose.vehicle is not None else VEHICLE_FRAME
    return frame | (0 if pose.rest is None else pose.rest.value)


def attitude_status(boot: int, device_id: int, pose: Pose) -> Any:
    """Return GIMBAL_DEVICE_ATTITUDE_STATUS, to everybody."""
    flags = flags_of(pose)
    vehicle = math.nan if pose.vehicle is None else pose.vehicle
    turning = math.nan if pose.turning is None else pose.turning
    north = bool(flags & EARTH_FRAME)
    yaw, rate = pose.yaw + (vehicle if north else 0.0), pose.rate + (turning if north else 0.0)
    q = quaternion(clockwise(yaw), 0.0, 0.0)
    return common.MAVLink_gimbal_device_attitude_status_message(
        0, 0, boot, flags, q, 0.0, 0.0, 0.0 - rate, pose.failures,
        delta_yaw=clockwise(vehicle), delta_yaw_velocity=0.0 - turning, gimbal_device_id=device_id,
    )  # fmt: skip


def firmware(version: str) -> int:
    """Return a version as a gimbal packs it, major in the lowest byte.

    >>> hex(firmware("1.2.3.dev4"))
    '0x30201'
    """
    numbers = [int(number) for number in re.findall(r"\d+", version)[:3]]
    return sum((number & 0xFF) << 8 * place for place, number in enumerate(numbers))


def _limits(axis: Axis) -> tuple[float, ...]:
    """Roll, pitch and yaw, each from least to most, clockwise."""
    return 0.0, 0.0, 0.0, 0.0, 0.0 - axis.upper, 0.0 - axis.lower
