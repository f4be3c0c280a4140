"""A file that can be written no more, for whatever user a test runs as."""

import os
from contextlib import suppress
from pathlib import Path


def lose(path: Path) -> None:
    """Put a folder in the place of a file: as on a full disk, nothing that is written takes its place."""
    path.unlink()
    path.mkdir()
    (path / "lost").touch()


def fill(path: Path) -> None:
    """Let the disk be full for a file that this process has open: what is written to it finds no room."""
    wanted = path.stat()
    full = os.open("/dev/full", os.O_RDWR)
    try:
        for descriptor in Path("/proc/self/fd").iterdir():
            with suppress(OSError):
                found = os.fstat(int(descriptor.name))
                if (found.st_dev, found.st_ino) == (wanted.st_dev, wanted.st_ino):
                    os.dup2(full, int(descriptor.name))
    finally:
        os.close(full)
