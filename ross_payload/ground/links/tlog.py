"""A log of everything that is heard and sent: what pymavlink, MAVProxy, Mission Planner and QGroundControl read.

The times are UNIX times; see ``ross_payload.transport.tlog``.
"""

from __future__ import annotations

import asyncio
import os
from contextlib import suppress
from datetime import UTC, datetime
from itertools import count
from pathlib import Path

from ross_payload.errors import reason, refused_as
from ross_payload.ground.errors import GroundError
from ross_payload.transport.tlog import append_records, tlog_record

MAX_WAITING_BYTES = 16_000_000  # bytes that wait for a slow disk


class BufferedTlog:
    """Collects records; `flush` writes them. A disk that takes no more ends the log, not the station.

    Raises
    ------
    GroundError
        When no file can be made there.
    """

    def __init__(self, folder: Path, unix: float) -> None:
        self.error = ""
        self._records: list[bytes] = []
        self._size = 0  # [bytes] of these
        self._writing: asyncio.Future[None] | None = None
        with refused_as(GroundError, f"--log {folder}: cannot be written"):
            folder.mkdir(parents=True, exist_ok=True)
            self.path, self._file = _made(folder, unix)

    def add(self, unix: float, frame: bytes, link: int) -> None:
        """Append a frame of a link at its UNIX time [s]."""
        if self.error:
            return
        if self._size > MAX_WAITING_BYTES:
            self._end("the disk is too slow")
            return
        self._records.append(tlog_record(int(unix * 1e6), frame, link))
        self._size += len(self._records[-1])

    async def flush(self) -> None:
        """Write what was collected, on a thread: a disk may take its time."""
        records, self._records, self._size = self._records, [], 0
        if records and not self.error:
            self._writing = asyncio.ensure_future(asyncio.to_thread(append_records, self._file, records))
            try:
                await asyncio.shield(self._writing)
            except OSError as error:
                self._end(reason(error))

    async def close(self) -> None:
        """Write what was collected and close the file, which goes when nothing is in it; idempotent."""
        if self._writing is not None:
            with suppress(OSError):
                await self._writing  # whoever has waited for it may have been cancelled; the file must stay open
        await self.flush()
        if self._file >= 0:
            if not os.fstat(self._file).st_size:
                self.path.unlink(missing_ok=True)
            os.close(self._file)
            self._file = -1

    def _end(self, why: str) -> None:
        self.error = f"{self.path}: the log has ended: {why}"
        self._records, self._size = [], 0


def _made(folder: Path, unix: float) -> tuple[Path, int]:
    """Make a file that was not there before, named by its UTC time."""
    stem = datetime.fromtimestamp(unix, UTC).strftime("%Y%m%dT%H%M%SZ")
    numbers = count(1)
    while True:
        number = next(numbers)
        path = folder / (f"{stem}.tlog" if number == 1 else f"{stem}-{number}.tlog")
        try:
            return path, os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
        except FileExistsError:
            continue
