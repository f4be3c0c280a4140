"""Telemetry logs: what pymavlink, MAVProxy, Mission Planner and QGroundControl call a .tlog.

A record is the time as 8 bytes, big endian, in microseconds, and the frame as it went over the wire. The two lowest
bits of the time are the number of the link.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import AbstractContextManager
from itertools import accumulate
from pathlib import Path

from ross_payload.errors import ConfigError, OutputError, refused_as


def tlog_record(time_usec: int, frame: bytes, link: int = 0) -> bytes:
    """Return the record of a frame of a link at its time [us].

    >>> tlog_record(1_000_002, b"frame", link=1).hex(" ", -8)
    '00000000000f4241 6672616d65'
    """
    return (time_usec & ~3 | link & 3).to_bytes(8, "big") + frame


def append_records(file: int, records: Sequence[bytes]) -> None:
    """Write records behind what stands in a file.

    Raises
    ------
    OSError
        When the disk takes no more; the file ends with the last whole record.
    """
    data, done = b"".join(records), 0
    try:
        while done < len(data):
            done += os.write(file, data[done:])
    except OSError:
        whole = max((end for end in accumulate(map(len, records)) if end <= done), default=0)
        if done > whole:
            os.ftruncate(file, os.lseek(file, whole - done, os.SEEK_CUR))
        raise


class TlogRecorder(AbstractContextManager["TlogRecorder"]):
    """Writes a .tlog record by record, so that a crash leaves whole records only. A context manager.

    Raises
    ------
    ConfigError
        When the file cannot be made.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        with refused_as(ConfigError, f"{path}: cannot be written"):
            self._file = path.open("wb", buffering=0)

    def write(self, time_usec: int, frame: bytes) -> None:
        """Append one frame at its time [us].

        Raises
        ------
        OutputError
            When the disk takes no more; the file ends with the last whole record.
        """
        with refused_as(OutputError, f"{self._path.name}: cannot be written"):
            append_records(self._file.fileno(), [tlog_record(time_usec, frame)])

    def close(self) -> None:
        """Close the file; idempotent."""
        self._file.close()

    def __exit__(self, *error: object) -> None:
        """Close the file."""
        self.close()
