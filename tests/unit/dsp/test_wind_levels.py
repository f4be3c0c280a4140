"""Wind that comes in gusts: how loud it is at every moment, and what is no talk."""

from __future__ import annotations

import numpy as np
import pytest

from ross_payload.dsp.covariance import outer
from ross_payload.dsp.ego_noise import learnt
from ross_payload.dsp.noise_field import noise_field, whitened
from ross_payload.dsp.noise_levels import noise_levels
from ross_sim.acoustics.wind_noise import wind
from rotor_scenes import RATE, STFT, rotor_noise, talk


def spectrogram(samples):
    return STFT.analyse(samples.astype(np.float32))


def gust(seconds=4.0):
    """Even wind that is 20 dB louder in the middle, and by how much at every frame [dB]."""
    even = wind(RATE, np.random.default_rng(1), gusts=False, seconds=seconds)
    times = np.arange(even.shape[1]) / RATE
    louder = 20 * np.exp(-(((times - seconds / 2) / 0.4) ** 2))
    frames = np.arange(STFT.frames_of(even.shape[1])) * STFT.period
    return even * 10 ** (louder / 20), np.interp(frames, times, louder)


def test_the_level_follows_a_gust_while_somebody_talks():
    blown, louder = gust()
    heard = spectrogram(blown + talk(4.0, 0.7, 0.0))
    level = 10 * np.log10(noise_levels(heard, STFT.frequencies))
    off = (level - np.median(level) - louder + np.median(louder))[20:-20]
    assert np.abs(off).max() < 4.0


def test_steady_noise_has_one_level():
    heard = spectrogram(np.random.default_rng(2).standard_normal((2, 3 * RATE)))
    assert np.ptp(10 * np.log10(noise_levels(heard, STFT.frequencies))[10:-10]) < 1.0


def test_silence_has_a_level():
    assert noise_levels(np.zeros((2, 257, 5), np.complex64), STFT.frequencies).tolist() == [1.0] * 5
    assert noise_levels(np.zeros((2, 257, 0), np.complex64), STFT.frequencies).shape == (0,)


def test_a_gust_in_the_lead_in_is_wind_and_no_talk():
    blown, _ = gust(2.0)
    known = learnt(spectrogram(blown), STFT.frequencies, STFT.period, 0.0, None)
    assert known is not None
    assert known.gusty


def test_rotors_are_not_gusty():
    known = learnt(spectrogram(rotor_noise(2, 0.0)), STFT.frequencies, STFT.period, 0.0, None)
    assert not known.gusty


@pytest.mark.soak
def test_the_noise_of_gusts_is_known_better_where_their_level_is():
    lead_in, (blown, _) = gust(2.0)[0], gust()
    heard = spectrogram(blown)
    known = learnt(spectrogram(lead_in), STFT.frequencies, STFT.period, 0.0, None)
    fields = (
        known.field(heard, STFT.frequencies, STFT.period, 0.0),
        noise_field(heard, STFT.frequencies, STFT.period),
    )
    within, without = (np.log(whitened(outer(heard), field)[:, 20:-20]).std() for field in fields)
    assert within < 0.9 * without
