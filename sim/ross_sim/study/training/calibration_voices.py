"""Voices to choose and calibrate the built-in model of voices by: of readers in turn, and of talkers of other corpora.

Readers are dealt to folds; whoever is heard in a mixture, and everybody it is compared with, is of one fold. A model
that was trained without this fold scores them, so that all readers calibrate what all readers train.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real
from ross_payload.voiceprint.disturbed_copies import disturbed
from ross_payload.voiceprint.features import Features, analyse, at_rate
from ross_payload.voiceprint.speaker_model import ENROL_SECONDS
from ross_sim.cache import Array, cached
from ross_sim.study.scenes.mixtures import RATE as MIXTURE_RATE
from ross_sim.study.training.training_voices import voices_fingerprint
from ross_sim.study.training.voice_augmentation import RATE
from ross_sim.study.training.voice_pieces import Piece, packed, sixteen_bits, unpacked
from ross_sim.study.voiceprint_study import OUTSIDE, TALKERS, scenes
from ross_sim.talkers.speech import ENROLMENT, TalkerVoice, load_folder, resampled

N_FOLDS, LONG_ENOUGH = 5, 14.2  # readers are heard in mixtures if they speak for so long [s]
ENROLLED = 5.0  # the others are strangers to them, enrolled from the end, if they speak for so long [s]
ONE_PERSON = ("ls4267", "ls8226")  # sound alike: no strangers to each other in trials
ROOMS = ("S1", "S2", "A0.3", "A0.45", "A0.7", "B0.3", "B0.45", "B0.7")
N_SCENES = {"readers": 10, "others": 6}  # mixtures in every room


@dataclass(frozen=True, slots=True)
class SeparatedVoice:
    """A separated voice."""

    corpus: str
    scene: str  # which mixture it was in
    fold: int
    seconds: float
    talker: str
    features: Features


def folds_of(voices: Mapping[str, Real], seed: int) -> dict[str, int]:
    """Deal readers (n,) at `RATE` to folds, those who speak for long enough evenly; the fold of each by name.

    Raises
    ------
    ConfigError
        When too few speak for long enough.
    """
    able = [name for name in sorted(voices) if speaks_long(name, voices[name])]
    if len(able) < N_FOLDS * TALKERS:
        raise ConfigError(
            f"expected at least {N_FOLDS * TALKERS} readers of more than {LONG_ENOUGH} s, got {len(able)}"
        )
    rng, rest = np.random.default_rng([seed, 5]), sorted(set(voices) - set(able))
    order = [*rng.permutation(able).tolist(), *rng.permutation(rest).tolist()]
    return {name: place % N_FOLDS for place, name in enumerate(order)}


def speaks_long(name: str, voice: Real) -> bool:
    """Whether a reader is heard in mixtures, and not only enrolled."""
    return len(voice) > LONG_ENOUGH * RATE and name not in ONE_PERSON


def reader_voice(name: str, voice: Real) -> TalkerVoice:
    """A reader's recording (n,) at `RATE` as a talker of mixtures, the last seconds of it to enrol from."""
    cut, at_rate_of_mixtures = round(ENROLMENT * MIXTURE_RATE), resampled(voice, RATE, MIXTURE_RATE)
    return TalkerVoice(name, at_rate_of_mixtures[:-cut], at_rate_of_mixtures[-cut:], MIXTURE_RATE)


def others(folder: Path) -> list[TalkerVoice]:
    """Load the talkers of other corpora.

    Raises
    ------
    ConfigError
        When there are too few.
    """
    found = [voice for voice in load_folder(folder, MIXTURE_RATE) if voice.name not in OUTSIDE]
    if len(found) < TALKERS:
        raise ConfigError(f"{folder}: expected at least {TALKERS} talkers beside {', '.join(OUTSIDE)}")
    return found


def enrolled_readers(voices: Mapping[str, Real], folds: Mapping[str, int]) -> list[list[TalkerVoice]]:
    """Return who can be enrolled of each fold."""
    able = [name for name in sorted(voices) if len(voices[name]) > ENROLLED * RATE]
    return [[reader_voice(name, voices[name]) for name in able if folds[name] == fold] for fold in range(N_FOLDS)]


def heard_in_rooms(corpus: str, groups: Sequence[Sequence[TalkerVoice]], work: Path, seed: int) -> list[SeparatedVoice]:
    """Return the separated voices of mixtures in `ROOMS`; those in a mixture are of one of the groups, in turn."""
    found, said = [], {f"{fold} {v.name}": v.speech for fold, group in enumerate(groups) for v in group}
    work /= f"heard-{voices_fingerprint(said, seed=seed)}"
    for where, room in enumerate(ROOMS):
        for number in range(N_SCENES[corpus]):
            fold, name = number % len(groups), f"{corpus}-{room}-{number:02d}"

            def made(room: str = room, where: int = where, number: int = number, fold: int = fold) -> dict[str, Array]:
                rng = np.random.default_rng([seed, 4, where, number])
                arrays: dict[str, Array] = {}
                for seconds, separated, _, talker, clip in scenes(groups[fold], room, rng, whole=True):
                    if separated:
                        arrays[f"{seconds:g} {talker}"] = sixteen_bits(at_rate(clip.samples, MIXTURE_RATE))
                return arrays

            def measured(path: Path = work / f"{name}.npz", made=made) -> dict[str, Array]:  # type: ignore[no-untyped-def]
                voices = cached(path, made)
                pieces = [Piece(told.split()[1], analyse(voice.astype(float), RATE)) for told, voice in voices.items()]
                return packed(pieces) | {"seconds": np.array([float(told.split()[0]) for told in voices])}

            arrays = cached(work / f"{name}-pieces.npz", measured)
            for seconds, piece in zip(arrays["seconds"].tolist(), unpacked(arrays), strict=True):
                found.append(
                    SeparatedVoice(corpus, f"{corpus} {room} {number}", fold, seconds, piece.talker, piece.features)
                )
    return found


def enrolments(voices: Sequence[TalkerVoice], work: Path) -> dict[str, list[Features]]:
    """Measure what each talker is enrolled from and its disturbed copies; without those who say too little."""
    found = {}
    for voice in voices:

        def made(voice: TalkerVoice = voice) -> dict[str, Array]:
            samples = resampled(voice.enrolment, voice.rate, RATE).astype(float)
            return packed([Piece(voice.name, analyse(clip, RATE)) for clip in (samples, *disturbed(samples))])

        name = f"enrolled-{voice.name}-{voices_fingerprint({voice.name: voice.enrolment}, rate=voice.rate)}"
        clips = [piece.features for piece in unpacked(cached(work / f"{name}.npz", made))]
        if clips[0].seconds >= ENROL_SECONDS:
            found[voice.name] = clips
    return found
