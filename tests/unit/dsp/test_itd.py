"""ITDs and how far to trust them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_payload.dsp.itd import ALARMS, STRICT, Trust, band_limits, itd_per_bin, raised_psd, tail, weighted_itd
from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Complex, Real
from ross_payload.localization import joint, markov_explorer

RATE = 16000
STFT = Stft(RATE, 512, 128)
PERIOD = STFT.hop / RATE


def plane_wave(tau: float, n_frames: int = 60) -> tuple[Complex, Real]:
    """One source with TDOA ``tau`` [s], gated in bursts, below 3.4 kHz."""
    rng = np.random.default_rng(0)
    frequencies = STFT.frequencies[10:109]
    source = rng.standard_normal((99, n_frames)) + 1j * rng.standard_normal((99, n_frames))
    source *= np.arange(n_frames) % 20 >= 10
    return np.stack([source, source * np.exp(2j * np.pi * frequencies * tau)[:, None]]), frequencies


@given(st.floats(-1.4e-4, 1.4e-4))
def test_a_plane_wave_has_its_tdoa_in_every_bin(tau: float) -> None:
    spectrogram, frequencies = plane_wave(tau)
    heard = np.abs(spectrogram[0]) > 0
    np.testing.assert_allclose(itd_per_bin(spectrogram, frequencies)[heard], tau, atol=1e-12)


def test_the_sign_is_positive_when_microphone_2_hears_it_first() -> None:
    noise = np.random.default_rng(1).standard_normal(RATE)
    spectrogram = STFT.analyse(np.stack([np.roll(noise, 2), noise]))[:, 10:100, 8:-8]
    itd = itd_per_bin(spectrogram, STFT.frequencies[10:100])
    assert np.median(itd) == pytest.approx(2 / RATE, rel=0.05)


def test_weights_lie_between_0_and_1_and_trust_one_talker() -> None:
    spectrogram, frequencies = plane_wave(1e-4)
    itd, weight = weighted_itd(spectrogram, frequencies, PERIOD, None, Trust())
    assert weight.min() >= 0
    assert 0 < weight.max() <= 1
    np.testing.assert_allclose(itd[weight > 0], 1e-4, atol=1e-9)


def test_independent_noise_at_the_microphones_is_hardly_trusted() -> None:
    rng = np.random.default_rng(2)
    noise = rng.standard_normal((2, 99, 400)) + 1j * rng.standard_normal((2, 99, 400))
    _, of_noise = weighted_itd(noise, STFT.frequencies[10:109], PERIOD, np.full(99, 2.0), Trust())
    _, of_voice = weighted_itd(*plane_wave(1e-4, 400), PERIOD, np.full(99, 0.02), Trust())
    assert of_noise.mean() < 0.02 * of_voice.mean()


def test_reverberation_that_decays_as_expected_is_not_trusted() -> None:
    decay = np.exp(-PERIOD * np.arange(40) / 2 / Trust().decay)
    spectrogram = np.tile(decay, (2, 20, 1)).astype(complex)
    _, weight = weighted_itd(spectrogram, STFT.frequencies[10:30], PERIOD, np.zeros(20), Trust())
    assert weight[:, 0].min() > 0
    assert weight[:, 3:-1].max() < 1e-9  # the average over the last frame has no next one


def test_what_lies_below_a_known_noise_is_not_trusted() -> None:
    spectrogram, frequencies = plane_wave(1e-4)
    _, weight = weighted_itd(spectrogram, frequencies, PERIOD, np.full(99, 1e6), Trust())
    assert weight.max() == 0


@given(st.lists(st.floats(0, 1e3), min_size=1, max_size=20), st.floats(0.01, 0.99))
def test_the_tail_never_exceeds_the_decayed_loudest_past(powers: list[float], decay: float) -> None:
    left = tail(np.array([powers]), decay)[0]
    wanted = [max((p * decay ** (n - m) for m, p in enumerate(powers[:n])), default=0.0) for n in range(len(powers))]
    np.testing.assert_allclose(left, wanted, rtol=1e-9, atol=1e-12)


@given(st.floats(0.005, 1.0))
def test_the_band_ends_where_half_a_wavelength_fits_between_the_microphones(spacing: float) -> None:
    low, high = band_limits(spacing, 343.0)
    assert 343.0 / high == pytest.approx(2 * spacing)
    assert 0 < low < high


@pytest.mark.parametrize("explorer", [joint.explorer, markov_explorer.explorer], ids=["joint", "markov"])
@pytest.mark.parametrize(("hop", "told"), [(128, None), (128, 128 / RATE), (384, 384 / RATE)])
def test_explorers_trust_a_steady_wave_by_what_decays_between_frames(
    explorer: joint.Factory | markov_explorer.Factory, hop: int, told: float | None
) -> None:
    """Onset: 1 in the first frame, then 1 less the tail of the frame before, exp(-hop / decay)."""
    n_frames, frequencies = 50, STFT.frequencies
    wave = np.exp(2j * np.pi * frequencies * 1e-4)
    heard = np.repeat(np.stack([np.ones_like(wave), wave])[..., None], n_frames, axis=2)
    silence = np.zeros(len(frequencies))
    seen = explorer.make(0.05, 343.0).observe(heard, frequencies, 0.0, silence, frame_period=told)
    low, high = band_limits(0.05, 343.0)
    band = frequencies[(frequencies >= low) & (frequencies <= high)]
    onsets = 1 + (n_frames - 1) * (1 - np.exp(-hop / RATE / Trust().decay))
    assert seen.weight == pytest.approx(onsets * band.sum() / band.max(), rel=0.02)


def fan(sensors: float, seed: int) -> Complex:
    """Two seconds of a fan that microphone 2 hears two samples before microphone 1, and white noise of each."""
    rng = np.random.default_rng(seed)
    heard, noise = rng.standard_normal(2 * RATE), sensors * rng.standard_normal((2, 2 * RATE))
    return STFT.analyse(np.stack([np.roll(heard, 2), heard]) + noise)[..., 4:-4]


def false_alarms(spectrogram: Complex, psd: Real) -> float:
    """Mean weight of the bins."""
    used = slice(16, 110)
    _, weight = weighted_itd(spectrogram[:, used], STFT.frequencies[used], PERIOD, psd[used], STRICT)
    return float(weight.mean())


def test_above_the_raised_psd_a_fan_passes_for_nobody() -> None:
    quiet, later = fan(0.05, 3), fan(0.05, 4)
    psd = (np.abs(quiet) ** 2).mean(axis=(0, 2))
    raised = raised_psd(quiet, STFT.frequencies, PERIOD, psd, (500.0, 3430.0))
    assert false_alarms(later, psd) > 20 * ALARMS
    assert false_alarms(later, raised) < 3 * ALARMS
    np.testing.assert_allclose(raised / psd, (raised / psd).max())
    assert 1.5 < (raised / psd).max() <= 3


def test_the_psd_of_white_noise_is_not_raised() -> None:
    rng = np.random.default_rng(5)
    quiet = STFT.analyse(rng.standard_normal((2, 2 * RATE)))[..., 4:-4]
    psd = (np.abs(quiet) ** 2).mean(axis=(0, 2))
    np.testing.assert_array_equal(raised_psd(quiet, STFT.frequencies, PERIOD, psd, (500.0, 3430.0)), psd)
