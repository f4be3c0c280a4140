"""Prints of synthetic talkers, kept in the cache: to enrol one takes as long as to fly a short mission.

Nothing of a person comes here: a print is personal data, and a cache no place for it.
"""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.metadata import version
from pathlib import Path

import numpy as np

from ross_payload import voiceprint
from ross_payload.dsp import stft
from ross_payload.voiceprint import BuiltInModel, EmbeddingPrint, enrol
from ross_sim.cache import Array, cache_folder, cached, fingerprint
from ross_sim.talkers.speech import TalkerVoice


def synthetic_print(voice: TalkerVoice, model: BuiltInModel, folder: Path | None = None) -> EmbeddingPrint:
    """Enrol a synthetic talker, or read the print from the cache (None: see ``cache_folder``).

    A print is kept for this model, these samples and this code: with any other, `enrol` makes it again.

    Raises
    ------
    AudioError
        When nobody can be enrolled from the voice.
    ConfigError
        When the cache cannot be written.
    """
    said = hashlib.sha256(np.ascontiguousarray(voice.enrolment).tobytes()).hexdigest()
    key = fingerprint(model=model.fingerprint, said=said, rate=voice.rate, code=_code())

    def make() -> dict[str, Array]:
        made = enrol(voice.enrolment, voice.rate, model)
        return {"embedding": made.embedding, "numbers": np.array([made.seconds, made.criterion])}

    kept = cached(cache_folder(folder) / "prints" / f"{voice.name}-{key}.npz", make)
    seconds, criterion = kept["numbers"].tolist()
    return EmbeddingPrint(kept["embedding"], seconds, model, criterion)


@cache
def _code() -> str:
    """Fingerprint of the code that a print depends on."""
    digest = hashlib.sha256(repr([version(name) for name in ("numpy", "scipy")]).encode())
    for path in (*sorted(Path(voiceprint.__file__).parent.glob("*.py")), Path(stft.__file__)):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]
