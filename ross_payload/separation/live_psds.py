"""Posteriors and PSDs of the local Gaussian model for the few frames that are under way.

Frequencies lie along the last axis, contiguous: arrays are (n_groups, n_freqs) and the like, a few frames stacked
before them. The formulas are those of `ross_payload.separation.local_gaussian_model.source_psds` and
`ross_payload.separation.cacgmm.learn`.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from ross_payload.dsp.covariance import ROOT2
from ross_payload.interfaces import Complex, Real
from ross_payload.separation.cacgmm import BLOCK, PRIOR_COUNT, STRONG, WEAK

REACH = (None, 4, 2, 1, 1)  # per iteration within a frame: blocks on either side whose shares are tied; None: all
SINGULAR = np.float32(1e-6)  # of the product of the powers: what rounding leaves of a determinant that is 0
SIGNS = np.array([1, 1, -1, -1], np.float32)[:, None]


def outer(frame: Complex) -> Real:
    """Coordinates of x x^H of a frame (2, n_freqs), (4, n_freqs)."""
    first, second = frame
    cross = np.float32(ROOT2) * first * second.conj()
    power = frame.real**2 + frame.imag**2
    return np.stack([power[0], power[1], cross.real, cross.imag])


def adjugate(matrices: Real) -> Real:
    """Coordinates of the adjugate of matrices (..., 4, n_freqs)."""
    return np.asarray(matrices[..., [1, 0, 2, 3], :] * SIGNS)


def determinant(matrices: Real) -> Real:
    """Determinant of matrices (..., 4, n_freqs)."""
    first, second, real, imag = np.moveaxis(matrices, -2, 0)
    return np.asarray(first * second - 0.5 * (real**2 + imag**2))


def shares_of(observed: Real, sources: Real, noise_psd: Real) -> Real:
    """How probable every group is in a frame, in every bin what its block says, (n_groups, n_freqs).

    Parameters
    ----------
    observed
        Coordinates of x x^H, (4, n_freqs).
    sources
        Coordinates of the covariances, trace 2, (n_groups, 4, n_freqs).
    noise_psd
        (n_freqs,).
    """
    n_groups, _, n_freqs = sources.shape
    power = observed[0] + observed[1]
    weight = power / (2 * STRONG * noise_psd)
    weight = np.where(weight > WEAK, np.minimum(weight, 1), 0).astype(np.float32)
    unit = adjugate(observed / np.maximum(power, np.finfo(np.float32).tiny))
    cross = np.maximum((sources * unit).sum(axis=1), 1e-5)
    likely = np.maximum(determinant(sources), 1e-9) / cross**2
    starts = np.arange(0, n_freqs, BLOCK)
    heard = np.add.reduceat(weight, starts)
    shares = np.full((n_groups, starts.size), 1 / n_groups, np.float32)
    widths = np.diff(starts, append=n_freqs)
    for reach in REACH:
        given = np.repeat(shares, widths, axis=1) * likely
        given *= weight / given.sum(axis=0)
        sums = np.add.reduceat(given, starts, axis=1)
        shares = (_tied(sums, reach) + PRIOR_COUNT) / (_tied(heard, reach) + PRIOR_COUNT * n_groups)
    return np.repeat(shares, widths, axis=1)


def _tied(sums: Real, reach: int | None) -> Real:
    """Sum of every block and those within ``reach`` of it, along the last axis."""
    if reach is None:
        return np.broadcast_to(sums.sum(axis=-1, keepdims=True), sums.shape)
    first, end = _reached(sums.shape[-1], reach)
    total = np.zeros((*sums.shape[:-1], sums.shape[-1] + 1), sums.dtype)
    np.cumsum(sums, axis=-1, out=total[..., 1:])
    return np.asarray(total.take(end, axis=-1) - total.take(first, axis=-1))


@cache
def _reached(n: int, reach: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Of every one of ``n`` blocks the first within ``reach`` of it, and behind the last."""
    index = np.arange(n)
    return np.maximum(index - reach, 0), np.minimum(index + reach + 1, n)


def averaged(values: Real) -> Real:
    """Average over three neighbouring frequencies, the last axis; edges are repeated."""
    result = values.copy()
    result[..., 1:] += values[..., :-1]
    result[..., :-1] += values[..., 1:]
    result[..., 0] += values[..., 0]
    result[..., -1] += values[..., -1]
    result *= np.float32(1 / 3)
    return result


def updated(psds: Real, cross: Real, gram: Real) -> Real:
    """One multiplicative update of the sources alone, (n_frames, n_groups, n_freqs).

    Parameters
    ----------
    psds
        The noise last, (n_frames, n_groups + 1, n_freqs).
    cross
        tr(R_k adj(x x^H)), of the same shape.
    gram
        tr(R_k adj(R_j)), (n_groups + 1, n_groups + 1, n_freqs).
    """
    mixed = np.einsum("kjf,tjf->tkf", gram, psds)
    total = 2 * (psds * cross).sum(axis=1) / (psds * mixed).sum(axis=1)
    ratio = np.asarray(total[:, None] - cross[:, :-1] / mixed[:, :-1])
    np.maximum(ratio, 0, out=ratio)
    ratio *= psds[:, :-1]
    return ratio


def wiener(frame: Complex, psds: Real, covariances: Real) -> Complex:
    """Multichannel Wiener output v_k e_1^T R_k S^-1 x of every group at microphone 1, (n_groups, n_freqs).

    Parameters
    ----------
    frame
        (2, n_freqs).
    psds, covariances
        The noise last, (n_groups + 1, n_freqs) and (n_groups + 1, 4, n_freqs).
    """
    total = (covariances * psds[:, None]).sum(axis=0)
    inverse = adjugate(total) / np.maximum(determinant(total), SINGULAR * total[0] * total[1])
    cross = (inverse[2] + 1j * inverse[3]) / np.float32(ROOT2)
    first, second = frame
    white = inverse[0] * first + cross * second, cross.conj() * first + inverse[1] * second
    sources = covariances[:-1]
    across = (sources[:, 2] + 1j * sources[:, 3]) / np.float32(ROOT2)
    return np.asarray(psds[:-1] * (sources[:, 0] * white[0] + across * white[1]))
