"""MAVLink FTP: what lies in the 251 bytes of FILE_TRANSFER_PROTOCOL, as far as reading needs it."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common

HEAD = struct.Struct("<HBBBBBxI")
SIZE = 251  # of the payload [bytes]
MOST = SIZE - HEAD.size  # data in one payload [bytes]


class Opcode(IntEnum):
    """What is asked for, or answered."""

    NONE = 0
    TERMINATE = 1
    RESET = 2
    LIST = 3
    OPEN_RO = 4
    READ = 5
    CRC32 = 14
    BURST_READ = 15
    ACK = 128
    NAK = 129


class Error(IntEnum):
    """Why something is not done: the first byte of the data of a NAK."""

    FAIL = 1
    INVALID_DATA_SIZE = 3
    INVALID_SESSION = 4
    END_OF_FILE = 6
    UNKNOWN_COMMAND = 7
    FILE_NOT_FOUND = 10


@dataclass(frozen=True, slots=True)
class Packet:
    """One request or answer."""

    sequence: int
    opcode: int
    session: int = 0
    size: int = 0  # of the data, or how much of a file is wanted [bytes]
    asked: int = 0  # of an answer: the opcode that it answers
    burst_complete: bool = False
    offset: int = 0  # in the file [bytes]
    data: bytes = b""


def packet_of(message: Any) -> Packet | None:
    """Return what a message carries; None: it is not of this protocol."""
    if message.get_msgId() != common.MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL:
        return None
    payload = bytes(message.payload)
    sequence, session, opcode, size, asked, complete, offset = HEAD.unpack_from(payload)
    data = payload[HEAD.size :][:size]
    return Packet(sequence, opcode, session, size, asked, bool(complete), offset, data)


def message_of(packet: Packet, target: ComponentId) -> Any:
    """Return the FILE_TRANSFER_PROTOCOL message that carries a packet to somebody."""
    head = HEAD.pack(
        packet.sequence % 65536,
        packet.session,
        packet.opcode,
        packet.size,
        packet.asked,
        packet.burst_complete,
        packet.offset,
    )
    payload = (head + packet.data).ljust(SIZE, b"\0")
    return common.MAVLink_file_transfer_protocol_message(0, *target, list(payload))


def checksum(content: bytes) -> int:
    """Return the CRC32 of a file as component metadata wants it: from 0, and not inverted at the end.

    >>> hex(checksum(b"123456789"))
    '0x2dfd2d88'
    """
    return zlib.crc32(content, 0xFFFFFFFF) ^ 0xFFFFFFFF
