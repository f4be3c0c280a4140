"""The file of a log as it was when it was opened, and its times made such that they never fall."""

from __future__ import annotations

import os
import stat
import weakref
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ross_payload.errors import refused_as
from ross_payload.ground.errors import GroundError

PIECE = 1 << 22  # [bytes]
KINDS = ((stat.S_ISFIFO, "a named pipe"), (stat.S_ISSOCK, "a socket"), (stat.S_ISDIR, "a folder"))
EXPECTED = "expected a telemetry log (.tlog) or a session folder"
SET_BACK_US = 1_000_000  # [us] by which a clock falls that was set; less is the order of two links
SET_AHEAD_US = 86_400_000_000  # [us] by which a clock leaps that was set; less is a pause
STRAY_US = 1_000_000  # [us] by which one stamp is off both its neighbours when it is wrong
BOOTED_US = 5_000_000  # [us] after its start no computer runs a program: a clock that says less is a simulation's
CALENDAR_FROM_US = 946_684_800_000_000  # UNIX time of 2000 [us]: a clock that says less counts from a start
CALENDAR_UNTIL_US = 4_102_444_800_000_000  # UNIX time of 2100 [us]: seconds of 32 bits, as of MCAP, end soon after


class LogFile:
    """Bytes of a file that may grow, shrink or be replaced meanwhile: none of that hurts the reader.

    The file is read piece by piece and never mapped: a mapped file that shrinks kills the program.

    Raises
    ------
    GroundError
        When it is no file, or cannot be read.
    """

    def __init__(self, path: Path) -> None:
        with refused_as(GroundError, f"{path}: cannot be read"):
            self._file = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
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


Micros = NDArray[np.int64]


def seconds_of(usec: Micros) -> tuple[NDArray[np.float64], float | None, int]:
    """Return the time of every frame since the first [s], the UNIX time of the first, and how often the clock jumped.

    >>> at, start, jumps = seconds_of(np.array([5_000_000, 6_000_000, 2_000_000, 3_500_000]))
    >>> at.tolist(), start, jumps
    ([0.0, 1.0, 1.0, 2.5], None, 1)
    """
    stamps, lonely = _without_lonely(usec)
    steps = np.diff(stamps, prepend=stamps[:1])
    jumps = (steps < -SET_BACK_US) | (steps > SET_AHEAD_US)
    smooth = stamps - np.cumsum(np.where(jumps, steps, 0))
    at = np.maximum.accumulate(smooth) - smooth[0]
    start = int(stamps[-1] - (smooth[-1] - smooth[0]))
    return at / 1e6, start / 1e6 if CALENDAR_FROM_US < start < CALENDAR_UNTIL_US else None, int(jumps.sum()) + lonely


def is_simulated(stamp: int) -> bool:
    """Whether the first stamp of a log [us] is that of a simulation, which counts from its own start.

    >>> is_simulated(100_000), is_simulated(60_000_000), is_simulated(1_700_000_000_000_000)
    (True, False, False)
    """
    return stamp < BOOTED_US


def _without_lonely(stamps: Micros) -> tuple[Micros, int]:
    """Put a stamp that is far off both its neighbours between them; tell how many there were."""
    if len(stamps) < 3:
        return stamps, 0
    before, here, after = stamps[:-2], stamps[1:-1], stamps[2:]
    middle = np.sort(np.stack([before, here, after]), axis=0)[1]
    lonely = (np.abs(here - middle) > STRAY_US) & (after - before >= -SET_BACK_US) & (after - before <= SET_AHEAD_US)
    return np.concatenate([stamps[:1], np.where(lonely, middle, here), stamps[-1:]]), int(lonely.sum())
