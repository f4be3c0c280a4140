"""Separators among noise that has a direction: the full-rank term serves, and without it nothing changes."""

import dataclasses

import numpy as np
import pytest

from ross_payload.dsp.covariance import direct
from ross_payload.dsp.metrics import si_sdr
from ross_payload.dsp.noise_field import noise_field
from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Scene
from ross_payload.separation import auto_separator, local_gaussian_model
from ross_payload.separation.local_gaussian_model import source_psds, wiener
from rotor_scenes import RATE, SPACING, SPEED_OF_SOUND, rotor_noise, talk

STFT = Stft(RATE, 1024, 256)
SECONDS, HEADING = 4, 0.4
AZIMUTHS = (0.5, 2.3)


@pytest.fixture(scope="module")
def recording():
    images = np.stack([talk(SECONDS, azimuth, HEADING, seed=5) for azimuth in AZIMUTHS])
    noise = np.sqrt(2) * rotor_noise(SECONDS, HEADING) * np.repeat([0.4, 1.4], SECONDS * RATE // 2)
    mixture = (images.sum(axis=0) + noise).astype(np.float32)
    spectrogram = STFT.analyse(mixture)
    tau = SPACING / SPEED_OF_SOUND * np.cos(np.array(AZIMUTHS) - HEADING)
    psd = (np.abs(STFT.analyse(noise[:, :RATE].astype(np.float32))) ** 2).mean(axis=(0, 2))
    white = Scene(STFT.frequencies, SPACING, SPEED_OF_SOUND, 2, tau, psd, hop=STFT.hop)
    field = noise_field(spectrogram, STFT.frequencies, STFT.period)
    return images[:, 0], mixture, spectrogram, white, dataclasses.replace(white, noise_field=field)


@pytest.fixture(scope="module")
def alone(recording):
    """What the local Gaussian model makes of it."""
    return local_gaussian_model.separator.batch(recording[2], recording[-1])


@pytest.fixture(scope="module")
def chosen(recording):
    """What is made of it unless somebody asks for another."""
    return auto_separator.separator.batch(recording[2], recording[-1])


def gains(groups, recording):
    images, mixture, *_ = recording
    assert groups.members == ((0,), (1,))
    voices = STFT.synthesise(groups.signals, mixture.shape[1])
    return [si_sdr(voice, image) - si_sdr(mixture[0], image) for voice, image in zip(voices, images, strict=True)]


@pytest.mark.soak
def test_noise_found_again_gains_over_the_psd_of_a_lead_in_when_the_throttle_moves(recording, alone):
    without = gains(local_gaussian_model.separator.batch(recording[2], recording[3]), recording)
    within = gains(alone, recording)
    assert np.mean(within) > np.mean(without) + 1
    assert min(within) > 4  # [dB]


def test_the_network_is_not_asked_where_it_knows_nothing(alone, chosen):
    assert chosen.method == "refined"
    assert np.abs(alone.signals - chosen.signals).max() < 1e-3 * np.abs(alone.signals).max()


def test_auto_takes_the_model_of_every_bin_and_says_why(chosen):
    network = "the local Gaussian model alone: frames of 64 ms, and the network is for 67 to 167 ms"
    assert (chosen.method, chosen.why) == ("refined", f"directions known, noise that is not white; {network}")


def test_a_louder_recording_gives_the_same_voices_louder(recording, alone):
    *_, coloured = recording
    louder = dataclasses.replace(coloured, noise_field=100 * coloured.noise_field)
    ten = local_gaussian_model.separator.batch(10 * recording[2], louder).signals
    assert np.abs(ten / 10 - alone.signals).max() < 1e-2 * np.abs(alone.signals).max()


def test_a_white_field_is_the_white_model():
    rng = np.random.default_rng(1)
    frequencies = np.linspace(500, 3000, 40)
    covariances = np.concatenate([direct(frequencies, np.array([-1e-4, 5e-5])), np.zeros((40, 1, 4))], axis=1)
    covariances[:, :2, 2:] *= 0.99
    covariances[:, 2, :2] = 1
    samples = rng.standard_normal((2, 40, 30)) + 1j * rng.standard_normal((2, 40, 30))
    observed = local_gaussian_model.outer(samples)
    shares, psd = np.full((40, 2, 30), 0.5), np.full(40, 0.3)
    field = np.broadcast_to(np.array([1.0, 1.0, 0.0, 0.0])[None, :, None], (40, 4, 30))
    without = source_psds(observed, covariances, psd, shares)
    within = source_psds(observed, covariances, psd, shares, noise=field)
    assert np.allclose(without, within)
    assert np.allclose(wiener(samples, without, covariances), wiener(samples, within, covariances, field))
