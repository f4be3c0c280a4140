"""Audio files: read whole, written as 24-bit PCM, and never left half-written in place of a good one."""

from __future__ import annotations

import math
import os
import stat
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from pathlib import Path
from typing import Self

import numpy as np
import soundfile

from ross_payload.atomic_files import replacing
from ross_payload.bounded_files import kind_of
from ross_payload.dsp.recording_limits import HIGHEST_PEAK, HIGHEST_RATE
from ross_payload.errors import AudioError, OutputError, reason, refused_as
from ross_payload.interfaces import Real

BLOCK = 65_536  # samples that are read at a time
CANCELLED = 1e-3  # power of the mean of channels over theirs, below which one is inverted


def check_readable(path: Path) -> None:
    """Refuse what no file is, or may not be read.

    Raises
    ------
    AudioError
        With one line that says what is wrong.
    """
    with refused_as(AudioError, f"{path}: cannot be read"):
        try:
            mode = path.stat().st_mode
        except (FileNotFoundError, NotADirectoryError) as error:
            raise AudioError(f"{path}: no such file") from error
        if not stat.S_ISREG(mode):
            raise AudioError(f"{path}: expected an audio file, got {kind_of(mode)}")
        os.close(os.open(path, os.O_RDONLY | os.O_CLOEXEC))


def check_audio(path: Path) -> None:
    """Refuse what is no audio file, as far as its beginning tells.

    Raises
    ------
    AudioError
        With one line that says what is wrong.
    """
    with _opened(path):
        pass


def read_audio(path: Path) -> tuple[Real, int]:
    """Read a file, (n_samples, n_channels), and its rate [Hz].

    Raises
    ------
    AudioError
        When the file is missing, not audio, sampled above 192 kHz or louder than any sound.
    """
    with _opened(path) as file:
        samples = file.read(always_2d=True)
        _check_peak(path, samples)
        return samples, int(file.samplerate)


def read_mono(path: Path, longest: float = math.inf) -> tuple[Real, int, bool]:
    """Read the first seconds of a file, ``longest`` [s] at most, as one channel: the mean of its channels.

    Returns
    -------
    tuple
        Samples (n_samples,), rate [Hz], and whether the file goes on.

    Raises
    ------
    AudioError
        When the file is missing, not audio, empty, sampled above 192 kHz or louder than any sound, holds samples
        that are not finite, or its channels cancel each other.
    """
    read: list[Real] = []
    power = mean_power = 0.0
    with _opened(path) as file:
        left = math.inf if longest == math.inf else round(longest * file.samplerate)
        while len(block := file.read(min(left, BLOCK), always_2d=True)):  # an hour does not fit into the memory
            if not np.isfinite(block).all():
                raise AudioError(f"{path}: expected finite samples, got NaN or infinity")
            _check_peak(path, block)
            read.append(block.mean(axis=1))
            power += float(np.sum(block**2) / block.shape[1])
            mean_power += float(np.sum(read[-1] ** 2))
            left -= len(block)
        if not read:
            raise AudioError(f"{path}: expected speech, got a clip of 0 s")
        if mean_power < CANCELLED * power:
            raise AudioError(f"{path}: expected channels to add up, got some that cancel the others: invert these")
        return np.concatenate(read), int(file.samplerate), left == 0 and len(file.read(1)) > 0


@contextmanager
def _opened(path: Path) -> Iterator[soundfile.SoundFile]:
    """Open a file for reading; whatever libsndfile says against it becomes an AudioError."""
    check_readable(path)
    try:
        with soundfile.SoundFile(os.fsencode(path)) as file:  # of any name: a text would have to be UTF-8
            if file.samplerate > HIGHEST_RATE:
                raise AudioError(f"{path}: expected at most {HIGHEST_RATE} Hz, got {file.samplerate} Hz")
            yield file
    except (soundfile.LibsndfileError, RuntimeError, TypeError) as error:  # a raw file tells no rate
        raise AudioError(f"{path}: expected audio that libsndfile can read") from error


def _check_peak(path: Path, samples: Real) -> None:
    peak = float(np.abs(samples).max(initial=0.0))
    if HIGHEST_PEAK < peak < math.inf:
        raise AudioError(f"{path}: expected samples of at most {HIGHEST_PEAK:g} re full scale, got {peak:.3g}")


OWN = 0o600  # who may read what people have said
BUFFER = 16000  # samples that wait to be written together: a hop at a time would cost more than the hearing


class WavWriter:
    """Writes PCM_24 WAV beside its place and puts it there when closed, also after an exception.

    One of which the disk has not taken all is deleted, and takes the place of no good file. The file is for its owner
    alone: it may hold what people have said.
    PCM_24 because float WAV files carry a time stamp and would differ from run to run.
    """

    def __init__(self, path: Path, rate: int, channels: int) -> None:
        self._path = path
        self._waiting: list[Real] = []
        self._pending = 0  # samples waiting
        self._error: OutputError | None = None  # why it is not whole
        with ExitStack() as stack, self._reported():
            part = stack.enter_context(replacing(path, OWN))
            self._file = soundfile.SoundFile(
                os.fsencode(part), "w", samplerate=rate, channels=channels, subtype="PCM_24", format="WAV"
            )
            self._place = stack.pop_all()

    def write(self, samples: Real) -> None:
        """Append samples (n_channels, n).

        Raises
        ------
        OutputError
            When the disk is full or gone.
        """
        self._waiting.append(samples)
        self._pending += samples.shape[1]
        if self._pending >= BUFFER:
            self._flush()

    def _flush(self) -> None:
        waiting, self._waiting, self._pending = self._waiting, [], 0
        if not waiting:
            return
        with self._reported():
            self._file.write(np.clip(np.concatenate(waiting, axis=1), -1.0, 1.0 - 2.0**-23).T)

    def close(self) -> None:
        """Finish the file and put it in place; idempotent."""
        if self._file.closed:
            return
        if self._error is not None:  # which was raised
            with self._reported():
                with suppress(soundfile.LibsndfileError):
                    self._file.close()
                self._place.__exit__(type(self._error), self._error, None)
            return
        with self._reported(), self._place, closing(self._file):
            self._flush()

    @contextmanager
    def _reported(self) -> Iterator[None]:
        try:
            yield
        except (OSError, soundfile.LibsndfileError) as error:
            told = isinstance(error, OSError) and error.errno  # libsndfile does not tell
            words = error.error_string if isinstance(error, soundfile.LibsndfileError) else error  # without a file
            why = reason(error) if told else f"is the disk full? ({words})"
            self._error = OutputError(f"{self._path.name}: cannot be written: {why}")
            raise self._error from error

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def gain_in_files(voices: Iterable[Real]) -> float:
    """Return the gain of voices (n,) in their files with which none exceeds full scale; 1 where none does anyhow."""
    loudest = max((float(np.abs(voice).max(initial=0.0)) for voice in voices), default=0.0)
    return 1.0 if loudest <= 1 else 1 / loudest


def write_wav(path: Path, samples: Real, rate: int) -> None:
    """Write samples (n,) or (n_channels, n) as PCM_24, for their owner alone."""
    block = np.atleast_2d(samples)
    with WavWriter(path, rate, block.shape[0]) as writer:
        writer.write(block)
