"""DroneCAN: transfers to CAN frames and back, whatever they carry: broadcasts, anonymous broadcasts, services."""

from __future__ import annotations

import struct
from binascii import crc_hqx
from collections import Counter
from dataclasses import dataclass

from ross_protocols.can import MOST_DATA, CanFrame

SERVICE, REQUEST = 0x80, 0x8000  # bits of an identifier
START, END, TOGGLE, COUNT = 0x80, 0x40, 0x20, 0x1F  # of a tail byte
ROOM = MOST_DATA - 1  # for the payload of a frame [bytes]
MOST_PAYLOAD = 1024  # of a transfer that is read [bytes]
NOTHING = -1  # has begun
MOST_PARTIAL = 256  # transfers that are not whole yet


@dataclass(frozen=True, slots=True)
class Header:
    """What an identifier says.

    >>> Header.of(0x1E0B7F89)
    Header(number=11, source=9, destination=127, request=False, priority=30)
    """

    number: int  # of the type; of an anonymous broadcast only its two lowest bits
    source: int  # 0: anonymous
    destination: int | None = None  # None: everybody
    request: bool = False  # of a service; else a response
    priority: int = 20  # 0 is the highest

    @classmethod
    def of(cls, identifier: int) -> Header:
        """Read an identifier."""
        priority, source = identifier >> 24, identifier & 0x7F
        if identifier & SERVICE:
            request = bool(identifier & REQUEST)
            return cls(identifier >> 16 & 0xFF, source, identifier >> 8 & 0x7F, request, priority)
        number = identifier >> 8 & 0xFFFF
        return cls(number if source else number & 3, source, priority=priority)

    @property
    def identifier(self) -> int:
        """The identifier of a broadcast or a service."""
        common = self.priority << 24 | self.source
        if self.destination is None:
            return common | self.number << 8
        return common | self.number << 16 | REQUEST * self.request | self.destination << 8 | SERVICE


def anonymous(number: int, discriminator: int, payload: bytes, transfer: int, priority: int) -> CanFrame:
    """Return the one frame of a broadcast of a node without an id; ``discriminator`` is 14 random bits."""
    identifier = priority << 24 | discriminator << 10 | (number & 3) << 8
    return CanFrame(identifier, payload + bytes([START | END | transfer & COUNT]))


def split(identifier: int, payload: bytes, seed: int, transfer: int) -> list[CanFrame]:
    """Return the frames of a transfer; a long one begins with its CRC, and ``seed`` is that of the type's signature.

    >>> [frame.data.hex() for frame in split(0x101, b"123456789", 0xFFFF, 3)]  # CRC 0x29B1
    ['b129313233343583', '3637383963']
    """
    if len(payload) > ROOM:
        payload = struct.pack("<H", crc_hqx(payload, seed)) + payload
    parts = [payload[begin : begin + ROOM] for begin in range(0, len(payload), ROOM)] or [b""]
    last, count = len(parts) - 1, transfer & COUNT
    tails = (START * (n == 0) | END * (n == last) | TOGGLE * (n % 2) | count for n in range(len(parts)))
    return [CanFrame(identifier, part + bytes([tail])) for part, tail in zip(parts, tails, strict=True)]


@dataclass(frozen=True, slots=True)
class Transfer:
    """The payload of a transfer that has arrived as it was sent."""

    payload: bytes
    transfer: int  # 0 to 31


class Reassembler:
    """Reassembles transfers from frames; drops and counts broken ones. The caller knows which types there are.

    CAN delivers a frame twice when its sender alone sees an error in the last bit: the second one is dropped, too.
    """

    def __init__(self) -> None:
        self.broken: Counter[int] = Counter()  # transfers that came damaged or in part, by source
        self._partial: dict[int, tuple[int, bytes]] = {}  # by identifier: the tail wanted next, the data so far
        self._last: dict[int, bytes] = {}  # by identifier: the last frame

    def feed(self, frame: CanFrame, seed: int) -> Transfer | None:
        """Return the transfer that this frame completes; ``seed`` is that of its type."""
        if not frame.data or self._repeats(frame):
            return None
        data, tail, source = frame.data[:-1], frame.data[-1], frame.id & 0x7F
        wanted, before = self._partial.pop(frame.id, (NOTHING, b""))
        if tail & START:
            self.broken[source] += wanted != NOTHING
            wanted, before = tail & COUNT, b""
        whole = before + data
        if tail & ~(START | END) != wanted or len(before) > MOST_PAYLOAD:
            self.broken[source] += 1
        elif not tail & END:
            self._begin(frame.id, wanted ^ TOGGLE, whole)
        elif tail & START:
            return Transfer(whole, tail & COUNT)
        elif crc_hqx(whole[2:], seed) == int.from_bytes(whole[:2], "little"):
            return Transfer(whole[2:], tail & COUNT)
        else:
            self.broken[source] += 1
        return None

    def _repeats(self, frame: CanFrame) -> bool:
        """Whether a frame, with its count of transfers, is the last one again; anonymous ones need not count."""
        if not frame.id & 0x7F:
            return False
        last = self._last.pop(frame.id, b"")
        self._last[frame.id] = frame.data
        if len(self._last) > MOST_PARTIAL:
            del self._last[next(iter(self._last))]
        return last == frame.data

    def _begin(self, identifier: int, tail: int, whole: bytes) -> None:
        self._partial[identifier] = tail, whole
        if len(self._partial) > MOST_PARTIAL:
            del self._partial[next(iter(self._partial))]
