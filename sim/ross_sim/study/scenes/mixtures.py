"""Making recordings to separate: where talkers stand, where the array points, what its microphones hear.

K talkers of equal power at microphone 1 stand around the array in the middle of a room (`rooms`); white noise is 15 dB
below the mixture. The reference of every talker is itself alone at microphone 1. `ross study` makes tables of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import fftconvolve

from ross_payload.angles import Real, difference
from ross_payload.dsp.metrics import si_sdri
from ross_payload.dsp.noise import quiet_psd
from ross_payload.dsp.steering import tdoa
from ross_payload.dsp.stft import Stft
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Samples, Scene, Separator
from ross_sim.study.scenes.room_settings import SPACING, SPEED_OF_SOUND, Setting
from ross_sim.talkers.speech import SILENCE

PAPER_DEG = (170.0, 70.0, -50.0, -120.0, 10.0)  # the layout of the prototypes
VOICES = ("ls3005", "ls3331", "ls2414", "ls3080", "ls533")
APART = np.deg2rad(25.0)
SNR_DB = 15.0  # mixture over noise, at microphone 1
RATE, FRAME, HOP = 24000, 2048, 512
LEAD_IN = 2.0  # [s]


@dataclass(frozen=True, slots=True, eq=False)
class Mixture:
    """One mixture at one alignment."""

    mixture: Real  # (2, n)
    lead_in: Real  # noise alone, (2, m)
    images: Real  # every talker alone at both microphones, (n_sources, 2, n)
    tau: Real  # [s], (n_sources,)
    target: int

    @property
    def reference(self) -> Real:
        """The target alone at microphone 1, (n,)."""
        return np.asarray(self.images[self.target, 0])


def spread(n_sources: int, rng: np.random.Generator, apart: float = APART) -> Real:
    """Draw azimuths [rad], (n_sources,), uniform on the circle and at least ``apart`` [rad] from each other."""
    while True:
        azimuths = rng.uniform(-np.pi, np.pi, n_sources)
        gaps = np.abs(difference(azimuths[:, None], azimuths)) + 2 * np.pi * np.eye(n_sources)
        if gaps.min() >= apart:
            return azimuths


def excerpt(voice: Samples, length: int, rng: np.random.Generator) -> Real:
    """Cut ``length`` samples out of a voice (n,) at random."""
    start = int(rng.integers(len(voice) - length))
    return voice[start : start + length].astype(float)


def layouts(n_sources: int, count: int, rng: np.random.Generator) -> list[Real]:
    """The paper's layout and ``count`` random ones, at least 25 deg apart: azimuths [rad], (n_sources,) each."""
    return [np.deg2rad(PAPER_DEG[:n_sources]), *(spread(n_sources, rng) for _ in range(count))]


def aligned_heading(azimuths: Real, target: int) -> float:
    """Heading [rad] by the paper: the interferers' bisector for K = 3, else the argmax of min_k |tau_i - tau_k|.

    >>> round(float(np.rad2deg(aligned_heading(np.deg2rad([0.0, 100.0, 40.0]), target=0))), 6)
    70.0
    """
    others = np.delete(azimuths, target)
    if others.size == 2:
        return float(others.mean())
    headings = np.deg2rad(np.arange(0.0, 180.0, 0.5))
    isolation = np.abs(np.cos(azimuths[target] - headings) - np.cos(others[:, None] - headings)).min(axis=0)
    return float(headings[isolation.argmax()])


def is_silent(voice: Samples | Real) -> bool:
    """Whether nothing is heard in a voice (n,): below -100 dB re full scale, as of a whole recording."""
    return bool(np.mean(np.square(voice, dtype=float)) < SILENCE**2)


def expect_sound(voices: Sequence[Samples | Real], rate: int) -> None:
    """Check that something is heard of every talker in what is used of his or her recording, (n,) each.

    Raises
    ------
    ConfigError
        Says which talker is silent, and for how long.
    """
    for number, voice in enumerate(voices, 1):
        if is_silent(voice):
            raise ConfigError(
                f"talker {number} of {len(voices)}: expected speech, got silence in the {len(voice) / rate:g} s in use"
            )


def images_of(voices: Sequence[Real], places: Real, heading: float, setting: Setting, rate: int) -> Real:
    """Every talker alone at both microphones, of equal power at microphone 1, (n_sources, 2, n).

    The voices (n,) each are at ``places`` [m], (n_sources, dim); the array is at ``heading`` [rad].

    Raises
    ------
    ConfigError
        When a voice is silent.
    """
    expect_sound(voices, rate)
    return convolved(voices, setting.responses(places, [heading], rate)[0])


def convolved(voices: Sequence[Real], responses: Real) -> Real:
    """Voices (n,) each by impulse responses (2, n_sources, m): of equal power at microphone 1, (n_sources, 2, n)."""
    heard = [fftconvolve(voice[None], responses[:, k], axes=1)[:, : voice.size] for k, voice in enumerate(voices)]
    images = np.stack(heard)
    return np.asarray(images / np.sqrt((images[:, :1] ** 2).mean(axis=2, keepdims=True)))


def record(
    voices: Sequence[Real],
    azimuths: Real,
    target: int,
    heading: float,
    setting: Setting,
    *,
    rng: np.random.Generator,
    rate: int = RATE,
    softer_db: float = 0.0,
) -> Mixture:
    """Simulate one recording of ``voices`` (n,) each at ``azimuths`` [rad] with the array at ``heading`` [rad].

    The target may speak softer than the others. Where exactly the talkers of a true room stand depends on the azimuths
    alone, so that every target and heading of a layout has the same room.
    """
    places = setting.places(azimuths, np.random.default_rng(np.abs(azimuths * 1e6).astype(int)))
    images = images_of(voices, places, heading, setting, rate)
    images[target] *= 10 ** (-softer_db / 20)
    return noisy(images, tdoa(azimuths, heading, SPACING, SPEED_OF_SOUND), target, snr_db=SNR_DB, rng=rng, rate=rate)


def noisy(
    images: Real, tau: Real, target: int, *, snr_db: float, rng: np.random.Generator, rate: int = RATE
) -> Mixture:
    """Add up images (n_sources, 2, n) of delays ``tau`` [s], (n_sources,), and white noise; noise alone goes ahead."""
    clean = images.sum(axis=0)
    sigma = np.sqrt((clean[0] ** 2).mean() * 10 ** (-snr_db / 10))
    mixture = clean + sigma * rng.standard_normal(clean.shape)
    lead_in = sigma * rng.standard_normal((2, round(LEAD_IN * rate)))
    return Mixture(mixture.astype(np.float32), lead_in.astype(np.float32), images, tau, target)


def scene_of(recording: Mixture, stft: Stft, known_noise: bool) -> Scene:
    """What the separator may know; the noise PSD from the lead-in, or nothing about it."""
    psd = quiet_psd(stft.analyse(recording.lead_in), stft.analyse(recording.mixture)) if known_noise else None
    return Scene(stft.frequencies, SPACING, SPEED_OF_SOUND, recording.tau.size, recording.tau, psd, hop=stft.hop)


def gains(separator: Separator, recording: Mixture) -> list[float]:
    """SI-SDRi [dB] of the group that holds each talker, (n_sources,); 0 for a talker whom none does."""
    stft = Stft(RATE, FRAME, HOP)
    groups = separator.batch(stft.analyse(recording.mixture), scene_of(recording, stft, known_noise=True))
    found = [0.0] * recording.tau.size
    for members, signal in zip(groups.members, groups.signals, strict=True):
        voice = stft.synthesise(signal, recording.mixture.shape[1])
        for member in members:
            found[member] = si_sdri(voice, recording.mixture[0], recording.images[member, 0])
    return found
