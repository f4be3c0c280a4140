"""Spatial covariances learnt from a recording: complex angular-central Gaussian mixture from a geometric start.

Every strong bin is given to the group whose covariance its direction x / |x| fits best; the share of each group in a
frame is tied over neighbouring frequencies, which keeps the groups apart from bin to bin (Ito, Araki, Nakatani 2016).
"""

from __future__ import annotations

import numpy as np

from ross_payload.dsp.covariance import adjugate, determinant
from ross_payload.interfaces import Real

BLOCK = 32  # bins whose shares are tied together
REACH = (None,) * 6 + (4,) * 6 + (2,) * 6 + (1,) * 10  # per iteration: blocks on either side tied too; None: all
SETTLE = (None, 4, 2, 1, 1)  # the same for the shares alone, where covariances are known from before
AGAIN = (1,)  # and then for both
STRONG = 16.0  # bins this many times above the noise count in full
WEAK = 0.3  # bins below this part of that do not count
PRIOR_COUNT = 0.3  # bins added to every group's share of a block
TINY = np.float32(1e-30)
EVERY = 2  # frames: neighbours overlap
AT_ONCE = 80000  # time-frequency bins worked on together: they stay in the cache


def learn(
    observed: Real, start: Real, noise_psd: Real, anchor: float, *, before: Real | None = None, prior_count: float = 0.0
) -> tuple[Real, Real]:
    """Covariances of the groups, trace 2, (n_freqs, n_groups, 4), and their shares, (n_freqs, n_groups, n_frames).

    The share of a group is how probable it is in a frame, whatever bin of a block it is looked for in.

    E step: gamma_k ~ pi_k det(R_k) / tr(R_k adj(z z^H))^2. M step: R_k ~ sum gamma_k z z^H / (z^H R_k^-1 z), drawn
    towards the start by ``anchor``.

    Parameters
    ----------
    observed
        Coordinates of x x^H, (n_freqs, 4, n_frames).
    start
        Covariances to begin with, trace 2, (n_freqs, n_groups, 4).
    noise_psd
        (n_freqs,).
    anchor
        Weight of the start in every iteration, in [0, 1].
    before
        What was learnt from a recording much like this one, (n_freqs, n_groups, 4): few iterations from there are
        enough. None: from the start on.
    prior_count
        Bins that the start counts for beside those that a group is heard in: a short recording changes little.
    """
    heard, noise, start = (_whole_blocks(each) for each in (observed[:, :, ::EVERY], noise_psd, start))
    power = heard[:, 0] + heard[:, 1]
    weight = power / (2 * STRONG * noise[:, None])
    weight = np.where(weight > WEAK, np.minimum(weight, 1), 0).astype(observed.dtype)
    weight[len(observed) :] = 0
    unit = heard / np.maximum(power, np.finfo(observed.dtype).tiny)[:, None]
    weights = weight.reshape(-1, BLOCK, weight.shape[1]).sum(axis=1)[:, None]
    shares = np.full((len(weights), start.shape[1], weight.shape[1]), 1 / start.shape[1], observed.dtype)
    flipped, learnt = adjugate(unit, axis=1), (start if before is None else _whole_blocks(before)).copy()
    if before is not None:
        shares = _settled(flipped, weight, learnt, weights)
    at_once = max(AT_ONCE // (BLOCK * max(weight.shape[1], 1)), 1)
    for reach in REACH if before is None else AGAIN:
        sums = np.empty_like(shares)
        for low in range(0, len(weights), at_once):
            blocks, bins = slice(low, low + at_once), slice(low * BLOCK, (low + at_once) * BLOCK)
            counts, inverse = _posteriors(flipped[bins], weight[bins], learnt[bins], shares[blocks])
            sums[blocks] = counts.reshape(-1, BLOCK, *counts.shape[1:]).sum(axis=1)
            drawn = anchor
            if prior_count:
                heard_in = counts.sum(axis=2, keepdims=True)
                drawn = 1 - (1 - anchor) * heard_in / (heard_in + prior_count)
            inverse *= counts
            learnt[bins] = (1 - drawn) * _moments(unit[bins], inverse, learnt[bins]) + drawn * start[bins]
        shares = _normed(sums, weights, reach)
    per_bin = np.repeat(np.arange(len(weights)), BLOCK)[: len(observed)]
    per_frame = np.repeat(np.arange(shares.shape[2]), EVERY)[: observed.shape[2]]
    return learnt[: len(observed)], shares[per_bin][..., per_frame]


def _whole_blocks(values: Real) -> Real:
    """Repeat the last bin until blocks of bins, the first axis, are whole."""
    return np.concatenate([values, np.repeat(values[-1:], -len(values) % BLOCK, axis=0)])


def _settled(flipped: Real, weight: Real, matrices: Real, weights: Real) -> Real:
    """Shares of known covariances, (n_blocks, n_groups, n_frames)."""
    cross = np.maximum(matrices @ flipped, 1e-5)
    likely = determinant(matrices)[..., None] / cross**2
    shares = np.full((len(weights), *likely.shape[1:]), 1 / likely.shape[1], likely.dtype)
    likely = likely.reshape(-1, BLOCK, *likely.shape[1:])
    for reach in SETTLE:
        given = shares[:, None] * likely
        given *= weight.reshape(-1, BLOCK, 1, weight.shape[1]) / _not_0(given.sum(axis=2, keepdims=True))
        shares = _normed(given.sum(axis=1), weights, reach)
    return shares


def _normed(sums: Real, weights: Real, reach: int | None) -> Real:
    """Shares from responsibilities and weights summed over every block, tied, (n_blocks, n_groups, n_frames)."""
    return np.asarray((_tied(sums, reach) + PRIOR_COUNT) / (_tied(weights, reach) + PRIOR_COUNT * sums.shape[1]))


def _posteriors(flipped: Real, weight: Real, matrices: Real, shares: Real) -> tuple[Real, Real]:
    """E step of whole blocks of bins: responsibilities and 1 / (z^H R_k^-1 z), both (n, n_groups, n_frames)."""
    cross = matrices @ flipped
    np.maximum(cross, 1e-5, out=cross)
    inverse = determinant(matrices)[..., None] / cross
    given = (shares[:, None] * inverse.reshape(-1, BLOCK, *inverse.shape[1:])).reshape(inverse.shape)
    given /= cross
    given *= (weight / _not_0(given.sum(axis=1)))[:, None]
    return given, inverse


def _not_0(total: Real) -> Real:
    """Sums to divide by; where every group is as coherent as can be they are 0, and the bin is nobody's."""
    total[np.abs(total) < TINY] = TINY
    return total


def _moments(unit: Real, given: Real, matrices: Real) -> Real:
    """M step of some bins: covariances of trace 2, (n, n_groups, 4); those before where nothing is heard."""
    moments = given @ np.swapaxes(unit, 1, 2)
    trace = moments[..., :1] + moments[..., 1:2]
    return np.asarray(np.where(trace > 1e-9, 2 * moments / np.maximum(trace, 1e-9), matrices))


def _tied(sums: Real, reach: int | None) -> Real:
    """Sum of every block and those within ``reach`` of it, (n_blocks, ...)."""
    if reach is None:
        return np.broadcast_to(sums.sum(axis=0), sums.shape)
    low = np.maximum(np.arange(len(sums)) - reach, 0)
    return np.stack([sums[first : index + reach + 1].sum(axis=0) for index, first in enumerate(low)])
