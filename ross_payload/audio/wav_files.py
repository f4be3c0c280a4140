"""24-bit WAV that may be cut off anywhere: the header tells after every write how much there is."""

from __future__ import annotations

import os
import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ross_payload.atomic_files import append, create
from ross_payload.audio.channel_map import FULL_SCALE
from ross_payload.bounded_files import open_regular
from ross_payload.errors import ConfigError, refused_as
from ross_payload.interfaces import Samples

WIDTH = 3  # [bytes] of a sample
HEADER = struct.Struct("<4sI4s4sIHHIIHH4sI")  # RIFF, fmt and data, 44 bytes
MOST = 2**32 - 1 - HEADER.size  # [bytes] of samples: the sizes in the header have 32 bits


def counts(samples: Samples) -> NDArray[np.int32]:
    """Round to the 24-bit grid, (n, n_channels); what lies beyond full scale is clipped.

    >>> counts(np.array([[0.5, 1.0, -1.0]], np.float32)).tolist()
    [[4194304], [8388607], [-8388608]]
    """
    return np.clip(np.rint(samples.T * FULL_SCALE), -FULL_SCALE, FULL_SCALE - 1).astype("<i4")


def exact(samples: Samples) -> bool:
    """Whether 24 bits hold the samples without rounding."""
    return np.array_equal(counts(samples).T / np.float32(FULL_SCALE), samples)


class WavFile:
    """Appends to a PCM_24 WAV file; its bytes are with the operating system when `write` returns."""

    def __init__(self, path: Path, rate: int, channels: int = 2) -> None:
        self._rate = rate
        self._channels = channels
        self.bytes = 0  # of samples
        self._file = create(path)
        try:
            append(self._file, self._header())
        except OSError:
            self._file.close()
            path.unlink(missing_ok=True)
            raise

    def write(self, samples: Samples) -> None:
        """Append samples (n_channels, n), then correct the header."""
        packed = counts(samples).reshape(-1, 1).view(np.uint8)[:, :WIDTH].tobytes()
        append(self._file, packed)
        self.bytes += len(packed)
        self._file.seek(0)
        self._file.write(self._header())
        self._file.seek(0, 2)

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _header(self) -> bytes:
        frame = self._channels * WIDTH
        form = (16, 1, self._channels, self._rate, self._rate * frame, frame, 8 * WIDTH)
        return HEADER.pack(b"RIFF", 36 + self.bytes, b"WAVE", b"fmt ", *form, b"data", self.bytes)


class WavReader:
    """Reads such a file as far as there is any, whatever its header says about the length.

    Raises
    ------
    ConfigError
        When the file is missing or is no 24-bit WAV of two channels.
    """

    def __init__(self, path: Path) -> None:
        with refused_as(ConfigError, f"{path.name}: cannot be read"), os.fdopen(open_regular(path), "rb") as file:
            head = file.read(HEADER.size)
        fields = HEADER.unpack(head) if len(head) == HEADER.size else ()
        if (
            not fields
            or not fields[7]
            or (fields[0], fields[2], fields[6], fields[10]) != (b"RIFF", b"WAVE", 2, 8 * WIDTH)
        ):
            raise ConfigError(f"{path.name}: not a 24-bit WAV file of two channels")
        self.rate: int = fields[7]
        self.length = (path.stat().st_size - HEADER.size) // (2 * WIDTH)  # [samples]
        self._bytes = np.memmap(path, np.uint8, "r") if self.length else np.zeros(HEADER.size, np.uint8)

    def read(self, start: int, n: int) -> Samples:
        """Return ``n`` samples from ``start`` on, (2, n); fewer at the end of the file."""
        n = max(min(n, self.length - start), 0)
        place = HEADER.size + start * 2 * WIDTH
        packed = np.zeros((n * 2, 4), np.uint8)
        packed[:, 1:] = self._bytes[place : place + n * 2 * WIDTH].reshape(-1, WIDTH)
        values = packed.view("<i4").reshape(n, 2) >> 8
        return np.ascontiguousarray(values.T / np.float32(FULL_SCALE), dtype=np.float32)
