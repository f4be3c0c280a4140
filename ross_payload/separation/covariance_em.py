"""Spatial covariances estimated once more, by expectation maximisation with PSDs that are better known by now.

The full-rank model of Duong, Vincent and Gribonval (2010). Their M step averages what is expected of x_k x_k^H / v_k
over all frames, x_k being the image of source k; here every frame counts by how much of it is the source's.
"""

from __future__ import annotations

import numpy as np

from ross_payload.dsp.covariance import adjugate, determinant
from ross_payload.interfaces import Real
from ross_payload.separation.cacgmm import AT_ONCE

ROUNDS = 3
SINGULAR = 1e-6  # of the squared trace: a determinant in single precision is not known better


def reestimated(observed: Real, covariances: Real, psds: Real) -> Real:
    """Covariances after some rounds, the noise last as it was, trace 2, (n_freqs, n_groups + 1, 4).

    What is expected of x_k x_k^H / v_k is R + v R M R with M = S^-1 x x^H S^-1 - S^-1 and S = sum_k v_k R_k. For two
    microphones M = ((t - 1) adj(S) - adj(x x^H)) / det(S) with t = tr(adj(S) x x^H) / det(S), and with the weighted
    mean G of v M R G R = tr(R G) R - det(R) adj(G) (Cayley-Hamilton): sums over frames are matrix products. A frame
    counts by (v_k / sum_j v_j)^4 v_k^(1/4).

    Parameters
    ----------
    observed
        Coordinates of x x^H, (n_freqs, 4, n_frames).
    covariances
        To begin with, the noise last, (n_freqs, n_groups + 1, 4).
    psds
        Of the groups and the noise, (n_freqs, n_groups + 1, n_frames).
    """
    made, height = covariances.copy(), max(AT_ONCE // max(psds.shape[2], 1), 1)
    for low in range(0, len(made), height):
        rows = slice(low, low + height)
        made[rows, :-1] = _rounds(observed[rows], covariances[rows], psds[rows])
    return made


def _rounds(observed: Real, covariances: Real, psds: Real) -> Real:
    """Covariances of the groups of some rows after `ROUNDS`, (n_rows, n_groups, 4)."""
    sources, noise = covariances[:, :-1], np.swapaxes(covariances[:, -1:], 1, 2) * psds[:, -1:]
    own, every, shown = _weighted(psds), psds[:, :-1], np.swapaxes(observed, 1, 2)
    for _ in range(ROUNDS):
        total = np.swapaxes(sources, 1, 2) @ every + noise
        inner = np.maximum(determinant(np.swapaxes(total, 1, 2)), SINGULAR * (total[:, 0] + total[:, 1]) ** 2)
        inner = np.maximum(inner, np.finfo(psds.dtype).tiny)
        fit = (adjugate(total, axis=1) * observed).sum(axis=1) / inner
        share = own / inner[:, None]
        opposite = (share * (fit - 1)[:, None]) @ np.swapaxes(total, 1, 2) - share @ shown  # adj(G)
        along = (sources * adjugate(opposite)).sum(axis=-1, keepdims=True)
        sources = _of_trace_2((1 + along) * sources - determinant(sources)[..., None] * opposite, sources)
    return sources


def _weighted(psds: Real) -> Real:
    """v_k of the groups times the weights of the frames, which sum to 1, (n_rows, n_groups, n_frames)."""
    own = psds[:, :-1]
    weights = own / psds.sum(axis=1, keepdims=True)
    weights *= weights
    weights *= weights
    weights *= np.sqrt(np.sqrt(own))
    weights /= np.maximum(weights.sum(axis=2, keepdims=True), np.finfo(psds.dtype).tiny)
    weights *= own
    return np.asarray(weights)


def _of_trace_2(matrices: Real, otherwise: Real) -> Real:
    """Scale covariances; those that no frame tells anything of stay as they were."""
    trace = matrices[..., :1] + matrices[..., 1:2]
    known = (trace > 0) & np.isfinite(trace) & (determinant(matrices) > 0)[..., None]
    return np.asarray(np.where(known, 2 * matrices / np.where(known, trace, 1), otherwise))
