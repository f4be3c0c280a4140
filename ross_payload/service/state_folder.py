"""The state folder: what outlives a restart."""

from __future__ import annotations

import errno
import fcntl
import logging
import os
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from ross_payload.atomic_files import make_private
from ross_payload.errors import ConfigError
from ross_payload.named_paths import expanded, home_folder, nearest_there

if TYPE_CHECKING:  # `ross health` does without it
    from ross_payload.config import Config

log = logging.getLogger(__name__)
CLOSED = (errno.EACCES, errno.EROFS)  # what is said of a folder that is there and may not be written


def named_folder(named: str, environment: Mapping[str, str] = os.environ) -> Path:
    """Return the folder of what outlives a restart by its name in a configuration; "" leaves it to the environment."""
    named = named or environment.get("STATE_DIRECTORY", "").partition(":")[0]
    if named:
        return _expanded("service.state_dir", named)
    return home_folder("service.state_dir or STATE_DIRECTORY") / ".local" / "state" / "ross"


def state_path(config: Config, environment: Mapping[str, str] = os.environ) -> Path:
    """Return the folder of what outlives a restart; it need not be there."""
    return named_folder(config.service.state_dir, environment)


def recording_path(config: Config, environment: Mapping[str, str] = os.environ) -> Path:
    """Return the folder of the recorded sessions; it need not be there."""
    named = config.recording.folder
    return _expanded("recording.folder", named) if named else state_path(config, environment) / "recordings"


def state_folder(config: Config) -> Path:
    """Return the folder of what outlives a restart, made when it is missing, for its owner alone.

    Raises
    ------
    ConfigError
        When it cannot be made.
    """
    folder = state_path(config)
    try:
        make_private(folder)
    except OSError as error:
        raise _unmade(folder, error.errno) from error
    return folder


@contextmanager
def owned(folder: Path) -> Iterator[None]:
    """Keep other payloads from a state folder; the kernel gives it back when the process ends, however it ends.

    One that is not there is nobody's.

    Raises
    ------
    ConfigError
        When another payload has it.
    """
    with ExitStack() as stack:
        try:
            handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
            stack.callback(os.close, handle)
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            expected = f"expected a folder that no other payload uses, got {folder}"
            raise ConfigError(f"service.state_dir: {expected}: stop the other one, or name another folder") from error
        except FileNotFoundError:
            pass
        except OSError as error:  # not every file system has locks
            log.warning("%s: %s; another payload in the same folder would not be noticed", folder, error.strerror)
        yield


def check_state_folder(config: Config) -> None:
    """Refuse a folder that cannot be made, and make none.

    Raises
    ------
    ConfigError
        When a file is in its way, or its parents may not be written.
    """
    folder = state_path(config)
    number = _obstacle(folder)
    if number and (number not in CLOSED or nearest_there(folder) != folder):
        raise _unmade(folder, number)


def unusable_recordings(folder: Path, place: Path | None = None) -> str:
    """Return why nothing can be recorded in a folder, '' when it can, and make none.

    ``place`` is where it is on this computer, when that is not what it is called.
    """
    place = place or folder
    number = _obstacle(place)
    verb = "written" if number in CLOSED and nearest_there(place) == place else "made"
    return f"recording.folder: {folder} cannot be {verb}: {os.strerror(number)}" if number else ""


def _obstacle(folder: Path) -> int:
    """Return with which errno a folder could not be made or written; 0: it could."""
    try:
        folder.lstat()
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:  # to `nearest_there` it is merely not there
            return error.errno
    there = nearest_there(folder)
    if not os.path.isdir(there):  # noqa: PTH112 - Path.is_dir raises where a link leads into a closed folder
        return errno.EEXIST if there == folder else errno.ENOTDIR
    if os.access(there, os.W_OK | os.X_OK):
        return 0
    return errno.EROFS if is_read_only(there) else errno.EACCES


def is_read_only(there: Path) -> bool:
    """Whether what is there lies on a file system that is mounted read-only."""
    return bool(os.statvfs(there).f_flag & os.ST_RDONLY)


def _expanded(key: str, named: str) -> Path:
    try:
        return expanded(named)
    except ConfigError as error:
        raise ConfigError(f"{key}: {error}") from error


def _unmade(folder: Path, number: int | None) -> ConfigError:
    return ConfigError(f"service.state_dir: {folder} cannot be made: {os.strerror(number or errno.EIO)}")
