import numpy as np
import pytest

from ross_payload.dsp.steering import steering_vectors
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Scene
from ross_payload.separation.beamforming import NOISE_GAIN, covariance_of, lcmv, lcmv_weights, mvdr, mvdr_weights

FREQUENCIES = np.fft.rfftfreq(512, 1 / 16000)
LONGEST = 0.05 / 343.0
TAU = LONGEST * np.array([-0.7, 0.8])


def _images(tau: np.ndarray, frames: int = 60) -> np.ndarray:
    """Plane waves with levels that change, at both microphones, (n_sources, 2, n_freqs, n_frames)."""
    rng = np.random.default_rng(0)
    shape = (len(tau), FREQUENCIES.size, frames)
    sources = np.sqrt(rng.gamma(0.3, size=shape)) * (rng.standard_normal(shape) + 1j * rng.standard_normal(shape))
    return np.einsum("fmk,kft->kmft", steering_vectors(FREQUENCIES, tau), sources)


def _scene(tau: np.ndarray | None, n_sources: int = 2) -> Scene:
    return Scene(FREQUENCIES, 0.05, 343.0, n_sources, tau)


@pytest.fixture
def covariances() -> np.ndarray:
    return covariance_of(_images(TAU).sum(axis=0))


def test_mvdr_is_distortionless(covariances: np.ndarray) -> None:
    steering = steering_vectors(FREQUENCIES, TAU)[..., 0]
    gain = (mvdr_weights(covariances, steering).conj() * steering).sum(axis=-1)
    np.testing.assert_allclose(gain, 1, atol=1e-9)


def test_mvdr_lets_less_through_than_any_other_distortionless_beam(covariances: np.ndarray) -> None:
    steering = steering_vectors(FREQUENCIES, TAU)[..., 0]
    best = mvdr_weights(covariances, steering)
    across = np.stack([steering[:, 1].conj(), -steering[:, 0].conj()], axis=-1)  # orthogonal to the steering

    def power(weights: np.ndarray) -> np.ndarray:
        return np.einsum("fi,fij,fj->f", weights.conj(), covariances, weights).real

    for other in (0.1, -0.1, 0.1j, -0.1j):
        assert (power(best + other * across) > power(best)).all()


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_lcmv_nulls_the_interferer_exactly_in_an_anechoic_mixture(order: list[int]) -> None:
    images = _images(TAU)
    signals = lcmv.batch(images.sum(axis=0), _scene(TAU)).signals
    apart = np.sin(np.pi * FREQUENCIES * (TAU[1] - TAU[0])) ** 2 > 1 / (2 * NOISE_GAIN)
    assert apart.sum() > 100
    np.testing.assert_allclose(signals[order[0]][apart], images[order[0], 0][apart], atol=1e-9)


def test_lcmv_amplifies_noise_no_more_than_its_limit_where_it_nulls(covariances: np.ndarray) -> None:
    constraints = steering_vectors(FREQUENCIES, TAU)
    weights = lcmv_weights(covariances, constraints)
    nulled = np.abs((weights.conj() * constraints[..., 1]).sum(axis=-1)) < 1e-9
    assert 0 < nulled.sum() < FREQUENCIES.size
    assert (np.abs(weights[nulled]) ** 2).sum(axis=-1).max() <= NOISE_GAIN * (1 + 1e-9)
    np.testing.assert_allclose((weights.conj() * constraints[..., 0]).sum(axis=-1), 1, atol=1e-9)


def test_lcmv_says_why_three_groups_get_mvdr() -> None:
    tau = LONGEST * np.array([-0.7, 0.0, 0.8])
    mixture = _images(tau).sum(axis=0)
    groups = lcmv.batch(mixture, _scene(tau, 3))
    np.testing.assert_array_equal(groups.signals, mvdr.batch(mixture, _scene(tau, 3)).signals)
    assert "3 groups" in groups.why


def test_aliased_interferers_share_one_null() -> None:
    tau = LONGEST * np.array([0.8, -0.7, 0.8])
    images = _images(tau)
    groups = lcmv.batch(images.sum(axis=0), _scene(tau, 3))
    assert groups.members == ((0, 2), (1,))
    assert groups.why == ""
    apart = np.sin(np.pi * FREQUENCIES * (tau[1] - tau[0])) ** 2 > 1 / (2 * NOISE_GAIN)
    np.testing.assert_allclose(groups.signals[0][apart], (images[0, 0] + images[2, 0])[apart], atol=1e-9)


@pytest.mark.parametrize("separator", [mvdr, lcmv])
def test_directions_are_needed(separator: object) -> None:
    with pytest.raises(ConfigError, match="TDOA"):
        separator.batch(_images(TAU).sum(axis=0), _scene(None))


@pytest.mark.parametrize("separator", [mvdr, lcmv])
@pytest.mark.parametrize("tau", [TAU, TAU[:1], np.zeros(0), np.zeros(2)])
def test_silence_no_frames_and_a_dead_microphone_give_finite_signals(separator: object, tau: np.ndarray) -> None:
    mixture = _images(TAU, 20).sum(axis=0).astype(np.complex64)
    dead = [mixture * np.array(on, np.float32)[:, None, None] for on in ([0, 0], [1, 0], [0, 1])]
    for changed in (*dead, mixture[..., :0]):
        groups = separator.batch(changed, _scene(tau, tau.size))
        assert groups.signals.shape == (len(groups.members), *changed.shape[1:])
        assert groups.signals.dtype == changed.dtype
        assert np.isfinite(groups.signals).all()
    assert sorted(sum(groups.members, ())) == list(range(tau.size))
