"""The file of a log: as much of it as there was when it was opened."""

from __future__ import annotations

import os
import stat
import weakref
from collections.abc import Iterator
from pathlib import Path

from ross_payload.ground.errors import GroundError

PIECE = 1 << 22  # [bytes]
KINDS = ((stat.S_ISFIFO, "a named pipe"), (stat.S_ISSOCK, "a socket"), (stat.S_ISDIR, "a folder"))
EXPECTED = "expected a telemetry log (.tlog) or a session folder"


class Tape:
    """Bytes of a file that may grow, shrink or be replaced meanwhile: none of that hurts the reader.

    The file is read piece by piece and never mapped: a mapped file that shrinks kills the program.

    Raises
    ------
    GroundError
        When it is no file, or cannot be read.
    """

    def __init__(self, path: Path) -> None:
        try:
            self._file = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        except OSError as error:
            raise GroundError(f"{path}: cannot be read: {error.strerror}") from error
        self._path = path
        self.close = weakref.finalize(self, os.close, self._file)
        about = os.fstat(self._file)
        if not stat.S_ISREG(about.st_mode):
            self.close()
            kind = next((words for is_it, words in KINDS if is_it(about.st_mode)), "a device")
            raise GroundError(f"{path}: {EXPECTED}, got {kind}")
        self.size = about.st_size

    def read(self, start: int, size: int) -> bytes:
        """Return ``size`` bytes from ``start``; fewer when the file has shrunk.

        Raises
        ------
        GroundError
            When the disk fails.
        """
        try:
            return os.pread(self._file, size, start)
        except OSError as error:
            raise GroundError(f"{self._path}: cannot be read: {error.strerror}") from error

    def pieces(self) -> Iterator[bytes]:
        """Yield the file piece by piece."""
        for start in range(0, self.size, PIECE):
            yield self.read(start, min(PIECE, self.size - start))
