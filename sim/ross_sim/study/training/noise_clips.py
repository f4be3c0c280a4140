"""Mixtures to train the refiner on where noise has a direction: rotors of many kinds, wind, or both, in the open.

Clip ``index`` of a seed is always the same. Rotors are made, or the recording of a motor without a propeller, through
random filters; their level moves with the throttle, in slow waves or in steps. No recorded propeller is among them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import oaconvolve

from ross_payload.dsp.ego_noise import learnt
from ross_payload.dsp.noise_field import noise_field
from ross_payload.dsp.rotors import Rotors
from ross_payload.dsp.steering import directions_of, tdoa
from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Complex, Real, Scene
from ross_payload.separation.evened_noise import evened
from ross_payload.separation.local_gaussian_model import fitted
from ross_payload.separation.refined import LARGER
from ross_payload.separation.refiner_features import HIGHEST
from ross_sim.acoustics.near_field import NearField
from ross_sim.acoustics.rotor_noise import rotor
from ross_sim.acoustics.wind_noise import gust_levels, wind
from ross_sim.study.scenes.mixtures import aligned_heading, spread
from ross_sim.study.scenes.room_settings import SPACING, SPEED_OF_SOUND
from ross_sim.study.training.refiner_data import (
    ALIGNED,
    APART,
    ASTRAY,
    FAST,
    FRAME,
    HOP,
    NEARLY,
    OFF,
    SECONDS,
    TIERS,
    recorded_voice,
)
from ross_sim.study.training.voice_augmentation import RATE, at_speed

LEAD_IN = 2.0  # [s]
N_TALKERS, TALKER_SHARES = (1, 2, 3, 4), (0.3, 0.3, 0.3, 0.1)
FASTER = 0.5  # how often the rate is `FAST`
RATIOS = (-14.0, 14.0)  # talkers over noise between `LOW` and `HIGH` [dB]
LOW, HIGH = 100.0, 5000.0  # [Hz]
SENSOR = -25.0  # noise of the microphones over the talkers [dB]
KINDS, KIND_SHARES = ("rotors", "wind", "both"), (0.6, 0.25, 0.15)
AFAR, BELOW = (1.5, 8.0), 12.0  # talkers along the ground [m]; and how far below in half of the clips, at most
N_ROTORS, ROTOR_SHARES = (1, 2, 4, 6, 8), (0.1, 0.1, 0.5, 0.2, 0.1)
ARMS, ABOVE = (0.15, 0.6), (-0.1, 0.3)  # of the rotors [m]
TOLD = 0.7  # how often the places of the rotors are known
SLOWEST, FASTEST = 2500.0, 10000.0  # [1/min]
MOTOR = 0.25  # how often the recorded motor stands for the rotors
STEPS, STEP = 0.35, 7.0  # how often the level moves in steps, and by how much, one standard deviation [dB]
TILT, WAVES = 3.0, 4.0  # of the random filter of rotors: per octave, and of its waves [dB]


@dataclass(frozen=True, slots=True, eq=False)
class NoisyClip:
    """One mixture as the separator has it before the network, bins up to `HIGHEST`."""

    rate: int
    mixture: Complex  # of mean power 1, over the level of the noise, (2, n_freqs, n_frames)
    covariances: Real  # of the groups, (n_freqs, n_groups, 4)
    psds: Real  # (n_freqs, n_groups, n_frames)
    noise: Real  # PSD, (n_freqs,)
    field: Real  # coordinates of its covariance, trace 2, (n_freqs, 4, n_frames)
    level: Real  # of the noise, by which what is heard was divided, (n_freqs, n_frames)
    wanted: Complex  # every group alone at microphone 1, over the level, (n_groups, n_freqs, n_frames)


@dataclass(frozen=True, slots=True, eq=False)
class _Talk:
    """Talkers around the array at one heading."""

    heading: float  # [rad]
    azimuths: Real  # [rad], (n_talkers,)
    elevations: Real  # [rad], (n_talkers,)
    images: Real  # every talker alone at both microphones, (n_talkers, 2, n)


def clip_in_noise(voices: Mapping[str, Real], motor: Real | None, seed: int, index: int) -> NoisyClip:
    """Make one clip from recordings (n,) at `RATE` by talker, and of a motor."""
    rng = np.random.default_rng([seed, 11, index])
    rate = FAST if rng.random() < FASTER else RATE
    talk = _talk(voices, rate, rng)
    kind, first = str(rng.choice(KINDS, p=KIND_SHARES)), float(rng.uniform(-np.pi, np.pi))
    lead_in, noise, rotors = _noise(kind, (first, talk.heading), rate, motor, rng)
    speech = talk.images.sum(axis=0)
    gain = _gain(speech[0], noise[0], rate, float(rng.uniform(*RATIOS)))
    sensor = 10 ** (SENSOR / 20) * np.sqrt((speech[0] ** 2).mean())
    lead_in, noise = (gain * each + sensor * rng.standard_normal(each.shape) for each in (lead_in, noise))
    wrong = rng.normal(0, ASTRAY, len(talk.azimuths)) if rng.random() < 0.5 else 0.0
    tau = tdoa(talk.azimuths + wrong, talk.heading, SPACING, SPEED_OF_SOUND, talk.elevations)
    told = rotors if rng.random() < TOLD else None
    stft = Stft(rate, FRAME, HOP)
    mixture = stft.analyse((speech + noise).astype(np.float32))
    field = _field(stft, lead_in, first, mixture, talk.heading, rotors=told)
    return _fitted(stft, mixture, stft.analyse(talk.images[:, 0].astype(np.float32)), tau, field)


def _talk(voices: Mapping[str, Real], rate: int, rng: np.random.Generator) -> _Talk:
    n = int(rng.choice(N_TALKERS, p=TALKER_SHARES))
    azimuths, heading = spread(n, rng, APART), float(rng.uniform(0, np.pi))
    if n > 1 and rng.random() < ALIGNED:
        heading = aligned_heading(azimuths, int(rng.integers(n))) if n > 2 else heading
        heading += float(rng.normal(0, OFF)) * (rng.random() < NEARLY)
    away, below = rng.uniform(*AFAR, n), rng.uniform(0, BELOW) * (rng.random() < 0.5)
    names = rng.permutation(sorted(voices))[:n]
    cast = [recorded_voice(voices[name], rate, rng) for name in names]
    places = np.stack([away * np.cos(azimuths), away * np.sin(azimuths), np.full(n, -below)], axis=1)
    return _Talk(heading, azimuths, -np.arctan2(below, away), _images(cast, places, heading, rate, rng))


def _field(stft: Stft, lead_in: Real, first: float, mixture: Complex, heading: float, *, rotors: Rotors | None) -> Real:
    """The noise field as the payload finds it; a lead-in at another heading tells what to begin with, if anything."""
    quiet = stft.analyse(lead_in.astype(np.float32))
    known = learnt(quiet, stft.frequencies, stft.period, first, rotors)
    if known is None:
        return noise_field(mixture, stft.frequencies, stft.period)
    return known.field(mixture, stft.frequencies, stft.period, heading)


def _fitted(stft: Stft, mixture: Complex, spectra: Complex, tau: Real, field: Real) -> NoisyClip:
    scene = Scene(stft.frequencies, SPACING, SPEED_OF_SOUND, len(tau), tau, hop=stft.hop, noise_field=field)
    members, delays = directions_of(scene, "training")
    even = evened(mixture, replace(scene, tau=delays), delays, LARGER)
    _, covariances, psds = fitted(even.unit, even.scene, even.noise_psd)
    use = slice(0, int((even.scene.frequencies < HIGHEST).sum()))
    wanted = np.stack([spectra[list(group)][:, even.used].sum(axis=0) / even.level for group in members])
    return NoisyClip(
        stft.rate,
        even.unit[:, use],
        covariances[use, :-1],
        psds[use, :-1],
        even.noise_psd[use],
        np.asarray(even.scene.noise_field)[use],
        even.level[use],
        wanted[:, use],
    )


def _images(cast: Sequence[Real], places: Real, heading: float, rate: int, rng: np.random.Generator) -> Real:
    """Every talker alone at both microphones, mean power about 1 at microphone 1, (n_talkers, 2, n)."""
    where = tuple((float(x), float(y), float(z)) for x, y, z in places)
    responses = NearField(where, SPACING, rate, SPEED_OF_SOUND, delayed=False).at(heading)
    images = np.stack([oaconvolve(v[None], responses[:, k], axes=-1)[:, : v.size] for k, v in enumerate(cast)])
    levels = 10 ** (rng.uniform(-TIERS, TIERS, len(cast)) / 20)
    level = np.sqrt((images[:, :1] ** 2).mean(axis=2, keepdims=True)) + 1e-9
    return np.asarray(images / level * levels[:, None, None])


def _noise(
    kind: str, headings: tuple[float, float], rate: int, motor: Real | None, rng: np.random.Generator
) -> tuple[Real, Real, Rotors | None]:
    """A lead-in and what goes on after it at another heading, (2, n) each, and where the rotors are."""
    first, n = round(LEAD_IN * rate), round(SECONDS * rate)
    lead_in: Real = np.zeros((2, first))
    noise: Real = np.zeros((2, n))
    rotors: Rotors | None = None
    if kind != "wind":
        rotors, near = _places(rate, rng)
        sounds = _sounds(len(rotors.places), first + n, rate, motor, rng)
        lead_in, noise = _heard(sounds[:, :first], near, headings[0]), _heard(sounds[:, first:], near, headings[1])
    if kind != "rotors":
        blown = wind(rate, rng, gusts=bool(rng.random() < 0.8), seconds=LEAD_IN + SECONDS).astype(float)
        gain = 10 ** (rng.uniform(-6, 6) / 20) if kind == "both" else 1.0
        lead_in, noise = lead_in + gain * blown[:, :first], noise + gain * blown[:, first : first + n]
    return lead_in, noise, rotors


def _heard(sounds: Real, near: NearField, heading: float) -> Real:
    """What both microphones hear of the rotors, of unit power, (2, n)."""
    heard = oaconvolve(sounds[None], near.at(heading), axes=-1).sum(axis=1)[:, : sounds.shape[1]]
    return np.asarray(heard / np.sqrt(np.mean(heard**2)))


def _places(rate: int, rng: np.random.Generator) -> tuple[Rotors, NearField]:
    n, arm, above = int(rng.choice(N_ROTORS, p=ROTOR_SHARES)), rng.uniform(*ARMS), rng.uniform(*ABOVE)
    turns = 2 * np.pi * (np.arange(n) + rng.random()) / n + rng.normal(0, 0.1, n)
    places = tuple((float(arm * np.cos(t)), float(arm * np.sin(t)), float(above)) for t in turns)
    return Rotors(places, SPACING, SPEED_OF_SOUND), NearField(places, SPACING, rate, SPEED_OF_SOUND)


def _sounds(n_rotors: int, n: int, rate: int, motor: Real | None, rng: np.random.Generator) -> Real:
    """Rotors of one vehicle, (n_rotors, n): much alike, each with a level of its own."""
    rpm, blades = float(np.exp(rng.uniform(np.log(SLOWEST), np.log(FASTEST)))), int(rng.choice((2, 3, 4)))
    response, waves = _response(n, rate, rng), THROTTLES[int(rng.integers(len(THROTTLES)))]
    recorded = motor is not None and rng.random() < MOTOR
    steps = rng.random() < STEPS
    speed = rng.uniform(0.7, 1.4)
    sounds = []
    for _ in range(n_rotors):
        if recorded and motor is not None:
            played = at_speed(motor, speed * (1 + rng.normal(0, 0.02)) * RATE / rate)
            sound = np.resize(np.roll(played, -int(rng.integers(played.size))), n).astype(float)
        else:
            sound = rotor(rate, rpm, blades, rng, n / rate).sound.astype(float)[:n]
        sound = np.fft.irfft(np.fft.rfft(sound, n) * response, n)
        level = waves * gust_levels(n, rng)
        if steps:
            cuts = np.sort(rng.integers(0, n, int(rng.integers(1, 5))))
            level = level + rng.normal(0, STEP, len(cuts) + 1)[np.searchsorted(cuts, np.arange(n), side="right")]
        sound = sound * 10 ** (level / 20)
        sounds.append(sound / np.sqrt(np.mean(sound**2)) * 10 ** (rng.normal(0, 1.5) / 20))
    return np.stack(sounds)


THROTTLES = (0.0, 0.3, 0.6, 1.0)  # times the gusts of wind: how far the level of every rotor drifts


def _response(n: int, rate: int, rng: np.random.Generator) -> Real:
    """Amplitudes of a random filter, (n // 2 + 1,)."""
    octaves = np.log2(np.maximum(np.fft.rfftfreq(n, 1 / rate), 40) / 1000)
    gain_db = np.clip(rng.normal(0, TILT) * octaves, -25, 25)
    for _ in range(3):
        gain_db = gain_db + rng.normal(0, WAVES) * np.cos(octaves * rng.uniform(0.5, 5) + rng.uniform(0, 6))
    return np.asarray(10 ** (gain_db / 20))


def _gain(talk: Real, noise: Real, rate: int, ratio_db: float) -> float:
    """What noise is multiplied by to have the talkers so far above it in the frequencies of voices."""
    frequencies = np.fft.rfftfreq(talk.size, 1 / rate)
    band = (frequencies >= LOW) & (frequencies <= HIGH)
    one, other = (float((np.abs(np.fft.rfft(each))[band] ** 2).sum()) for each in (talk, noise))
    return float(np.sqrt(one / max(other, 1e-30)) * 10 ** (-ratio_db / 20))
