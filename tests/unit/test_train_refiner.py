"""Training of the refiner; what needs jax is soak."""

from pathlib import Path

import numpy as np
import pytest

from ross_payload.separation.local_gaussian_model import wiener
from ross_payload.separation.network import network_of, places
from ross_payload.separation.refiner_features import N_FEATURES
from ross_sim.study import refiner_model
from ross_sim.study.refiner_data import RATES, clip
from ross_sim.study.train_refiner import PIECE, keep, load, piece, train


def _voices(n_talkers: int = 3) -> dict[str, dict[int, np.ndarray]]:
    rng = np.random.default_rng(0)
    return {f"t{i}": {rate: rng.standard_normal(8 * rate) for rate in RATES} for i in range(n_talkers)}


def test_a_clip_depends_on_its_number_alone_and_adds_up() -> None:
    made, again = (clip(_voices(), seed=1, index=4) for _ in range(2))
    np.testing.assert_array_equal(made.mixture, again.mixture)
    assert np.isfinite(made.shown).all()
    assert made.shown.shape[1] == N_FEATURES
    rest = made.mixture[0] - made.wanted.sum(axis=0)
    assert (np.abs(rest) ** 2).sum() < 0.5 * (np.abs(made.mixture[0]) ** 2).sum()


def test_the_filter_that_training_differentiates_is_the_one_of_the_payload() -> None:
    rng = np.random.default_rng(2)
    factors = rng.standard_normal((6, 3, 2, 2, 2)) @ [1, 1j]
    matrices = factors @ np.swapaxes(factors.conj(), 2, 3)
    root2 = np.sqrt(2)
    h = [matrices[..., 0, 0].real, matrices[..., 1, 1].real, root2 * matrices[..., 0, 1].real]
    sources = np.stack([*h, root2 * matrices[..., 0, 1].imag], axis=-1)
    sources *= 2 / (sources[..., :1] + sources[..., 1:2])
    covariances = np.concatenate([sources, np.tile([1.0, 1, 0, 0], (6, 1, 1))], axis=1)
    psds, noise = rng.uniform(0.1, 2, (3, 6, 5)), rng.uniform(0.01, 0.1, 6)
    x = rng.standard_normal((2, 6, 5, 2)) @ [1, 1j]
    every = np.concatenate([psds.swapaxes(0, 1), np.tile(noise[:, None, None], (1, 1, 5))], axis=1)
    found = refiner_model.filtered(np, np.log(psds), covariances, noise, np.stack([x.real, x.imag]))
    np.testing.assert_allclose(found[0] + 1j * found[1], wiener(x, every, covariances), rtol=1e-6)


@pytest.mark.soak
def test_a_few_steps_lessen_the_loss_and_the_payload_computes_the_same(tmp_path: Path) -> None:
    jax = pytest.importorskip("jax", reason="training needs jax and optax")
    path = tmp_path / "0.npz"
    index = next(i for i in range(20) if len(clip(_voices(), 1, i).shown) in (2, 3))
    keep(clip(_voices(), 1, index), path)
    start = refiner_model.initial(8, 2, np.random.default_rng(0))
    weights, batch = train([path], 40, 0, start), piece(load(path), 20)
    assert refiner_model.loss(np, weights, batch) < refiner_model.loss(np, start, batch)
    shown = batch[0]
    assert shown.shape[-1] == PIECE
    frequencies = np.arange(shown.shape[2]) * float(load(path)["rate"]) / 2048
    expected = refiner_model.corrections(jax.numpy, weights, shown, places(frequencies))
    np.testing.assert_allclose(network_of(weights).corrections(shown, frequencies), expected, atol=1e-4)
