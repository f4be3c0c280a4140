import numpy as np
import pytest

from ross_payload.dsp.covariance import outer
from ross_payload.dsp.steering import steering_vectors
from ross_payload.interfaces import Scene
from ross_payload.separation.auxiva import demix, projected_back, separator, start_from

FREQUENCIES = np.fft.rfftfreq(512, 1 / 16000)
LONGEST = 0.05 / 343.0
TAU = LONGEST * np.array([-0.7, 0.8])


def _mixture(tau: np.ndarray = TAU, frames: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """Sources whose level changes from frame to frame: images at microphone 1 and the mixture."""
    rng = np.random.default_rng(0)
    shape = (len(tau), FREQUENCIES.size, frames)
    levels = rng.gamma(0.3, size=(len(tau), 1, frames))
    images = np.sqrt(levels) * (rng.standard_normal(shape) + 1j * rng.standard_normal(shape))
    return images, np.einsum("fmk,kft->mft", steering_vectors(FREQUENCIES, tau), images)


def _scene(tau: np.ndarray | None, n_sources: int = 2) -> Scene:
    return Scene(FREQUENCIES, 0.05, 343.0, n_sources, tau, np.zeros(FREQUENCIES.size))


def _leak_db(estimate: np.ndarray, image: np.ndarray) -> float:
    heard = (FREQUENCIES > 300) & (FREQUENCIES < 6000)
    error = (np.abs(estimate - image) ** 2)[heard].sum() / (np.abs(image) ** 2)[heard].sum()
    return float(10 * np.log10(error))


def test_two_sources_are_unmixed_without_knowing_where_they_are() -> None:
    images, mixture = _mixture()
    signals = separator.batch(mixture, _scene(None)).signals
    assert min(_leak_db(signals[0], images[0]), _leak_db(signals[1], images[0])) < -20
    assert min(_leak_db(signals[0], images[1]), _leak_db(signals[1], images[1])) < -20


def test_known_directions_say_whom_each_output_holds() -> None:
    images, mixture = _mixture()
    groups = separator.batch(mixture, _scene(TAU))
    assert groups.members == ((0,), (1,))
    assert _leak_db(groups.signals[0], images[0]) < -20
    assert _leak_db(groups.signals[1], images[1]) < -20


def test_more_sources_are_cut_at_the_widest_gap() -> None:
    tau = LONGEST * np.array([0.8, -0.9, 0.6])
    _, mixture = _mixture(tau)
    assert separator.batch(mixture, _scene(tau, 3)).members == ((0, 2), (1,))


def test_both_outputs_add_up_to_microphone_1() -> None:
    _, mixture = _mixture()
    use = np.ones(FREQUENCIES.size)
    rows = demix(outer(mixture), use, start_from(FREQUENCIES, None), iterations=3)
    total = np.einsum("fkm,mft->ft", rows, mixture)
    np.testing.assert_allclose(total, mixture[0], atol=1e-8)


def test_projection_back_undoes_any_scale_of_the_rows() -> None:
    start = start_from(FREQUENCIES, TAU)
    np.testing.assert_allclose(projected_back(start * np.array([[3.0], [-2j]])), projected_back(start))


@pytest.mark.parametrize(("tau", "count"), [(TAU, 2), (None, 2), (TAU[:1], 1), (np.zeros(0), 0)])
def test_silence_and_a_dead_microphone_give_finite_signals(tau: np.ndarray | None, count: int) -> None:
    _, mixture = _mixture(frames=20)
    for changed in (0 * mixture, mixture * np.array([1, 0])[:, None, None], mixture * np.array([0, 1])[:, None, None]):
        groups = separator.batch(changed, _scene(tau, count))
        assert groups.signals.shape == (count, *mixture.shape[1:])
        assert np.isfinite(groups.signals).all()
