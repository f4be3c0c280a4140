"""What an autopilot says about the vehicle and its clock, and what we ask of it; bytes stay in `codec`.

On the wire yaw is clockwise from north and quaternions are wxyz, north-east-down. Here yaw is counter-clockwise; pitch
(nose up) and roll (right side down) are as on the wire.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ross_protocols.mavlink.component_id import ComponentId, target_of
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.field_converters import clockwise

NO_HEADING = 65535  # of GLOBAL_POSITION_INT
AUTOPILOT = 1  # component id: MAV_COMP_ID_AUTOPILOT1
NO_AUTOPILOT = 8  # MAV_AUTOPILOT_INVALID
SINCE_1970 = 1_577_836_800  # UNIX time of 2020 [s]: a clock that says less has not been set
EVERYBODY = ComponentId(0, 0)  # as a target
STEEP = math.radians(80)  # beyond this pitch the yaw of an aircraft means nothing


@dataclass(frozen=True, slots=True)
class VehicleAttitude:
    """ATTITUDE or AUTOPILOT_STATE_FOR_GIMBAL_DEVICE."""

    boot: float  # of the autopilot's clock [s]
    yaw: float  # counter-clockwise from north [rad]
    pitch: float  # [rad]
    roll: float  # [rad]
    yaw_rate: float  # counter-clockwise [rad/s]


@dataclass(frozen=True, slots=True)
class SystemTime:
    """SYSTEM_TIME."""

    boot: float  # of the autopilot's clock [s]
    unix: float | None  # [s], None: the autopilot does not know


@dataclass(frozen=True, slots=True)
class TimeSync:
    """TIMESYNC: a request carries no answer."""

    asked: int  # clock of whoever asks [ns]
    answered: int | None = None  # clock of whoever answers [ns], None: a request
    target: ComponentId = EVERYBODY  # of a request who is asked, of an answer who has asked


@dataclass(frozen=True, slots=True)
class Position:
    """GLOBAL_POSITION_INT; None is not known."""

    latitude: float  # [rad]
    longitude: float  # [rad]
    height: float  # above the sea [m]
    yaw: float | None = None  # of the nose, counter-clockwise from north [rad]


def position_of(message: Any) -> Position | None:
    """Return where a message says that the vehicle is; None: any other message, or it does not know."""
    if message.get_type() != "GLOBAL_POSITION_INT" or message.lat == message.lon == 0:
        return None
    yaw = None if message.hdg == NO_HEADING else clockwise(math.radians(message.hdg / 100))
    return Position(math.radians(message.lat / 1e7), math.radians(message.lon / 1e7), message.alt / 1e3, yaw)


def height_of(message: Any) -> float | None:
    """Return how high above home [m] a message says that the vehicle is; None: any other message."""
    return message.relative_alt / 1e3 if message.get_type() == "GLOBAL_POSITION_INT" else None


def read(message: Any) -> VehicleAttitude | SystemTime | TimeSync | None:
    """Return what a message means; None for any other message, and for numbers that cannot be meant."""
    match message.get_type():
        case "ATTITUDE":
            return _finite(_attitude(message))
        case "AUTOPILOT_STATE_FOR_GIMBAL_DEVICE":
            return _finite(_gimbal_state(message))
        case "SYSTEM_TIME":
            seconds = message.time_unix_usec / 1e6
            return SystemTime(message.time_boot_ms / 1e3, seconds if seconds > SINCE_1970 else None)
        case "TIMESYNC":
            return TimeSync(message.ts1, message.tc1 or None, target_of(message))
    return None


def attitude(value: VehicleAttitude) -> Any:
    """Return the ATTITUDE of a vehicle that is nearly level."""
    milliseconds = round(value.boot * 1e3) % 2**32
    turn = (0.0, 0.0, -value.yaw_rate)
    return common.MAVLink_attitude_message(milliseconds, value.roll, value.pitch, clockwise(value.yaw), *turn)


def gimbal_state(value: VehicleAttitude) -> Any:
    """Return the AUTOPILOT_STATE_FOR_GIMBAL_DEVICE of a vehicle, to everybody."""
    q = quaternion(clockwise(value.yaw), value.pitch, value.roll)
    rate = -value.yaw_rate
    return common.MAVLink_autopilot_state_for_gimbal_device_message(
        0, 0, round(value.boot * 1e6), q, 0, 0.0, 0.0, 0.0, 0, math.nan, 0, 0, angular_velocity_z=rate
    )


def system_time(value: SystemTime) -> Any:
    """Return SYSTEM_TIME."""
    return common.MAVLink_system_time_message(round((value.unix or 0.0) * 1e6), round(value.boot * 1e3) % 2**32)


def time_sync(value: TimeSync) -> Any:
    """Return TIMESYNC."""
    return ross.MAVLink_timesync_message(value.answered or 0, value.asked, *value.target)


def message_interval(system_id: int, message_id: int, hertz: float) -> Any:
    """Return the command that asks an autopilot for a message at a rate."""
    command, interval = common.MAV_CMD_SET_MESSAGE_INTERVAL, 1e6 / hertz
    rest = (0.0,) * 5
    return common.MAVLink_command_long_message(system_id, AUTOPILOT, command, 0, float(message_id), interval, *rest)


def quaternion(yaw: float, pitch: float, roll: float) -> tuple[float, float, float, float]:
    """Return the quaternion wxyz of Euler angles [rad], yaw first.

    >>> [round(part, 6) for part in quaternion(math.pi / 2, 0.0, 0.0)]
    [0.707107, 0.0, 0.0, 0.707107]
    """
    (cy, cp, cr), (sy, sp, sr) = ([f(angle / 2) for angle in (yaw, pitch, roll)] for f in (math.cos, math.sin))
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def euler(q: Sequence[float]) -> tuple[float, float, float]:
    """Return yaw, pitch and roll [rad] of a quaternion wxyz of any length.

    >>> [round(angle, 6) for angle in euler(quaternion(0.3, 0.2, -0.1))]
    [0.3, 0.2, -0.1]
    """
    norm = math.hypot(*q) or math.nan
    w, x, y, z = (part / norm for part in q)
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    pitch = math.asin(min(max(2 * (w * y - z * x), -1.0), 1.0)) if math.isfinite(norm) else math.nan
    return yaw, pitch, math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))


def _attitude(message: Any) -> VehicleAttitude:
    """Read ATTITUDE; the rates on the wire are about the axes of the body."""
    roll, pitch = message.roll, message.pitch
    rate = math.nan
    if math.isfinite(roll) and abs(pitch) < STEEP:
        rate = (message.pitchspeed * math.sin(roll) + message.yawspeed * math.cos(roll)) / math.cos(pitch)
    return VehicleAttitude(message.time_boot_ms / 1e3, clockwise(message.yaw), pitch, roll, -rate)


def _gimbal_state(message: Any) -> VehicleAttitude:
    yaw, pitch, roll = euler(message.q)
    rates = (message.angular_velocity_z or math.nan, message.feed_forward_angular_velocity_z, 0.0)  # measured, wanted
    rate = next(rate for rate in rates if math.isfinite(rate))
    return VehicleAttitude(message.time_boot_us / 1e6, clockwise(yaw), pitch, roll, -rate)


def _finite(value: VehicleAttitude) -> VehicleAttitude | None:
    numbers = (value.yaw, value.pitch, value.roll, value.yaw_rate)
    return value if all(map(math.isfinite, numbers)) and abs(value.pitch) < STEEP else None
