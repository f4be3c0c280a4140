"""MAVLink 2 signatures: what stands in one, and whether it is right. No key file, no clock.

A signature is the last 13 bytes of a frame: the sender's link id, a timestamp in units of 10 us since 2015, and the
first 48 bits of the SHA-256 of the key and all that comes before.
"""

from __future__ import annotations

import hashlib
import hmac

KEY_SIZE = 32  # [bytes]
SIGNATURE_SIZE = 13  # [bytes]
SECOND = 100_000  # in units of a timestamp
EPOCH = 1_420_070_400  # 1 January 2015, UNIX time [s]
LATEST = 2**48 - 1  # timestamp

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
