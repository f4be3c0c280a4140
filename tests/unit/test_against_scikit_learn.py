"""What is computed by hand, beside scikit-learn as an independent implementation (docs/decisions/0075)."""

import numpy as np
import pytest
from sklearn.cluster import KMeans
from sklearn.decomposition import FactorAnalysis
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis
from sklearn.mixture import GaussianMixture
from sklearn.neighbors import KernelDensity

from examples import in_soak
from ross_payload.dsp.density import histogram, itd_grid, kde
from ross_payload.localization.clusters import best_cuts, unwrapped
from ross_payload.voiceprint import built_in_model
from ross_payload.voiceprint.built_in import Background
from ross_sim.study.training.voice_factors import discriminants, first_loadings, improved_loadings

MOST = 6  # clusters


def votes(seed):
    """Directions around two to five places, a fifth of them anywhere, and their weights."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(-np.pi, np.pi, rng.integers(2, 6))
    angles = rng.choice(places, 60) + rng.normal(0, np.deg2rad(6), 60)
    astray = rng.random(60) < 0.2
    return np.where(astray, rng.uniform(-np.pi, np.pi, 60), angles), rng.gamma(1.0, 1.0, 60) + 0.05


@pytest.mark.parametrize("seed", [0, *in_soak(1, 2, 3, 4)])
def test_no_start_of_k_means_finds_better_clusters(seed):
    angles, weights = votes(seed)
    line, order = unwrapped(angles)
    inertia, _ = best_cuts(line, weights[order], MOST)
    for k, least in enumerate(inertia, start=1):
        fit = KMeans(k, n_init=5, random_state=seed).fit(line[:, None], sample_weight=weights[order])
        assert least <= fit.inertia_ * (1 + 1e-9)


def test_the_density_of_a_histogram_is_that_of_its_itds():
    rng = np.random.default_rng(0)
    itds, weights = np.clip(rng.normal(0.3, 0.2, 2000), -1.2, 1.2), rng.random(2000)
    grid = itd_grid(343.0, 343.0, 241)
    found = kde(histogram(itds, weights, grid), grid, 0.045)
    exact = KernelDensity(bandwidth=0.045).fit(itds[:, None], sample_weight=weights).score_samples(grid[:, None])
    assert found == pytest.approx(np.exp(exact) / np.exp(exact).sum(), abs=0.005 * found.max())


@pytest.fixture(scope="module")
def learnt():
    return built_in_model().parameters


@pytest.fixture(scope="module")
def frames(learnt):
    """Frames near the model's own."""
    rng = np.random.default_rng(0)
    owner = rng.choice(len(learnt.weights), 300, p=learnt.weights / learnt.weights.sum())
    return learnt.means[owner] + learnt.deviations[owner] * rng.standard_normal((300, learnt.means.shape[1]))


def test_frames_are_shared_among_gaussians_by_the_posteriors_of_the_mixture(learnt, frames):
    mixture = GaussianMixture(len(learnt.weights), covariance_type="diag")
    mixture.weights_, mixture.covariances_, mixture.means_ = learnt.weights, learnt.deviations**2, learnt.means
    mixture.precisions_cholesky_ = 1 / learnt.deviations
    posterior = mixture.predict_proba(frames)
    background = Background(learnt.weights, learnt.means, learnt.deviations)
    count, sums = background.statistics(frames.astype(np.float32))
    assert count == pytest.approx(posterior.sum(axis=0), abs=1e-2)
    moved = posterior.T @ frames - posterior.sum(axis=0)[:, None] * learnt.means
    assert sums == pytest.approx(moved / learnt.deviations, abs=0.05)


def test_discriminants_are_those_of_scikit_learn():
    rng = np.random.default_rng(0)
    owners = np.repeat(np.arange(5), 40)
    vectors = 2 * rng.standard_normal((5, 6))[owners] + rng.standard_normal((200, 6)) @ rng.standard_normal((6, 6))
    centre, directions = discriminants(vectors, [str(owner) for owner in owners], 0.0)
    found = (vectors - centre) @ directions
    other = LinearDiscriminantAnalysis(solver="eigen", n_components=2).fit_transform(vectors, owners)
    for axis in range(2):
        assert abs(np.corrcoef(found[:, axis], other[:, axis])[0, 1]) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.soak
def test_expectation_maximisation_finds_the_factors_that_made_the_statistics():
    """Two factors behind the mean of the frames of one Gaussian; scikit-learn fits them to the means themselves."""
    rng = np.random.default_rng(0)
    truth, n_frames = rng.standard_normal((8, 2)), 50
    means = rng.standard_normal((2000, 2)) @ truth.T + rng.standard_normal((2000, 8)) / np.sqrt(n_frames)
    counts = np.full((2000, 1), float(n_frames))
    loadings = first_loadings(counts, n_frames * means, 2)
    for _ in range(30):
        loadings = improved_loadings(counts, n_frames * means, loadings, 1.0)
    other = FactorAnalysis(2, tol=1e-8, max_iter=2000).fit(means).components_.T
    assert loadings @ loadings.T == pytest.approx(other @ other.T, rel=0.02, abs=0.05)
