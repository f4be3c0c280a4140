"""How many sources: a mixture grows while the likelihood gains, then loses what is worth no more than a ghost.

The worth of a source is the log-likelihood lost without it, once the others have adapted. A ghost lives on the misfit
of the model, which grows with the evidence, so the price of a source has a constant part and a share of the evidence.
Bins that two near talkers share have ITDs in between: a source between two near others costs more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ross_payload.angles import difference
from ross_payload.dsp import mixture
from ross_payload.dsp.mixture import Data, Mixture
from ross_payload.interfaces import Real

MAX_SOURCES = 6
HOPEFUL = 0.3  # a gain below this share of the price is not tried: kernels adapt, so gains grow
SPARE = 2  # sources tried beyond the largest K
GRID = np.deg2rad(np.arange(-180.0, 180.0, 5.0))  # azimuths tried [rad]


@dataclass(frozen=True, slots=True)
class Price:
    """What a source must be worth."""

    base: float = 5.0  # [nat]
    share: float = 0.015  # [nat] per count of evidence
    width: float = 0.1  # kernel of a new source [d / v_p]
    apart: float = np.deg2rad(15.0)  # nearer than this [rad] two sources are one
    near: float = np.deg2rad(35.0)  # between two sources both nearer than this [rad] ...
    between: float = 2.5  # ... a source costs so many times as much,
    wide: float = 0.15  # and more, by the square, when its kernel is wider than this [d / v_p]: nobody talks there

    def of(self, data: Data) -> float:
        """Log-likelihood [nat] that a source must be worth."""
        return float(self.base + self.share * data.counts.sum())

    def factors(self, azimuths: Real, widths: Real) -> Real:
        """How many times the price each source costs, (k,).

        >>> Price().factors(np.deg2rad([0.0, 25.0, 50.0, 150.0]), np.array([0.1, 0.1, 0.1, 0.3])).tolist()
        [1.0, 2.5, 1.0, 1.0]
        """
        off = difference(azimuths[:, None], azimuths)
        ahead, behind = (off < 0) & (off > -self.near), (off > 0) & (off < self.near)
        dearer = self.between * np.maximum(widths / self.wide, 1) ** 2
        return np.where(ahead.any(axis=1) & behind.any(axis=1), dearer, 1.0)


@dataclass(frozen=True, slots=True)
class Fit:
    """The mixture of the chosen order, and by how much it was chosen."""

    model: Mixture
    worth: Real  # of every source over its price, (k,)
    rival: float  # worth over price of the last source that was turned down


def search(data: Data, price: Price) -> Fit:
    """Fit mixtures of falling order until every source is worth its price."""
    model, rival = _grow(data, price)
    while True:
        worth, reduced = worths(data, model)
        worth = worth / (price.of(data) * price.factors(model.azimuths, model.widths))
        least = _least(model, worth, price)
        if least is None or (least.paid and worth[least.source] >= 1):
            return Fit(model, worth, rival)
        rival = float(worth[least.source]) if least.paid else rival
        model = mixture.refine(data, reduced[least.source], 10)


def worths(data: Data, model: Mixture) -> tuple[Real, list[Mixture]]:
    """Worth of every source [nat], (k,), and the models without it."""
    reduced = [mixture.refine(data, mixture.remove(model, k), 5) for k in range(len(model.azimuths))]
    full = mixture.log_likelihood(data, model)
    return np.array([full - mixture.log_likelihood(data, other) for other in reduced]), reduced


def profile(data: Data, model: Mixture, source: int) -> Real:
    """Gain of log-likelihood [nat] with one source put at every azimuth of the grid instead, (n_grid,)."""
    width = float(model.widths[source])
    gain, _ = mixture.gains(data, mixture.remove(model, source), GRID, width)
    return gain


@dataclass(frozen=True, slots=True)
class _Least:
    source: int
    paid: bool  # False: goes in any case


def _grow(data: Data, price: Price) -> tuple[Mixture, float]:
    """Add sources where the likelihood gains most; also the last gain over the price."""
    model, rival = mixture.empty(data), 0.0
    for _ in range(MAX_SOURCES + SPARE):
        gain, share = mixture.gains(data, model, GRID, price.width)
        best = int(gain.argmax())
        rival = float(gain[best]) / price.of(data)
        if rival < HOPEFUL:
            break
        added = mixture.add(model, float(GRID[best]), price.width, np.maximum(share[:, best], 0.01))
        model = mixture.refine(data, added, 8)
    return mixture.refine(data, model, 20), rival


def _least(model: Mixture, worth: Real, price: Price) -> _Least | None:
    """The source to take away first: one of two that are too near, else the one worth least."""
    k = len(worth)
    if not k:
        return None
    apart = np.abs(difference(model.azimuths[:, None], model.azimuths)) + 2 * np.pi * np.eye(k)
    if apart.min() < price.apart:
        pair = np.unravel_index(int(apart.argmin()), apart.shape)
        return _Least(int(min(pair, key=lambda source: worth[source])), paid=False)
    return _Least(int(worth.argmin()), paid=k <= MAX_SOURCES)
