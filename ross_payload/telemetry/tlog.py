"""Telemetry logs: what pymavlink, MAVProxy, Mission Planner and QGroundControl call a .tlog.

A record is the time as 8 bytes, big endian, in microseconds, and the frame as it went over the wire. The two lowest
bits of the time stand for the link and are 0.
"""

from __future__ import annotations

import errno
import os
from pathlib import Path
from types import TracebackType
from typing import Self

from ross_payload.errors import ConfigError, OutputError


class TlogRecorder:
    """Writes a .tlog record by record, so that a crash leaves whole records only. A context manager.

    Raises
    ------
    ConfigError
        When the file cannot be made.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            self._file = path.open("wb", buffering=0)
        except OSError as error:
            raise ConfigError(f"{path}: cannot be written: {error.strerror}") from error

    def write(self, time_usec: int, frame: bytes) -> None:
        """Append one frame at its time [us].

        Raises
        ------
        OutputError
            When the disk takes no more; the file ends with the last whole record.
        """
        record = (time_usec & ~3).to_bytes(8, "big") + frame
        try:
            written = self._file.write(record)
            if written != len(record):
                self._take_back(written)
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        except OSError as error:
            raise OutputError(f"{self._path.name}: cannot be written: {error.strerror}") from error

    def _take_back(self, written: int) -> None:
        self._file.seek(-written, os.SEEK_CUR)
        self._file.truncate()

    def close(self) -> None:
        """Close the file; idempotent."""
        self._file.close()

    def __enter__(self) -> Self:
        """The file is open from the start."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file."""
        self.close()
