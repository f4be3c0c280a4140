"""The public recordings of the benchmark: where they come from, and whether a file is one of them.

A recording is known by a hash of its 16-bit samples, less their rounded mean: so much of it survives in a copy that was
amplified by a constant, with its mean removed, and rounded again, as ours were. Such a copy is restored and used too.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import soundfile
from numpy.typing import NDArray

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real
from ross_sim.talkers.speech import why_unreadable

RATE = 16000  # of LibriSpeech, and of the benchmark [Hz]
FULL_SCALE = 32768
ROUNDING = 1 / 12  # power of the error of rounding to whole numbers
SUFFIXES = (".flac", ".wav")
CORPORA = {"LibriSpeech": "https://www.openslr.org/12"}

Integers = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Recording:
    """One utterance of a public corpus: a line of ``recordings.csv``."""

    utterance: str  # READER-CHAPTER-NUMBER, or what else its file is called
    corpus: str
    subset: str
    licence: str
    sex: str
    samples: int
    mean: float  # of the samples less their rounded mean, in steps of 16 bits
    rms: float  # of the samples less their mean, in steps of 16 bits
    sha256: str  # of the samples less their rounded mean, as little-endian 32-bit integers

    @property
    def reader(self) -> str:
        """Who speaks."""
        return self.utterance.split("-")[0]

    @property
    def download(self) -> str:
        """Where it can be got."""
        return f"{self.subset}.tar.gz at {CORPORA[self.corpus]}" if self.corpus in CORPORA else self.corpus

    def places(self, folder: Path) -> Iterator[Path]:
        """Where it may be in a folder: LibriSpeech's own layout from any level on, or beside the others."""
        chapter = Path(*self.utterance.split("-")[:-1])
        tops = (Path(self.corpus, self.subset) / chapter, Path(self.subset) / chapter, chapter, Path())
        for top in tops:
            yield from (folder / top / f"{self.utterance}{suffix}" for suffix in SUFFIXES)

    def of_the_reader(self, folder: Path) -> Iterator[Path]:
        """Other recordings in a folder of the reader's name."""
        for name in (self.reader, f"ls{self.reader}"):
            if (folder / name).is_dir():
                yield from (path for path in sorted((folder / name).iterdir()) if path.suffix in SUFFIXES)


def centred(samples: Integers) -> Integers:
    """Samples (n,) less their rounded mean.

    >>> centred(np.array([2, 3, 4, 3, 4])).tolist()
    [-1, 0, 1, 0, 1]
    """
    n = samples.size
    return samples - (2 * int(samples.sum()) + n) // (2 * n)


def sha256(samples: Integers) -> str:
    """Hash samples (n,) as little-endian 32-bit integers."""
    return hashlib.sha256(samples.astype("<i4").tobytes()).hexdigest()


def described(utterance: str, samples: Integers, **of_the_corpus: str) -> Recording:
    """The line of ``recordings.csv`` about an utterance with these samples (n,)."""
    own = centred(samples)
    return Recording(
        utterance,
        samples=own.size, mean=float(own.mean()), rms=float(own.std()), sha256=sha256(own), **of_the_corpus,
    )  # fmt: skip


def one_of_each_reader(folder: Path, shortest: int, **of_the_corpus: str) -> list[Recording]:
    """Describe the first recording of every reader of a folder that has at least ``shortest`` samples.

    Raises
    ------
    ConfigError
        When there is none, or one cannot be read, is silent, or has another rate, more channels or a space in its name.
    """
    lines: dict[str, Recording] = {}
    for path in sorted(path for path in folder.rglob("*") if path.suffix in SUFFIXES):
        line = Recording(path.stem, samples=0, mean=0.0, rms=0.0, sha256="", **of_the_corpus)
        if line.reader in lines or path not in line.places(folder):
            continue
        if len(path.stem.split()) != 1:
            raise ConfigError(f"{path}: expected a name without spaces")
        try:
            about = soundfile.info(path)
            if (about.samplerate, about.channels) != (RATE, 1):
                got = f"{about.channels} at {about.samplerate} Hz"
                raise ConfigError(f"{path}: expected one channel at {RATE} Hz, got {got}")
            if about.frames < shortest:
                continue
            line = described(path.stem, soundfile.read(path, dtype="int16")[0].astype(np.int64), **of_the_corpus)
        except (soundfile.LibsndfileError, OSError) as error:
            raise ConfigError(f"{path}: not a recording that can be read: {why_unreadable(error)}") from error
        if not line.rms > 0:
            raise ConfigError(f"{path}: expected a voice, got silence")
        lines[line.reader] = line
    if not lines:
        kinds = " or ".join(f"*{suffix}" for suffix in SUFFIXES)
        raise ConfigError(
            f"{folder}: expected recordings of at least {shortest / RATE:g} s, {kinds}, "
            "all in this folder or in READER/CHAPTER, got none"
        )
    return list(lines.values())


def restored(copy: Integers, recording: Recording) -> Integers:
    """Undo the gain of a copy (n,) that is its recording, less its mean, times a constant of at least 1, rounded.

    >>> original = np.array([-20, 8, 3, -4, 12])
    >>> copy = np.round(1.37 * (original - original.mean()))
    >>> of_the_corpus = {"corpus": "", "subset": "", "licence": "", "sex": ""}
    >>> restored(copy, described("1-2-0", original, **of_the_corpus)).tolist()
    [-20, 8, 3, -4, 12]
    """
    gain = np.sqrt(max(float(copy.var()) - ROUNDING, 0.0)) / recording.rms
    if not gain > 0:
        return copy
    return np.asarray(np.round((copy - copy.mean()) / gain + recording.mean), np.int64)


def found(folder: Path, recordings: Iterable[Recording]) -> dict[str, Real]:
    """Find recordings in a folder: samples (n,), 1 at full scale, by utterance.

    Raises
    ------
    ConfigError
        When there is no such folder, or recordings are missing or differ; names the first, and where to get it.
    """
    if not folder.is_dir():
        raise ConfigError(f"{folder}: expected a folder of recordings, got none")
    samples: dict[str, Real] = {}
    lacking: list[tuple[Recording, str]] = []
    for recording in recordings:
        own = _of(folder, recording)
        if isinstance(own, str):
            lacking.append((recording, own))
        else:
            samples[recording.utterance] = own / FULL_SCALE
    if lacking:
        recording, why = lacking[0]
        more = f"; {len(lacking) - 1} more are missing or differ" if len(lacking) > 1 else ""
        name = f"{recording.utterance} of {recording.corpus}"
        raise ConfigError(f"{folder}: {name} {why}; it is in {recording.download}{more}")
    return samples


def _of(folder: Path, recording: Recording) -> Integers | str:
    """Samples (n,) of one recording, or why there are none."""
    named = [path for path in recording.places(folder) if path.is_file()]
    differs = ""
    for path in named or recording.of_the_reader(folder):
        samples = _read(path, recording)
        if isinstance(samples, str):
            differs = differs or f"is not in {path.relative_to(folder)}, {samples}"
        else:
            return samples
    return differs or "is missing"


def _read(path: Path, recording: Recording) -> Integers | str:
    """Samples (n,) of a file that is this recording, or what differs."""
    try:
        about = soundfile.info(path)
        if (about.samplerate, about.channels, about.frames) != (RATE, 1, recording.samples):
            got = f"{about.channels} x {about.frames} samples at {about.samplerate} Hz"
            return f"which has {got}, not 1 x {recording.samples} at {RATE} Hz"
        samples = soundfile.read(path, dtype="int16")[0].astype(np.int64)
    except (soundfile.LibsndfileError, OSError):
        return "which cannot be read"
    for candidate in (centred(samples), restored(samples, recording)):
        if sha256(candidate) == recording.sha256:
            return candidate
    return f"whose samples have the SHA-256 {sha256(centred(samples))[:12]}... and not {recording.sha256[:12]}..."
