"""DroneCAN: parameters of a node, read and set one by one, and all of them saved or erased."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import Self

from ross_protocols.dronecan.messages import DroneCanError
from ross_protocols.mavlink.params import shortest

MOST_NAME = 92  # of a parameter [bytes]

ParameterValue = bool | int | float | str | None  # None: empty; the type is the wire's


class Tag(IntEnum):
    """Which kind of value follows."""

    EMPTY = 0
    INTEGER = 1
    REAL = 2
    BOOLEAN = 3
    STRING = 4


class Opcode(IntEnum):
    """What is done with all parameters."""

    SAVE = 0
    ERASE = 1


def tagged(value: ParameterValue) -> tuple[Tag, bytes]:
    """Return the tag and the bytes of a value.

    >>> tag, value = tagged(0.5)
    >>> tag.name, value.hex()
    ('REAL', '0000003f')
    """
    match value:
        case None:
            return Tag.EMPTY, b""
        case bool():
            return Tag.BOOLEAN, bytes([value])
        case int():
            return Tag.INTEGER, value.to_bytes(8, "little", signed=True)
        case float():
            return Tag.REAL, struct.pack("<f", value)
        case str():
            text = value.encode()[:128]
            return Tag.STRING, bytes([len(text)]) + text


class _Reader:
    """Takes a payload from its front."""

    def __init__(self, payload: bytes) -> None:
        self.rest = payload

    def read(self, size: int) -> bytes:
        """Return the next bytes."""
        if size > len(self.rest):
            raise DroneCanError(f"expected {size} bytes, got {len(self.rest)}")
        taken, self.rest = self.rest[:size], self.rest[size:]
        return taken

    def value(self, tag: int) -> ParameterValue:
        """Return the value behind a tag."""
        match tag:
            case Tag.EMPTY:
                return None
            case Tag.INTEGER:
                return int.from_bytes(self.read(8), "little", signed=True)
            case Tag.REAL:
                return shortest(float(struct.unpack("<f", self.read(4))[0]))
            case Tag.BOOLEAN:
                return bool(self.read(1)[0])
            case Tag.STRING:
                return self.read(self.read(1)[0]).decode(errors="replace")
        raise DroneCanError(f"a value of kind {tag}")

    def tagged(self) -> ParameterValue:
        """Return the value behind a tag of a whole byte."""
        return self.value(self.read(1)[0] & 7)

    def limit(self) -> int | float | None:
        """Return a number behind a tag of two bits."""
        found = self.value(self.read(1)[0] & 3)
        return None if isinstance(found, (bool, str)) else found


@dataclass(frozen=True, slots=True)
class GetSetRequest:
    """uavcan.protocol.param.GetSet, the question: by name, else by index; an empty value only reads.

    >>> GetSetRequest(index=300, value=True).pack().hex()
    '2c0b01'
    """

    NUMBER, SEED = 11, 0xFB10

    name: str = ""
    index: int = 0
    value: ParameterValue = None

    def pack(self) -> bytes:
        """Write the payload."""
        tag, value = tagged(self.value)
        return bytes([self.index & 0xFF, self.index >> 8 << 3 | tag]) + value + self.name.encode()[:MOST_NAME]

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        reader = _Reader(payload)
        low, high = reader.read(2)
        value = reader.value(high & 7)
        return cls(reader.rest.decode(errors="replace"), high >> 3 << 8 | low, value)


@dataclass(frozen=True, slots=True)
class GetSetResponse:
    """uavcan.protocol.param.GetSet, the answer; without a name there is no such parameter."""

    NUMBER, SEED = 11, 0xFB10

    name: str = ""
    value: ParameterValue = None
    default: ParameterValue = None
    maximum: int | float | None = None
    minimum: int | float | None = None

    def pack(self) -> bytes:
        """Write the payload."""
        pairs = (tagged(value) for value in (self.value, self.default, self.maximum, self.minimum))
        return b"".join(bytes([tag]) + value for tag, value in pairs) + self.name.encode()[:MOST_NAME]

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        reader = _Reader(payload)
        values = reader.tagged(), reader.tagged(), reader.limit(), reader.limit()
        return cls(reader.rest.decode(errors="replace"), *values)


@dataclass(frozen=True, slots=True)
class OpcodeRequest:
    """uavcan.protocol.param.ExecuteOpcode, the question."""

    NUMBER, SEED = 10, 0xD7D4

    opcode: int
    argument: int = 0

    def pack(self) -> bytes:
        """Write the payload."""
        return bytes([self.opcode]) + self.argument.to_bytes(6, "little", signed=True)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        reader = _Reader(payload)
        return cls(reader.read(1)[0], int.from_bytes(reader.read(6), "little", signed=True))


@dataclass(frozen=True, slots=True)
class OpcodeResponse:
    """uavcan.protocol.param.ExecuteOpcode, the answer."""

    NUMBER, SEED = 10, 0xD7D4

    ok: bool
    argument: int = 0

    def pack(self) -> bytes:
        """Write the payload."""
        return self.argument.to_bytes(6, "little", signed=True) + bytes([self.ok << 7])

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        reader = _Reader(payload)
        argument = int.from_bytes(reader.read(6), "little", signed=True)
        return cls(bool(reader.read(1)[0] >> 7), argument)
