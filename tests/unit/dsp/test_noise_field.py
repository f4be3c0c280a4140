"""The covariance of noise in every bin: found among talk, in level and direction, as it changes."""

import numpy as np
import pytest

from examples import in_soak
from ross_payload.dsp.covariance import ROOT2, outer
from ross_payload.dsp.noise_field import coherence, noise_field, whitened
from rotor_scenes import ROTORS, STFT, rotor_noise, talk

BAND = (STFT.frequencies > 500) & (STFT.frequencies < 3400)


def found(samples):
    return noise_field(STFT.analyse(samples.astype(np.float32)), STFT.frequencies, STFT.period)


def level_db(field):
    return 10 * np.log10(0.5 * (field[BAND, 0] + field[BAND, 1]).mean())


def true_level_db(samples):
    power = (np.abs(STFT.analyse(samples.astype(np.float32))) ** 2).mean(axis=(0, 2))
    return 10 * np.log10(power[BAND].mean())


def off(field, samples):
    """Mean distance of the complex coherence, smoothed as the field is, from that of the samples."""
    true = outer(STFT.analyse(samples.astype(np.float32))).mean(axis=2)
    kernel = np.ones(15) / 15
    both = []
    for each in (field.mean(axis=2), true):
        one, two, cross = (
            np.convolve(part, kernel, mode="same") for part in (each[:, 0], each[:, 1], each[:, 2] - 1j * each[:, 3])
        )
        both.append(cross / np.sqrt(2 * one * two))
    return np.abs(both[0] - both[1])[BAND].mean()


def test_noise_alone_is_found_with_its_level_and_its_direction():
    noise = rotor_noise(4, 0.4)
    field = found(noise)
    assert level_db(field) == pytest.approx(true_level_db(noise), abs=0.7)
    assert off(field, noise) < 0.1
    assert whitened(outer(STFT.analyse(noise.astype(np.float32))), field)[BAND].mean() == pytest.approx(2, rel=0.15)


def test_talk_of_the_same_loudness_is_left_out():
    noise = rotor_noise(4, 0.4)
    field = found(noise + talk(4, 2.0, 0.4))
    assert level_db(field) == pytest.approx(true_level_db(noise), abs=1.5)
    assert off(field, noise) < 0.2


def test_white_noise_has_no_direction():
    field = found(np.random.default_rng(1).standard_normal((2, 64000)))
    assert np.median(coherence(field)[BAND]) < 0.15


def test_the_level_is_followed_as_it_changes():
    noise = rotor_noise(4, 0.4) * np.repeat([1, 4], 32000)
    field = found(noise)
    ends = [10 * np.log10(field[BAND, 0, part].mean()) for part in (slice(0, 100), slice(-100, None))]
    assert ends[1] - ends[0] == pytest.approx(20 * np.log10(4), abs=1.5)


def test_a_louder_recording_has_a_louder_field_of_the_same_shape():
    noise = rotor_noise(2, 0.4)
    quiet, loud = found(noise), found(10 * noise)
    assert np.abs(loud / 100 - quiet).max() < 1e-3 * quiet.max()


def test_silence_and_nothing_are_no_trouble():
    assert np.isfinite(found(np.zeros((2, 16000)))).all()
    assert noise_field(np.zeros((2, 257, 0), complex), STFT.frequencies, STFT.period).shape == (257, 4, 0)


@pytest.mark.parametrize("heading", [0.7, *in_soak(0.0, 2.0)])
def test_known_places_give_the_covariance_at_any_heading(heading):
    noise = rotor_noise(6, heading)
    true = outer(STFT.analyse(noise.astype(np.float32))).mean(axis=2)
    shape = ROTORS.shape(STFT.frequencies, heading, np.ones(STFT.frequencies.size))
    assert np.allclose(shape[:, 0] + shape[:, 1], 2)
    for coordinate in (2, 3):
        measured = (true[:, coordinate] / (true[:, 0] + true[:, 1]))[BAND]
        expected = (shape[:, coordinate] / 2)[BAND]
        assert np.abs(measured - expected).mean() / ROOT2 < 0.12
