"""What the built-in model of voices is trained on: recordings, disturbed copies, and voices separated from others.

Separated voices are kept as they sound, so that another analysis does not have to separate them again. Every file
depends on its number and the seed alone; what was made before is read.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ross_payload.interfaces import Real
from ross_payload.voiceprint.disturbed_copies import disturbed
from ross_payload.voiceprint.features import Features, analyse
from ross_sim.cache import Array, cached
from ross_sim.study.training.reader_mixtures import COLOURED, groups_of, heard
from ross_sim.study.training.training_voices import voices_fingerprint
from ross_sim.study.training.voice_augmentation import RATE, at_speed, coloured, excerpt

N_ROUNDS = 1  # in which everybody is heard in a mixture
PIECES = (20.0, 3.0, 5.0)  # of every separated voice [s]
CLEAN_PIECES, COPY_PIECE = (20.0, 4.0), 6.0  # of every recording and every disturbed copy of it [s]
LEAST_FRAMES = 80  # loud ones of a piece
SLOWER, FASTER = (0.86, 0.93), (1.07, 1.16)  # at which a reader is another talker
AT_SPEED = "@"  # between a reader's name and the speed


@dataclass(frozen=True, slots=True)
class Piece:
    """Some seconds of a talker."""

    talker: str
    features: Features


def reader_of(talker: str) -> str:
    """Return whose recording a talker is made of.

    >>> reader_of("ls103@0.9"), reader_of("ls103")
    ('ls103', 'ls103')
    """
    return talker.partition(AT_SPEED)[0]


def with_speeds(voices: Mapping[str, Real], seed: int) -> dict[str, Real]:
    """Add everybody (n,) played slower and faster, as other talkers."""
    rng, found = np.random.default_rng([seed, 7]), dict(voices)
    for name, voice in sorted(voices.items()):
        for low, high in (SLOWER, FASTER):
            speed = round(float(rng.uniform(low, high)), 2)
            found[f"{name}{AT_SPEED}{speed}"] = at_speed(voice, speed)
    return found


def training_pieces(voices: Mapping[str, Real], work: Path, seed: int) -> Iterator[Piece]:
    """Make pieces of everybody (n,): clean, disturbed, and separated from others in `N_ROUNDS` rounds of mixtures.

    What was made of the same voices and seed is read from ``work``.
    """
    work /= f"pieces-{voices_fingerprint(voices, seed=seed)}"
    for index, (name, voice) in enumerate(sorted(voices.items())):

        def alone(index: int = index, name: str = name, voice: Real = voice) -> dict[str, Array]:
            rng = np.random.default_rng([seed, 1, index])
            copies = [] if AT_SPEED in name else [(copy, (COPY_PIECE,)) for copy in disturbed(voice, index)]
            clips = [(voice, CLEAN_PIECES), *copies]
            shaded = [(coloured(clip, rng) if rng.random() < COLOURED else clip, cut) for clip, cut in clips]
            return packed([piece for clip, cut in shaded for piece in _pieces(name, clip, cut, rng)])

        yield from unpacked(cached(work / f"reader-{index:03d}.npz", alone))
    lengths = {name: len(voice) for name, voice in voices.items()}
    for number in range(N_ROUNDS):
        for index, names in enumerate(groups_of(lengths, seed, number)):

            def cut(number: int = number, index: int = index, names: Sequence[str] = names) -> dict[str, Array]:
                rng = np.random.default_rng([seed, 3, number, index])
                mixture = separated([voices[name] for name in names], work / f"mixture-{number}-{index:03d}.npz", rng)
                found = zip(names, mixture, strict=True)
                return packed([p for name, one in found if len(one) for p in _pieces(name, one, PIECES, rng)])

            yield from unpacked(cached(work / f"pieces-{number}-{index:03d}.npz", cut))


def separated(voices: Sequence[Real], path: Path, rng: np.random.Generator) -> list[Real]:
    """Mix and separate voices (n,) each, or read what was; empty where one cannot be told from another."""
    seeds = rng.integers(2**32, size=4).tolist()

    def made() -> dict[str, Array]:
        found = heard(voices, np.random.default_rng(seeds))
        return {f"voice{index}": sixteen_bits(np.zeros(0) if one is None else one) for index, one in enumerate(found)}

    arrays = cached(path, made)
    return [arrays[f"voice{index}"].astype(float) for index in range(len(voices))]


def sixteen_bits(voice: Real) -> Array:
    """Scale a recording (n,) to whole numbers up to 32767."""
    peak = float(np.abs(voice).max(initial=0.0))
    return np.round(voice * (32767 / peak if peak else 0.0)).astype(np.int16)


def _pieces(talker: str, voice: Real, seconds: Sequence[float], rng: np.random.Generator) -> list[Piece]:
    found = [Piece(talker, analyse(excerpt(voice, each, rng), RATE)) for each in seconds if len(voice)]
    return [piece for piece in found if len(piece.features.cepstra) >= LEAST_FRAMES]


def packed(pieces: Sequence[Piece]) -> dict[str, Array]:
    """Arrays of pieces by name."""
    found = {"talkers": np.array([piece.talker for piece in pieces], dtype="U32")}
    for index, piece in enumerate(pieces):
        found |= {f"cepstra{index}": piece.features.cepstra, f"pitch{index}": piece.features.pitch}
    return found


def unpacked(arrays: Mapping[str, Array]) -> Iterator[Piece]:
    """Pieces again of their arrays."""
    for index, talker in enumerate(arrays["talkers"]):
        yield Piece(str(talker), Features(arrays[f"cepstra{index}"], arrays[f"pitch{index}"]))
