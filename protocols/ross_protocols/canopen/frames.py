"""CANopen (CiA 301): identifiers, network management, heartbeats, emergencies, process data. No bus, no clock."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

from ross_protocols.can import CanFrame
from ross_protocols.canopen.error_texts import emergency_words

NMT, SYNC = 0x000, 0x080  # identifiers of frames to all
EMERGENCY, HEARTBEAT = 0x080, 0x700  # of frames from a node: plus its number
TPDO, RPDO = (0x180, 0x280), (0x200, 0x300)  # the first and the second process data from and to a node
SDO_REPLY, SDO_REQUEST = 0x580, 0x600
NOT_VALID = 0x8000_0000  # process data that are switched off
ON_EVENT = 255  # transmission type: at once, and by a timer


class NmtCommand(IntEnum):
    """Orders to a node or, for node 0, to all."""

    START = 1
    STOP = 2
    PRE_OPERATIONAL = 128
    RESET_NODE = 129
    RESET_COMMUNICATION = 130

    @classmethod
    def says(cls, code: int) -> str:
        """Name an order.

        >>> NmtCommand.says(129), NmtCommand.says(7)
        ('reset-node', '0x07')
        """
        return cls(code).name.lower().replace("_", "-") if code in set(cls) else f"0x{code:02X}"


class NmtState(IntEnum):
    """What a node says in its heartbeat."""

    BOOT_UP = 0
    STOPPED = 4
    OPERATIONAL = 5
    PRE_OPERATIONAL = 127

    @property
    def words(self) -> str:
        """Its name.

        >>> NmtState(127).words
        'pre-operational'
        """
        return self.name.lower().replace("_", "-")


@dataclass(frozen=True, slots=True)
class Item:
    """An entry of an object dictionary that is a number.

    >>> target = Item(0x607A, 0, "i")
    >>> target.size, hex(target.mapping), str(target)
    (4, '0x607a0020', '0x607A')
    """

    index: int
    sub: int
    format: str  # of `struct`: b, B, h, H, i or I

    @property
    def size(self) -> int:
        """Length [bytes]."""
        return struct.calcsize(self.format)

    @property
    def mapping(self) -> int:
        """What maps it into process data."""
        return self.index << 16 | self.sub << 8 | 8 * self.size

    def pack(self, value: int) -> bytes:
        """Turn a value into bytes.

        >>> Item(0x6060, 0, "b").pack(-1).hex()
        'ff'
        """
        return struct.pack(f"<{self.format}", value)

    def unpack(self, data: bytes) -> int:
        """Turn bytes into a value; ``struct.error`` when there are not as many as it has."""
        (value,) = struct.unpack(f"<{self.format}", data)
        return int(value)

    def __str__(self) -> str:
        return f"0x{self.index:04X}" + (f":{self.sub}" if self.sub else "")


def packed(items: Sequence[Item], values: Sequence[int]) -> bytes:
    """Put values into process data.

    >>> packed([Item(0x6040, 0, "H"), Item(0x607A, 0, "i")], [0x3F, -2]).hex()
    '3f00feffffff'
    """
    return b"".join(item.pack(value) for item, value in zip(items, values, strict=True))


def unpacked(items: Sequence[Item], data: bytes) -> list[int] | None:
    """Take the values out of process data; None when the length is wrong.

    >>> unpacked([Item(0x6041, 0, "H"), Item(0x6064, 0, "i")], bytes.fromhex("3702feffffff"))
    [567, -2]
    """
    layout = struct.Struct("<" + "".join(item.format for item in items))
    return list(layout.unpack(data)) if len(data) == layout.size else None


def mapped(mapping: int) -> tuple[int, int, int]:
    """Return index, subindex and length [bytes] of what a mapping maps.

    >>> mapped(0x60410010)
    (24641, 0, 2)
    """
    return mapping >> 16, mapping >> 8 & 0xFF, (mapping & 0xFF) // 8


def nmt(command: NmtCommand, node: int) -> CanFrame:
    r"""Order a node to change its state.

    >>> nmt(NmtCommand.START, 5)
    CanFrame(id=0, data=b'\x01\x05', extended=False)
    """
    return CanFrame(NMT, bytes((command, node)), extended=False)


def heartbeat(node: int, state: NmtState) -> CanFrame:
    """Say that a node lives; its first one after power-up says so.

    >>> heartbeat(5, NmtState.OPERATIONAL).id
    1797
    """
    return CanFrame(HEARTBEAT + node, bytes((state,)), extended=False)


def state_of(data: bytes) -> NmtState | None:
    r"""Return the state in a heartbeat; None when it is none.

    >>> state_of(b"\x05"), state_of(b"\x33")
    (<NmtState.OPERATIONAL: 5>, None)
    """
    return NmtState(data[0]) if len(data) == 1 and data[0] in set(NmtState) else None


@dataclass(frozen=True, slots=True)
class Emergency:
    """An error that a node reports, or with code 0 that errors are gone.

    >>> print(Emergency(0x8611, 0x21))
    following error (0x8611)
    """

    code: int
    register: int = 0  # of errors, object 0x1001
    vendor: bytes = bytes(5)

    def __str__(self) -> str:
        vendor = f", vendor bytes {self.vendor.hex()}" if any(self.vendor) else ""
        return f"{emergency_words(self.code)} (0x{self.code:04X}{vendor})"

    def frame(self, node: int) -> CanFrame:
        """Return it as a frame of a node.

        >>> Emergency(0x8611, 0x21).frame(5).data.hex()
        '1186210000000000'
        """
        return CanFrame(EMERGENCY + node, struct.pack("<HB5s", self.code, self.register, self.vendor), extended=False)


def emergency_of(data: bytes) -> Emergency | None:
    """Return the emergency in a frame; None when it is none."""
    return Emergency(*struct.unpack("<HB5s", data)) if len(data) == 8 else None
