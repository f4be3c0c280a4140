"""MAVLink 2 signatures: what stands in one, and whether it is right. No clock.

A signature is the last 13 bytes of a frame: the sender's link id, a timestamp in units of 10 us since 2015, and the
first 48 bits of the SHA-256 of the key and all that comes before.
"""

from __future__ import annotations

import hashlib
import hmac
from enum import Enum
from typing import Protocol

from ross_protocols.mavlink.codec import Packet

KEY_SIZE = 32  # [bytes]
SIGNATURE_SIZE = 13  # [bytes]
SECOND = 100_000  # in units of a timestamp
EPOCH = 1_420_070_400  # 1 January 2015, UNIX time [s]
LATEST = 2**48 - 1  # timestamp
LAST = LATEST - 366 * 86_400 * SECOND  # timestamp that is followed: time has to go on after it
WINDOW = 60 * SECOND  # that a new stream may be behind us
STREAMS = 1024  # that one link keeps apart
UNSIGNED = "RADIO_STATUS"  # a radio has no key

_MARKER, _SIGNED, _DIGEST = 0xFD, 1, 6


def is_signed(frame: bytes) -> bool:
    """Tell whether a frame carries a signature."""
    return frame[0] == _MARKER and bool(frame[2] & _SIGNED)


def link_and_time(frame: bytes) -> tuple[int, int]:
    """Return the link id and the timestamp of a signed frame."""
    return frame[-SIGNATURE_SIZE], int.from_bytes(frame[-SIGNATURE_SIZE + 1 : -_DIGEST], "little")


def is_good(frame: bytes, key: bytes) -> bool:
    """Tell whether a signed frame was signed with this key."""
    digest = hashlib.sha256(key + frame[:-_DIGEST]).digest()[:_DIGEST]
    return hmac.compare_digest(digest, frame[-_DIGEST:])


def timestamp_of(unix: float) -> int:
    """Return the timestamp of a UNIX time [s].

    >>> timestamp_of(EPOCH + 1.5)
    150000
    """
    return min(max(int((unix - EPOCH) * SECOND), 0), LATEST)


class Trust(Enum):
    """What the signature of a packet is worth."""

    BELIEVED = "believed"
    UNSAVED = "its timestamp is not saved to disk yet: after a crash it could be replayed"
    BEHIND = "signed with our key, and behind: its sender has not heard our time yet, or it is a replay"
    OLD = "signed with our key, but it was heard before, or there are too many streams"
    REFUSED = "not signed with our key"


class Time(Protocol):
    """The local signing time, which never goes back."""

    floor: int  # nothing at or below this timestamp is believed
    trouble: str  # why later timestamps cannot be covered; empty when they can

    def stamp(self, now: float) -> int | None:
        """Return a timestamp that was never used, at ``now`` [s]; None while there is none."""

    def covers(self, timestamp: int, now: float) -> bool:
        """Tell whether a timestamp may be believed at ``now`` [s], and followed."""

    def behind(self, timestamp: int, now: float) -> bool:
        """Tell whether a timestamp is more than `WINDOW` behind ours."""

    def learn(self, timestamp: int) -> None:
        """Follow a peer that is ahead."""


class Guardian:
    """Believes or refuses what arrives on one signed link."""

    def __init__(self, key: bytes, time: Time) -> None:
        self.key = key
        self.time = time
        self._streams: dict[tuple[int, int, int], int] = {}  # (link id, system, component) -> latest timestamp

    def believes(self, packet: Packet, now: float) -> bool:
        """Tell whether a packet is signed with our key and newer than what its stream has brought before."""
        return self.judge(packet, now) is Trust.BELIEVED

    def judge(self, packet: Packet, now: float) -> Trust:
        """Return what the signature of a packet is worth at ``now`` [s]."""
        if not is_signed(packet.frame):
            return Trust.BELIEVED if packet.name == UNSIGNED else Trust.REFUSED
        if not is_good(packet.frame, self.key):
            return Trust.REFUSED
        link, timestamp = link_and_time(packet.frame)
        if timestamp > LAST:
            return Trust.UNSAVED  # and never saved: what is signed after it would count from 0 again
        stream = link, packet.system_id, packet.component_id
        before = self._streams.get(stream)
        late = self._late(timestamp, now) if before is None else _not_after(timestamp, before)
        if late is not None:
            if before is not None and self.time.covers(before, now):
                self.time.learn(before)  # it was not on the disk when it came; who is told our time gets past it now
            return late
        self._streams[stream] = timestamp
        if not self.time.covers(timestamp, now):
            return Trust.UNSAVED
        self.time.learn(timestamp)
        return Trust.BELIEVED

    def _late(self, timestamp: int, now: float) -> Trust | None:
        """Return why a new stream cannot begin with a timestamp; None: it can."""
        if len(self._streams) >= STREAMS:
            return Trust.OLD
        return Trust.BEHIND if timestamp <= self.time.floor or self.time.behind(timestamp, now) else None


def _not_after(timestamp: int, before: int) -> Trust | None:
    """Return why a stream cannot go on with a timestamp; None: it can."""
    if timestamp > before:
        return None
    return Trust.BEHIND if timestamp < before else Trust.OLD
