"""Talkers from any folder of recordings."""

from __future__ import annotations

import logging
import math
import os
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import soundfile

from ross_payload.dsp.recording_limits import HIGHEST_PEAK, HIGHEST_RATE
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Samples

SUFFIXES = frozenset({".aif", ".aiff", ".au", ".caf", ".flac", ".mp3", ".ogg", ".opus", ".w64", ".wav"})
ENROLMENT = 4.0  # cut off the end of the speech when there is no enrolment clip [s]
SHORTEST = 1.0  # of speech, after that [s]
SILENCE = 1e-5  # root mean square, -100 dB re full scale
CLIPPING = 1e-4  # share of samples at full scale

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, eq=False)
class TalkerVoice:
    """One talker: what is heard in the room, and another clip of the same voice to enrol from."""

    name: str
    speech: Samples  # (n,)
    enrolment: Samples  # (m,)
    rate: int  # [Hz]


def load_folder(folder: Path, rate: int, only: Collection[str] = ()) -> tuple[TalkerVoice, ...]:
    """Load every talker of a folder, or some ``only``, at ``rate`` [Hz], sorted by name.

    Each sub-folder with recordings is a talker: files whose name begins with "enrol" are the enrolment clip, the
    others are speech, joined in order of their names. Each recording in the folder itself is a talker too. Any
    sampling rate and any format that libsndfile reads will do; channels are averaged. Without an enrolment clip the
    last 4 s of the speech become it, so that the two never overlap. Other files are left alone.

    Raises
    ------
    ConfigError
        When the folder is missing or holds no recording, or a recording cannot be read, is empty or silent, holds
        NaN, or is too short.
    """
    if not folder.is_dir():
        raise ConfigError(f"{folder}: no such folder of recordings")
    entries = sorted(entry for entry in folder.iterdir() if not entry.name.startswith("."))
    talkers = {entry.name: _recordings(entry) for entry in entries if entry.is_dir()}
    for entry in filter(_is_recording, entries):
        if talkers.get(entry.stem):
            raise ConfigError(f"{folder}: two talkers are named '{entry.stem}': {entry.name} is the second")
        talkers[entry.stem] = [entry]
    wanted = sorted(name for name in talkers if talkers[name] and (not only or name in only))
    for name in wanted:
        _check_name(folder, name)
    voices = tuple(_voice(name, talkers[name], rate) for name in wanted)
    if not voices:
        raise ConfigError(f"{folder}: expected one sub-folder or one file ({_suffixes()}) per talker, got none")
    return voices


def read(path: Path, rate: int) -> Samples:
    """Read one recording as mono at ``rate`` [Hz], (n,).

    Raises
    ------
    ConfigError
        When it cannot be read, is empty, silent, sampled above 192 kHz or louder than any sound, or holds NaN.
    """
    try:
        channels, original = soundfile.read(os.fsencode(path), dtype="float64", always_2d=True)
    except (soundfile.LibsndfileError, OSError) as error:
        raise ConfigError(f"{path}: not a recording that can be read: {why_unreadable(error)}") from error
    if original > HIGHEST_RATE:
        raise ConfigError(f"{path}: expected at most {HIGHEST_RATE} Hz, got {original} Hz")
    mono = channels.mean(axis=1)
    if not mono.size:
        raise ConfigError(f"{path}: is empty (0 s)")
    if not np.isfinite(mono).all():
        raise ConfigError(f"{path}: expected finite samples, got NaN or infinity")
    if (peak := np.abs(mono).max()) > HIGHEST_PEAK:
        raise ConfigError(f"{path}: expected samples of at most {HIGHEST_PEAK:g} re full scale, got {peak:.3g}")
    if math.sqrt(float(np.mean(mono**2))) < SILENCE:
        raise ConfigError(f"{path}: is silent")
    clipped = float(np.mean(np.abs(channels) >= 1 - 2**-15))
    if clipped > CLIPPING:
        _log.warning("%s: is clipped: %.1f %% of its samples are at full scale", path, 100 * clipped)
    return resampled(mono, int(original), rate)


def resampled(samples: np.ndarray, original: int, rate: int) -> Samples:
    """Change the rate of (n,) samples from ``original`` to ``rate`` [Hz].

    >>> resampled(np.ones(320), 32000, 16000).size
    160
    """
    common = math.gcd(original, rate)
    if original != rate:
        from scipy.signal import resample_poly  # noqa: PLC0415  takes long, and is not needed for most recordings

        samples = resample_poly(samples, rate // common, original // common)
    return np.asarray(samples, dtype=np.float32)


def _voice(name: str, paths: Sequence[Path], rate: int) -> TalkerVoice:
    clips = [read(path, rate) for path in paths if path.stem.lower().startswith("enrol")]
    speech = [read(path, rate) for path in paths if not path.stem.lower().startswith("enrol")]
    if not speech:
        raise ConfigError(
            f"{paths[0]}: is an enrolment clip, without speech of its talker beside it: expected a folder that holds "
            "one sub-folder or one file per talker"
        )
    joined = np.concatenate(speech)
    cut = 0 if clips else round(ENROLMENT * rate)
    if joined.size - cut < SHORTEST * rate:
        least = (
            f"{SHORTEST:g} s of speech" if clips else f"{SHORTEST + ENROLMENT:g} s of speech without an enrolment clip"
        )
        raise ConfigError(f"talker '{name}': expected at least {least}, got {joined.size / rate:.1f} s")
    if clips:
        return TalkerVoice(name, joined, np.concatenate(clips), rate)
    return TalkerVoice(name, joined[:-cut], joined[-cut:], rate)


def _check_name(folder: Path, name: str) -> None:
    """Refuse a name that cannot stand in results, which are UTF-8: file names may have another encoding."""
    try:
        name.encode()
    except UnicodeEncodeError as error:
        raise ConfigError(f"{folder}: talker '{name}': expected a name in UTF-8: rename it") from error


def _recordings(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if _is_recording(path))


def _is_recording(path: Path) -> bool:
    return path.is_file() and path.suffix.lower() in SUFFIXES and not path.name.startswith(".")


def _suffixes() -> str:
    return ", ".join(sorted(SUFFIXES))


def why_unreadable(error: Exception) -> str:
    """Say what libsndfile or the system has against a file, without naming it again."""
    return str(getattr(error, "error_string", None) or getattr(error, "strerror", None) or error)
