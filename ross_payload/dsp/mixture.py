"""ITD histograms of several orientations as one mixture: sources that keep their azimuth while the array turns.

At heading phi_r the ITD of a source at azimuth theta_k is normal around ``s (d / v_p) cos(theta_k - phi_r)`` with a
width sigma_k of its own; s <= 1 is the directness (reflections pull ITDs towards 0). Every orientation has its own
weights, because talkers pause, and a share that nobody explains, spread evenly over all ITDs. ITDs are in units of
d / v_p here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ross_payload.interfaces import Real

TINY = 1e-12
WIDTH = (0.05, 0.25)  # narrowest and widest kernel [d / v_p]
DIRECTNESS = (0.6, 1.0)
POOL = 3.0  # counts by which the weights of one orientation are drawn to those of all


@dataclass(frozen=True, slots=True)
class Data:
    """Histograms of all orientations."""

    grid: Real  # centres of the ITD bins [d / v_p], (n_bins,)
    headings: Real  # [rad], (n_headings,)
    counts: Real  # effective counts, (n_headings, n_bins)


@dataclass(frozen=True, slots=True)
class Mixture:
    """Parameters of the model."""

    azimuths: Real  # [rad], (k,)
    widths: Real  # [d / v_p], (k,)
    weights: Real  # (n_headings, k + 1), rows sum to 1; the last column is nobody's
    directness: float = 1.0


def empty(data: Data) -> Mixture:
    """The model of no source."""
    return Mixture(np.zeros(0), np.zeros(0), np.ones((len(data.headings), 1)))


def kernels(data: Data, azimuths: Real, widths: Real, directness: float) -> Real:
    """Probability of every ITD bin for every source, (n_headings, k, n_bins); sums to nearly 1 over the bins."""
    centre = directness * np.cos(azimuths[None, :] - data.headings[:, None])
    off = (data.grid - centre[..., None]) / widths[:, None]
    step = data.grid[1] - data.grid[0]
    return np.asarray(step / np.sqrt(2 * np.pi) / widths[:, None] * np.exp(-0.5 * off**2))


def densities(data: Data, model: Mixture) -> Real:
    """Probability of every ITD bin in every orientation, (n_headings, n_bins)."""
    return np.asarray(_joint(data, model).sum(axis=1))


def log_likelihood(data: Data, model: Mixture) -> float:
    """Log-likelihood of the counts [nat]."""
    return float((data.counts * np.log(densities(data, model) + TINY)).sum())


def refine(data: Data, model: Mixture, rounds: int) -> Mixture:
    """Expectation maximisation from ``model``."""
    for _ in range(rounds):
        model = _step(data, model)
    return model


def add(model: Mixture, azimuth: float, width: float, share: Real) -> Mixture:
    """The model with one source more, which takes ``share`` (n_headings,) of every orientation."""
    weights = np.insert(model.weights * (1 - share[:, None]), -1, share, axis=1)
    return replace(
        model, azimuths=np.append(model.azimuths, azimuth), widths=np.append(model.widths, width), weights=weights
    )


def remove(model: Mixture, source: int) -> Mixture:
    """The model without one source; the others share its weights in proportion."""
    weights = np.delete(model.weights, source, axis=1)
    weights = weights + 1e-3
    return replace(
        model,
        azimuths=np.delete(model.azimuths, source),
        widths=np.delete(model.widths, source),
        weights=weights / weights.sum(axis=1, keepdims=True),
    )


def gains(data: Data, model: Mixture, azimuths: Real, width: float, rounds: int = 4) -> tuple[Real, Real]:
    """Gain of log-likelihood [nat] by a source at each azimuth, (n,), and its best shares, (n_headings, n).

    All else stays; the share is found by expectation maximisation in every orientation.
    """
    old = densities(data, model)[:, None] + TINY
    excess = kernels(data, azimuths, np.full(len(azimuths), width), model.directness) / old - 1
    total = data.counts.sum(axis=1)[:, None] + TINY
    share = np.full(excess.shape[:2], 0.1)
    for _ in range(rounds):
        quotient = excess / (1 + share[..., None] * excess)
        share = share * (1 + (1 - share) * np.einsum("rb,rgb->rg", data.counts, quotient) / total)
    gain = np.einsum("rb,rgb->g", data.counts, np.log1p(share[..., None] * excess))
    return np.asarray(gain), share


def sigmas(data: Data, model: Mixture) -> Real:
    """One standard deviation of every azimuth [rad], from the expected information, (k,)."""
    counts, slope = _claimed(data, model).sum(axis=-1)[:, :-1], _slope(data, model)
    information = (counts * slope**2).sum(axis=0) / model.widths**2
    return np.asarray(1 / np.sqrt(information + TINY))


def _step(data: Data, model: Mixture) -> Mixture:
    claimed = _claimed(data, model)
    counts = claimed.sum(axis=-1)
    sources, mean = counts[:, :-1], (claimed * data.grid).sum(axis=-1)[:, :-1]
    square = (claimed * data.grid**2).sum(axis=-1)[:, :-1]
    centre, slope = _centre(data, model), _slope(data, model)
    curvature = (sources * slope**2).sum(axis=0) + 0.02 * sources.sum(axis=0) + TINY
    turn = ((mean - sources * centre) * slope).sum(axis=0) / curvature
    azimuths = model.azimuths + np.clip(turn, -0.2, 0.2)
    spread = (square - 2 * mean * centre + sources * centre**2).sum(axis=0)
    variance = (spread + 2.0 * 0.1**2) / (sources.sum(axis=0) + 2.0)
    unit = centre / model.directness
    directness = (20.0 + (mean * unit).sum()) / (20.0 + (sources * unit**2).sum())
    pooled = counts.sum(axis=0) / (counts.sum() + TINY)
    weights = (counts + POOL * pooled + TINY) / (counts.sum(axis=1, keepdims=True) + POOL * pooled.sum() + TINY)
    weights = weights / weights.sum(axis=1, keepdims=True)
    return Mixture(azimuths, np.clip(np.sqrt(variance), *WIDTH), weights, float(np.clip(directness, *DIRECTNESS)))


def _centre(data: Data, model: Mixture) -> Real:
    return np.asarray(model.directness * np.cos(model.azimuths[None] - data.headings[:, None]))


def _slope(data: Data, model: Mixture) -> Real:
    return np.asarray(-model.directness * np.sin(model.azimuths[None] - data.headings[:, None]))


def _joint(data: Data, model: Mixture) -> Real:
    """Weight times probability, (n_headings, k + 1, n_bins)."""
    named = kernels(data, model.azimuths, model.widths, model.directness)
    nobody = np.full((len(data.headings), 1, len(data.grid)), 1 / len(data.grid))
    return np.concatenate([named, nobody], axis=1) * model.weights[..., None]


def _claimed(data: Data, model: Mixture) -> Real:
    """Counts that every source claims of every bin, (n_headings, k + 1, n_bins)."""
    joint = _joint(data, model)
    return np.asarray(data.counts[:, None] * joint / (joint.sum(axis=1, keepdims=True) + TINY))
