"""Times of a log that somebody can play: they never fall, whatever its clock did."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Micros = NDArray[np.int64]
BACK = 1_000_000  # [us] by which a clock falls that was set; less is the order of two links
AHEAD = 86_400_000_000  # [us] by which a clock leaps that was set; less is a pause
ALONE = 1_000_000  # [us] by which one stamp is off both its neighbours when it is wrong
BOOTED = 5_000_000  # [us] after its start no computer runs a program: a clock that says less is a simulation's
SET = 946_684_800_000_000  # UNIX time of 2000 [us]: a clock that says less counts from a start
LAST = 253_402_300_800_000_000  # UNIX time of 10000 [us]: no calendar goes further


def seconds_of(usec: Micros) -> tuple[NDArray[np.float64], float | None, int]:
    """Return the time of every frame since the first [s], the UNIX time of the first, and how often the clock jumped.

    >>> at, start, jumps = seconds_of(np.array([5_000_000, 6_000_000, 2_000_000, 3_500_000]))
    >>> at.tolist(), start, jumps
    ([0.0, 1.0, 1.0, 2.5], None, 1)
    """
    stamps, lonely = _without_lonely(usec)
    steps = np.diff(stamps, prepend=stamps[:1])
    jumps = (steps < -BACK) | (steps > AHEAD)
    smooth = stamps - np.cumsum(np.where(jumps, steps, 0))
    at = np.maximum.accumulate(smooth) - smooth[0]
    start = int(stamps[-1] - (smooth[-1] - smooth[0]))
    return at / 1e6, start / 1e6 if SET < start < LAST else None, int(jumps.sum()) + lonely


def is_simulated(stamp: int) -> bool:
    """Whether the first stamp of a log [us] is that of a simulation, which counts from its own start.

    >>> is_simulated(100_000), is_simulated(60_000_000), is_simulated(1_700_000_000_000_000)
    (True, False, False)
    """
    return stamp < BOOTED


def _without_lonely(stamps: Micros) -> tuple[Micros, int]:
    """Put a stamp that is far off both its neighbours between them; tell how many there were."""
    if len(stamps) < 3:
        return stamps, 0
    before, here, after = stamps[:-2], stamps[1:-1], stamps[2:]
    middle = np.sort(np.stack([before, here, after]), axis=0)[1]
    lonely = (np.abs(here - middle) > ALONE) & (after - before >= -BACK) & (after - before <= AHEAD)
    return np.concatenate([stamps[:1], np.where(lonely, middle, here), stamps[-1:]]), int(lonely.sum())
