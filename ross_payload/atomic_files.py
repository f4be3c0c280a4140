"""Files that are whole or not there, also after a kill or a power cut, and files for their owner alone."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import FileIO
from pathlib import Path
from typing import Any

PART = ".part"  # in the name of what is not whole yet
NO_LINKS = (errno.EPERM, errno.EOPNOTSUPP, errno.ENOSYS, errno.EMLINK)  # of a file system without hard links


def make_private(folder: Path) -> None:
    """Make a folder, and those that are missing above it, for their owner alone, whatever the umask.

    `Path.mkdir` gives its mode to the last one only: whoever may write above it can put another in its place.

    Raises
    ------
    OSError
        When it cannot be made; FileExistsError when something else is there.
    """
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
    except FileNotFoundError:
        if folder.parent == folder:
            raise
        make_private(folder.parent)
        folder.mkdir(mode=0o700, exist_ok=True)


@contextmanager
def replacing(path: Path, mode: int = 0o666) -> Iterator[Path]:
    """Give an empty file beside ``path``; it takes the place of ``path`` in the end, unless something went wrong.

    Its name is its own, so that of two writers the last wins with a whole file. ``mode`` is narrowed by the umask.

    Raises
    ------
    OSError
        When it cannot be made or put in place.
    """
    part, handle = _part_of(path, mode)
    os.close(handle)
    try:
        yield part
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def _part_of(path: Path, mode: int) -> tuple[Path, int]:
    """Make and open a file beside ``path``."""
    part = path.with_name(f".{secrets.token_hex(4)}{PART}-{path.name}")  # with its suffix, by which formats are chosen
    return part, os.open(part, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, mode)


def remove_leftovers(folder: Path, pattern: str) -> None:
    """Remove what kills left of files in ``folder`` whose names match; what is being written now stays."""
    for part in folder.glob(f".{8 * '?'}{PART}-{pattern}"):
        with suppress(OSError):
            handle = os.open(part, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                part.unlink()
            finally:
                os.close(handle)


def write_whole(path: Path, data: bytes, *, new: bool = False) -> None:
    """Write a file crash-safe, for its owner alone, and its folder where it is missing; if ``new``, in place of none.

    It is locked while it is written: what nobody has locked was left by a kill.

    Raises
    ------
    OSError
        When it cannot be written; FileExistsError when it is to be new and is there.
    """
    make_private(path.parent)
    part, handle = _part_of(path, 0o600)
    try:
        with FileIO(handle, "w") as file:  # all through the one that is locked: SMB refuses any other
            with suppress(OSError):  # a file system without locks
                fcntl.flock(file, fcntl.LOCK_EX)
            append(file, data)
            os.fsync(handle)
            if new:
                _put_in_place_of_none(part, path)
            else:
                part.replace(path)
    finally:
        part.unlink(missing_ok=True)
    synchronise(path.parent)  # the new name, too, outlives a power cut


def synchronise(path: Path) -> None:
    """Have a file, or the names in a folder, outlive a power cut.

    Raises
    ------
    OSError
        When the disk fails.
    """
    handle = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _put_in_place_of_none(part: Path, path: Path) -> None:
    """Give a file its name unless that is taken."""
    try:
        os.link(part, path)
    except OSError as error:
        if error.errno not in NO_LINKS:
            raise
        os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600))  # taken: nobody else may
        part.replace(path)


def json_text(values: Any) -> str:
    """Return plain values as indented JSON, as it stands in a file of results."""
    return json.dumps(values, indent=2, allow_nan=False) + "\n"


def create(path: Path) -> FileIO:
    """Make a new file for its owner alone, without a buffer of our own: what was written survives a kill."""
    return FileIO(os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600), "r+")


def append(file: FileIO, data: bytes) -> None:
    """Write all of it; a disk that takes only a part of it raises with the rest."""
    view = memoryview(data)
    while view:
        view = view[file.write(view) or 0 :]
