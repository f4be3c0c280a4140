"""What a simulated world is heard with."""

from __future__ import annotations

import math
from collections import deque
from typing import Protocol, Self

import numpy as np

from ross_payload.errors import AudioError
from ross_payload.interfaces import AudioBlock, AudioFlag, Samples

FULL_SCALE = 2**23  # of a 24-bit converter [counts]


class Sounding(Protocol):
    """A world that sounds quantum by quantum while it is open."""

    rate: int  # [Hz]

    def open(self) -> None:
        """Begin to sound."""

    def close(self) -> None:
        """Fall silent."""

    def sound(self) -> tuple[float, Samples]:
        """Return when the next quantum began [s] and what is heard, (2, n), as soon as it is over."""


class WorldMicrophones:
    """The world's AudioSource: reading renders until enough has been heard; nothing is ever skipped."""

    def __init__(self, world: Sounding) -> None:
        self._world = world
        self._blocks: deque[Samples] = deque()
        self._available = 0
        self._index = 0
        self._open = self._opened = False
        self._began = math.nan  # when the first sample was heard [s]

    @property
    def rate(self) -> int:
        """Sampling rate [Hz]."""
        return self._world.rate

    def read(self, n: int) -> AudioBlock:
        """Return the next ``n`` samples.

        Raises
        ------
        AudioError
            When the source is not open.
        """
        if not self._open:
            raise AudioError("the simulated microphones are not open")
        while self._available < n:
            self._hear()
        samples = self._next_samples(n)
        index, self._index = self._index, self._index + n
        clipped = samples.size and (samples.max() >= 1 - 1 / FULL_SCALE or samples.min() <= -1)
        flags = AudioFlag.CLIPPED if clipped else AudioFlag.NONE
        return AudioBlock(samples, index, self._began + index / self.rate, flags=flags)

    def __enter__(self) -> Self:
        """Open the microphones, once.

        Raises
        ------
        AudioError
            When they were opened before.
        """
        if self._opened:
            raise AudioError("the simulated microphones can be opened only once")
        self._open = self._opened = True
        self._world.open()
        return self

    def __exit__(self, *exception: object) -> None:
        """Close them."""
        self._open = False
        self._world.close()

    def _hear(self) -> None:
        begin, samples = self._world.sound()
        if math.isnan(self._began):
            self._began = begin
        self._blocks.append(samples)
        self._available += samples.shape[1]

    def _next_samples(self, n: int) -> Samples:
        self._available -= n
        if self._blocks and self._blocks[0].shape[1] == n:
            return self._blocks.popleft()
        parts, wanted = [np.zeros((2, 0), dtype=np.float32)], n
        while wanted:
            head = self._blocks.popleft()
            parts.append(head[:, :wanted])
            if head.shape[1] > wanted:
                self._blocks.appendleft(head[:, wanted:])
            wanted -= parts[-1].shape[1]
        return np.concatenate(parts, axis=1)
