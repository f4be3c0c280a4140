"""How much separation gains at a heading, from geometry alone.

The local Gaussian model knows every TDOA. It hears each interferer ``k`` the less, the further its TDOA is from the
target's: a share ``exp(-|tau_i - tau_k| / s)`` of its power leaks into the target, with ``s`` a part of ``d / v_p``.
Echoes come from everywhere, so a share ``r`` leaks whatever the heading. Two interferers on either side of the target
can sound like somebody between them, so a share ``m`` more leaks from them. With K - 1 interferers of equal power

    gain_i = -10 log10(r + m + mean_k exp(-|tau_i - tau_k| / s)) + b  dB.

``b`` is for two groups before two microphones, where everything can be nulled: all interferers pose as one, in the
open. In reverberation they gain nothing by posing. ``python -m ross_sim.study.predicted_gain_study`` fits the
constants.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ross_payload.interfaces import Complex, Real

OPEN = 0.99  # directness of the open at least: explorers say 1 there, and up to 0.985 in reverberation
REACH = (0.14, 0.25)  # s [d / v_p] in the open and in reverberation
ECHOES = (0.023, 0.06)  # r in the open and in reverberation
BETWEEN = (0.036, 0.018)  # m in the open and in reverberation
DETERMINED = (1.1, 0.0)  # b [dB] in the open and in reverberation, when all interferers have one TDOA
POSING = 0.3  # b is 0 when theirs spread over this part of d / v_p
FINE = np.pi / 360  # [rad], half a degree: no heading is 0.05 dB better than the best of this grid


def phasors(azimuths: ArrayLike, elevations: ArrayLike | None = None) -> Complex:
    """Every source as z = cos(eps) exp(j theta), (n_sources,): heard at phi its TDOA is Re(z exp(-j phi)) d / v_p."""
    cosine = 1.0 if elevations is None else np.cos(np.asarray(elevations, dtype=float))
    return np.asarray(cosine * np.exp(1j * np.asarray(azimuths, dtype=float)))


def distances(z: Complex, headings: ArrayLike) -> Real:
    """Distances |tau_i - tau_k| [d / v_p] between all sources at headings [rad], (n_sources, n_sources, n_headings)."""
    tau = (z[:, None] * np.exp(-1j * np.asarray(headings, dtype=float))).real
    return np.asarray(np.abs(tau[:, None] - tau[None]))


def predicted_gain(
    azimuths: ArrayLike, headings: ArrayLike, elevations: ArrayLike | None = None, directness: float | None = None
) -> Real:
    """Predict the SI-SDRi [dB] of every source as the target at every heading.

    Parameters
    ----------
    azimuths, elevations
        Where the sources are [rad], (n_sources,); elevations are 0 when not given.
    headings
        Headings of the array [rad], (n_headings,).
    directness
        1 in the open, less in reverberation, which is assumed when it is not known.

    Returns
    -------
    ndarray
        (n_sources, n_headings); 0 for a single source, which has no interferer to lose.

    Examples
    --------
    A talker on either side of the axis: along it they are one source, across it they are 2 d / v_p apart.

    >>> predicted_gain([np.pi / 2, -np.pi / 2], [0.0, np.pi / 2]).round(1).tolist()
    [[-0.3, 12.2], [-0.3, 12.2]]
    """
    return gain_of(phasors(azimuths, elevations), headings, directness)


def gain_of(
    z: Complex, headings: ArrayLike, directness: float | None = None, beside: Complex | None = None, share: float = 0.0
) -> Real:
    """Predict the SI-SDRi [dB] of sources that are given as phasors, (n_sources, n_headings).

    Noise sources ``beside`` them, (n,), are no targets, but leak as interferers do; ``share`` is their power
    together over that of all interferers of a target. A single source has only these to lose.
    """
    tau = (z[:, None] * np.exp(-1j * np.asarray(headings, dtype=float))).real
    noise = 0.0
    if beside is not None and len(beside) and share > 0:
        at = (beside[:, None] * np.exp(-1j * np.asarray(headings, dtype=float))).real
        wide = REACH[directness is None or directness < OPEN]
        noise = share * np.exp(-np.abs(at[None] - tau[:, None]) / wide).mean(axis=1)
    if len(z) < 2:
        return np.zeros_like(tau) if np.isscalar(noise) else -10 * np.log10(ECHOES[0] + noise)
    wet = directness is None or directness < OPEN
    reach, echoes, phantom, bonus = (pair[wet] for pair in (REACH, ECHOES, BETWEEN, DETERMINED))
    ahead = _others(tau) - tau[:, None]
    leak = np.exp(-np.abs(ahead) / reach).mean(axis=1)
    between = (ahead.min(axis=1) < 0) & (ahead.max(axis=1) > 0)
    posing = np.maximum(1 - np.ptp(ahead, axis=1) / POSING, 0)
    return np.asarray(-10 * np.log10(echoes + phantom * between + leak + noise) + bonus * posing)


def _others(tau: Real) -> Real:
    """TDOAs of the interferers of every target, (n_sources, n_sources - 1, n_headings)."""
    n = len(tau)
    return tau[[[k for k in range(n) if k != i] for i in range(n)]]


def best_headings(azimuths: ArrayLike, elevations: ArrayLike | None = None, directness: float | None = None) -> Real:
    """Heading in [0, pi) [rad] with the best predicted gain for every source, (n_sources,), on a grid of 0.5 deg.

    >>> np.rad2deg(best_headings(np.deg2rad([30, -30]))).round().tolist()
    [90.0, 90.0]
    """
    grid = np.arange(0, np.pi - FINE / 2, FINE)
    return np.asarray(grid[predicted_gain(azimuths, grid, elevations, directness).argmax(axis=1)])
