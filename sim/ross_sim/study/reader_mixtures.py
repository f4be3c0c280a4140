"""Readers as the payload hears them: three at once in a room of random size, separated by `auto`.

Mixture ``index`` of a seed is always the same, whatever else is made.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ross_payload.alignment.predicted_gain import best_headings
from ross_payload.dsp.steering import tdoa
from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Real
from ross_payload.separation.auto_separator import separator
from ross_sim.acoustics.room import RoomSpec, respond
from ross_sim.study.mixtures import Mixture, convolved, noisy, scene_of, spread
from ross_sim.study.room_settings import SPACING, SPEED_OF_SOUND
from ross_sim.study.voice_augmentation import RATE, coloured

TALKERS = 3
STFT = Stft(RATE, 2048, 512)
PLANES, OPEN = 0.5, 0.15  # how often the room is a plane, and has no walls
SIDES, HEIGHTS = (5.0, 11.0), (2.5, 3.5)  # of the room [m]
T60 = (0.2, 0.55)  # nominal [s]
NEAREST, FARTHEST, FROM_WALL = 1.5, 3.0, 0.8  # where the talkers stand [m]
ASIDE = 0.5  # how far the array may be from the middle [m]
ARRAY, MOUTHS = (1.0, 1.4), (1.4, 1.8)  # heights [m]
LEVELS_DB, SNR_DB = (-3.0, 3.0), (10.0, 25.0)
COLOURED = 0.4  # how often a voice comes by another microphone
SHORTEST, LONGEST = 3.0, 16.0  # of a mixture [s]


def groups_of(lengths: dict[str, int], seed: int, number: int) -> list[tuple[str, ...]]:
    """Draw who speaks with whom, all but two at most and each once: recordings of about one length [samples]."""
    names = np.random.default_rng([seed, number]).permutation(sorted(lengths))
    alike = sorted((str(name) for name in names), key=lambda name: lengths[name] // (2 * RATE))
    return [tuple(alike[at : at + TALKERS]) for at in range(0, len(alike) - TALKERS + 1, TALKERS)]


def heard(voices: Sequence[Real], rng: np.random.Generator) -> list[Real | None]:
    """Separate three voices (n,) each at `RATE`; None for one that the array cannot tell from another."""
    n = int(np.clip(np.median([len(voice) for voice in voices]), SHORTEST * RATE, LONGEST * RATE))
    clips = [np.resize(coloured(voice, rng) if rng.random() < COLOURED else voice, n) for voice in voices]
    recording = _recorded(clips, rng)
    groups = separator.batch(STFT.analyse(recording.mixture), scene_of(recording, STFT, known_noise=True))
    found: list[Real | None] = [None] * TALKERS
    for members, signal in zip(groups.members, groups.signals, strict=True):
        if len(members) == 1:
            found[members[0]] = STFT.synthesise(signal, n)[: len(voices[members[0]])]
    return found


def _recorded(clips: Sequence[Real], rng: np.random.Generator) -> Mixture:
    """Record talkers (n,) each in a random room, the array at one talker's best heading."""
    plane, dry = rng.random() < PLANES, rng.random() < OPEN
    floor = rng.uniform(*SIDES, 2)
    centre = floor / 2 + rng.uniform(-ASIDE, ASIDE, 2)
    azimuths, far = spread(TALKERS, rng), min(FARTHEST, floor.min() / 2 - ASIDE - FROM_WALL + NEAREST / 2)
    distance = rng.uniform(min(NEAREST, far - FROM_WALL / 2), far, TALKERS)
    places = centre + (distance * [np.cos(azimuths), np.sin(azimuths)]).T
    if not plane:
        floor, centre = np.append(floor, rng.uniform(*HEIGHTS)), np.append(centre, rng.uniform(*ARRAY))
        places = np.column_stack([places, rng.uniform(*MOUTHS, TALKERS)])
    places[:, :2] = np.clip(places[:, :2], FROM_WALL / 2, floor[:2] - FROM_WALL / 2)
    t60 = 0.0 if dry else float(rng.uniform(*T60))
    spots = tuple(tuple(place) for place in places.tolist())
    spec = RoomSpec(tuple(floor.tolist()), t60, RATE, tuple(centre.tolist()), SPACING, spots, SPEED_OF_SOUND)
    heading = float(best_headings(azimuths, directness=float(dry))[int(rng.integers(TALKERS))])
    images = convolved(clips, respond(spec, [heading])[0])
    images *= 10 ** (rng.uniform(*LEVELS_DB, TALKERS) / 20)[:, None, None]
    tau = tdoa(azimuths, heading, SPACING, SPEED_OF_SOUND)
    return noisy(images, tau, 0, snr_db=float(rng.uniform(*SNR_DB)), rng=rng, rate=RATE)
