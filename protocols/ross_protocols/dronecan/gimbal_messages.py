"""DroneCAN: what gimbals are told and what they report; part of `dronecan`.

On the wire an attitude is a quaternion xyzw of four float16, in the frame forward-right-down, so that yaw is clockwise.
Here yaw is counter-clockwise. A quaternion does not count turns.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import Self

COARSE = 2**-10  # worst error of a yaw [rad]: two components near 0.7, each wrong by half of 2^-11


class GimbalMode(IntEnum):
    """How a gimbal handles commands."""

    ANGULAR_VELOCITY = 0
    FIXED_FRAME = 1  # the earth's
    BODY_FRAME = 2  # the vehicle's
    POINT_OF_INTEREST = 3


@dataclass(frozen=True, slots=True)
class AngularCommand:
    """uavcan.equipment.camera_gimbal.AngularCommand of a camera that is level.

    >>> AngularCommand(1, math.pi / 2).pack().hex()
    '010200000000a8b9a839'
    """

    NUMBER, SEED, PRIORITY = 1040, 0xCD1F, 8

    gimbal_id: int
    yaw: float  # counter-clockwise [rad]; from the nose in BODY_FRAME
    mode: int = GimbalMode.BODY_FRAME

    def pack(self) -> bytes:
        """Write the payload."""
        return struct.pack("<BB4e", self.gimbal_id, self.mode, *_quaternion(self.yaw))

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload; in other modes ``yaw`` means something else, or nothing."""
        number, mode, *q = struct.unpack("<BB4e", payload)
        return cls(number, _yaw(*q), mode)


@dataclass(frozen=True, slots=True)
class GimbalStatus:
    """uavcan.equipment.camera_gimbal.Status; its covariance is neither sent nor read."""

    NUMBER, SEED, PRIORITY = 1044, 0xEFD0, 16

    gimbal_id: int
    yaw: float  # of the camera's axis, counter-clockwise from the nose [rad]; not-a-number: no attitude
    mode: int = GimbalMode.BODY_FRAME

    def pack(self) -> bytes:
        """Write the payload."""
        return struct.pack("<BB4e", self.gimbal_id, self.mode, *_quaternion(self.yaw))

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        number, mode, *q = struct.unpack_from("<BB4e", payload)
        return cls(number, _yaw(*q), mode)


def _quaternion(yaw: float) -> tuple[float, float, float, float]:
    """Return xyzw of a yaw [rad] that is counter-clockwise."""
    return 0.0, 0.0, 0.0 - math.sin(yaw / 2), math.cos(yaw / 2)


def _yaw(x: float, y: float, z: float, w: float) -> float:
    """Return the yaw [rad], counter-clockwise, of a quaternion of any length but 0."""
    if not math.hypot(x, y, z, w):
        return math.nan
    return 0.0 - math.atan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z)
