"""Signed links: the key, and the signing time that never goes back.

One number on disk, the bound, guards both ways: no timestamp above it is ever used or believed. It is raised in steps
of a minute before it is needed. After a crash we go on above the bound, so that no timestamp is used twice, and
believe nothing below it, so that nothing that was recorded before can be played to us again.

While the disk takes nothing, time stands still some seconds below the bound: every frame that we sign is 10 us later
than the one before, so that answers and telemetry go on for hours.
"""

from __future__ import annotations

import logging
import os
import stat
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path

from ross_payload.atomic_files import write_whole
from ross_payload.bounded_files import read_bounded, set_aside
from ross_payload.errors import ConfigError, refused_as
from ross_payload.transport.async_task import begin
from ross_protocols.mavlink.signing import EPOCH, KEY_SIZE, LATEST, SECOND, WINDOW, timestamp_of

FILE = "signing-time"  # in the state folder
STEP = 60 * SECOND  # by which the bound is raised
RESERVE = 10 * SECOND  # below the bound, for us alone while the disk takes nothing
SAVE_TIMEOUT_S = 2.0  # that the disk may take until it is said [s]
SAVE_RETRY_S = 1.0  # after the disk has refused [s]
LONGEST = 64  # file [bytes]
MAX_KEY_FILE_BYTES = 1024  # that are read to see whether it is a key
DAY = 86_400.0  # [s]; a signing time that is farther ahead of the computer's clock is somebody's mistake
SET = EPOCH + 5 * 365 * DAY  # before this UNIX time a computer's clock was never set [s]
log = logging.getLogger(__name__)


def read_key(path: Path, name: str = "key_file") -> bytes:
    """Read a key: 32 bytes, or 64 hexadecimal digits; ``name`` is the option, for messages.

    Raises
    ------
    ConfigError
        When it cannot be read, is none, or others can read it too.
    """
    flags = os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC
    with refused_as(ConfigError, f"{name} {path}: cannot be read"), os.fdopen(os.open(path, flags), "rb") as file:
        mode = os.fstat(file.fileno()).st_mode
        data = file.read(MAX_KEY_FILE_BYTES) if stat.S_ISREG(mode) else b""
    if not stat.S_ISREG(mode):
        raise ConfigError(f"{name} {path}: expected a regular file of 32 bytes, got something else")
    if mode & 0o077:
        raise ConfigError(f"{name} {path}: expected mode 0600, got {stat.S_IMODE(mode):04o}: chmod 600 {path}")
    if len(data) == KEY_SIZE:
        return data
    try:
        key = bytes.fromhex(data.decode("ascii"))
    except ValueError:
        key = b""
    if len(key) != KEY_SIZE:
        raise ConfigError(f"{name} {path}: expected 32 bytes or 64 hexadecimal digits, got {len(data)} bytes")
    return key


class SigningTime:
    """The local signing time of all links; `close` saves how far it went.

    Raises
    ------
    ConfigError
        When the time cannot be saved.
    """

    def __init__(self, state: Path, unix: Callable[[], float], now: float) -> None:
        self._path = state / FILE
        self._unix = unix
        self.floor = self._read()  # nothing at or below this is believed
        self._latest = max(self.floor, timestamp_of(unix()))
        self._origin = self._latest - int(now * SECOND)
        self._bound = 0
        self._next = now
        self._saving: Future[int] | None = None
        self._saving_since = now
        self.trouble = ""  # why the bound cannot be raised
        with refused_as(ConfigError, f"{self._path}: the signing time cannot be saved"):
            self._bound = self._save(self._latest + STEP)
        self._warned = False
        self._warn()

    @property
    def ahead(self) -> str:
        """Why peers that do not follow our time are refused, in words; empty: they are not, as far as is known."""
        clock = self._unix()
        lead = (self._latest - timestamp_of(clock)) / SECOND
        if lead <= DAY or clock < SET:
            return ""
        span = f"{lead / DAY:.0f} days" if lead < 1000 * DAY else f"{lead / DAY / 365.25:.0f} years"
        return f"signing time is {span} ahead of this computer's clock: peers that do not follow it are refused"

    def stamp(self, now: float) -> int | None:
        """Return a timestamp that was never used, at ``now`` [s]; None while the disk is behind."""
        stamp = max(self._latest + 1, self._origin + int(now * SECOND), timestamp_of(self._unix()))
        if not self.covers(stamp, now):
            stamp = self._latest + 1
            if not self.trouble or stamp > self._bound:
                return None
        self._latest = stamp
        return stamp

    def covers(self, timestamp: int, now: float) -> bool:
        """Tell whether a timestamp lies below the bound and its reserve; sees to it that it soon does."""
        if self._saving is not None:
            self._look(self._saving, now)
        if timestamp + STEP // 2 > self._bound and self._saving is None and now >= self._next:
            self._saving, self._saving_since = begin(lambda: self._save(timestamp + STEP)), now
        return timestamp <= self._bound - RESERVE

    def _look(self, saving: Future[int], now: float) -> None:
        """See what has become of the latest attempt to raise the bound."""
        if not saving.done():
            if now - self._saving_since > SAVE_TIMEOUT_S:
                self.trouble = f"{self._path}: the disk does not respond"
            return
        self._saving, error = None, saving.exception()
        if error is None:
            self._bound, self.trouble = saving.result(), ""
        else:
            self._next = now + SAVE_RETRY_S
            self.trouble = f"{self._path}: {getattr(error, 'strerror', None) or error}"

    def behind(self, timestamp: int, now: float) -> bool:
        """Tell whether a timestamp is more than a minute behind ours."""
        return timestamp + WINDOW < max(self._latest, self._origin + int(now * SECOND))

    def learn(self, timestamp: int) -> None:
        """Follow a peer that is ahead."""
        if timestamp > self._latest + DAY * SECOND:
            self._latest = timestamp
            self._warn()
        self._latest = max(self._latest, timestamp)

    def _warn(self) -> None:
        """Tell the log once, with the remedy."""
        ahead = self.ahead
        if ahead and not self._warned:
            self._warned = True
            remedy = f"correct the clock that is ahead; then stop, delete {self._path}, and give all sides a new key"
            log.warning("%s; %s", ahead, remedy)

    def close(self) -> None:
        """Save how far the time went, so that we go on from there."""
        if self._saving is not None:
            self._saving.exception()
        try:
            self._save(self._latest)
        except OSError:  # the bound that is on disk holds as well
            return

    def _read(self) -> int:
        """Return the saved bound; of a file that cannot be used, the latest that it can have held by the clock.

        What was recorded before the file was last written, or before now, is then not believed.
        """
        try:
            bound = int(read_bounded(self._path, LONGEST))
            if not 0 <= bound <= LATEST:
                raise ValueError(f"expected 0 to {LATEST}")
        except FileNotFoundError:
            return 0
        except (OSError, ValueError):
            written = os.lstat(self._path).st_mtime if os.path.lexists(self._path) else 0.0
            bound = max(timestamp_of(self._unix()), timestamp_of(written) + STEP)
            where = set_aside(self._path, "unreadable")
            log.warning("%s: damaged; %s; messages signed before now are rejected", self._path, where)
        return bound

    def _save(self, bound: int) -> int:
        write_whole(self._path, f"{bound}\n".encode())
        return bound
