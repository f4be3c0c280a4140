"""A log of everything that is heard and sent: what pymavlink, MAVProxy, Mission Planner and QGroundControl read.

A record is the time as 8 bytes, big endian, UNIX time in microseconds, and the frame as it went over the wire. The two
lowest bits of the time are the number of the link.
"""

from __future__ import annotations

import asyncio
import os
from datetime import UTC, datetime
from itertools import accumulate, count
from pathlib import Path

from ross_payload.ground.errors import GroundError
from ross_payload.ground.links.ports import words

MOST_WAITING = 16_000_000  # bytes that wait for a slow disk


class Log:
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
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self.path, self._file = _made(folder, unix)
        except OSError as error:
            raise GroundError(f"--log {folder}: cannot be written: {words(error)}") from error

    def add(self, unix: float, frame: bytes, link: int) -> None:
        """Append a frame of a link at its UNIX time [s]."""
        if self.error:
            return
        if self._size > MOST_WAITING:
            self._end("the disk is too slow")
            return
        self._records.append((int(unix * 1e6) & ~3 | link & 3).to_bytes(8, "big") + frame)
        self._size += len(self._records[-1])

    async def flush(self) -> None:
        """Write what was collected, on a thread: a disk may take its time."""
        records, self._records, self._size = self._records, [], 0
        if records and not self.error:
            error = await asyncio.to_thread(_written, self._file, records)
            if error is not None:
                self._end(words(error))

    async def close(self) -> None:
        """Write what was collected and close the file, which goes when nothing is in it; idempotent."""
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


def _written(file: int, records: list[bytes]) -> OSError | None:
    """Write the records, or as many whole ones as the disk takes; then return why not all."""
    begin, data, done = os.lseek(file, 0, os.SEEK_CUR), b"".join(records), 0
    try:
        while done < len(data):
            done += os.write(file, data[done:])
    except OSError as error:
        whole = [end for end in accumulate(map(len, records)) if end <= done]
        os.ftruncate(file, begin + (whole[-1] if whole else 0))
        return error
    return None
