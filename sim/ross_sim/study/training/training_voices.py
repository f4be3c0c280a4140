"""Whose voices are learnt from: readers of a folder with a list, and synthetic voices that no scenario casts."""

from __future__ import annotations

import csv
import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real
from ross_sim.cache import Array, cache_folder, cached, fingerprint
from ross_sim.study.training.voice_augmentation import RATE
from ross_sim.talkers.speech import read
from ross_sim.talkers.synthetic_voices import Recipe, levelled, speak, speech_text

LANGUAGES = ("en", "en-US", "en-GB-x-rp", "en-GB-scotland", "en-GB-x-gbclan", "en-GB-x-gbcwmd", "de", "fr")
LIST = "MANIFEST.tsv"  # of a folder of readers: columns `set`, `id`, `file`


def readers(folder: Path, chosen: str) -> dict[str, Real]:
    """Read the recordings (n,) at `RATE` of the readers of one set of a folder, such as ``train`` or ``test``, by name.

    Raises
    ------
    ConfigError
        When the list or a recording cannot be read, or the set is empty.
    """
    try:
        with (folder / LIST).open(encoding="utf-8", newline="") as file:
            rows = [(row["id"], row["file"]) for row in csv.DictReader(file, delimiter="\t") if row["set"] == chosen]
    except (OSError, KeyError, UnicodeDecodeError) as error:
        raise ConfigError(f"{folder / LIST}: expected a list with the columns set, id and file: {error}") from error
    if not rows:
        raise ConfigError(f"{folder / LIST}: expected readers of the set '{chosen}', got none")
    return {name: read(folder / name / file, RATE).astype(float) for name, file in sorted(rows)}


def voices_fingerprint(voices: Mapping[str, Array], **more: Any) -> str:
    """Hash who is learnt from, recordings (n,) by name, and whatever else what is made of them depends on.

    >>> one, other = np.zeros(3), np.ones(3)
    >>> voices_fingerprint({"a": one}) == voices_fingerprint({"a": other})
    False
    >>> voices_fingerprint({"a": one}, seed=0) == voices_fingerprint({"a": one}, seed=1)
    False
    """
    heard = {name: hashlib.sha256(voice.tobytes()).hexdigest() for name, voice in voices.items()}
    return fingerprint(voices=heard, **more)[:12]


def recipes(n: int, rng: np.random.Generator) -> Iterator[Recipe]:
    """Draw recipes of synthetic voices, low and high ones in turn."""
    for index in range(n):
        low = int(rng.uniform(65, 150) if index % 2 else rng.uniform(140, 300))
        scale = rng.uniform(84, 104) if index % 2 else rng.uniform(102, 130)
        first, second, higher = (int(scale + rng.uniform(-7, 7)) for _ in range(3))
        tilt, speed = int(rng.uniform(60, 140)), int(rng.uniform(135, 180))
        language = LANGUAGES[int(rng.integers(len(LANGUAGES)))]
        pitch = (low, int(low * rng.uniform(1.25, 1.4)))
        yield Recipe(f"train{index}", language, pitch, (first, second, higher), tilt, speed)


def synthetic(recipe: Recipe, index: int) -> Real:
    """Speak about a minute with a recipe, (n,), from the cache when it was spoken before."""
    text = speech_text(index)
    key = fingerprint(recipe=asdict(recipe), said=text, rate=RATE, engine=_engine(), use="train")
    path = cache_folder(None) / "voices" / f"{recipe.name}-{key}.npz"
    return cached(path, lambda: {"speech": levelled(*speak(recipe, text), RATE)})["speech"].astype(float)


def _engine() -> str:
    try:
        return version("espeakng-loader")
    except PackageNotFoundError as error:
        raise ConfigError("training needs synthetic voices: install the package espeakng-loader") from error
