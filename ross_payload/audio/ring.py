"""A ring between the thread that hears and the one that reads: one writer, one reader, nothing allocated, no lock.

The writer only copies. When the reader is too far behind, what has no room is not kept but counted: the frames offered
go on counting, so that the reader finds the gap where it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ross_payload.interfaces import Real, Samples

SMALLEST = 16  # frames of a usual callback, at least: so many marks there are


@dataclass(frozen=True, slots=True)
class Piece:
    """What one callback brought."""

    samples: Samples  # (2, n)
    offered: int  # frames that had been offered to the ring before these
    arrived: float  # on the Clock [s]


class Ring:
    """Holds the frames of two channels and when they arrived.

    ``write`` belongs to one thread, ``read`` to another; each writes only its own counter, after its copying is done.
    """

    def __init__(self, capacity: int) -> None:
        self._frames = np.zeros((2, capacity), np.float32)
        self._marks = max(capacity // SMALLEST, 8)
        self._sizes = np.zeros(self._marks, np.int64)
        self._offers: NDArray[np.int64] = np.zeros(self._marks, np.int64)
        self._arrivals = np.zeros(self._marks, np.float64)
        self._written = 0  # frames kept, by the writer
        self._marked = 0  # pieces kept, by the writer
        self._read = 0  # frames, by the reader
        self._taken = 0  # pieces, by the reader
        self.offered = 0  # frames, kept or not

    @property
    def capacity(self) -> int:
        """Frames that can wait."""
        return self._frames.shape[1]

    @property
    def waiting(self) -> int:
        """Frames that wait."""
        return self._written - self._read

    def write(self, frames: Real, channels: tuple[int, int], arrived: float) -> None:
        """Copy two channels of frames (n, n_channels) that arrived at a time [s]; all of them or none."""
        size, offered = len(frames), self.offered
        self.offered = offered + size
        if size == 0 or size > self.capacity - self.waiting or self._marked - self._taken >= self._marks:
            return
        begin = self._written % self.capacity
        first = min(size, self.capacity - begin)
        for row, channel in enumerate(channels):
            self._frames[row, begin : begin + first] = frames[:first, channel]
            self._frames[row, : size - first] = frames[first:, channel]
        slot = self._marked % self._marks
        self._sizes[slot], self._offers[slot], self._arrivals[slot] = size, offered, arrived
        self._written += size
        self._marked += 1

    def read(self) -> Piece | None:
        """Return the oldest piece, None when there is none."""
        if self._taken == self._marked:
            return None
        slot = self._taken % self._marks
        size = int(self._sizes[slot])
        begin = self._read % self.capacity
        first = min(size, self.capacity - begin)
        samples = np.empty((2, size), np.float32)
        samples[:, :first] = self._frames[:, begin : begin + first]
        samples[:, first:] = self._frames[:, : size - first]
        piece = Piece(samples, int(self._offers[slot]), float(self._arrivals[slot]))
        self._read += size
        self._taken += 1
        return piece
