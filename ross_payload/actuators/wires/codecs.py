"""Frames as bytes, for wires that reach into another process over TCP."""

from __future__ import annotations

import struct
from typing import Any

from ross_payload.errors import LinkError
from ross_protocols.can import MOST_DATA, CanFrame

EXTENDED = 0x8000_0000  # the identifier has 29 bits


class RawCodec:
    """Bytes with nothing around them.

    >>> RawCodec().feed(RawCodec().pack(b"ok"))
    [b'ok']
    """

    name = ""

    def pack(self, frame: Any) -> bytes:
        """Return the bytes."""
        return bytes(frame)

    def feed(self, data: bytes) -> list[Any]:
        """Return the bytes, if there are any."""
        return [data] if data else []


class CanCodec:
    """Frames of 16 bytes, as Linux has them: identifier and flag, length, padding, data; little-endian.

    >>> codec = CanCodec()
    >>> codec.pack(CanFrame(0x1234, b"ab")).hex()
    '34120080020000006162000000000000'
    >>> [codec.feed(bytes([byte])) for byte in codec.pack(CanFrame(0x1234, b"ab"))][-1]
    [CanFrame(id=4660, data=b'ab', extended=True)]
    """

    name = "can"
    _FRAME = struct.Struct("<IB3x8s")

    def __init__(self) -> None:
        self._held = b""

    def pack(self, frame: Any) -> bytes:
        """Turn a CanFrame into bytes."""
        return self._FRAME.pack(frame.id | EXTENDED * frame.extended, len(frame.data), frame.data)

    def feed(self, data: bytes) -> list[CanFrame]:
        """Return the frames that are complete.

        Raises
        ------
        LinkError
            When the bytes are no frame.
        """
        data = self._held + data
        whole = len(data) // self._FRAME.size * self._FRAME.size
        self._held = data[whole:]
        return [self._frame(*values) for values in self._FRAME.iter_unpack(data[:whole])]

    def _frame(self, identifier: int, length: int, data: bytes) -> CanFrame:
        extended = identifier >= EXTENDED
        number = identifier - EXTENDED * extended
        if number >= 2 ** (29 if extended else 11) or length > MOST_DATA:
            raise LinkError(f"not a CAN frame: identifier {identifier:#x}, {length} bytes")
        return CanFrame(number, data[:length], extended)
