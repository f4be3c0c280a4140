"""Readers as the payload hears them: three at once in a room, separated by `auto`.

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
from ross_payload.voiceprint.features import at_rate
from ross_sim.acoustics.room import RoomSpec, respond
from ross_sim.study.scenes.mixtures import Mixture, convolved, noisy, scene_of, spread
from ross_sim.study.scenes.room_settings import SPACING, SPEED_OF_SOUND
from ross_sim.study.training.voice_augmentation import RATE, coloured
from ross_sim.talkers.speech import resampled

TALKERS = 3
FRAME, HOP = 2048, 512
RATES = (RATE, 24_000)  # of the microphones [Hz], one as often as the other
OPEN, PLANES = 0.15, 0.2  # how often there are no walls, and the room is a plane; else it has three dimensions
LIKE_SETTINGS, SIZES = 0.5, ((10.0, 10.0, 3.0), (6.0, 8.0, 3.0))  # how often a room has one of these sizes [m]
SIDES, HEIGHTS = (5.0, 11.0), (2.5, 3.5)  # of the others [m]
T60, PLANE_T60 = (0.26, 0.6), (0.3, 0.7)  # nominal [s]; in true rooms what is measured is up to a third longer
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
    """Separate voices (n,) each at `RATE`; None for one that the array cannot tell from another."""
    rate = int(rng.choice(RATES))
    n = int(np.clip(np.median([len(voice) for voice in voices]), SHORTEST * RATE, LONGEST * RATE))
    clips = [np.resize(coloured(voice, rng) if rng.random() < COLOURED else voice, n) for voice in voices]
    recording = _recorded([resampled(clip, RATE, rate).astype(float) for clip in clips], rate, rng)
    stft = Stft(rate, FRAME, HOP)
    groups = separator.batch(stft.analyse(recording.mixture), scene_of(recording, stft, known_noise=True))
    found: list[Real | None] = [None] * len(voices)
    for members, signal in zip(groups.members, groups.signals, strict=True):
        if len(members) == 1:
            voice = at_rate(stft.synthesise(signal, recording.mixture.shape[1]), rate)
            found[members[0]] = voice[: len(voices[members[0]])]
    return found


def _recorded(clips: Sequence[Real], rate: int, rng: np.random.Generator) -> Mixture:
    """Record talkers (n,) each in a random room, the array at one talker's best heading."""
    n_talkers, kind = len(clips), rng.random()
    dry, plane = kind < OPEN, kind < OPEN + PLANES
    size = np.append(rng.uniform(*SIDES, 2), rng.uniform(*HEIGHTS))
    if rng.random() < LIKE_SETTINGS:
        size = np.array(SIZES[int(rng.integers(len(SIZES)))])
    t60 = 0.0 if dry else float(rng.uniform(*(PLANE_T60 if plane else T60)))
    floor = size[:2]
    centre = np.append(floor / 2 + rng.uniform(-ASIDE, ASIDE, 2), rng.uniform(*ARRAY))
    azimuths, far = spread(n_talkers, rng), min(FARTHEST, floor.min() / 2 - ASIDE - FROM_WALL + NEAREST / 2)
    distance = rng.uniform(min(NEAREST, far - FROM_WALL / 2), far, n_talkers)
    along = centre[:2] + (distance * [np.cos(azimuths), np.sin(azimuths)]).T
    along = np.clip(along, FROM_WALL / 2, floor - FROM_WALL / 2)
    places = np.column_stack([along, rng.uniform(*MOUTHS, n_talkers)])
    n_dim = 2 if plane else 3
    spots = tuple(tuple(place) for place in places[:, :n_dim].tolist())
    room, middle = tuple(size[:n_dim].tolist()), tuple(centre[:n_dim].tolist())
    heading = float(best_headings(azimuths, directness=float(dry))[int(rng.integers(n_talkers))])
    responses = respond(RoomSpec(room, t60, rate, middle, SPACING, spots, SPEED_OF_SOUND), [heading])[0]
    images = convolved(clips, responses) * 10 ** (rng.uniform(*LEVELS_DB, n_talkers) / 20)[:, None, None]
    tau = tdoa(azimuths, heading, SPACING, SPEED_OF_SOUND)
    return noisy(images, tau, 0, snr_db=float(rng.uniform(*SNR_DB)), rng=rng, rate=rate)
