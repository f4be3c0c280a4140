"""Parts of a recording, each with its time, as one file in which every sample is where its time says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import soundfile
from numpy.typing import NDArray

APART_S = 0.01  # by which a sample may be off its time: stamps of a computer that is busy tremble
LONGEST_S = 86_400.0  # of a recording
MOST_BYTES = 2 << 30  # of a recording as 16-bit samples
PIECE = 1 << 16  # frames that are written together


class AudioAssembly:
    """Keeps parts in a file until all are there.

    Parameters
    ----------
    path
        Of that file; it is deleted in the end.
    rate
        Of the samples [Hz].
    channels
        How many.
    """

    def __init__(self, path: Path, rate: int, channels: int) -> None:
        self._path, self._rate, self._channels = path, rate, channels
        self._file = path.open("xb")
        self._parts: list[tuple[int, int, int]] = []  # time [ns], first frame in the file, frames
        self._kept = 0  # frames

    def add(self, time: int, rate: int, samples: NDArray[np.int16]) -> bool:
        """Keep frames (n, n_channels) whose first was heard at ``time`` [ns]; False: they are of another kind."""
        if (rate, samples.shape[1]) != (self._rate, self._channels):
            return False
        self._file.write(samples.tobytes())
        self._parts.append((time, self._kept, len(samples)))
        self._kept += len(samples)
        return True

    def write(self, path: Path) -> tuple[float, float] | None:
        """Write a WAV file; return when it begins and ends [s], None when there is no sample.

        Gaps become silence, what comes twice is left out, and a sample is nowhere more than `APART_S` off its time.
        What lies further behind than a file can hold is left out.
        """
        self._file.flush()
        if not self._kept:
            return None
        frames = np.memmap(self._path, "<i2", "r", shape=(self._kept, self._channels))
        begin, written = min(self._parts)[0], 0
        most = min(round(LONGEST_S * self._rate), MOST_BYTES // (2 * self._channels))
        with soundfile.SoundFile(path, "w", self._rate, self._channels, "PCM_16", format="WAV") as file:
            for time, first, count in sorted(self._parts):
                place = round((time - begin) * self._rate / 1e9)
                if place + count > most:
                    break
                early = 0
                if abs(place - written) > APART_S * self._rate:
                    _silence(file, place - written, self._channels)
                    early = min(max(written - place, 0), count)
                    written = max(place, written)
                file.write(frames[first + early : first + count])
                written += count - early
        return begin / 1e9, begin / 1e9 + written / self._rate

    def close(self) -> None:
        """Delete what was kept."""
        self._file.close()
        self._path.unlink(missing_ok=True)


def _silence(file: soundfile.SoundFile, count: int, channels: int) -> None:
    """Write so many frames of silence; none when it is less than one."""
    while count > 0:
        zeros = np.zeros((min(count, PIECE), channels), np.int16)
        file.write(zeros)
        count -= len(zeros)
