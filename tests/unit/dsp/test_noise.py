import numpy as np
import pytest

from ross_payload.dsp.noise import flatness, guessed_psd, quiet_psd

N_FREQS, N_FRAMES = 257, 200
COLOUR = np.linspace(0.5, 4.0, N_FREQS)


def _noise(frames: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    shape = (2, N_FREQS, frames)
    return np.sqrt(COLOUR / 2)[:, None] * (rng.standard_normal(shape) + 1j * rng.standard_normal(shape))


def _talk(frames: int, seed: int) -> np.ndarray:
    """Level that moves as syllables do, 20 dB up and down."""
    return _noise(frames, seed) * 10 ** (np.sin(np.arange(frames) / 3) + 1)


def _crowd(frames: int, seed: int) -> np.ndarray:
    """As loud in every frame, but each bin is 20 dB louder or softer than its mean from frame to frame."""
    return _noise(frames, seed) * 10 ** np.random.default_rng(seed + 100).uniform(-1, 1, (1, N_FREQS, frames))


def test_a_quiet_lead_in_gives_the_psd_that_was_put_in() -> None:
    psd = quiet_psd(_noise(N_FRAMES, 0), _talk(N_FRAMES, 1))
    assert psd is not None
    np.testing.assert_allclose(psd, COLOUR, rtol=0.25)  # five standard deviations of the mean of 400


def test_a_cough_and_an_early_talker_stay_out() -> None:
    lead_in = _noise(N_FRAMES, 0)
    lead_in[:, :, 30:40] *= 30
    lead_in[:, :, 150:] *= 20
    psd = quiet_psd(lead_in, _talk(N_FRAMES, 1))
    assert psd is not None
    np.testing.assert_allclose(psd, COLOUR, rtol=0.3)


def test_talk_in_the_lead_in_is_not_noise() -> None:
    assert quiet_psd(_talk(N_FRAMES, 0), _talk(N_FRAMES, 1)) is None


def test_many_who_talk_in_the_lead_in_are_not_noise_when_they_pause_later() -> None:
    later = 2 * _crowd(N_FRAMES, 1)
    later[:, :, 50:90] = 0.1 * _noise(40, 2)
    assert quiet_psd(_crowd(N_FRAMES, 0), later) is None


def test_many_voices_that_never_pause_are_noise() -> None:
    assert quiet_psd(_crowd(N_FRAMES, 0), _crowd(N_FRAMES, 1) + 10 * _talk(N_FRAMES, 2)) is not None


def test_many_voices_that_never_pause_are_noise_where_sound_is_missing_later() -> None:
    later = _crowd(N_FRAMES, 1) + 10 * _talk(N_FRAMES, 2)
    later[:, :, 50:90] = 0
    assert quiet_psd(_crowd(N_FRAMES, 0), later) is not None


def test_a_motor_that_runs_slower_later_was_noise() -> None:
    later = _talk(N_FRAMES, 1)
    later[:, :, 50:90] = 0.1 * _noise(40, 2)
    assert quiet_psd(_noise(N_FRAMES, 0), later) is not None


def test_flatness_of_gaussian_noise_is_ten_times_the_logarithm_of_e_to_eulers_constant() -> None:
    power = np.abs(_noise(4000, 0)) ** 2
    assert np.mean(flatness(power)) == pytest.approx(10 * np.log10(np.e) * np.euler_gamma, abs=0.02)


def test_flatness_of_silence_and_of_a_steady_tone_is_nothing() -> None:
    np.testing.assert_allclose(flatness(np.array([[0.0, 0.0], [5.0, 5.0]])), 0.0, atol=1e-9)


def test_a_lead_in_as_loud_as_what_follows_is_not_noise() -> None:
    assert quiet_psd(_noise(N_FRAMES, 0), 1.5 * _noise(N_FRAMES, 1)) is None


def test_too_short_a_lead_in_tells_nothing() -> None:
    assert quiet_psd(_noise(5, 0), _talk(N_FRAMES, 1)) is None
    assert quiet_psd(_noise(N_FRAMES, 0), _talk(0, 1)) is None


def test_the_guess_is_unbiased_in_noise_alone() -> None:
    guess = guessed_psd(_noise(4000, 0))
    np.testing.assert_allclose(guess, COLOUR, rtol=0.25)
    assert abs(np.mean(guess / COLOUR) - 1) < 0.02
