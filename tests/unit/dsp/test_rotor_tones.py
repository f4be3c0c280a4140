"""Tones of rotors whose speeds are known: where they are, and what the noise is taken to be there."""

from __future__ import annotations

import numpy as np
import pytest

from ross_payload.dsp.covariance import outer
from ross_payload.dsp.noise_field import noise_field, whitened
from ross_payload.dsp.rotor_tones import raised, tones
from ross_payload.dsp.stft import Stft
from ross_sim.acoustics.rotor_noise import rotor

RATE = 16000
STFT = Stft(RATE, 1024, 256)


def found_of(speeds, seconds=2.0, blades=2):
    n_frames = STFT.frames_of(round(seconds * RATE))
    return tones(STFT.frequencies, STFT.period, n_frames, np.asarray(speeds, float), seconds=seconds, blades=blades)


def test_tones_follow_a_speed_that_changes():
    found = found_of(np.linspace(80.0, 120.0, 200)[:, None])
    first, last = (STFT.frequencies[found[:, frame]][0] for frame in (4, -5))
    assert first == pytest.approx(160.0, abs=30)
    assert last == pytest.approx(240.0, abs=30)


def test_rotors_that_stand_or_are_not_known_have_no_tones():
    assert not found_of(np.zeros((10, 4))).any()
    assert not found_of(np.zeros((10, 0))).any()


def test_tones_that_fill_the_spectrum_are_none():
    slow = found_of([[12.0]])  # 24 Hz apart, in bins of 15.6 Hz
    assert not slow.any()


def test_the_energy_of_a_made_rotor_is_where_its_tones_are():
    made = rotor(RATE, 5400.0, 2, np.random.default_rng(3), seconds=4.0)
    spectrogram = STFT.analyse(np.stack([made.sound, made.sound]))
    speeds = made.speed[:: RATE // 100][:, None]
    tonal = tones(STFT.frequencies, STFT.period, spectrogram.shape[2], speeds, seconds=4.0, blades=2)
    band = (STFT.frequencies > 100) & (STFT.frequencies < 1000)
    power = np.abs(spectrogram[0][band]) ** 2
    assert power[tonal[band]].mean() > 5 * power[~tonal[band]].mean()


def test_the_noise_of_tones_is_raised_to_what_they_are_and_the_rest_stays():
    rng = np.random.default_rng(0)
    times = np.arange(4 * RATE) / RATE
    swept = np.sin(2 * np.pi * np.cumsum(200 + 40 * np.sin(2 * np.pi * 0.5 * times)) / RATE)  # at no frequency for long
    heard = rng.standard_normal((2, times.size)) + 1.5 * swept
    spectrogram = STFT.analyse(heard.astype(np.float32))
    field = noise_field(spectrogram, STFT.frequencies, STFT.period)
    speeds = (100 + 20 * np.sin(2 * np.pi * 0.5 * times[::160]))[:, None]
    tonal = tones(STFT.frequencies, STFT.period, spectrogram.shape[2], speeds, seconds=4.0, blades=2)
    tonal[(STFT.frequencies < 130) | (STFT.frequencies > 270)] = False
    better = raised(field, spectrogram, STFT.frequencies, tonal)
    before, after = (np.median(whitened(outer(spectrogram), each)[tonal]) for each in (field, better))
    assert before > 3 * 1.7  # the median of a gamma distribution of shape 2 is 1.68
    assert after < before / 2
    np.testing.assert_array_equal(np.swapaxes(better, 1, 2)[~tonal], np.swapaxes(field, 1, 2)[~tonal])
