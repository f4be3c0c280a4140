"""CANopen's reads and writes of an object dictionary (expedited SDO, CiA 301): frames of 8 bytes, both ways.

Numbers of up to four bytes, which is all that a drive is configured with; longer transfers are refused.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from ross_protocols.can import CanFrame
from ross_protocols.canopen.error_texts import abort_words
from ross_protocols.canopen.frames import SDO_REPLY, SDO_REQUEST

UNKNOWN_COMMAND = 0x05040001
ONLY_READ, ONLY_WRITTEN = 0x06010002, 0x06010001
NO_OBJECT, NO_SUBINDEX = 0x06020000, 0x06090011
WRONG_LENGTH, TOO_HIGH, TOO_LOW = 0x06070010, 0x06090031, 0x06090032
NOT_MAPPABLE = 0x06040041
_HEAD = struct.Struct("<BHB")


@dataclass(frozen=True, slots=True)
class Read:
    """Ask for an entry."""

    index: int
    sub: int


@dataclass(frozen=True, slots=True)
class Write:
    """Set an entry, 1 to 4 bytes."""

    index: int
    sub: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Value:
    """The answer to a read, 1 to 4 bytes."""

    index: int
    sub: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Written:
    """The answer to a write."""

    index: int
    sub: int


@dataclass(frozen=True, slots=True)
class Abort:
    """The answer to what is refused.

    >>> print(Abort(0x6099, 1, 0x06090030))
    value out of range
    """

    index: int
    sub: int
    code: int

    def __str__(self) -> str:
        return abort_words(self.code)


def request(node: int, wanted: Read | Write) -> CanFrame:
    r"""Ask a node.

    >>> request(5, Read(0x1000, 0))
    CanFrame(id=1541, data=b'@\x00\x10\x00\x00\x00\x00\x00', extended=False)
    >>> request(5, Write(0x6040, 0, b"\x06\x00")).data.hex()
    '2b40600006000000'
    """
    if isinstance(wanted, Read):
        data = _HEAD.pack(0x40, wanted.index, wanted.sub)
    else:
        data = _HEAD.pack(_expedited(0x23, wanted.data), wanted.index, wanted.sub) + wanted.data
    return CanFrame(SDO_REQUEST + node, data.ljust(8, b"\0"), extended=False)


def reply(node: int, answer: Value | Written | Abort) -> CanFrame:
    """Answer as a node.

    >>> reply(5, Value(0x1000, 0, bytes.fromhex("92010200"))).data.hex()
    '4300100092010200'
    """
    head = (answer.index, answer.sub)
    if isinstance(answer, Value):
        data = _HEAD.pack(_expedited(0x43, answer.data), *head) + answer.data
    elif isinstance(answer, Written):
        data = _HEAD.pack(0x60, *head)
    else:
        data = _HEAD.pack(0x80, *head) + struct.pack("<I", answer.code)
    return CanFrame(SDO_REPLY + node, data.ljust(8, b"\0"), extended=False)


def request_of(data: bytes) -> Read | Write | Abort | None:
    """Return what is asked in a frame; None when it is neither a read nor a short write."""
    if len(data) != 8:
        return None
    command, index, sub = _HEAD.unpack_from(data)
    if command == 0x40:
        return Read(index, sub)
    if command == 0x80:
        return Abort(index, sub, *struct.unpack_from("<I", data, 4))
    return Write(index, sub, _payload(command, data)) if command & 0xE2 == 0x22 else None


def reply_of(data: bytes) -> Value | Written | Abort | None:
    """Return the answer in a frame; None when it is none, or announces more than four bytes.

    >>> reply_of(bytes.fromhex("8000100000000206"))
    Abort(index=4096, sub=0, code=100794368)
    """
    if len(data) != 8:
        return None
    command, index, sub = _HEAD.unpack_from(data)
    if command == 0x60:
        return Written(index, sub)
    if command == 0x80:
        return Abort(index, sub, *struct.unpack_from("<I", data, 4))
    return Value(index, sub, _payload(command, data)) if command & 0xE2 == 0x42 else None


def _expedited(command: int, data: bytes) -> int:
    """Return a command byte with the number of unused bytes."""
    if not 1 <= len(data) <= 4:
        raise ValueError(f"expected 1 to 4 bytes, got {len(data)}")
    return command | (4 - len(data)) << 2


def _payload(command: int, data: bytes) -> bytes:
    """Return the bytes that are used; all when the command does not say how many."""
    unused = command >> 2 & 3 if command & 1 else 0
    return data[4 : 8 - unused]
