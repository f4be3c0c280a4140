"""Synthetic talkers by espeak-ng, each spoken in a fresh child process and kept in the cache.

Different pitch, formants, spectral tilt, accent and speed make them as distinct as the engine allows.
"""

from __future__ import annotations

import json
import struct
import subprocess
import sys
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Samples
from ross_payload.plugins import install_line
from ross_sim.cache import Array, cache_folder, cached, fingerprint
from ross_sim.talkers import texts
from ross_sim.talkers.speech import TalkerVoice, load_folder, resampled

LEVEL = 0.05  # root mean square of every voice, re full scale
TIMEOUT = 60  # for one voice [s]


@dataclass(frozen=True, slots=True)
class Recipe:
    """How one voice is made."""

    name: str
    language: str
    pitch: tuple[int, int]  # lowest and highest [Hz]
    formants: tuple[int, int, int]  # frequencies of the first, second and the higher formants [% of a male voice]
    tilt: int  # strength of the higher formants [%]
    speed: int  # [words per minute]
    extra: str = ""  # further lines of an espeak-ng voice variant
    intonation: int = 50  # how far the pitch moves, 0 to 100

    def variant(self) -> str:
        """Write it as an espeak-ng voice variant."""
        first, second, higher = self.formants
        lines = ["language variant", f"name {self.name}", f"pitch {self.pitch[0]} {self.pitch[1]}"]
        lines += [f"formant {index} {first} 100 100" for index in (0, 1)]
        lines += [f"formant 2 {second} 100 100"]
        lines += [f"formant {index} {higher} {self.tilt} 100" for index in range(3, 9)]
        return "\n".join([*lines, self.extra, ""])


RECIPES = (
    Recipe("arthur", "en", (60, 80), (88, 90, 92), 90, 138),
    Recipe("bella", "en-US", (190, 250), (116, 114, 112), 100, 160),
    Recipe("cedric", "en-GB-x-rp", (120, 165), (102, 104, 100), 130, 172),
    Recipe("dora", "en-GB-scotland", (240, 310), (124, 124, 120), 80, 148),
    Recipe("edgar", "en-US", (82, 108), (98, 102, 106), 60, 150, "roughness 5\nflutter 4"),
    Recipe("fiona", "en-GB-x-gbcwmd", (155, 195), (108, 120, 116), 140, 140),
    Recipe("ivan", "en-GB-x-gbclan", (102, 132), (92, 88, 94), 70, 158, "consonants 130 130"),
    Recipe("hilda", "en", (300, 390), (134, 116, 130), 130, 176, "voicing 80"),
)


def voices_of(folder: Path | None, rate: int) -> tuple[TalkerVoice, ...]:
    """Return the talkers of a folder of recordings, None: the synthetic ones, at ``rate`` [Hz]."""
    return load_folder(folder, rate) if folder is not None else synthetic_voices(rate)


def synthetic_voices(rate: int) -> tuple[TalkerVoice, ...]:
    """Eight talkers that nobody has to record, at ``rate`` [Hz]: at least a minute of speech each, levelled to -26 dB.

    Raises
    ------
    ConfigError
        When espeakng-loader is not installed, or the engine fails or stays silent.
    """
    return tuple(synthetic_voice(index, rate) for index in range(len(RECIPES)))


def synthetic_voice(index: int, rate: int, cache: Path | None = None) -> TalkerVoice:
    """Make one of the synthetic talkers, or read it from the cache."""
    recipe = RECIPES[index]
    said = {"speech": speech_text(index), "enrolment": texts.ENROLMENT[index % 4] + " " + texts.ENROLMENT[index // 4]}
    key = fingerprint(recipe=asdict(recipe), said=said, rate=rate, engine=_engine_version(), layout=1)

    def make() -> dict[str, Array]:
        return {part: levelled(*speak(recipe, text), rate) for part, text in said.items()}

    clips = cached(cache_folder(cache) / "voices" / f"{recipe.name}-{key}.npz", make)
    return TalkerVoice(recipe.name, clips["speech"], clips["enrolment"], rate)


def speech_text(index: int) -> str:
    """Sixteen sentences; neighbours in the list of recipes have none in common.

    >>> set(speech_text(0).split(".")) & set(speech_text(1).split("."))
    {''}
    """
    share = len(texts.SPEECH) // 4
    chosen = [texts.SPEECH[(index % 4) * share + (7 * place + index // 4) % share] for place in range(share)]
    return " ".join(chosen)


def levelled(samples: Samples, original: int, rate: int) -> Samples:
    """Change the rate and bring the root mean square to ``LEVEL``, (n,)."""
    clip = resampled(samples, original, rate)
    return np.asarray(clip * (LEVEL / np.sqrt(np.mean(clip.astype(float) ** 2))), dtype=np.float32)


def speak(recipe: Recipe, text: str) -> tuple[Samples, int]:
    """Speak a text in a child process; returns samples (n,) and their rate [Hz].

    Raises
    ------
    ConfigError
        When espeakng-loader is not installed, or the engine fails or stays silent.
    """
    _engine_version()
    order = {
        "name": recipe.name,
        "language": recipe.language,
        "variant": recipe.variant(),
        "speed": recipe.speed,
        "intonation": recipe.intonation,
        "text": text,
    }
    try:
        child = subprocess.run(
            [sys.executable, "-m", "ross_sim.talkers.espeak"],
            input=json.dumps(order).encode(),
            capture_output=True,
            timeout=TIMEOUT,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise ConfigError(f"voice '{recipe.name}': espeak-ng did not finish within {TIMEOUT} s") from error
    if child.returncode or len(child.stdout) < 4:
        reason = child.stderr.decode(errors="replace").strip().rpartition("\n")[2]
        raise ConfigError(f"voice '{recipe.name}': espeak-ng failed with code {child.returncode}: {reason}")
    (rate,) = struct.unpack_from("<I", child.stdout)
    samples = np.frombuffer(child.stdout, dtype="<i2", offset=4).astype(np.float32) / np.float32(2**15)
    if samples.size < rate // 10 or not samples.any():
        raise ConfigError(f"voice '{recipe.name}': espeak-ng stayed silent ({samples.size} samples)")
    return samples, int(rate)


def _engine_version() -> str:
    try:
        return version("espeakng-loader")
    except PackageNotFoundError as error:
        raise ConfigError(
            f"synthetic voices need the package espeakng-loader: {install_line('sim')}; or give a folder of recordings"
        ) from error
