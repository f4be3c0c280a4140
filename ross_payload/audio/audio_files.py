"""Audio files: read whole, written as 24-bit PCM, and never left half-written in place of a good one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Self

import numpy as np
import soundfile

from ross_payload.atomic_files import replacing
from ross_payload.errors import AudioError, OutputError, refused_as
from ross_payload.interfaces import Real


def read_audio(path: Path) -> tuple[Real, int]:
    """Read a file, (n_samples, n_channels), and its rate [Hz].

    Raises
    ------
    AudioError
        When the file is missing or not audio.
    """
    with refused_as(AudioError, f"{path}: cannot be read"):
        if not path.is_file():
            raise AudioError(f"{path}: no such file")
    try:
        samples, rate = soundfile.read(path, dtype="float64", always_2d=True)
    except (soundfile.LibsndfileError, RuntimeError, TypeError) as error:  # a raw file tells no rate
        raise AudioError(f"{path}: expected audio that libsndfile can read") from error
    return samples, int(rate)


def read_mono(path: Path) -> tuple[Real, int]:
    """Read a file as one channel (n_samples,), the mean of its channels, and its rate [Hz].

    Raises
    ------
    AudioError
        When the file is missing, not audio, empty, or holds samples that are not finite.
    """
    samples, rate = read_audio(path)
    if len(samples) == 0:
        raise AudioError(f"{path}: expected speech, got a clip of 0 s")
    if not np.isfinite(samples).all():
        raise AudioError(f"{path}: expected finite samples, got NaN or infinity")
    return samples.mean(axis=1), rate


BUFFER = 16000  # samples that wait to be written together: a hop at a time would cost more than the hearing


class WavWriter:
    """Writes PCM_24 WAV beside its place and puts it there when closed, also after an exception.

    PCM_24 because float WAV files carry a time stamp and would differ from run to run.
    """

    def __init__(self, path: Path, rate: int, channels: int, mode: int = 0o666) -> None:
        self._path = path
        self._waiting: list[Real] = []
        self._pending = 0  # samples waiting
        with ExitStack() as stack, self._reported():
            part = stack.enter_context(replacing(path, mode))
            self._file = soundfile.SoundFile(
                part, "w", samplerate=rate, channels=channels, subtype="PCM_24", format="WAV"
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
        with self._reported(), self._place, closing(self._file):
            self._flush()

    @contextmanager
    def _reported(self) -> Iterator[None]:
        try:
            yield
        except (OSError, soundfile.LibsndfileError) as error:
            raise OutputError(f"{self._path.name}: cannot be written: is the disk full? ({error})") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def write_wav(path: Path, samples: Real, rate: int, mode: int = 0o666) -> None:
    """Write samples (n,) or (n_channels, n) as PCM_24; the umask narrows who may read them."""
    block = np.atleast_2d(samples)
    with WavWriter(path, rate, block.shape[0], mode) as writer:
        writer.write(block)
