"""MAVLink gimbal protocol v2: what gimbals and their managers say, and what is asked of them; bytes stay in `codec`.

On the wire yaw is clockwise and quaternions are wxyz. Here yaw is counter-clockwise. Whoever sends sets exactly one
frame flag; in what arrives with none or both, YAW_LOCK tells the frame.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ross_protocols.mavlink.commands import long_message
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.field_converters import clockwise
from ross_protocols.mavlink.vehicle import euler, quaternion

TYPE_GIMBAL = common.MAV_TYPE_GIMBAL
MANAGER_INFORMATION, MANAGER_STATUS, DEVICE_INFORMATION, DEVICE_ATTITUDE = 280, 281, 283, 285  # message ids
REQUEST_MESSAGE, MESSAGE_INTERVAL, CONFIGURE = 512, 511, 1001  # commands
COMPONENTS = (154, 171, 172, 173, 174, 175)  # of gimbal devices
ITSELF, NOBODY, UNCHANGED = -2.0, -3.0, -1.0  # in CONFIGURE

YAW_LOCK, VEHICLE_FRAME, EARTH_FRAME = 16, 32, 64  # flags
INFINITE_YAW = 2048  # capability
CALIBRATING, NO_MANAGER = 256, 512  # failure flags
FAILURES = {
    8: "encoder",
    16: "power",
    32: "motor",
    64: "software",
    128: "communication inside the gimbal",
    CALIBRATING: "calibrating",
    NO_MANAGER: "no data from its manager",
}


@dataclass(frozen=True, slots=True)
class GimbalAttitude:
    """GIMBAL_DEVICE_ATTITUDE_STATUS."""

    boot: float  # of the sender's clock [s]
    yaw: float  # counter-clockwise [rad]
    rate: float | None  # counter-clockwise [rad/s], in the same frame
    earth: bool  # from north; else from the nose of the vehicle
    failures: int  # flags
    device_id: int  # 0: the sender is the device


@dataclass(frozen=True, slots=True)
class GimbalTravel:
    """GIMBAL_MANAGER_INFORMATION or GIMBAL_DEVICE_INFORMATION."""

    device_id: int  # 1 to 6: the sender's own; else a component id, 0 the sender
    lower: float  # counter-clockwise from the nose [rad]; NaN: not told
    upper: float  # [rad]


@dataclass(frozen=True, slots=True)
class GimbalControl:
    """GIMBAL_MANAGER_STATUS."""

    device_id: int
    primary: ComponentId  # who controls; (0, 0): nobody


def read(message: Any) -> GimbalAttitude | GimbalTravel | GimbalControl | None:
    """Return what a message means; None for any other, and for an attitude whose yaw is no number."""
    match message.get_type():
        case "GIMBAL_DEVICE_ATTITUDE_STATUS":
            return _attitude(message)
        case "GIMBAL_MANAGER_INFORMATION" | "GIMBAL_DEVICE_INFORMATION":
            if message.cap_flags & INFINITE_YAW:
                return GimbalTravel(message.gimbal_device_id, -math.inf, math.inf)
            return GimbalTravel(message.gimbal_device_id, -message.yaw_max, -message.yaw_min)
        case "GIMBAL_MANAGER_STATUS":
            primary = ComponentId(message.primary_control_sysid, message.primary_control_compid)
            return GimbalControl(message.gimbal_device_id, primary)
    return None


def maker(message: Any) -> str:
    """Return vendor, model and firmware of a GIMBAL_DEVICE_INFORMATION, in one line; empty when it tells none.

    >>> names = b"Gremsy", b"Pixy", b""
    >>> maker(common.MAVLink_gimbal_device_information_message(0, *names, 0x0203, 0, 0, 0, 0, *(0.0,) * 6))
    'Gremsy Pixy, firmware 3.2.0'
    """
    names = message.vendor_name, message.model_name
    texts = ["".join(letter for letter in name if letter.isprintable()).strip() for name in names]
    version = message.firmware_version.to_bytes(4, "little")[:3]
    firmware = "firmware " + ".".join(map(str, version)) if any(version) else ""
    return ", ".join(part for part in (" ".join(filter(None, texts)), firmware) if part)


def in_earth_frame(flags: int) -> bool:
    """Tell the frame of a yaw.

    >>> [in_earth_frame(flags) for flags in (44, 92, 28, 12, 32 | 16)]
    [False, True, True, False, False]
    """
    frames = flags & (VEHICLE_FRAME | EARTH_FRAME)
    return frames == EARTH_FRAME if frames in (VEHICLE_FRAME, EARTH_FRAME) else bool(flags & YAW_LOCK)


def failures(flags: int) -> str:
    """Name the failures among failure flags.

    >>> failures(8 | 32), failures(4)
    ('encoder, motor', '')
    """
    return ", ".join(name for flag, name in FAILURES.items() if flags & flag)


def point_manager(manager: ComponentId, device_id: int, yaw: float) -> Any:
    """Return the GIMBAL_MANAGER_SET_PITCHYAW that levels a gimbal and turns it to ``yaw`` [rad] from the nose.

    Rates are not told: an ArduPilot ignores angles that come with rates.
    """
    angles, rates = (0.0, clockwise(yaw)), (math.nan, math.nan)
    return common.MAVLink_gimbal_manager_set_pitchyaw_message(*manager, VEHICLE_FRAME, device_id, *angles, *rates)


def point_device(device: ComponentId, yaw: float) -> Any:
    """Return the GIMBAL_DEVICE_SET_ATTITUDE that levels a device and turns it to ``yaw`` [rad] from the nose."""
    q = quaternion(clockwise(yaw), 0.0, 0.0)
    return common.MAVLink_gimbal_device_set_attitude_message(*device, VEHICLE_FRAME, q, *(math.nan,) * 3)


def configure(manager: ComponentId, device_id: int, primary: float) -> Any:
    """Return the command that takes control (``ITSELF``) or gives it back (``NOBODY``)."""
    return long_message(CONFIGURE, (primary, primary, UNCHANGED, UNCHANGED, 0.0, 0.0, float(device_id)), manager)


def request(whom: ComponentId, message_id: int) -> Any:
    """Return the command that asks for one message."""
    return long_message(REQUEST_MESSAGE, (message_id,), whom)


def interval(whom: ComponentId, message_id: int, hertz: float) -> Any:
    """Return the command that asks for a message at a rate."""
    return long_message(MESSAGE_INTERVAL, (message_id, 1e6 / hertz), whom)


def _attitude(message: Any) -> GimbalAttitude | None:
    yaw, rate = euler(message.q)[0], message.angular_velocity_z
    if not math.isfinite(yaw):
        return None
    return GimbalAttitude(
        boot=message.time_boot_ms / 1e3,
        yaw=clockwise(yaw),
        rate=0.0 - rate if math.isfinite(rate) else None,
        earth=in_earth_frame(message.flags),
        failures=message.failure_flags,
        device_id=message.gimbal_device_id,
    )
