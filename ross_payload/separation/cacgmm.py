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
EVERY = 2  # frames: neighbours overlap


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
    heard = observed[:, :, ::EVERY]
    power = heard[:, 0] + heard[:, 1]
    weight = power / (2 * STRONG * noise_psd[:, None])
    weight = np.where(weight > WEAK, np.minimum(weight, 1), 0).astype(observed.dtype)
    unit = heard / np.maximum(power, np.finfo(observed.dtype).tiny)[:, None]
    blocks = [slice(low, low + BLOCK) for low in range(0, len(start), BLOCK)]
    weights = np.stack([weight[block].sum(axis=0) for block in blocks])[:, None]
    shares = np.full((len(blocks), start.shape[1], weight.shape[1]), 1 / start.shape[1], observed.dtype)
    flipped, learnt = adjugate(unit, axis=1), (start if before is None else before).copy()
    if before is not None:
        shares = _settled(flipped, weight, learnt, weights)
    for reach in REACH if before is None else AGAIN:
        sums = np.empty_like(shares)
        for index, block in enumerate(blocks):
            counts, inverse = _posteriors(flipped[block], weight[block], learnt[block], shares[index])
            sums[index] = counts.sum(axis=0)
            moments = _moments(unit[block], counts * inverse, learnt[block])
            drawn = anchor
            if prior_count:
                heard_in = counts.sum(axis=2, keepdims=True)
                drawn = 1 - (1 - anchor) * heard_in / (heard_in + prior_count)
            learnt[block] = (1 - drawn) * moments + drawn * start[block]
        shares = _normed(sums, weights, reach)
    per_bin = np.repeat(np.arange(len(blocks)), BLOCK)[: len(start)]
    per_frame = np.repeat(np.arange(shares.shape[2]), EVERY)[: observed.shape[2]]
    return learnt, shares[per_bin][..., per_frame]


def _settled(flipped: Real, weight: Real, matrices: Real, weights: Real) -> Real:
    """Shares of known covariances, (n_blocks, n_groups, n_frames)."""
    cross = np.maximum(matrices @ flipped, 1e-5)
    likely = determinant(matrices)[..., None] / cross**2
    shares = np.full((len(weights), *likely.shape[1:]), 1 / likely.shape[1], likely.dtype)
    whole = len(likely) // BLOCK  # blocks of full length: done all at once
    parts = [(slice(0, whole), slice(0, whole * BLOCK), BLOCK)] * (whole > 0)
    parts += [(slice(whole, whole + 1), slice(whole * BLOCK, len(likely)), len(likely) - whole * BLOCK)] * (
        len(likely) % BLOCK > 0
    )
    for reach in SETTLE:
        sums = np.empty_like(shares)
        for blocks, bins, length in parts:
            given = shares[blocks, None] * likely[bins].reshape(-1, length, *likely.shape[1:])
            given *= weight[bins].reshape(-1, length, 1, weight.shape[1]) / given.sum(axis=2, keepdims=True)
            sums[blocks] = given.sum(axis=1)
        shares = _normed(sums, weights, reach)
    return shares


def _normed(sums: Real, weights: Real, reach: int | None) -> Real:
    """Shares from responsibilities and weights summed over every block, tied, (n_blocks, n_groups, n_frames)."""
    return np.asarray((_tied(sums, reach) + PRIOR_COUNT) / (_tied(weights, reach) + PRIOR_COUNT * sums.shape[1]))


def _posteriors(flipped: Real, weight: Real, matrices: Real, shares: Real) -> tuple[Real, Real]:
    """E step of a block of bins: responsibilities and 1 / (z^H R_k^-1 z), both (n, n_groups, n_frames)."""
    cross = np.maximum(matrices @ flipped, 1e-5)
    inverse = determinant(matrices)[..., None] / cross
    given = shares * inverse / cross
    given *= (weight / given.sum(axis=1))[:, None]
    return given, inverse


def _moments(unit: Real, given: Real, matrices: Real) -> Real:
    """M step of a block of bins: covariances of trace 2, (n, n_groups, 4); those before where nothing is heard."""
    moments = given @ np.swapaxes(unit, 1, 2)
    trace = moments[..., :1] + moments[..., 1:2]
    return np.asarray(np.where(trace > 1e-9, 2 * moments / np.maximum(trace, 1e-9), matrices))


def _tied(sums: Real, reach: int | None) -> Real:
    """Sum of every block and those within ``reach`` of it, (n_blocks, ...)."""
    if reach is None:
        return np.broadcast_to(sums.sum(axis=0), sums.shape)
    low = np.maximum(np.arange(len(sums)) - reach, 0)
    return np.stack([sums[first : index + reach + 1].sum(axis=0) for index, first in enumerate(low)])
