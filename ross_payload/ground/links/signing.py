"""Signed links of the ground: the key, and a signing time that nothing keeps on a disk."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ross_payload.errors import ConfigError
from ross_payload.ground.errors import GroundError
from ross_payload.transport import signing
from ross_protocols.mavlink.signing import LATEST, SECOND, WINDOW, timestamp_of


def read_key(path: Path) -> bytes:
    """Read a key: 32 bytes, or 64 hexadecimal digits, for its owner's eyes only.

    Raises
    ------
    GroundError
        When it cannot be read, is none, or others can read it too.
    """
    try:
        return signing.read_key(path, "key")
    except ConfigError as error:
        raise GroundError(str(error)) from error


class SigningTime:
    """The local signing time: the system's clock, never back, and never behind a peer that is believed."""

    floor = 0  # nothing is remembered of earlier runs
    trouble = ""  # nor written

    def __init__(self, unix: Callable[[], float]) -> None:
        self._unix = unix
        self._latest = 0

    def stamp(self, now: float) -> int | None:
        """Return a timestamp that was never used; None when there is none left."""
        stamp = max(self._latest + 1, timestamp_of(self._unix()))
        if stamp > LATEST:
            return None
        self._latest = stamp
        return stamp

    def covers(self, timestamp: int, now: float) -> bool:
        """Tell whether a timestamp leaves room to follow it: a day at least."""
        return timestamp < LATEST - 86400 * SECOND

    def behind(self, timestamp: int, now: float) -> bool:
        """Tell whether a timestamp is more than a minute behind ours."""
        return timestamp + WINDOW < max(self._latest, timestamp_of(self._unix()))

    def learn(self, timestamp: int) -> None:
        """Follow a peer that is ahead."""
        self._latest = max(self._latest, timestamp)
