"""Explorer and separators at other rates and spacings than the shipped ones, and what must not matter to them."""

from dataclasses import replace

import numpy as np
import pytest

from ross_payload.angles import difference
from ross_payload.dsp.steering import steering_vectors, tdoa
from ross_payload.dsp.stft import short_frames
from ross_payload.interfaces import Complex, Observation, Real, Scene
from ross_payload.localization.joint import explorer
from ross_payload.plugin_checks import load_separator

SPEED = 343.0
AZIMUTHS = np.deg2rad([-100.0, 20.0, 140.0])
HEADINGS = np.deg2rad(np.arange(0.0, 105.0, 15.0))
ARRAYS = [(8000, 0.01), (11025, 0.3), (44100, 0.02), (96000, 0.3)]  # rate [Hz], spacing [m]


def _heard(rate: int, spacing: float, heading: float, rng: np.random.Generator, n_frames: int = 160) -> Complex:
    """Spectrogram (2, n_freqs, n_frames): bursts of 10 frames, each bin of each burst is ruled by one talker."""
    frequencies = short_frames(rate).frequencies
    shape = (len(frequencies), n_frames)
    ruler = np.repeat(rng.integers(len(AZIMUTHS), size=(shape[0], n_frames // 10)), 10, axis=1)
    burst = np.repeat(rng.standard_normal((shape[0], n_frames // 10)) ** 3, 10, axis=1)
    voices = burst * np.exp(2j * np.pi * rng.random(shape)) * (ruler == np.arange(len(AZIMUTHS))[:, None, None])
    waves = steering_vectors(frequencies, tdoa(AZIMUTHS, heading, spacing, SPEED))
    noise = 0.1 * rng.standard_normal((2, *shape, 2)).view(np.complex128)[..., 0]
    return np.asarray(np.einsum("fmk,kft->mft", waves, voices) + noise)


def _observed(rate: int, spacing: float, heading: float, heard: Complex) -> Observation:
    return explorer.make(spacing, SPEED).observe(heard, short_frames(rate).frequencies, heading, None)


@pytest.mark.parametrize(("rate", "spacing"), ARRAYS)
def test_every_talker_is_counted_and_placed(rate: int, spacing: float) -> None:
    rng = np.random.default_rng(0)
    seen = [_observed(rate, spacing, heading, _heard(rate, spacing, heading, rng, 300)) for heading in HEADINGS]
    found = np.array([source.azimuth for source in explorer.make(spacing, SPEED).estimate(seen).sources])
    assert len(found) == len(AZIMUTHS)
    assert np.rad2deg(np.abs(difference(AZIMUTHS[:, None], found)).min(axis=1)).max() < 3


def test_microphones_that_change_places_mirror_every_delay() -> None:
    heard = _heard(16000, 0.05, 0.3, np.random.default_rng(1))
    one, other = (_observed(16000, 0.05, 0.3, each) for each in (heard, heard[::-1]))
    np.testing.assert_allclose(one.features.strict, other.features.strict[::-1], atol=1e-9)
    np.testing.assert_allclose(one.density, other.density[::-1], atol=1e-9)


def _separated(name: str, heard: Complex, order: list[int]) -> Real:
    """Signals of the groups of AZIMUTHS, whatever the order in which the sources are told."""
    tau = tdoa(AZIMUTHS, 0.0, 0.2, SPEED)
    scene = Scene(short_frames(44100).frequencies, 0.2, SPEED, len(order), tau[order])
    groups = load_separator(name).batch(heard.astype(np.complex64), replace(scene, hop=short_frames(44100).hop))
    assert groups.members == ((0,), (1,), (2,))
    return np.asarray(groups.signals[np.argsort(order), 1:])  # at zero frequency all delays look alike


@pytest.mark.parametrize("name", ["auto", "gaussian", "duet", "mvdr"])
def test_neither_the_level_nor_the_order_of_the_sources_matters(name: str) -> None:
    heard = _heard(44100, 0.2, 0.0, np.random.default_rng(2), 40)
    usual = _separated(name, heard, [0, 1, 2])
    least = 1e-3 * np.abs(usual).max()
    np.testing.assert_allclose(100 * _separated(name, 0.01 * heard, [0, 1, 2]), usual, atol=least)
    np.testing.assert_allclose(_separated(name, heard, [2, 0, 1]), usual, atol=least)
