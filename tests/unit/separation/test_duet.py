from dataclasses import replace

import numpy as np
import pytest

from ross_payload.dsp.steering import steering_vectors
from ross_payload.interfaces import Scene
from ross_payload.plugin_checks import load_separator
from ross_payload.separation.duet import blind_delays, separator

FREQUENCIES = np.fft.rfftfreq(512, 1 / 16000)
LONGEST = 0.05 / 343.0
TAU = LONGEST * np.array([-0.8, 0.1, 0.9])


def _disjoint() -> tuple[np.ndarray, np.ndarray]:
    """Three sources that never share a bin: images at microphone 1 (3, n_freqs, n_frames), mixture (2, ...)."""
    rng = np.random.default_rng(0)
    shape = (FREQUENCIES.size, 100)
    owner = rng.integers(0, 3, shape)
    bins = rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
    images = bins * (owner == np.arange(3)[:, None, None])
    return images, np.einsum("fmk,kft->mft", steering_vectors(FREQUENCIES, TAU), images)


def _scene(tau: np.ndarray | None, n_sources: int = 3) -> Scene:
    return Scene(FREQUENCIES, 0.05, 343.0, n_sources, tau, np.zeros(FREQUENCIES.size))


def test_disjoint_sources_come_out_whole() -> None:
    images, mixture = _disjoint()
    groups = separator.batch(mixture, _scene(TAU))
    assert groups.members == ((0,), (1,), (2,))
    above = FREQUENCIES > 0  # at zero frequency all delays look alike
    np.testing.assert_allclose(groups.signals[:, above], images[:, above], atol=1e-9)


def test_aliased_sources_are_one_group() -> None:
    _, mixture = _disjoint()
    groups = separator.batch(mixture, _scene(TAU[[0, 1, 0]]))
    assert groups.members == ((0, 2), (1,))
    assert groups.signals.shape == (2, *mixture.shape[1:])


def test_the_delays_are_found_when_they_are_not_known() -> None:
    _, mixture = _disjoint()
    np.testing.assert_allclose(blind_delays(mixture, _scene(None)), np.sort(TAU), atol=0.02 * LONGEST)
    assert separator.batch(mixture, _scene(None)).members == ((), (), ())


@pytest.mark.parametrize("tau", [TAU, None])
def test_silence_gives_silence(tau: np.ndarray | None) -> None:
    groups = separator.batch(np.zeros((2, FREQUENCIES.size, 20), np.complex64), _scene(tau))
    assert not groups.signals.any()


@pytest.mark.parametrize("dead", [0, 1])
def test_where_no_delay_is_found_the_mixture_of_the_microphone_that_hears_is_the_only_group(dead: int) -> None:
    _, mixture = _disjoint()
    mixture[dead] = 0
    groups = load_separator("duet").batch(mixture, replace(_scene(None), noise_psd=None))
    np.testing.assert_array_equal(groups.signals[0], mixture[1 - dead])
    assert (groups.members, groups.why) == (((),), "no delay found: the mixture as it is")


def test_no_frames_give_groups_without_frames() -> None:
    nothing = np.zeros((2, FREQUENCIES.size, 0), np.complex64)
    assert separator.batch(nothing, _scene(TAU)).signals.shape == (3, FREQUENCIES.size, 0)


def test_nobody_gives_no_groups() -> None:
    _, mixture = _disjoint()
    assert separator.batch(mixture, _scene(np.zeros(0), 0)).signals.shape == (0, *mixture.shape[1:])


def test_a_dead_microphone_gives_finite_signals() -> None:
    _, mixture = _disjoint()
    mixture[1] = 0
    assert np.isfinite(separator.batch(mixture, _scene(TAU)).signals).all()
