import numpy as np
import pytest

from ross_payload.dsp.covariance import ROOT2, direct, outer
from ross_payload.separation import covariance_em
from ross_payload.separation.covariance_em import reestimated

WHITE = np.array([1.0, 1, 0, 0])


def _matrix(coordinates: np.ndarray) -> np.ndarray:
    first, second, real, imag = coordinates
    across = (real + 1j * imag) / ROOT2
    return np.array([[first, across], [np.conj(across), second]])


def _coordinates(matrix: np.ndarray) -> np.ndarray:
    return np.array([matrix[0, 0].real, matrix[1, 1].real, ROOT2 * matrix[0, 1].real, ROOT2 * matrix[0, 1].imag])


def _model(rng: np.random.Generator, n_freqs: int, n_groups: int, n_frames: int) -> tuple[np.ndarray, np.ndarray]:
    """Covariances of full rank and trace 2, the noise last, and PSDs of which one is mostly far above the others."""
    draws = rng.standard_normal((n_freqs, n_groups, 2, 2)) + 1j * rng.standard_normal((n_freqs, n_groups, 2, 2))
    matrices = draws @ draws.conj().swapaxes(-1, -2) + 0.2 * np.eye(2)
    matrices *= 2 / np.trace(matrices, axis1=-2, axis2=-1).real[..., None, None]
    sources = np.stack([[_coordinates(matrix) for matrix in row] for row in matrices])
    covariances = np.concatenate([sources, np.broadcast_to(WHITE, (n_freqs, 1, 4))], axis=1)
    psds = np.exp(2.5 * rng.standard_normal((n_freqs, n_groups + 1, n_frames)))
    psds[:, -1] = 0.01
    return covariances, psds


def _drawn(rng: np.random.Generator, covariances: np.ndarray, psds: np.ndarray) -> np.ndarray:
    """A mixture (2, n_freqs, n_frames) of the model."""
    total = np.swapaxes(covariances, 1, 2) @ psds
    roots = np.linalg.cholesky(np.array([[_matrix(c) for c in row.T] for row in total]))
    white = rng.standard_normal((*roots.shape[:2], 2, 2)) @ np.array([1, 1j]) / ROOT2
    return np.moveaxis((roots @ white[..., None])[..., 0], -1, 0)


def test_one_round_is_the_weighted_m_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """By 2 x 2 matrices, one frame after the other, as Duong et al. (2010) write it."""
    monkeypatch.setattr(covariance_em, "ROUNDS", 1)
    rng = np.random.default_rng(0)
    covariances, psds = _model(rng, 1, 3, 20)
    mixture = _drawn(rng, covariances, psds)
    found = reestimated(outer(mixture), covariances, psds)
    matrices = [_matrix(coordinates) for coordinates in covariances[0]]
    for k in range(3):
        expected = np.zeros((2, 2), complex)
        for t, x in enumerate(mixture[:, 0].T):
            total = sum(v * matrix for v, matrix in zip(psds[0, :, t], matrices, strict=True))
            wiener = psds[0, k, t] * matrices[k] @ np.linalg.inv(total)
            image = wiener @ np.outer(x, x.conj()) @ wiener.conj().T + (np.eye(2) - wiener) @ (
                psds[0, k, t] * matrices[k]
            )
            weight = (psds[0, k, t] / psds[0, :, t].sum()) ** 4 * psds[0, k, t] ** 0.25
            expected += weight * image / psds[0, k, t]
        np.testing.assert_allclose(found[0, k], _coordinates(2 * expected / np.trace(expected).real), rtol=1e-9)
    np.testing.assert_array_equal(found[:, -1], covariances[:, -1])


def test_it_comes_nearer_to_the_truth() -> None:
    rng = np.random.default_rng(1)
    covariances, psds = _model(rng, 30, 3, 300)
    observed = outer(_drawn(rng, covariances, psds))
    start = covariances.copy()
    start[:, :-1] = 0.5 * covariances[:, :-1] + 0.5 * WHITE
    found = reestimated(observed.astype(np.float32), start.astype(np.float32), psds.astype(np.float32))
    before, after = (np.linalg.norm(each[:, :-1] - covariances[:, :-1], axis=-1) for each in (start, found))
    assert after.mean() < 0.5 * before.mean()
    np.testing.assert_allclose(found[..., 0] + found[..., 1], 2, rtol=1e-5)


def test_blocks_of_bins_do_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(2)
    covariances, psds = _model(rng, 7, 2, 10)
    observed = outer(_drawn(rng, covariances, psds))
    whole = reestimated(observed, covariances, psds)
    monkeypatch.setattr(covariance_em, "AT_ONCE", 20)
    np.testing.assert_allclose(reestimated(observed, covariances, psds), whole, rtol=1e-12)


@pytest.mark.parametrize("n_frames", [0, 1, 5])
def test_where_nothing_is_heard_nothing_changes(n_frames: int) -> None:
    rng = np.random.default_rng(3)
    covariances, psds = (each.astype(np.float32) for each in _model(rng, 4, 2, n_frames))
    psds[:, 0] = 0
    found = reestimated(np.zeros((4, 4, n_frames), np.float32), covariances, psds)
    assert np.isfinite(found).all()
    np.testing.assert_array_equal(found[:, 0], covariances[:, 0])


def test_a_source_without_reflections_keeps_its_direction() -> None:
    waves = direct(np.array([1000.0]), np.array([1e-4]))
    covariances = np.concatenate([waves, WHITE[None, None]], axis=1).astype(np.float32)
    voice = np.exp(np.random.default_rng(4).standard_normal(50))
    mixture = np.array([1, np.exp(2j * np.pi * 0.1)])[:, None, None] * np.sqrt(voice)
    psds = np.stack([voice, np.full(50, 1e-4)])[None].astype(np.float32)
    np.testing.assert_allclose(
        reestimated(outer(mixture).astype(np.float32), covariances, psds), covariances, atol=1e-3
    )


@pytest.mark.parametrize("noise", [1e-7, 1e-12])
def test_a_voice_far_above_the_noise_keeps_the_covariance_of_its_direction(noise: float) -> None:
    """Single precision has no determinant left there: it may be 0, or below, and one over it overflows."""
    rng = np.random.default_rng(6)
    waves = direct(np.array([1000.0]), np.array([1e-4]))
    voice = rng.standard_normal(300) + 1j * rng.standard_normal(300)
    mixture = np.array([1.0, np.exp(2j * np.pi * 0.1)])[:, None, None] * voice
    covariances = np.concatenate([waves, WHITE[None, None]], axis=1).astype(np.float32)
    psds = np.stack([np.abs(voice) ** 2, np.full(300, noise)])[None].astype(np.float32)
    found = reestimated(outer(mixture).astype(np.float32), covariances, psds)
    np.testing.assert_allclose(found, covariances, atol=0.01)
