"""How many sources: a mixture grows while the likelihood gains, then loses what is worth no more than a misfit.

The worth of a source is the log-likelihood lost without it, once the others have adapted. A spurious source results
from the misfit of the model, which grows with the evidence, so the penalty of a source has a constant part and a share
of the evidence. In a reverberant room, recognised by ITDs that are both drawn to 0 and spread, the evidence is less
sharp, and true and spurious sources alike are worth a smaller share of it. Bins that two near talkers share have ITDs
in between: a source between two near others costs more.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ross_payload.angles import difference
from ross_payload.interfaces import Real
from ross_payload.localization import itd_mixture
from ross_payload.localization.itd_mixture import Data, Mixture

MAX_SOURCES = 6
HOPEFUL = 0.1  # a gain below this share of the penalty is not tried: kernels adapt, so gains grow
SPARE = 2  # sources tried beyond the largest K
GRID = np.deg2rad(np.arange(-180.0, 180.0, 5.0))  # azimuths tried [rad]
REACH = (1.0, 0.75, 0.5)  # amplitudes tried, as a share of the directness
STEEP = (1.0, 0.75, 0.5, 0.3, 0.15)  # the same below a vehicle, as a share of the greatest amplitude there can be
ASIDE = np.deg2rad(14.0)  # half of the angle between the two that one source is split into [rad]
MOVED = np.deg2rad(20.0)  # a source that is moved goes further than this [rad]
MERGED = np.deg2rad(10.0)  # a new source that comes nearer than this [rad] to another explains nothing of its own ...
MERGERS = 5  # ... and with so many the search ends
BEGUN = 0.9  # amplitude with which a mixture begins at known azimuths
TIED = (
    1e-3  # [nat]; gains that differ by less are equal: one heading does not tell 60 degrees aside from 60 degrees below
)
BETTER = 0.5  # [nat] by which another arrangement must be better


@dataclass(frozen=True, slots=True)
class Penalty:
    """What a source must be worth."""

    base: float = 1.0  # [nat]
    dry: float = 0.0095  # [nat] per count of evidence
    wet: float = 0.005  # the same in a reverberant room
    width: float = 0.1  # kernel of a new source [d / v_p]
    apart: float = np.deg2rad(15.0)  # nearer than this [rad] two sources are one
    near: float = np.deg2rad(35.0)  # between two sources both nearer than this [rad] ...
    between: float = 2.5  # ... a source costs so many times as much,
    wide: float = 0.15  # and more, by the square, when its kernel is wider than this [d / v_p]: nobody talks there

    def of(self, data: Data, model: Mixture) -> float:
        """Log-likelihood [nat] that a source must be worth."""
        share = self.dry + (self.wet - self.dry) * wetness(data, model)
        return float(self.base + share * data.counts.sum())

    def factors(self, azimuths: Real, widths: Real) -> Real:
        """How many times the penalty each source costs, (k,).

        >>> Penalty().factors(np.deg2rad([0.0, 25.0, 50.0, 150.0]), np.array([0.1, 0.1, 0.1, 0.3])).tolist()
        [1.0, 2.5, 1.0, 1.0]
        """
        off = difference(azimuths[:, None], azimuths)
        ahead, behind = (off < 0) & (off > -self.near), (off > 0) & (off < self.near)
        dearer = self.between * np.maximum(widths / self.wide, 1) ** 2
        return np.where(ahead.any(axis=1) & behind.any(axis=1), dearer, 1.0)


def wetness(data: Data, model: Mixture) -> float:
    """From 0 in the open to 1 in a reverberant room, where ITDs are both drawn to 0 and spread."""
    if data.aloft:
        return 0.0
    drawn, spread = (0.97 - model.directness) / 0.08, (model.width - 0.08) / 0.015
    return float(np.clip(drawn, 0, 1) * np.clip(spread, 0, 1))


@dataclass(frozen=True, slots=True)
class Step:
    """The mixture of one order on the way from too many sources to none."""

    model: Mixture
    worth: Real  # of every source over its penalty, (k,)
    reduced: Sequence[Mixture]  # the models without each source
    possible: bool  # not too many sources, and none too near another

    @property
    def least(self) -> int:
        """The source that is worth least."""
        return int(self.worth.argmin())


def steps(data: Data, penalty: Penalty) -> Iterator[Step]:
    """Fit mixtures of falling order: the source goes that is worth least, or one of two that are too near."""
    model = _grow(data, penalty)
    while len(model.azimuths):
        near = _too_near(model, penalty)
        possible = len(model.azimuths) <= MAX_SOURCES and not near
        if possible:
            model = rearrange(data, model, penalty)
            near = _too_near(model, penalty)
        step = _weighed(data, model, penalty, possible=possible and not near)
        yield step
        model = itd_mixture.refine(data, step.reduced[_nearest(step) if near else step.least], 6)


def begun(data: Data, penalty: Penalty, azimuths: Real) -> Step:
    """Fit the mixture whose sources begin at these azimuths [rad], (k,)."""
    k = len(azimuths)
    amplitude = min(max(BEGUN, data.amplitudes[0]), data.amplitudes[1])
    weights = np.full((data.n_periods, k + itd_mixture.OTHERS), 1 / (k + itd_mixture.OTHERS))
    model = Mixture(azimuths, np.full(k, amplitude), np.full(k, penalty.width), weights, amplitude)
    return _weighed(data, itd_mixture.refine(data, model, 20), penalty, possible=True)


def _weighed(data: Data, model: Mixture, penalty: Penalty, *, possible: bool) -> Step:
    worth, reduced = worths(data, model)
    return Step(
        model, worth / (penalty.of(data, model) * penalty.factors(model.azimuths, model.widths)), reduced, possible
    )


def search(data: Data, penalty: Penalty, known: int) -> Step | None:
    """Fit the mixture of ``known`` sources, or of fewer when the histograms do not hold so many."""
    return next((step for step in steps(data, penalty) if step.possible and len(step.worth) <= known), None)


def worths(data: Data, model: Mixture, rounds: int = 8) -> tuple[Real, list[Mixture]]:
    """Worth of every source [nat], (k,), and the models without it."""
    if not len(model.azimuths):
        return np.zeros(0), []
    reduced = [itd_mixture.remove(model, k) for k in range(len(model.azimuths))]
    refined, likelihoods = _refined(data, reduced, rounds)
    return itd_mixture.log_likelihood(data, model) - likelihoods, refined


def profile(data: Data, model: Mixture, source: int) -> Real:
    """Gain of log-likelihood [nat] with one source put at every azimuth of the grid instead, (n_grid,)."""
    amplitude, width = model.amplitudes[source], float(model.widths[source])
    gain, _ = itd_mixture.gains(data, itd_mixture.remove(model, source), (GRID, np.full(len(GRID), amplitude)), width)
    return gain


def rearrange(data: Data, model: Mixture, penalty: Penalty) -> Mixture:
    """A better mixture of as many sources, if one is near.

    One of the three sources worth least is moved to where the likelihood gains most, or the one worth least goes and
    another is split in two: sources that are found one after the other may sit between two true ones.
    """
    if len(model.azimuths) < 2:
        return model
    best = itd_mixture.log_likelihood(data, model)
    for _ in range(2):
        worth, reduced = worths(data, model, 3)
        least = np.argsort(worth)[:3]
        moved = [_added(data, reduced[k], penalty, [float(model.azimuths[k])])[0] for k in least]
        fewer = reduced[least[0]]
        halves = [itd_mixture.split(fewer, k, ASIDE, penalty.width) for k in range(len(fewer.azimuths))]
        tried, likelihoods = _refined(data, [*moved, *halves], 10)
        if likelihoods.max() <= best + BETTER:
            break
        best, model = likelihoods.max(), tried[int(likelihoods.argmax())]
    return model


def _refined(data: Data, models: Sequence[Mixture], rounds: int) -> tuple[list[Mixture], Real]:
    """Models of as many sources, refined together, and the log-likelihood of each [nat], (n,)."""
    together = itd_mixture.refine(data, itd_mixture.stacked(models), rounds)
    return [itd_mixture.taken(together, index) for index in range(len(models))], itd_mixture.log_likelihood(
        data, together
    )


def _grow(data: Data, penalty: Penalty) -> Mixture:
    """Add sources where the likelihood gains most, but not again where one has merged with another.

    Far below a vehicle two at one azimuth may differ in elevation, as a talker and what a rotor leaves over do.
    """
    model, merged = itd_mixture.empty(data), list[float]()
    while len(model.azimuths) < MAX_SOURCES + SPARE and len(merged) < MERGERS:
        added, gain = _added(data, model, penalty, merged)
        if gain < HOPEFUL * penalty.of(data, model):
            break
        grown = itd_mixture.refine(data, added, 8)
        if not data.aloft and _apart(grown).min(initial=np.inf) < MERGED:
            merged.append(float(added.azimuths[-1]))
        else:
            model = grown
    return itd_mixture.refine(data, model, 20)


def _added(data: Data, model: Mixture, penalty: Penalty, not_at: Sequence[float]) -> tuple[Mixture, float]:
    """The model with a source more where it gains most, but not near one of ``not_at`` [rad], and the gain [nat]."""
    least, greatest = data.amplitudes
    tried = np.multiply(STEEP, greatest) if data.aloft else np.multiply(REACH, model.directness)
    azimuths, amplitudes = np.tile(GRID, len(tried)), np.maximum(np.repeat(tried, len(GRID)), least)
    gain, share = itd_mixture.gains(data, model, (azimuths, amplitudes), penalty.width)
    for place in not_at:
        gain = np.where(np.abs(difference(azimuths, place)) < MOVED, -np.inf, gain)
    best = int((gain >= gain.max() - TIED).argmax())  # the first: as direct as the room allows
    shares = np.maximum(share[:, best], 0.01)
    added = itd_mixture.add(model, float(azimuths[best]), float(amplitudes[best]), penalty.width, shares)
    return added, float(gain[best])


def _too_near(model: Mixture, penalty: Penalty) -> bool:
    return bool(_apart(model).min(initial=np.inf) < penalty.apart)


def _apart(model: Mixture) -> Real:
    """Angles between all sources [rad], (k, k); more than pi between a source and itself."""
    between = np.abs(difference(model.azimuths[:, None], model.azimuths))
    return np.asarray(between + 2 * np.pi * np.eye(len(between)))


def _nearest(step: Step) -> int:
    """Of the two sources nearest to each other, the one worth less."""
    apart = _apart(step.model)
    pair = np.unravel_index(int(apart.argmin()), apart.shape)
    return int(min(pair, key=lambda source: step.worth[source]))
