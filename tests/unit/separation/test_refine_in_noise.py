"""The refiner where noise has a direction: what it is shown, what it is trained with, and what it corrects."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest

from ross_payload.dsp.covariance import outer
from ross_payload.dsp.metrics import si_sdr
from ross_payload.dsp.noise_field import noise_field
from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Scene
from ross_payload.separation import local_gaussian_model
from ross_payload.separation.evened_noise import LOWEST_VOICE
from ross_payload.separation.local_gaussian_model import wiener
from ross_payload.separation.network import network_in_noise, network_of, shipped_arrays, shipped_network
from ross_payload.separation.refined import LARGER, Refined
from ross_payload.separation.refiner_features import N_FEATURES, N_IN_NOISE, features, features_in_noise, stacked
from ross_sim.study.training import noise_clips, refiner_data, refiner_model
from ross_sim.study.training.noise_clips import clip_in_noise
from ross_sim.study.training.noise_pieces import packed, piece_in_noise
from ross_sim.study.training.refiner_model import widened
from ross_sim.study.training.voice_augmentation import RATE
from rotor_scenes import SPACING, SPEED_OF_SOUND, rotor_noise, talk

STFT = Stft(RATE, 2048, 512)
SECONDS = 2
MARGIN = 5  # of the features: how much more likely a group is than the others, of whom the noise is one


def matrices(rng, shape):
    """Coordinates of random covariances of trace 2, (*shape, 4)."""
    factors = rng.standard_normal((*shape, 2, 2, 2)) @ [1, 1j]
    every = factors @ np.swapaxes(factors.conj(), -1, -2)
    across = np.sqrt(2) * every[..., 0, 1]
    found = np.stack([every[..., 0, 0].real, every[..., 1, 1].real, across.real, across.imag], axis=-1)
    return found * 2 / (found[..., :1] + found[..., 1:2])


def drawn(seed=3, n_freqs=8, n_frames=6, n_groups=2):
    """Covariances, the white noise last, PSDs, and a mixture of bins."""
    rng = np.random.default_rng(seed)
    white = np.tile([1.0, 1, 0, 0], (n_freqs, 1, 1))
    covariances = np.concatenate([matrices(rng, (n_freqs, n_groups)), white], axis=1)
    psds = rng.uniform(0.1, 2, (n_freqs, n_groups + 1, n_frames))
    return covariances, psds, rng.standard_normal((2, n_freqs, n_frames, 2)) @ [1, 1j]


def test_in_white_noise_talkers_are_shown_as_ever_and_the_noise_beside_them():
    covariances, psds, x = drawn()
    psds[:, -1] = 0.3
    field = np.broadcast_to(np.array([1.0, 1, 0, 0])[:, None], (8, 4, 6))
    shown = stacked(features_in_noise(outer(x), covariances, psds, field))
    before = stacked(features(outer(x), covariances, psds))
    assert shown.shape == (3, N_IN_NOISE, 8, 6)
    same = [index for index in range(N_FEATURES) if index != MARGIN]
    np.testing.assert_allclose(shown[:2, same], before[:, same], rtol=1e-4, atol=1e-5)
    assert shown[:, -1].max(axis=(1, 2)).tolist() == [0, 0, 1]


def test_the_filter_that_training_differentiates_is_the_one_of_the_payload():
    covariances, psds, x = drawn()
    field = np.moveaxis(matrices(np.random.default_rng(4), (8, 6)), 2, 1)
    found = refiner_model.filtered_in_noise(
        np, np.log(psds.swapaxes(0, 1)), covariances[:, :-1], field, np.stack([x.real, x.imag])
    )
    np.testing.assert_allclose(found[0] + 1j * found[1], wiener(x, psds, covariances, field), rtol=1e-5)


def test_weights_begin_as_those_without_a_direction():
    rng = np.random.default_rng(5)
    shown = rng.standard_normal((N_IN_NOISE, 16, 2, 8)).astype(np.float32)
    frequencies = 80 + 7.8125 * np.arange(16)
    found = network_of(widened(shipped_arrays())).corrections(shown, frequencies)
    np.testing.assert_allclose(found, shipped_network().corrections(shown[:N_FEATURES], frequencies), atol=1e-4)


@pytest.fixture
def _short(monkeypatch):
    """Clips of 2 s, rotors and wind together."""
    for module in (refiner_data, noise_clips):
        monkeypatch.setattr(module, "SECONDS", 2.0)
    monkeypatch.setattr(noise_clips, "KIND_SHARES", (0.0, 0.0, 1.0))


@pytest.mark.soak
@pytest.mark.usefixtures("_short")
def test_a_clip_in_noise_depends_on_its_number_and_its_piece_shows_what_the_payload_would():
    rng = np.random.default_rng(0)
    voices = {f"t{i}": rng.standard_normal(4 * RATE) for i in range(4)}
    made, again = (clip_in_noise(voices, None, 1, 3) for _ in range(2))
    np.testing.assert_array_equal(made.mixture, again.mixture)
    shown, where, covariances, field, level, mixture, _ = piece_in_noise(packed(made), 10, 20)
    n_groups, n_freqs = made.wanted.shape[0], len(made.noise) // 4 * 4
    assert shown.shape == (n_groups + 1, N_IN_NOISE, n_freqs, 20)
    assert covariances.shape == (n_freqs, n_groups, 4)
    np.testing.assert_allclose(field, made.field[:n_freqs, :, 10:30], atol=2e-3)
    np.testing.assert_allclose(level, made.level[:n_freqs, 10:30], rtol=1e-2)
    np.testing.assert_allclose(mixture[0], made.mixture[:, :n_freqs, 10:30].real, rtol=1e-3, atol=1e-6)
    assert where[0, 0] * 4000 == pytest.approx(LOWEST_VOICE, abs=3 * made.rate / 2048)


@cache
def scene_of(heading=0.4, azimuth=1.9, louder=1.0):
    """One talker among rotors whose amplitude is ``louder`` times that of the talker."""
    image = talk(SECONDS, azimuth, heading)
    spectrogram = STFT.analyse((image + louder * rotor_noise(SECONDS, heading)).astype(np.float32))
    tau = SPACING / SPEED_OF_SOUND * np.cos([azimuth - heading])
    field = noise_field(spectrogram, STFT.frequencies, STFT.period)
    return spectrogram, Scene(STFT.frequencies, SPACING, SPEED_OF_SOUND, 1, tau, hop=STFT.hop, noise_field=field)


def silent():
    """A network that corrects nothing."""
    arrays = widened(shipped_arrays())
    return network_of(arrays | {name: 0 * arrays[name] for name in ("out", "out_b", "skip")})


@cache
def uncorrected():
    """What such a network makes of that scene."""
    return Refined(in_noise=silent()).batch(*scene_of()).signals


@pytest.mark.soak
def test_a_network_that_corrects_nothing_leaves_nearly_the_local_gaussian_model():
    spectrogram, scene = scene_of()
    found = uncorrected()
    alone = local_gaussian_model.from_directions(
        local_gaussian_model._separated, spectrogram, scene, "gaussian", larger=LARGER
    ).signals
    assert (np.abs(found - alone) ** 2).sum() < 0.02 * (np.abs(alone) ** 2).sum()


def test_what_the_network_says_of_the_noise_counts():
    spectrogram, scene = scene_of()
    arrays = widened(shipped_arrays())
    skip = 0 * arrays["skip"]
    skip[:, 8 * N_FEATURES : 8 * N_IN_NOISE] = 1.0  # the noise by e^8, the talker not at all
    louder = network_of(arrays | {"out": 0 * arrays["out"], "out_b": 0 * arrays["out_b"], "skip": skip})
    usual, less = uncorrected(), Refined(in_noise=louder).batch(spectrogram, scene).signals
    low = (STFT.frequencies > 100) & (STFT.frequencies < 5000)
    assert (np.abs(less[:, low]) ** 2).sum() < 0.1 * (np.abs(usual[:, low]) ** 2).sum()


def test_the_weights_of_the_package_are_those_of_noise():
    assert network_in_noise().enter.shape[1] == 8 * N_IN_NOISE + 3
    assert dataclasses.asdict(network_in_noise()).keys() == dataclasses.asdict(shipped_network()).keys()


@pytest.mark.soak
def test_the_weights_of_the_package_leave_less_noise_than_none_and_than_those_for_white_noise():
    image, (spectrogram, scene) = talk(SECONDS, 1.9, 0.4)[0], scene_of(louder=3.0)
    networks = {"none": silent(), "white": network_of(widened(shipped_arrays())), "shipped": None}
    found = {
        name: si_sdr(STFT.synthesise(Refined(in_noise=each).batch(spectrogram, scene).signals, image.size)[0], image)
        for name, each in networks.items()
    }
    assert found["shipped"] > max(found["none"], found["white"]) + 2  # [dB]
