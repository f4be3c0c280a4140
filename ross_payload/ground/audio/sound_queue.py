"""Who listens to a payload: what waits for it, and what it was too slow for."""

from __future__ import annotations

import asyncio
import math
import struct
from collections import deque
from typing import Any

import numpy as np

from ross_payload.interfaces import Samples

HEAD = struct.Struct("<If")  # index of the first sample, modulo 2^32; its age [ms], NaN: not known
MOST_FRAMES = 50  # that wait for a listener, older ones are dropped: half a second
MOST_WORDS = 16


def frame_of(samples: Samples, index: int, age: float | None) -> bytes:
    """Return samples (n,) as a listener gets them: a head, then 16 bits each, little-endian.

    >>> frame_of(np.array([0.5, -1.0, 2.0], np.float32), 7, 0.125).hex()
    '070000000000fa42ff3f0180ff7f'
    """
    whole = (np.clip(samples, -1, 1) * 32767).astype("<i2").tobytes()
    return HEAD.pack(index % 2**32, math.nan if age is None else 1000 * age) + whole


class Listener:
    """One of those who listen; never waited for.

    Parameters
    ----------
    name
        Who it is, in words.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.dropped = 0  # frames that it was too slow for
        self.wake = asyncio.Event()
        self._frames: deque[bytes] = deque(maxlen=MOST_FRAMES)
        self._words: deque[dict[str, Any]] = deque(maxlen=MOST_WORDS)

    def hear(self, frame: bytes) -> None:
        """Keep a frame until it is taken, or too many wait."""
        self.dropped += len(self._frames) == MOST_FRAMES
        self._frames.append(frame)
        self.wake.set()

    def send(self, message: dict[str, Any]) -> None:
        """Keep a message until it is taken."""
        self._words.append(message)
        self.wake.set()

    def due(self) -> tuple[list[dict[str, Any]], list[bytes]]:
        """Take what waits: messages, and frames."""
        self.wake.clear()
        messages, frames = list(self._words), list(self._frames)
        self._words.clear()
        self._frames.clear()
        return messages, frames
