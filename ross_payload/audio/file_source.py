"""A recording in the place of the microphones, in real time."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Self

import numpy as np
import soundfile

from ross_payload.audio.audio_files import check_readable
from ross_payload.audio.channel_map import ChannelMap
from ross_payload.audio.open_source import SourceServices
from ross_payload.errors import AudioEnded, AudioError
from ross_payload.interfaces import AudioBlock, Clock
from ross_payload.named_paths import expanded


class FileSource:
    """An AudioSource that plays a file of at least two channels once, as fast as it was recorded.

    Parameters
    ----------
    path
        WAV, FLAC, or what else libsndfile reads.
    rate
        It must have [Hz].
    wiring
        Which of the channels are the microphones.
    clock
        Paces the reading.
    """

    def __init__(self, path: Path, rate: int, wiring: ChannelMap, clock: Clock) -> None:
        self._path = path
        self._rate = rate
        self._wiring = wiring
        self._correction = wiring.correction(rate)
        self._clock = clock
        self._file: soundfile.SoundFile | None = None
        self._began = math.nan  # [s]
        self._index = 0

    @property
    def rate(self) -> int:
        """Sampling rate [Hz]."""
        return self._rate

    def read(self, n: int) -> AudioBlock:
        """Return the next ``n`` samples when their time has come; fewer at the end of the file are not given.

        Raises
        ------
        AudioEnded
            At the end of the file.
        AudioError
            When the source is not open, or the file broken.
        """
        if self._file is None:
            raise AudioError(f"{self._path}: not open")
        try:
            frames = self._file.read(n, dtype="float32", always_2d=True)
        except (soundfile.LibsndfileError, RuntimeError) as error:
            raise AudioError(f"{self._path}: broken after {self._index / self._rate:.2f} s") from error
        if len(frames) < n:
            raise AudioEnded(f"{self._path}: end of file after {self._index / self._rate:.2f} s")
        wired = self._correction.apply(np.ascontiguousarray(frames[:, list(self._wiring.channels)].T))
        index, self._index = self._index, self._index + n
        self._clock.sleep(max(self._began + self._index / self._rate - self._clock.now(), 0.0))
        time = self._began + index / self._rate
        return AudioBlock(wired.samples, index, time, flags=wired.flags, raw=wired.raw, carried=wired.carried)

    def __enter__(self) -> Self:
        """Open the file; its first sample is heard at this moment.

        Raises
        ------
        AudioError
            When it is missing, not audio, lacks the rate or the channels, or was opened before.
        """
        if not math.isnan(self._began):
            raise AudioError(f"{self._path}: can be opened only once")
        check_readable(self._path)
        try:
            file = soundfile.SoundFile(os.fsencode(self._path))
        except (soundfile.LibsndfileError, RuntimeError) as error:
            raise AudioError(f"{self._path}: expected audio that libsndfile can read") from error
        try:
            self._check(file)
        except AudioError:
            file.close()
            raise
        self._file, self._began = file, self._clock.now()
        return self

    def __exit__(self, *exception: object) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def _check(self, file: soundfile.SoundFile) -> None:
        if file.samplerate != self._rate:
            raise AudioError(f"{self._path}: expected {self._rate} Hz (audio.rate_hz), got {file.samplerate} Hz")
        if file.channels < self._wiring.needed:
            raise AudioError(
                f"{self._path}: expected at least {self._wiring.needed} channels (audio.channels), got {file.channels}"
            )


def audio_source(address: str, services: SourceServices) -> FileSource:
    """Make the source ``file:PATH``."""
    return FileSource(expanded(address), services.audio.rate_hz, services.wiring, services.clock)
