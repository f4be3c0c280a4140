"""The recorded sessions as files to be read over MAVLink FTP: names are checked, and the disk is another thread's.

Only regular files of sessions are offered, and no link is followed: whatever lies in the folder, nothing outside it can
be read. Functions that touch the disk run on a thread of their own, since a card may take a second for a sector.
"""

from __future__ import annotations

import os
import re
import stat
import zlib
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from ross_payload.transport.async_task import begin

FOLDER = "recordings"  # as clients name it
BLOCK = 65_536  # read at once [bytes]
BLOCKS = 2  # that are kept: a portion may lie across two
MOST_SIZE = 2**32 - 1  # of a file: the protocol has 32 bits for its offsets [bytes]
SESSION = re.compile(r"\d{4,}(-\d{8}T\d{6}Z)?")
FILE = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
FLAGS = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC  # a pipe in the folder is not waited for


@dataclass(frozen=True, slots=True)
class Recordings:
    """The folder of the sessions, and how fast its files may be read by all clients of one link together [bytes/s]."""

    folder: Path
    speed: float

    def owns(self, name: str) -> bool:
        """Tell whether a name is meant to be in here."""
        return name.partition("/")[0] == FOLDER

    def entries(self, name: str) -> list[bytes]:
        """Return what is in a folder, as the protocol lists it; from a thread that may wait.

        Raises
        ------
        OSError
            When there is no such folder.
        """
        match name.strip("/").split("/"):
            case [_]:
                names = sorted(each.name for each in os.scandir(self.folder) if each.is_dir(follow_symlinks=False))
                return [b"D" + each.encode() for each in names if SESSION.fullmatch(each)]
            case [_, session]:
                with _folder(self.folder, session) as descriptor:
                    names = sorted(each for each in os.listdir(descriptor) if FILE.fullmatch(each))  # noqa: PTH208
                    found = [(each, os.stat(each, dir_fd=descriptor, follow_symlinks=False)) for each in names]
                return [f"F{each}\t{about.st_size}".encode() for each, about in found if stat.S_ISREG(about.st_mode)]
        raise FileNotFoundError(name)

    def opened(self, name: str) -> DiskFile:
        """Return a file; from a thread that may wait.

        Raises
        ------
        OSError
            When there is no such file, or it is none of a session.
        """
        with self._descriptor(name) as descriptor:
            return DiskFile(self, name, min(os.fstat(descriptor).st_size, MOST_SIZE))

    def checksum(self, name: str) -> int:
        """Return the CRC32 of a file, as the protocol has it; from a thread that may wait.

        Raises
        ------
        OSError
            As for `opened`.
        """
        value, offset = 0xFFFFFFFF, 0
        while block := self.block(name, offset):
            value, offset = zlib.crc32(block, value), offset + len(block)
        return value ^ 0xFFFFFFFF

    def block(self, name: str, offset: int) -> bytes:
        """Return up to `BLOCK` bytes of a file; from a thread that may wait.

        Raises
        ------
        OSError
            As for `opened`.
        """
        with self._descriptor(name) as descriptor:
            return os.pread(descriptor, BLOCK, offset)

    @contextmanager
    def _descriptor(self, name: str) -> Iterator[int]:
        match name.split("/"):
            case [_, session, file] if FILE.fullmatch(file):
                with _folder(self.folder, session) as folder:
                    descriptor = os.open(file, FLAGS, dir_fd=folder)
            case _:
                raise FileNotFoundError(name)
        try:
            if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                raise FileNotFoundError(name)
            yield descriptor
        finally:
            os.close(descriptor)


@contextmanager
def _folder(parent: Path, session: str) -> Iterator[int]:
    if not SESSION.fullmatch(session):
        raise FileNotFoundError(session)
    descriptor = os.open(parent / session, FLAGS | os.O_DIRECTORY)
    try:
        yield descriptor
    finally:
        os.close(descriptor)


@dataclass(slots=True)
class DiskFile:
    """A file that is read block by block in the background."""

    recordings: Recordings
    name: str
    size: int  # when it was opened [bytes]
    _blocks: dict[int, bytes] = field(default_factory=dict)  # by offset
    _coming: tuple[int, Future[bytes]] | None = None

    def read(self, offset: int, size: int) -> bytes | None:
        """Return a portion, empty behind the end; None: it is not here yet, ask again.

        Raises
        ------
        OSError
            When it cannot be read any more.
        """
        end = min(offset + size, self.size)
        if offset >= end:
            return b""
        self._store_block()
        starts = range(offset // BLOCK * BLOCK, end, BLOCK)
        for start in starts:
            if start not in self._blocks:
                if self._coming is None:
                    self._coming = start, begin(partial(self.recordings.block, self.name, start))
                return None
        whole = b"".join(self._blocks[start] for start in starts)
        return whole[offset - starts[0] : end - starts[0]]

    def _store_block(self) -> None:
        """Take the block that has come in; the oldest makes room for it."""
        if self._coming is None or not self._coming[1].done():
            return
        (start, coming), self._coming = self._coming, None
        self._blocks[start] = coming.result()
        while len(self._blocks) > BLOCKS:
            del self._blocks[next(iter(self._blocks))]
