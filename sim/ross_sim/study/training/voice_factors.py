"""Learning the built-in model of voices: factors by expectation maximisation, and directions in which talkers differ.

Factors as in Kenny, Boulianne and Dumouchel, "Eigenvoice modeling with sparse training data", IEEE Trans. Speech and
Audio Processing 13 (2005), with residual variances kept at those of the mixture, and the minimum divergence step of
Brümmer; linear discriminant analysis with the variance within talkers shrunk towards a multiple of the identity.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import eigh
from scipy.sparse.linalg import svds

from ross_payload.interfaces import Real

PRIOR = 4.0  # frames that the mean of a Gaussian counts for at the start
BATCH = 200  # recordings at a time
LOOSE = 1e-3  # added where the normal equations are singular


def first_loadings(counts: Real, sums: Real, n_factors: int) -> Real:
    """Start from the principal components of the adapted means: counts (m, n), sums (m, n * d); (n * d, n_factors)."""
    width = sums.shape[1] // counts.shape[1]
    adapted = sums / np.repeat(counts + PRIOR, width, axis=1)
    _, sizes, vectors = svds(adapted, n_factors, v0=np.ones(min(adapted.shape)))
    return np.asarray(vectors.T * np.maximum(sizes / np.sqrt(len(adapted)), np.finfo(float).tiny))


def improved_loadings(counts: Real, sums: Real, loadings: Real, independence: float) -> Real:
    """Take one step of expectation maximisation, (n_gaussians * n_features, n_factors).

    Parameters
    ----------
    counts, sums
        Statistics of m recordings, (m, n_gaussians) and (m, n_gaussians * n_features).
    loadings
        Of before.
    independence
        How many independent frames one frame counts for.
    """
    n, r = counts.shape[1], loadings.shape[1]
    each = loadings.reshape(n, -1, r).astype(np.float32)
    products = (each.transpose(0, 2, 1) @ each).reshape(n, r * r)
    moments, cross, second = np.zeros((n, r * r)), np.zeros(loadings.shape), np.zeros((r, r))
    for at in range(0, len(counts), BATCH):
        count = (independence * counts[at : at + BATCH]).astype(np.float32)
        total = (independence * sums[at : at + BATCH]).astype(np.float32)
        covariance = np.linalg.inv((count @ products).reshape(-1, r, r) + np.eye(r, dtype=np.float32))
        mean = np.einsum("mrs,ms->mr", covariance, total @ loadings.astype(np.float32))
        covariance += mean[:, :, None] * mean[:, None, :]
        moments += count.T @ covariance.reshape(len(count), -1)
        cross += total.T @ mean
        second += covariance.sum(axis=0)
    found = [
        np.linalg.solve(moment + LOOSE * np.eye(r), part.T).T
        for moment, part in zip(moments.reshape(n, r, r), cross.reshape(n, -1, r), strict=True)
    ]
    return np.asarray(np.concatenate(found) @ np.linalg.cholesky(second / len(counts)))


def discriminants(vectors: Real, talkers: Sequence[str], shrinkage: float) -> tuple[Real, Real]:
    """Return the centre (n,) and the directions (n, n) in which talkers differ, most for how much each varies first.

    Along each, the standard deviation within a talker is B / (B + W), the share of the variance that is between
    talkers: what is projected is the posterior mean of a talker after one recording (S. Ioffe, "Probabilistic linear
    discriminant analysis", Proc. ECCV 2006). ``vectors`` (m, n) are of ``talkers`` (m,); every talker counts alike.

    >>> rng = np.random.default_rng(0)
    >>> people = np.repeat([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], 50, axis=0)
    >>> names = np.repeat(["a", "b", "c"], 50).tolist()
    >>> _, found = discriminants(people + [0.1, 3.0] * rng.standard_normal((150, 2)), names, 0.0)
    >>> bool(abs(found[0, 0]) > 10 * abs(found[1, 0]))
    True
    >>> bool(np.linalg.norm([0.1, 3.0] * found[:, 0]) > 10 * np.linalg.norm([0.1, 3.0] * found[:, 1]))
    True
    """
    owners = np.array(talkers)
    parts = [vectors[owners == name] for name in sorted(set(talkers))]
    means = np.array([part.mean(axis=0) for part in parts])
    within = np.mean([(part - mean).T @ (part - mean) / len(part) for part, mean in zip(parts, means, strict=True)], 0)
    centre = means.mean(axis=0)
    between = (means - centre).T @ (means - centre) / len(means)
    n = len(centre)
    within = (1 - shrinkage) * within + shrinkage * np.trace(within) / n * np.eye(n)
    ratios, directions = eigh(between, within)
    ratios = np.maximum(ratios, 0)
    return centre, np.asarray((directions * (ratios / (1 + ratios)))[:, ::-1])
