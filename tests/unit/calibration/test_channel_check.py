"""Processed and copied channels are told from two raw microphones, from four seconds of a recording."""

import re

import numpy as np
import pytest

from ross_payload.calibration.channel_check import channel_troubles, correlation_delay
from ross_payload.config import Config, validated
from ross_payload.doctor.examination import processed
from turned_array import RATE, SPEED, waves

N = 4 * RATE


def syllables(seed=0):
    rng = np.random.default_rng(seed)
    loud = np.repeat(rng.random(20) ** 3, N // 20)
    return rng.standard_normal(N) * loud


def raw(noise=0.02, signal=None):
    """Two microphones 50 mm apart that hear somebody."""
    rng = np.random.default_rng(5)
    both = waves(syllables() if signal is None else signal, [1.0], 0.0, 0.05)
    return (0.1 * (both + noise * rng.standard_normal(both.shape))).astype(np.float32)


def said(samples):
    return [(each.channel, each.found) for each in channel_troubles(samples, RATE, 0.05, SPEED)]


def test_two_raw_microphones_are_well():
    assert said(raw()) == []


def test_two_raw_microphones_that_hear_only_themselves_are_well():
    assert said((0.01 * np.random.default_rng(1).standard_normal((2, N))).astype(np.float32)) == []


def test_silence_tells_nothing():
    assert said(np.zeros((2, N), np.float32)) == []
    assert said((1e-5 * raw()).astype(np.float32)) == []


@pytest.mark.parametrize(("channel", "lag"), [(0, 320), (1, 320), (1, 16)])
def test_a_channel_that_comes_late_is_named(channel, lag):
    samples = raw()
    samples[channel] = np.roll(samples[channel], lag)
    ((which, text),) = said(samples)
    assert which == channel
    late = float(re.match(r"comes ([0-9.]+) ms late", text)[1])
    assert late == pytest.approx(1e3 * lag / RATE, abs=0.15)  # with the delay of the sound itself


def test_a_gated_channel_is_named():
    samples = raw()
    quiet = np.abs(syllables()) < 0.05
    samples[1, np.repeat(quiet.reshape(-1, 800).mean(axis=1) > 0.5, 800)] = 0
    assert [channel for channel, text in said(samples) if "gated" in text] == [1]


def test_a_channel_that_ends_at_some_frequency_is_named():
    samples = raw(noise=0.2)
    spectrum = np.fft.rfft(samples[0])
    spectrum[np.fft.rfftfreq(N, 1 / RATE) > 4000] *= 1e-3
    samples[0] = np.fft.irfft(spectrum, N)
    assert (0, "has nothing above 4000 Hz: cut off by a codec or a speech filter") in said(samples)


@pytest.mark.parametrize("lag", [0, 3])
def test_a_copy_is_named_also_when_it_is_softer_or_late(lag):
    samples = raw()
    samples[1] = 0.5 * np.roll(samples[0], lag)
    assert (None, "have no noise of their own: one is a copy of the other") in said(samples)


def test_a_channel_that_has_lost_its_phase_is_noticed():
    samples = raw()
    loud = np.abs(syllables())
    samples[1] = (0.1 * loud * np.random.default_rng(9).standard_normal(N)).astype(np.float32)  # a vocoder, the extreme
    assert (None, "have nothing in common: one is processed, or they hear different things") in said(samples)


def test_the_delay_of_noise_is_found():
    noise = np.random.default_rng(0).standard_normal(5000)
    delay, peak = correlation_delay(np.stack([noise[40:], noise[:-40]]), RATE)
    assert delay == pytest.approx(-40 / RATE)
    assert peak > 0.5


def test_the_doctor_names_channels_by_their_numbers_in_the_configuration():
    samples = raw()
    samples[0] = np.roll(samples[0], 320)
    config = validated(Config, {"audio": {"channels": (1, 2), "device_channels": 6}}, "")
    (text,) = processed(config, samples)
    assert text.startswith("channel 1 comes 20")
