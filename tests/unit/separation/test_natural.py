import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from examples import in_soak, rows_in_soak
from ross_payload.dsp.covariance import outer
from ross_payload.dsp.steering import steering_vectors
from ross_payload.interfaces import Scene
from ross_payload.separation.natural_gradient_iva import (
    HIGH,
    LOW,
    demix,
    images_of,
    outputs_of,
    separator,
    whitening,
)

FREQUENCIES = np.fft.rfftfreq(256, 1 / 16000)
LONGEST = 0.05 / 343.0
TAU = LONGEST * np.array([-0.7, 0.8])


def _mixture(tau: np.ndarray = TAU, frames: int = 300) -> tuple[np.ndarray, np.ndarray]:
    """Sources whose level changes from frame to frame: images at microphone 1 and the mixture."""
    rng = np.random.default_rng(0)
    shape = (len(tau), FREQUENCIES.size, frames)
    levels = rng.gamma(0.3, size=(len(tau), 1, frames))
    images = np.sqrt(levels) * (rng.standard_normal(shape) + 1j * rng.standard_normal(shape))
    return images, np.einsum("fmk,kft->mft", steering_vectors(FREQUENCIES, tau), images)


def _scene(tau: np.ndarray | None, n_sources: int = 2) -> Scene:
    return Scene(FREQUENCIES, 0.05, 343.0, n_sources, tau)


def _leak_db(estimate: np.ndarray, image: np.ndarray) -> float:
    heard = (FREQUENCIES > 300) & (FREQUENCIES < 6000)
    return float(10 * np.log10((np.abs(estimate - image) ** 2)[heard].sum() / (np.abs(image) ** 2)[heard].sum()))


@pytest.mark.parametrize("order", [[1, 0], *in_soak([0, 1])])
def test_two_sources_are_unmixed_and_told_apart_by_their_directions(order: list[int]) -> None:
    images, mixture = _mixture()
    groups = separator.batch(mixture, _scene(TAU[order]))
    assert groups.members == ((0,), (1,))
    for signal, source in zip(groups.signals, order, strict=True):
        assert _leak_db(signal, images[source]) < -15


def test_aliased_sources_come_out_together() -> None:
    tau = LONGEST * np.array([0.8, -0.7, 0.8])
    images, mixture = _mixture(tau)
    groups = separator.batch(mixture, _scene(tau, 3))
    assert groups.members == ((0, 2), (1,))
    assert _leak_db(groups.signals[0], images[0] + images[2]) < -15


@pytest.mark.soak
def test_the_gradient_vanishes_at_the_solution() -> None:
    """E[phi(y) y^H] = I is the fixed point of the natural gradient, whatever the scale of the projection back."""
    _, mixture = _mixture()
    rows = demix(outer(mixture), iterations=400)
    outputs = np.einsum("fkm,mft->kft", rows, mixture)
    score = outputs / np.sqrt((np.abs(outputs) ** 2).sum(axis=1, keepdims=True))
    moments = np.einsum("kft,lft->fkl", score, outputs.conj())
    sizes = np.sqrt(np.abs(moments[:, 0, 0] * moments[:, 1, 1]))[5:]  # at low frequencies both directions look alike
    assert np.median(np.abs(moments[5:, 0, 1]) / sizes) < 0.02


def test_both_outputs_add_up_to_microphone_1() -> None:
    _, mixture = _mixture()
    total = np.einsum("fkm,mft->ft", demix(outer(mixture), iterations=3), mixture)
    np.testing.assert_allclose(total, mixture[0], atol=1e-8)


def test_whitened_observations_are_uncorrelated_and_of_unit_power() -> None:
    rng = np.random.default_rng(1)
    source = rng.standard_normal((2, 3, 500)) + 1j * rng.standard_normal((2, 3, 500))
    mixture = np.einsum("ij,jft->ift", np.array([[1.0, 0.5], [0.2j, 2.0]]), source)
    white = np.einsum("fij,jft->ift", whitening(outer(mixture)), mixture)
    covariance = np.einsum("ift,jft->fij", white, white.conj()) / white.shape[-1]
    np.testing.assert_allclose(covariance, np.broadcast_to(np.eye(2), (3, 2, 2)), atol=5e-3)


def test_columns_of_the_inverse_point_at_the_sources() -> None:
    mixing = steering_vectors(FREQUENCIES[1:], TAU)
    cross = images_of(np.linalg.inv(mixing))
    assert outputs_of(cross, FREQUENCIES[1:], TAU) == (0, 1)
    assert outputs_of(cross, FREQUENCIES[1:], TAU[::-1]) == (1, 0)
    assert outputs_of(cross, FREQUENCIES[1:], TAU[1:]) == (1,)


@pytest.mark.parametrize("n_groups", [1, 2, 3, 4])
def test_the_assignment_of_outputs_is_the_best_one_as_scipy_finds_it(n_groups: int) -> None:
    rng = np.random.default_rng(n_groups)
    cross = np.exp(2j * np.pi * rng.random((FREQUENCIES.size - 1, 4)))
    tau = rng.uniform(-1.5e-4, 1.5e-4, n_groups)
    used = (FREQUENCIES[1:] >= LOW) & (FREQUENCIES[1:] <= HIGH)
    phases = 2 * np.pi * FREQUENCIES[1:][used, None, None] * tau[:, None]
    agreement = np.cos(np.angle(cross[used])[:, None, :] - phases).sum(axis=0)
    assert outputs_of(cross, FREQUENCIES[1:], tau) == tuple(linear_sum_assignment(agreement, maximize=True)[1])


def test_same_input_same_output() -> None:
    _, mixture = _mixture(frames=50)
    np.testing.assert_array_equal(*(separator.batch(mixture, _scene(TAU)).signals for _ in range(2)))


@pytest.mark.parametrize(
    ("tau", "count"), [(TAU, 2), (None, 1), (np.zeros(0), 0), *rows_in_soak((None, 2), (TAU[:1], 1))]
)
def test_silence_no_frames_and_a_dead_microphone_give_finite_signals(tau: np.ndarray | None, count: int) -> None:
    _, mixture = _mixture(frames=20)
    dead = [mixture * np.array(on)[:, None, None] for on in ([0, 0], [1, 0], [0, 1])]
    low_passed = mixture * (FREQUENCIES < 4000)[None, :, None]
    for changed in (*dead, low_passed, mixture[..., :0]):
        groups = separator.batch(changed, _scene(tau, count))
        assert groups.signals.shape == (count, *changed.shape[1:])
        assert np.isfinite(groups.signals).all()
