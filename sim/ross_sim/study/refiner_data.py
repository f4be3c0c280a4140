"""Mixtures to train the refiner on: random rooms, talkers, headings, noise and mistakes, one clip per number.

Clip ``index`` of a seed is always the same, whatever else is made.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import fftconvolve

from ross_payload.dsp.noise import guessed_psd
from ross_payload.dsp.steering import directions_of, tdoa
from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Complex, Real, Scene
from ross_payload.separation.local_gaussian_model import FLOOR, fitted
from ross_payload.separation.refiner_features import HIGHEST, features
from ross_sim.acoustics.room import RoomSpec, respond
from ross_sim.study.mixtures import aligned_heading, spread
from ross_sim.study.voice_augmentation import at_speed

SPACING, SPEED_OF_SOUND = 0.05, 343.0  # d [m], v_p [m/s]
SECONDS = 4.5
FRAME, HOP = 2048, 512
RATES, RATE_SHARES = (24000, 16000), (0.65, 0.35)
APART = np.deg2rad(20.0)
TIERS = 3.0  # spread of the talkers' levels [dB]
ASTRAY = np.deg2rad(2.5)  # error of the azimuths, in half of the clips
GHOST, MISSED = 0.06, 0.06  # how often an azimuth is too many, or lacks
GUESSED = 0.3  # how often the noise is not known


@dataclass(frozen=True, slots=True, eq=False)
class Clip:
    """One mixture as the local Gaussian model leaves it, bins up to `HIGHEST`, mean power 1."""

    rate: int
    shown: Real  # features, (n_groups, N_FEATURES, n_freqs, n_frames)
    mixture: Complex  # (2, n_freqs, n_frames)
    covariances: Real  # the noise last, (n_freqs, n_groups + 1, 4)
    noise: Real  # (n_freqs,)
    wanted: Complex  # every group alone at microphone 1, (n_groups, n_freqs, n_frames)


def clip(voices: Mapping[str, Mapping[int, Real]], seed: int, index: int) -> Clip:
    """Make one clip from recordings (n,) by talker and rate [Hz]."""
    rng = np.random.default_rng([seed, index])
    rate = int(rng.choice(RATES, p=RATE_SHARES))
    n_sources = int(rng.choice((2, 3, 4, 5), p=(0.15, 0.35, 0.25, 0.25)))
    azimuths = spread(n_sources, rng, APART)
    names = rng.permutation(list(voices))
    cast = [_voice(voices[names[i % len(names)]][rate], rate, rng) for i in range(n_sources)]
    heading = float(rng.uniform(0, np.pi))
    if rng.random() < 0.75 and n_sources > 2:
        heading = aligned_heading(azimuths, int(rng.integers(n_sources)))
    images = _images(cast, azimuths, heading, rate, rng)
    return _fitted(images, *_believed_tdoas(azimuths, heading, rng), rate, rng)


def _voice(speech: Real, rate: int, rng: np.random.Generator) -> Real:
    """A piece of a talker at another speed, through another microphone, (n,)."""
    n, speed = round(SECONDS * rate), float(rng.uniform(0.85, 1.2))
    length = round(n * speed) + 400
    start = int(rng.integers(max(speech.size - length, 1)))
    piece = np.resize(at_speed(speech[start : start + length], speed), n)
    bins = np.fft.rfftfreq(n, 1 / rate)
    octaves = np.log2(np.maximum(bins, 50) / 1000)
    gain_db = rng.normal(0, 1.5) * octaves + rng.normal(0, 2) * np.cos(
        octaves * rng.uniform(0.5, 2) + rng.uniform(0, 6)
    )
    if rng.random() < 0.2:
        gain_db -= 60 * gaussian_filter1d((bins > rng.uniform(3500, 7500)).astype(float), 300)
    return np.fft.irfft(np.fft.rfft(piece) * 10 ** (gain_db / 20), n)


def _images(cast: Sequence[Real], azimuths: Real, heading: float, rate: int, rng: np.random.Generator) -> Real:
    """Every talker alone at both microphones, mean power about 1 at microphone 1, (n_sources, 2, n)."""
    size = [rng.uniform(4.5, 11), rng.uniform(4.5, 11)]
    centre = [side * rng.uniform(0.4, 0.6) for side in size]
    places = np.array(centre) + rng.uniform(0.8, 0.38 * min(size), len(cast))[:, None] * np.stack(
        [np.cos(azimuths), np.sin(azimuths)], axis=1
    )
    t60 = 0.0 if rng.random() < 0.25 else float(rng.uniform(0.3, 0.8))
    if t60 and rng.random() < 0.5:
        t60 = float(rng.uniform(0.28, 0.55))
        size, centre = [*size, 3.0], [*centre, 1.2]
        places = np.column_stack([places, rng.uniform(1.4, 1.8, len(cast))])
    spec = RoomSpec(tuple(size), t60, rate, tuple(centre), SPACING, tuple(map(tuple, places.tolist())), SPEED_OF_SOUND)
    responses = respond(spec, [heading])[0]
    n = len(cast[0])
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
    if chance < GHOST:
        believed, owners = np.append(believed, rng.uniform(-np.pi, np.pi)), [*owners, -1]
    elif chance < GHOST + MISSED:
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
    observed, covariances, psds = fitted(unit, replace(scene, tau=delays), psd)
    use = slice(0, int((stft.frequencies < HIGHEST).sum()))
    people = [[owners[i] for i in group if owners[i] >= 0] for group in members]
    wanted = np.stack([spectra[group][:, use].sum(axis=0) for group in people]) / np.sqrt(power)
    shown = features(observed[use], covariances[use], psds[use])
    return Clip(rate, shown, unit[:, use], covariances[use], psd[use], wanted)
