"""Mixtures to train the refiner on: random rooms, readers, headings, noise and mistakes, one clip per number.

Clip ``index`` of a seed is always the same, whatever else is made. Neighbouring clips share a room, because that costs
more than all the rest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import fftconvolve

from ross_payload.dsp.noise import guessed_psd
from ross_payload.dsp.steering import directions_of, tdoa
from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Complex, Real, Samples, Scene
from ross_payload.separation.evened_noise import FLOOR
from ross_payload.separation.local_gaussian_model import fitted
from ross_payload.separation.refiner_features import HIGHEST
from ross_sim.acoustics.room import RoomSpec, respond
from ross_sim.study.scenes.mixtures import aligned_heading, spread
from ross_sim.study.scenes.room_settings import SPACING, SPEED_OF_SOUND
from ross_sim.study.training.voice_augmentation import RATE, at_speed
from ross_sim.talkers.speech import resampled

SECONDS = 8.0
FRAME, HOP = 2048, 512
SHARING = 2  # clips in one room
N_SOURCES, SOURCE_SHARES = (2, 3, 4, 5), (0.1, 0.35, 0.3, 0.25)
OPEN, PLANE = 0.17, 0.17  # how often there are no walls, and the room is a plane; else it has three dimensions
FASTER, FAST = {"open": 0.6, "plane": 0.1, "room": 0.1}, 24000  # how often the rate is not `RATE`, but this one [Hz]
SIDES, HEIGHTS = (4.5, 11.0), (2.4, 4.0)  # of the room [m]
OFF_CENTRE = 0.12  # how far the array may be from the middle, relative to the sides
NEAREST, FARTHEST, FROM_WALL = 1.2, 3.0, 0.3  # where the talkers stand, along the floor [m]
ARRAY, MOUTHS = (1.0, 1.5), (1.4, 1.8)  # heights [m]
T60, PLANE_T60 = (0.22, 0.6), (0.3, 0.8)  # nominal [s]
SABINE, IMAGES = 0.161, 2e5  # T60 S / V of walls that absorb everything [s / m]; most images that are added up
APART = np.deg2rad(20.0)
ALIGNED, NEARLY, OFF = 0.7, 0.5, np.deg2rad(6.0)  # how often at an alignment; of these turned away, and by how much
TIERS = 3.0  # spread of the talkers' levels [dB]
ASTRAY = np.deg2rad(2.5)  # error of the azimuths, in half of the clips
SPURIOUS, MISSED = 0.04, 0.04  # how often an azimuth is too many, or lacks
GUESSED = 0.25  # how often the noise is not known


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """A room with the array and places for talkers in it."""

    rate: int
    azimuths: Real  # [rad], (n_sources,)
    heading: float  # [rad]
    responses: Samples  # (2, n_sources, n_taps)


@dataclass(frozen=True, slots=True, eq=False)
class Clip:
    """One mixture as the local Gaussian model leaves it, bins up to `HIGHEST`, mean power 1."""

    rate: int
    mixture: Complex  # (2, n_freqs, n_frames)
    covariances: Real  # the noise last, (n_freqs, n_groups + 1, 4)
    psds: Real  # the noise last, (n_freqs, n_groups + 1, n_frames)
    wanted: Complex  # every group alone at microphone 1, (n_groups, n_freqs, n_frames)


def clip(voices: Mapping[str, Real], seed: int, index: int, longest: float | None = None) -> Clip:
    """Make one clip from recordings (n,) at `RATE` by talker; ``longest`` is another limit of `T60` [s]."""
    stage = _stage(seed, index // SHARING, T60[1] if longest is None else longest)
    rng = np.random.default_rng([seed, 1, index])
    names = rng.permutation(sorted(voices))
    n_sources = len(stage.azimuths)
    cast = [recorded_voice(voices[names[i % len(names)]], stage.rate, rng) for i in range(n_sources)]
    images = _images(cast, stage, rng)
    return _fitted(images, *_believed_tdoas(stage.azimuths, stage.heading, rng), stage.rate, rng)


@lru_cache(maxsize=1)
def _stage(seed: int, index: int, at_most: float) -> Stage:
    """Draw a room, and simulate it."""
    rng = np.random.default_rng([seed, 0, index])
    chance = rng.random()
    kind = "open" if chance < OPEN else "plane" if chance < OPEN + PLANE else "room"
    rate = FAST if rng.random() < FASTER[kind] else RATE
    azimuths = spread(int(rng.choice(N_SOURCES, p=SOURCE_SHARES)), rng, APART)
    heading = float(rng.uniform(0, np.pi))
    if len(azimuths) > 2 and rng.random() < ALIGNED:
        heading = aligned_heading(azimuths, int(rng.integers(len(azimuths))))
        heading += float(rng.normal(0, OFF)) * (rng.random() < NEARLY)
    size = rng.uniform(*SIDES, 2)
    centre = size * (0.5 + rng.uniform(-OFF_CENTRE, OFF_CENTRE, 2))
    along = np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1)
    reach = np.where(along > 0, size - FROM_WALL - centre, centre - FROM_WALL) / np.maximum(np.abs(along), 1e-9)
    far = np.minimum(reach.min(axis=1), FARTHEST)
    places = centre + rng.uniform(np.minimum(NEAREST, far), far)[:, None] * along
    t60 = float(rng.uniform(*PLANE_T60)) * (kind == "plane")
    if kind == "room":
        size, centre = np.append(size, rng.uniform(*HEIGHTS)), np.append(centre, rng.uniform(*ARRAY))
        places = np.column_stack([places, rng.uniform(*MOUTHS, len(places))])
        volume = float(size.prod())
        surface = 2 * volume * float((1 / size).sum())
        longest = (0.75 / np.pi * IMAGES * volume) ** (1 / 3) / SPEED_OF_SOUND
        t60 = float(rng.uniform(max(T60[0], 1.2 * SABINE * volume / surface), min(at_most, longest)))
    spots = tuple(map(tuple, places.tolist()))
    spec = RoomSpec(tuple(size.tolist()), t60, rate, tuple(centre.tolist()), SPACING, spots, SPEED_OF_SOUND)
    return Stage(rate, azimuths, heading, respond(spec, [heading])[0])


def recorded_voice(speech: Real, rate: int, rng: np.random.Generator) -> Real:
    """A piece of a talker at another speed, through another microphone, (n,) at ``rate``."""
    n, speed = round(SECONDS * RATE), float(rng.uniform(0.85, 1.2))
    length = round(n * speed) + 400
    start = int(rng.integers(max(speech.size - length, 1)))
    piece = np.resize(at_speed(speech[start : start + length], speed), n)
    bins = np.fft.rfftfreq(n, 1 / RATE)
    octaves = np.log2(np.maximum(bins, 50) / 1000)
    gain_db = rng.normal(0, 1.5) * octaves + rng.normal(0, 2) * np.cos(
        octaves * rng.uniform(0.5, 2) + rng.uniform(0, 6)
    )
    if rng.random() < 0.1:
        gain_db -= 60 * gaussian_filter1d((bins > rng.uniform(3500, 7500)).astype(float), 300)
    return resampled(np.fft.irfft(np.fft.rfft(piece) * 10 ** (gain_db / 20), n), RATE, rate).astype(float)


def _images(cast: Sequence[Real], stage: Stage, rng: np.random.Generator) -> Real:
    """Every talker alone at both microphones, mean power about 1 at microphone 1, (n_sources, 2, n)."""
    n, responses = len(cast[0]), stage.responses
    images = np.stack([fftconvolve(voice[None], responses[:, k], axes=1)[:, :n] for k, voice in enumerate(cast)])
    levels = 10 ** (rng.uniform(-TIERS, TIERS, len(cast)) / 20)
    level = np.sqrt((images[:, :1] ** 2).mean(axis=2, keepdims=True)) + 1e-9
    return np.asarray(images / level * levels[:, None, None])


def _believed_tdoas(azimuths: Real, heading: float, rng: np.random.Generator) -> tuple[Real, list[int]]:
    """TDOAs [s] as the explorer might have them, and the source that each belongs to (-1: nobody)."""
    believed, owners = azimuths.copy(), list(range(len(azimuths)))
    if rng.random() < 0.5:
        believed = believed + rng.normal(0, ASTRAY, len(believed))
    chance = rng.random()
    if chance < SPURIOUS:
        believed, owners = np.append(believed, rng.uniform(-np.pi, np.pi)), [*owners, -1]
    elif chance < SPURIOUS + MISSED:
        believed, owners = believed[:-1], owners[:-1]
    return tdoa(believed, heading, SPACING, SPEED_OF_SOUND), owners


def _fitted(images: Real, tau: Real, owners: Sequence[int], rate: int, rng: np.random.Generator) -> Clip:
    stft = Stft(rate, FRAME, HOP)
    snr_db = 15.0 if rng.random() < 0.5 else float(rng.uniform(5, 30))
    sigma = np.sqrt((images.sum(axis=0)[0] ** 2).mean() * 10 ** (-snr_db / 10))
    noise = sigma * rng.standard_normal(images.shape[1:])
    spectra = stft.analyse(np.append(images[:, 0], [noise[0]], axis=0).astype(np.float32))
    mixture = stft.analyse((images.sum(axis=0) + noise).astype(np.float32))
    power = float((np.abs(mixture) ** 2).mean())
    lead_in = stft.analyse((sigma * rng.standard_normal((2, rate))).astype(np.float32))[:, :, 2:-2]
    psd = (np.abs(lead_in) ** 2).mean(axis=(0, 2))
    if rng.random() < GUESSED:
        psd = guessed_psd(mixture)
    psd = np.maximum(psd / power, FLOOR).astype(np.float32)
    scene = Scene(stft.frequencies, SPACING, SPEED_OF_SOUND, len(tau), tau)
    members, delays = directions_of(scene, "training")
    unit = (mixture / np.sqrt(power)).astype(np.complex64)
    _, covariances, psds = fitted(unit, replace(scene, tau=delays), psd)
    use = slice(0, int((stft.frequencies < HIGHEST).sum()))
    people = [[owners[i] for i in group if owners[i] >= 0] for group in members]
    wanted = np.stack([spectra[group][:, use].sum(axis=0) for group in people]) / np.sqrt(power)
    return Clip(rate, unit[:, use], covariances[use], psds[use], wanted)
