"""DroneCAN: messages of actuators and nodes to CAN frames and back; no bus, no clock.

A transfer is one frame or several, each with a tail byte (start, end, toggle, transfer id); a long one begins with a
CRC over the type's signature and its payload. Numbers are little-endian, bit fields begin at the highest bit, and
real numbers are float16: see `spacing`. Of every type ``SEED`` is the CRC-16 of its signature, and ``PRIORITY`` 0 is
the highest.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Self

from ross_protocols.can import CanFrame
from ross_protocols.dronecan.gimbal_messages import AngularCommand, GimbalStatus
from ross_protocols.dronecan.transfer import anonymous

MOST_COMMANDS = 15  # in one message
UNIQUE = 16  # size of a unique id [bytes]
MOST_ASKED = 6  # bytes of a unique id in a request
REQUEST_PERIOD = (0.6, 1.0)  # [s] between two requests, by chance
FOLLOW_UP = (0.0, 0.4)  # [s] until a follow-up, by chance
FOLLOW_UP_TIMEOUT = 0.5  # [s] after which an allocator forgets a request
NAN = math.nan


class DroneCanError(ValueError):
    """The bytes are no such message."""


class CommandKind(IntEnum):
    """What the value of a command is."""

    UNITLESS = 0  # -1 to 1
    POSITION = 1  # [rad]
    PWM = 4  # [us]


class Health(IntEnum):
    """How a node is."""

    OK = 0
    WARNING = 1
    ERROR = 2
    CRITICAL = 3


class Mode(IntEnum):
    """What a node does."""

    OPERATIONAL = 0
    INITIALIZATION = 1
    MAINTENANCE = 2
    SOFTWARE_UPDATE = 3
    RESERVED_4 = 4
    RESERVED_5 = 5
    RESERVED_6 = 6
    OFFLINE = 7


@dataclass(frozen=True, slots=True)
class Command:
    """One actuator's part of an ArrayCommand; the kind may be one that we do not send."""

    actuator_id: int
    kind: int
    value: float


@dataclass(frozen=True, slots=True)
class ArrayCommand:
    """uavcan.equipment.actuator.ArrayCommand.

    >>> ArrayCommand((Command(3, CommandKind.UNITLESS, -0.5),)).pack().hex()
    '030000b8'
    """

    NUMBER, SEED, PRIORITY = 1010, 0x5E37, 8

    commands: tuple[Command, ...]

    def pack(self) -> bytes:
        """Write the payload."""
        return b"".join(struct.pack("<BBe", each.actuator_id, each.kind, each.value) for each in self.commands)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        if len(payload) % 4 or len(payload) > 4 * MOST_COMMANDS:
            raise DroneCanError(f"commands of {len(payload)} bytes")
        return cls(tuple(Command(*values) for values in struct.iter_unpack("<BBe", payload)))


@dataclass(frozen=True, slots=True)
class Status:
    """uavcan.equipment.actuator.Status; not-a-number is unknown."""

    NUMBER, SEED, PRIORITY = 1011, 0x9A63, 16

    actuator_id: int
    position: float = NAN  # [rad]
    force: float = NAN  # [N m]
    speed: float = NAN  # [rad/s]
    load: int = 127  # [% of the rated power]; 127: unknown

    def pack(self) -> bytes:
        """Write the payload."""
        return struct.pack("<BeeeB", self.actuator_id, self.position, self.force, self.speed, self.load)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        number, position, force, speed, load = struct.unpack("<BeeeB", payload)
        return cls(number, position, force, speed, load & 0x7F)


@dataclass(frozen=True, slots=True)
class NodeStatus:
    """uavcan.protocol.NodeStatus.

    >>> NodeStatus(70000, Health.ERROR, Mode.MAINTENANCE).pack().hex()
    '70110100900000'
    """

    NUMBER, SEED, PRIORITY = 341, 0xBE5F, 20

    uptime: int  # [s]
    health: Health = Health.OK
    mode: Mode = Mode.OPERATIONAL
    vendor_code: int = 0

    def pack(self) -> bytes:
        """Write the payload."""
        return struct.pack("<IBH", self.uptime, self.health << 6 | self.mode << 3, self.vendor_code)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        uptime, bits, code = struct.unpack("<IBH", payload)
        return cls(uptime, Health(bits >> 6), Mode(bits >> 3 & 7), code)


@dataclass(frozen=True, slots=True)
class LogMessage:
    """uavcan.protocol.debug.LogMessage."""

    NUMBER, SEED, PRIORITY = 16383, 0x4570, 31

    level: int  # 0 debug, 1 information, 2 warning, 3 error
    source: str  # at most 31 bytes
    text: str  # at most 90 bytes

    def pack(self) -> bytes:
        """Write the payload; what is too long is cut."""
        source, text = self.source.encode()[:31], self.text.encode()[:90]
        return bytes([self.level << 5 | len(source)]) + source + text

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        if not payload:
            raise DroneCanError("an empty log message")
        end = 1 + (payload[0] & 31)
        source, text = (part.decode(errors="replace") for part in (payload[1:end], payload[end:]))
        return cls(payload[0] >> 5, source, text)


@dataclass(frozen=True, slots=True)
class Allocation:
    """uavcan.protocol.dynamic_node_id.Allocation: a node without an id asks anonymously, its unique id in three parts.

    >>> Allocation(125, b"abcdef", first=True).pack().hex()
    'fb616263646566'
    """

    NUMBER, SEED, PRIORITY = 1, 0xF258, 30

    node_id: int  # wanted or given; 0: any, or not given yet
    unique_id: bytes  # as much of it as is told
    first: bool = False  # the first part

    def pack(self) -> bytes:
        """Write the payload."""
        return bytes([self.node_id << 1 | self.first]) + self.unique_id

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        if not 1 <= len(payload) <= 1 + UNIQUE:
            raise DroneCanError(f"an allocation of {len(payload)} bytes")
        return cls(payload[0] >> 1, payload[1:], bool(payload[0] & 1))

    def asked(self, discriminator: int, transfer: int) -> CanFrame:
        """Return the frame of a node without an id."""
        return anonymous(self.NUMBER, discriminator, self.pack(), transfer, self.PRIORITY)


Message = ArrayCommand | Status | NodeStatus | LogMessage | AngularCommand | GimbalStatus


@dataclass(frozen=True, slots=True)
class Received:
    """A message and the node that sent it."""

    node: int
    message: Message
    transfer: int = field(default=0, compare=False)  # counts the node's messages of this type, modulo 32


def as_sent(value: float) -> float:
    """Return the float16 nearest to a value."""
    return float(struct.unpack("<e", struct.pack("<e", value))[0])


def spacing(value: float) -> float:
    """Return the distance between neighbours of float16 just below a magnitude >= 2^-14.

    >>> spacing(1.0) == 2**-11, spacing(math.pi) == 2**-9
    (True, True)
    """
    mantissa, exponent = math.frexp(abs(value))
    return 2.0 ** (exponent - 11 - (mantissa == 0.5))
