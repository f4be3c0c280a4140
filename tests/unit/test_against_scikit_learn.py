"""What is computed by hand, beside scikit-learn as an independent implementation (docs/decisions/0075)."""

import numpy as np
import pytest
from sklearn.cluster import KMeans
from sklearn.mixture import GaussianMixture
from sklearn.neighbors import KernelDensity

from ross_payload.dsp.density import histogram, itd_grid, kde
from ross_payload.localization.clusters import best_cuts, unwrapped
from ross_payload.voiceprint import shipped_background
from ross_payload.voiceprint.background import COHORT_STEP, ENOUGH, RIVALS
from ross_payload.voiceprint.features import Features

MOST = 6  # clusters


def votes(seed):
    """Directions around two to five places, a fifth of them anywhere, and their weights."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(-np.pi, np.pi, rng.integers(2, 6))
    angles = rng.choice(places, 60) + rng.normal(0, np.deg2rad(6), 60)
    astray = rng.random(60) < 0.2
    return np.where(astray, rng.uniform(-np.pi, np.pi, 60), angles), rng.gamma(1.0, 1.0, 60) + 0.05


@pytest.mark.parametrize("seed", range(5))
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
def background():
    return shipped_background()


@pytest.fixture(scope="module")
def features(background):
    """Frames near the background's own."""
    rng = np.random.default_rng(0)
    owner = rng.choice(len(background.weights), 300, p=background.weights / background.weights.sum())
    cepstra = background.means[owner] + background.deviations[owner] * rng.standard_normal((300, 48))
    return Features(cepstra.astype(np.float32), np.log(rng.uniform(80, 250, 200)))


def mixture_of(background, offsets):
    """The background with its means moved by offsets [standard deviations], as scikit-learn has it."""
    found = GaussianMixture(len(background.weights), covariance_type="diag")
    found.weights_, found.covariances_ = background.weights, background.deviations**2
    found.means_ = background.means + offsets * background.deviations
    found.precisions_cholesky_ = 1 / background.deviations
    return found


def test_a_voice_is_adapted_by_the_posteriors_of_the_mixture(background, features):
    posterior = mixture_of(background, 0.0).predict_proba(features.cepstra.astype(float))
    count = posterior.sum(axis=0)[:, None]
    moved = (posterior.T @ features.cepstra - count * background.means) / background.deviations
    assert background.adapt(features).offsets == pytest.approx(moved / (count + background.relevance), abs=1e-4)


def test_the_evidence_is_the_gain_in_likelihood_over_the_nearest_of_the_cohort(background, features):
    voice = background.adapt(features)
    frames = features.cepstra.astype(float)
    own = mixture_of(background, voice.offsets).score(frames)
    others = [mixture_of(background, offsets).score(frames) for offsets in background.cohort * COHORT_STEP]
    gain = own - np.sort(others)[-RIVALS:].mean()
    assert background.evidence(voice, features)[0] == pytest.approx(ENOUGH * np.tanh(gain / ENOUGH), abs=1e-4)
