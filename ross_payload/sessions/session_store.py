"""The folder of all sessions: which there are, which is being written, and what has to go."""

from __future__ import annotations

import fcntl
import math
import os
import re
import shutil
import stat
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from ross_payload import config
from ross_payload.atomic_files import PART, make_private, replacing
from ross_payload.bounded_files import open_regular, read_bounded, set_aside
from ross_payload.config.listening_options import MOST_SOURCES
from ross_payload.errors import ConfigError, near, refused_as, shown
from ross_payload.named_paths import home_folder
from ross_payload.sessions import manifest
from ross_payload.sessions.manifest import MANIFEST, is_session

NAME = re.compile(r"(\d{4,})(-\d{8}T\d{6}Z)?")
FILES = (
    "audio.wav", "inputs.jsonl", "events.jsonl", "scores.jsonl", "telemetry.tlog", "memory.npz", "voice.npz",
    "config.json", "session.json", "dated",
    "target.flac", *(f"source-{number}.flac" for number in range(MOST_SOURCES)),
)  # fmt: skip
OURS = frozenset(FILES)
DATED = "dated"  # when a clock that is trusted was there first, in a session that began without one; empty until then
DATED_AT_ONCE = 100  # sessions: what is being recorded waits meanwhile
STAMP = "%Y%m%dT%H%M%SZ"  # of times in names and in `DATED`, UTC
ASIDE = "unreadable"  # in the name of a session.json that was set aside
LOCKED = "inputs.jsonl"  # its writer holds a lock on it, which the kernel takes back when the process dies
GB = 1e9  # [bytes]
DAY = 86_400.0  # [s]


@dataclass(frozen=True, slots=True)
class StoredSession:
    """One session in the store."""

    path: Path
    number: int
    bytes: int
    modified: float  # [s] since 1970, by the clock of the computer
    running: bool
    whole: bool  # its session.json says that it is ours


@dataclass(frozen=True, slots=True)
class SessionStore:
    """A folder with one folder per session; what else lies there is left alone."""

    folder: Path

    def all(self) -> tuple[StoredSession, ...]:
        """Return all sessions, the oldest first."""
        return tuple(kept for kept in self.with_damaged() if kept.whole)

    def with_damaged(self) -> tuple[StoredSession, ...]:
        """Return all sessions, and what is left of those whose session.json is lost, the oldest first."""
        found = [kept for path in self._paths() if (kept := _kept(path)) is not None]
        return tuple(sorted(found, key=lambda kept: kept.number))

    def find(self, name: str) -> StoredSession:
        """Return the session of a name, or what is left of it.

        Raises
        ------
        ConfigError
            When there is none.
        """
        kept = {each.path.name: each for each in self.with_damaged()}
        if name in kept:
            return kept[name]
        names = list(kept)
        raise ConfigError(f"{self.folder}: no session {shown(name)}; see: ross sessions{near(name, names)}")

    def set_damaged_aside(self) -> tuple[str, ...]:
        """Rename every session.json that cannot be read, and return one line about each; nothing is deleted.

        The rest of such a folder stays as it is: its audio can be heard, and `tidy` leaves it alone.
        """
        sessions = [path for path in self._paths() if NAME.fullmatch(path.name) and not path.is_symlink()]
        found = [(path / MANIFEST, why) for path in sessions if (why := manifest.damage(path))]
        return tuple(f"{path}: {why}; {set_aside(path, ASIDE)}" for path, why in found)

    def _paths(self) -> list[Path]:
        """Return what lies in the folder; nothing of one that is none or cannot be read."""
        try:
            return sorted(self.folder.iterdir())
        except OSError:
            return []

    def add(self, stamp: str) -> Path:
        """Make the folder of a new session, mode 0700; ``stamp`` is the time in its name, empty when unknown."""
        make_private(self.folder)
        numbers = [int(match[1]) for path in self.folder.iterdir() if (match := NAME.fullmatch(path.name))]
        number = max(numbers, default=0)
        while True:
            number += 1
            path = self.folder / (f"{number:04d}" + (f"-{stamp}" if stamp else ""))
            try:
                path.mkdir(mode=0o700)
            except FileExistsError:  # another payload writes here too
                continue
            return path

    def doubt(self, path: Path) -> None:
        """Note that nobody confirms the time in the name of a new session; may raise OSError."""
        _date(path, "")

    def delete(self, kept: StoredSession) -> None:
        """Delete a session: the files that we write, then the folder when nothing else is in it.

        Raises
        ------
        ConfigError
            When it is being recorded, or cannot be deleted.
        """
        if kept.running:
            raise ConfigError(f"session '{kept.path.name}' is being recorded: stop the recording first")
        with refused_as(ConfigError, f"{kept.path}: cannot be deleted"):
            self.discard(kept.path)

    def discard(self, path: Path) -> None:
        """Remove our files from a folder, and the folder when nothing else is in it; may raise OSError.

        Its date and session.json go last: what a kill leaves is as old a session still, and goes the next time.
        """
        ours = [path / name for name in FILES if name not in (DATED, MANIFEST)]
        with suppress(FileNotFoundError):  # another payload deletes it this moment, too
            aside = path.glob(f"{MANIFEST}.{ASIDE}*")
            for file in [*path.glob(f".*{PART}*"), *ours, *aside, path / DATED, path / MANIFEST]:
                file.unlink(missing_ok=True)
            if not any(path.iterdir()):
                path.rmdir()

    def tidy(self, limits: config.Recording, running: Path | None = None, stamp: str = "") -> str:
        """Delete what is too old or too much, the oldest first; return why ``running`` must stop, or ''.

        The age of a session counts from the time in its name; the days of one that began without a clock that is
        trusted, or by one that nobody confirmed, or that was far ahead, begin now. Without such a clock nothing is too
        old.

        Parameters
        ----------
        limits
            Of the storage.
        running
            The session that is being recorded.
        stamp
            The time, as `add` has it; empty when no clock can be trusted.

        Raises
        ------
        ConfigError
            When the folder cannot be read, or a session not be deleted.
        OSError
            When nothing can be written there.
        """
        with refused_as(ConfigError, f"recording.folder: {self.folder} cannot be read"):
            if not _is_folder(self.folder):
                return ""
        now, kept = _time(stamp), list(self.all())
        starts = [] if now is None else [(one, _start_time(one, now)) for one in kept if not one.running]
        undated = [one for one, start in starts if start is None]
        for session in _older(starts, now, limits):
            kept.remove(session)
            self.delete(session)
        why = self._too_much(kept, limits, running)
        left = {one.path for one in kept}
        waiting = [one.path for one in undated if one.path in left]
        for path in waiting[:DATED_AT_ONCE]:  # at last: now a full disk has room
            with suppress(FileNotFoundError):  # another payload has deleted it meanwhile
                _date(path, stamp)
        return why

    def doubtful(self, limits: config.Recording) -> int:
        """Count the sessions that are too old if the clock of this computer is right, by name or files.

        Raises
        ------
        OSError
            When nothing can be written there.
        """
        kept = [one for one in self.all() if not one.running]
        if not kept:
            return 0
        now = _now(self.folder)
        starts = [(one, _start_time(one, now) or one.modified) for one in kept]
        return len(_older(starts, now, limits))

    def _too_much(self, kept: list[StoredSession], limits: config.Recording, running: Path | None) -> str:
        """Delete the oldest of these while they are too much, also from the list; return why ``running`` must stop."""
        while sum(one.bytes for one in kept) > limits.max_gb * GB:
            oldest = next((one for one in kept if not one.running and one.path != running), None)
            if oldest is None:
                return "" if running is None else f"the recording has reached max_gb = {limits.max_gb:g}"
            kept.remove(oldest)
            self.delete(oldest)
        free = self.free()
        if free < limits.min_free_gb * GB:
            return f"free disk space: expected min_free_gb = {limits.min_free_gb:g}, got {free / GB:.2f}"
        return ""

    def free(self) -> int:
        """Return what is left on the disk [bytes]."""
        return shutil.disk_usage(self.folder).free


def home(environment: Mapping[str, str] = os.environ) -> Path:
    """Return where sessions lie when no configuration says otherwise."""
    state = environment.get("STATE_DIRECTORY", "").partition(":")[0]
    return (Path(state) if state else home_folder("STATE_DIRECTORY") / ".local" / "state" / "ross") / "recordings"


def _is_folder(path: Path) -> bool:
    """Tell whether there is such a folder; where that cannot be known, raise OSError."""
    try:
        return stat.S_ISDIR(path.stat().st_mode)
    except (FileNotFoundError, NotADirectoryError):
        return False


def _kept(path: Path) -> StoredSession | None:
    match = NAME.fullmatch(path.name)
    if match is None or path.is_symlink() or not ((whole := is_session(path)) or _is_lost(path)):
        return None
    files = _statuses(path)
    if not files:  # somebody deletes it this moment
        return None
    newest = max(file.st_mtime for file in files)
    return StoredSession(path, int(match[1]), sum(file.st_size for file in files), newest, is_running(path), whole)


def _is_lost(path: Path) -> bool:
    """Whether a folder has no session.json that anybody could read: its session may be without one."""
    return not os.path.lexists(path / MANIFEST) or bool(manifest.damage(path))


def _statuses(folder: Path) -> list[os.stat_result]:
    """Return those of our files in a folder; none of one that cannot be read."""
    try:
        with os.scandir(folder) as entries:
            return [status for entry in entries if entry.name in OURS and (status := _status(entry)) is not None]
    except OSError:
        return []


def _status(entry: os.DirEntry[str]) -> os.stat_result | None:
    try:
        return entry.stat(follow_symlinks=False)
    except OSError:
        return None


def is_running(folder: Path) -> bool:
    """Whether a session is being recorded at this moment; where no file can be locked, whether it says no end."""
    try:
        handle = open_regular(folder / LOCKED)
    except OSError:
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:  # a share of another computer
        return not _is_ended(folder)
    else:
        return False
    finally:
        os.close(handle)


def _is_ended(folder: Path) -> bool:
    try:
        return manifest.read(folder).end is not None
    except ConfigError:
        return False


def _older(
    starts: Sequence[tuple[StoredSession, float | None]], now: float | None, limits: config.Recording
) -> list[StoredSession]:
    """Return which of these began more than ``max_days`` ago; none while ``now`` is not known."""
    oldest = -math.inf if now is None else now - limits.max_days * DAY
    return [one for one, start in starts if start is not None and start < oldest]


def _start_time(session: StoredSession, now: float) -> float | None:
    """When a session began [s] since 1970, by its name or the stamp that it was given; None: that is not known.

    A name that is more than a day after ``now`` was given by a clock that was wrong; where there is a stamp, even one
    that is to come, nobody confirmed the name.
    """
    if os.path.lexists(session.path / DATED):
        return _time(_kept_stamp(session.path))
    named = NAME.fullmatch(session.path.name)
    start = _time((named[2] or "")[1:]) if named else None
    return None if start is None or start > now + DAY else start


def _date(folder: Path, stamp: str) -> None:
    """Note when a clock was there first, without waiting for the disk; what a power cut takes of it is noted again."""
    with replacing(folder / DATED, 0o600) as part:
        part.write_text(stamp)


def _kept_stamp(folder: Path) -> str:
    try:
        return read_bounded(folder / DATED).decode()
    except (OSError, ValueError):  # not there, or spoilt
        return ""


def _time(stamp: str) -> float | None:
    """The time [s] since 1970 of a stamp; None when it is none.

    >>> _time("19700102T000000Z"), _time("")
    (86400.0, None)
    """
    try:
        return datetime.strptime(stamp, STAMP).replace(tzinfo=UTC).timestamp()
    except ValueError:
        return None


def _now(folder: Path) -> float:
    """What the computer's clock says, as the file system stamps it."""
    with tempfile.TemporaryFile(dir=folder) as file:
        return os.fstat(file.fileno()).st_mtime
