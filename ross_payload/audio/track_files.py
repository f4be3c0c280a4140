"""Files of one voice, FLAC or WAV with 24 bits, that may be cut off anywhere and are read as far as they go.

libFLAC writes how many samples there are only when a file is closed, and without that number libsndfile reads nothing
back. So the number in the STREAMINFO block (RFC 9639, 8.2) is kept up with every block of samples that is on the disk.
"""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Protocol

import numpy as np
import soundfile

from ross_payload.audio.wav_files import MOST, WIDTH, WavFile
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Samples

SUFFIXES = (".flac", ".wav")
FLAC_BLOCK = 4096  # samples that libFLAC encodes together
COUNT_OFFSET = 21  # [bytes] of the 36 bits that hold the number of samples; 4 other bits share the first byte
LOUDEST = 1 - 2.0**-23
GAP = 16_000  # zeros that are written together


class Track(Protocol):
    """A file of one channel; every method may raise OSError."""

    def write(self, samples: Samples) -> None:
        """Append samples (n,)."""

    def close(self) -> None:
        """Finish the file; idempotent."""


class FlacTrack:
    """A FLAC file that is new; a killed process loses at most `FLAC_BLOCK` samples and one."""

    def __init__(self, path: Path, rate: int) -> None:
        self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
        self._written = self._size = 0
        try:
            self._encoder = soundfile.SoundFile(
                self._file, "w", samplerate=rate, channels=1, format="FLAC", subtype="PCM_24", closefd=False
            )
        except soundfile.LibsndfileError as error:
            os.close(self._file)
            raise self._disk_error() from error

    def write(self, samples: Samples) -> None:
        """Append samples (n,); what lies beyond full scale is clipped."""
        try:
            self._encoder.write(np.clip(samples, -1.0, LOUDEST))
        except (soundfile.LibsndfileError, AssertionError) as error:  # an encoder that failed once asserts from then on
            raise self._disk_error() from error
        self._written += len(samples)
        size = os.fstat(self._file).st_size
        if size != self._size:
            self._size = size
            self._count((self._written - 1) // FLAC_BLOCK * FLAC_BLOCK)

    def close(self) -> None:
        """Write what waits and close; idempotent."""
        if self._encoder.closed:
            return
        try:
            self._encoder.close()
        except soundfile.LibsndfileError as error:
            raise self._disk_error() from error
        finally:
            os.close(self._file)

    def _count(self, samples: int) -> None:
        """Say in the header how many samples are on the disk."""
        shared = os.pread(self._file, 1, COUNT_OFFSET)[0] & 0xF0
        os.pwrite(self._file, ((shared << 32) | samples).to_bytes(5, "big"), COUNT_OFFSET)

    def _disk_error(self) -> OSError:
        """What the system says, which libsndfile does not hand on."""
        try:
            full = os.fstatvfs(self._file).f_bavail == 0
        except OSError:
            full = False
        number = errno.ENOSPC if full else errno.EIO
        return OSError(number, os.strerror(number))


class WavTrack:
    """A WAV file that is new."""

    def __init__(self, path: Path, rate: int) -> None:
        self._file = WavFile(path, rate, channels=1)

    def write(self, samples: Samples) -> None:
        """Append samples (n,); what lies beyond full scale is clipped."""
        if self._file.bytes + WIDTH * len(samples) > MOST:
            raise OSError(errno.EFBIG, os.strerror(errno.EFBIG))
        self._file.write(samples[None])

    def close(self) -> None:
        """Close the file."""
        self._file.close()


class AlignedTrack:
    """A track in which every sample has its place, whatever is missing or comes twice.

    Parameters
    ----------
    path
        Of a file that is not there yet; its suffix tells the format.
    rate
        Sampling rate [Hz].

    Raises
    ------
    ConfigError
        When the suffix is none of `SUFFIXES`.
    OSError
        When it is there, or cannot be made.
    """

    def __init__(self, path: Path, rate: int) -> None:
        self._track: Track = FlacTrack(path, rate) if checked_suffix(path) == ".flac" else WavTrack(path, rate)
        self.length = 0  # [samples]

    def write(self, place: int, samples: Samples) -> None:
        """Write samples (n,) whose first has the index ``place`` in the file; a gap before them becomes silence."""
        while self.length < place:
            zeros = np.zeros(min(place - self.length, GAP), np.float32)
            self._track.write(zeros)
            self.length += len(zeros)
        news = samples[self.length - place :]
        if len(news):
            self._track.write(news)
            self.length += len(news)

    def close(self) -> None:
        """Finish the file; idempotent."""
        self._track.close()


def checked_suffix(path: Path) -> str:
    """Return the suffix of a track, in lower case.

    Raises
    ------
    ConfigError
        When it is none of `SUFFIXES`.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise ConfigError(f"expected a name that ends in {' or '.join(SUFFIXES)}, got '{path.name}'")
    return suffix
