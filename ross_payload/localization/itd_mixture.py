"""ITD histograms of several orientations as one mixture: sources that keep their place while the array turns.

At heading phi_r the ITD of a source at azimuth theta_k and elevation epsilon_k is normal around
``a_k cos(theta_k - phi_r)`` with a width sigma_k. The amplitude is ``a_k = s cos(epsilon_k)``: s <= 1 is the directness
of the room (reflections pull ITDs towards 0). All amplitudes are drawn to their common s and all widths to their common
width, as if so many counts had said so. Every orientation has its own weights, because talkers pause. While the array
turns many headings share the weights of one period, and every row of a histogram has its own heading. What no source
explains is diffuse, normal around 0, or nobody's, spread evenly over all ITDs. ITDs are in units of d / v_p here.

Many models of as many sources are refined together as one whose arrays have a leading dimension (`stacked`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ross_payload.interfaces import Real

TINY = 1e-12
WIDTH = (0.05, 0.25)  # narrowest and widest kernel [d / v_p]
AMPLITUDE = (0.4, 1.0)
DIFFUSE = 0.3  # width of the diffuse share [d / v_p]
POOL = 3.0  # counts by which the weights of one orientation are drawn to those of all
TIE = 20.0  # counts by which an amplitude is drawn to the directness
ALIKE = 60.0  # counts by which a width is drawn to that of all
LONGEST = 1.3  # amplitude that is tried of an array that may be wider than it is configured
LONGER_BY = 5.0  # log-likelihood that it must gain [nat]; where the configuration is right it gains 0.3 at most
TRIED = 8  # rounds of refinement for it
OTHERS = 2  # columns of the weights that belong to no source: diffuse, nobody


@dataclass(frozen=True, slots=True)
class Data:
    """Histograms of all orientations."""

    grid: Real  # centres of the ITD bins [d / v_p], (n_bins,)
    headings: Real  # [rad], (n_headings,)
    counts: Real  # effective counts, (n_headings, n_bins)
    amplitudes: tuple[float, float] = AMPLITUDE  # least and greatest there can be
    alike: float = TIE  # counts by which an amplitude is drawn to that of all
    periods: NDArray[np.intp] | None = None  # first row of every period, (n_periods,); None: each row is one

    @property
    def n_periods(self) -> int:
        """Periods in which talkers are equally loud: an orientation, or a while in which the array turns."""
        return len(self.headings if self.periods is None else self.periods)

    @property
    def evidence(self) -> Real:
        """Counts of every period, (n_periods,)."""
        return np.asarray(self.by_period(self.counts).sum(axis=1))

    def by_period(self, values: Real, axis: int = 0) -> Real:
        """Add up what rows have in common, (..., n_headings, ...) to (..., n_periods, ...).

        >>> turned = Data(np.zeros(1), np.zeros(3), np.zeros((3, 1)), periods=np.array([0, 2]))
        >>> turned.by_period(np.array([1.0, 2.0, 5.0])).tolist(), turned.by_row(np.array([7.0, 8.0])).tolist()
        ([3.0, 5.0], [7.0, 7.0, 8.0])
        """
        if self.periods is None:
            return values
        return np.asarray(np.add.reduceat(values, self.periods, axis=axis))

    def by_row(self, values: Real, axis: int = 0) -> Real:
        """Give every row what its period has, (..., n_periods, ...) to (..., n_headings, ...)."""
        if self.periods is None:
            return values
        return np.asarray(np.repeat(values, np.diff(self.periods, append=len(self.headings)), axis=axis))

    @property
    def aloft(self) -> bool:
        """Whether the array is known to be above everybody: delays are short because of that alone."""
        return self.amplitudes[1] < 1


@dataclass(frozen=True, slots=True)
class Mixture:
    """Parameters of the model, or of n models: then every shape begins with n."""

    azimuths: Real  # [rad], (k,)
    amplitudes: Real  # (k,)
    widths: Real  # [d / v_p], (k,)
    weights: Real  # (n_periods, k + 2), rows sum to 1; the last two columns are the diffuse share and nobody's
    directness: float | Real = 1.0

    @property
    def width(self) -> float:
        """Mean width of the kernels [d / v_p]; the narrowest there is when there is no source."""
        return float(self.widths.mean()) if len(self.widths) else WIDTH[0]


def empty(data: Data) -> Mixture:
    """The model of no source."""
    nothing = np.zeros(0)
    return Mixture(nothing, nothing, nothing, np.full((data.n_periods, OTHERS), 1 / OTHERS))


def stacked(models: Sequence[Mixture]) -> Mixture:
    """Models of as many sources as one with a leading dimension."""
    return Mixture(
        np.stack([model.azimuths for model in models]),
        np.stack([model.amplitudes for model in models]),
        np.stack([model.widths for model in models]),
        np.stack([model.weights for model in models]),
        np.array([model.directness for model in models]),
    )


def taken(models: Mixture, index: int) -> Mixture:
    """One of the models that are `stacked`."""
    return Mixture(
        models.azimuths[index],
        models.amplitudes[index],
        models.widths[index],
        models.weights[index],
        float(np.asarray(models.directness)[index]),
    )


def kernels(data: Data, azimuths: Real, amplitudes: Real, widths: Real) -> Real:
    """Probability of every ITD bin for every source, (n_headings, k, n_bins); sums to nearly 1 over the bins."""
    centre = amplitudes[..., None, :] * np.cos(azimuths[..., None, :] - data.headings[:, None])
    return _normal(data, centre[..., None], widths[..., None, :, None])


def densities(data: Data, model: Mixture) -> Real:
    """Probability of every ITD bin in every orientation, (n_headings, n_bins)."""
    return np.asarray(_joint(data, model).sum(axis=-2))


def log_likelihood(data: Data, model: Mixture) -> Real:
    """Log-likelihood of the counts [nat], one number per model."""
    return np.asarray((data.counts * np.log(densities(data, model) + TINY)).sum(axis=(-2, -1)))


def claims(data: Data, model: Mixture) -> Real:
    """Share of every bin that is each source's, diffuse, or nobody's, (n_headings, k + 2, n_bins)."""
    joint = _joint(data, model)
    return np.asarray(joint / (joint.sum(axis=-2, keepdims=True) + TINY))


def refine(data: Data, model: Mixture, rounds: int, tie: float | None = None) -> Mixture:
    """Expectation maximisation from ``model``; ``tie`` draws the amplitudes to their common directness [counts].

    None: as ``data`` says.
    """
    for _ in range(rounds):
        model = _step(data, model, data.alike if tie is None else tie)
    return model


def longer(data: Data, model: Mixture) -> float:
    """How much longer the delays of all sources are than their array allows, as a factor; 1 where that is not sure.

    Elevations and reflections only shorten delays: the array is wider than configured, or the air colder.
    """
    if data.aloft or float(np.max(model.directness)) < data.amplitudes[1]:
        return 1.0
    free = replace(data, amplitudes=(data.amplitudes[0], LONGEST))
    bound, loose = refine(data, model, TRIED), refine(free, model, TRIED)
    gain = log_likelihood(data, loose) - log_likelihood(data, bound)
    return float(loose.directness) if gain > LONGER_BY else 1.0


def add(model: Mixture, azimuth: float, amplitude: float, width: float, share: Real) -> Mixture:
    """The model with one source more, the last, which takes ``share`` (n_periods,) of every period."""
    return replace(
        model,
        azimuths=np.append(model.azimuths, azimuth),
        amplitudes=np.append(model.amplitudes, amplitude),
        widths=np.append(model.widths, width),
        weights=np.insert(model.weights * (1 - share[:, None]), -OTHERS, share, axis=1),
    )


def remove(model: Mixture, source: int) -> Mixture:
    """The model without one source; the others share its weights in proportion."""
    weights = np.delete(model.weights, source, axis=1) + 1e-3
    return replace(
        model,
        azimuths=np.delete(model.azimuths, source),
        amplitudes=np.delete(model.amplitudes, source),
        widths=np.delete(model.widths, source),
        weights=weights / weights.sum(axis=1, keepdims=True),
    )


def split(model: Mixture, source: int, by: float, width: float) -> Mixture:
    """The model with one source more: two at ``by`` [rad] to both sides of one, no wider than ``width`` [d / v_p]."""
    azimuths, widths, weights = model.azimuths.copy(), model.widths.copy(), model.weights.copy()
    azimuths[source] -= by
    widths[source] = min(widths[source], width)
    weights[:, source] /= 2
    return replace(
        model,
        azimuths=np.append(azimuths, model.azimuths[source] + by),
        amplitudes=np.append(model.amplitudes, model.amplitudes[source]),
        widths=np.append(widths, widths[source]),
        weights=np.insert(weights, -OTHERS, weights[:, source], axis=1),
    )


def gains(data: Data, model: Mixture, places: tuple[Real, Real], width: float, rounds: int = 4) -> tuple[Real, Real]:
    """Gain of log-likelihood [nat] by a source at each place, (n,), and its best shares, (n_periods, n).

    ``places`` are azimuths and amplitudes, (n,) each. All else stays; the share is found by expectation maximisation in
    every period.
    """
    excess = kernels(data, *places, np.full(len(places[0]), width))
    excess /= densities(data, model)[:, None] + TINY
    excess -= 1
    total = data.evidence[:, None] + TINY
    share, most = np.full((len(total), excess.shape[1]), 0.1, excess.dtype), 1 - np.finfo(excess.dtype).epsneg
    counts = data.counts[..., None]
    quotient = np.empty_like(excess)
    for _ in range(rounds):
        np.multiply(data.by_row(share)[..., None], excess, out=quotient)
        quotient += 1
        np.divide(excess, quotient, out=quotient)
        share = share * (1 + (1 - share) * data.by_period((quotient @ counts)[..., 0]) / total)
        share = np.minimum(share, most)  # what has all of it would leave other bins impossible
    np.multiply(data.by_row(share)[..., None], excess, out=quotient)
    gain = (np.log1p(quotient, out=quotient) @ counts)[..., 0].sum(axis=0)
    return np.asarray(gain), share


def sigmas(data: Data, model: Mixture) -> tuple[Real, Real]:
    """One standard deviation of every azimuth [rad] and amplitude, from the expected information, (k,) each."""
    counts = _claimed(data, model).sum(axis=-1)[:, :-OTHERS]
    cosine, sine = _turned(data, model)
    along = (counts * cosine**2).sum(axis=0) / model.widths**2
    across = (counts * (model.amplitudes * sine) ** 2).sum(axis=0) / model.widths**2
    return np.asarray(1 / np.sqrt(across + TINY)), np.asarray(1 / np.sqrt(along + TINY))


def _step(data: Data, model: Mixture, tie: float) -> Mixture:
    claimed = _claimed(data, model)
    counts = claimed.sum(axis=-1)
    sources = counts[..., :-OTHERS]
    mean, square = ((claimed[..., :-OTHERS, :] @ power) for power in (data.grid, data.grid**2))
    cosine, sine = _turned(data, model)
    amplitudes = model.amplitudes[..., None, :]
    centre, slope = amplitudes * cosine, -amplitudes * sine
    curvature = (sources * slope**2).sum(axis=-2) + 0.02 * sources.sum(axis=-2) + TINY
    turn = ((mean - sources * centre) * slope).sum(axis=-2) / curvature
    reach, weight = (mean * cosine).sum(axis=-2), (sources * cosine**2).sum(axis=-2)
    directness = _clipped((20.0 + reach.sum(axis=-1)) / (20.0 + weight.sum(axis=-1)), *data.amplitudes)
    spread = (square - 2 * mean * centre + sources * centre**2).sum(axis=-2)
    return Mixture(
        azimuths=model.azimuths + _clipped(turn, -0.2, 0.2),
        amplitudes=_clipped((tie * directness[..., None] + reach) / (tie + weight), *data.amplitudes),
        widths=_widths(spread, sources.sum(axis=-2)),
        weights=_weights(data.by_period(counts, axis=-2)),
        directness=directness,
    )


def _widths(spread: Real, counts: Real) -> Real:
    """Widths from summed squares, drawn to their common one and weakly to 0.1, (k,)."""
    common = (spread.sum(axis=-1, keepdims=True) + 20 * 0.1**2) / (counts.sum(axis=-1, keepdims=True) + 20)
    return _clipped(np.sqrt((spread + 2 * 0.1**2 + ALIKE * common) / (counts + 2 + ALIKE)), *WIDTH)


def _weights(counts: Real) -> Real:
    """Shares of the counts (n_periods, k + 2), drawn to those of all periods."""
    of_all = counts.sum(axis=-2, keepdims=True)
    pooled = POOL * of_all / (of_all.sum(axis=-1, keepdims=True) + TINY)
    weights = counts + pooled + TINY
    return np.asarray(weights / weights.sum(axis=-1, keepdims=True))


def _clipped(values: Real, low: float, high: float) -> Real:
    return np.asarray(np.minimum(np.maximum(values, low), high))


def _turned(data: Data, model: Mixture) -> tuple[Real, Real]:
    """Cosine and sine of the azimuths relative to the array, (n_headings, k) each."""
    angle = model.azimuths[..., None, :] - data.headings[:, None]
    return np.cos(angle), np.sin(angle)


def _normal(data: Data, centre: Real | float, width: Real | float) -> Real:
    """Normal density over the bins times their width, broadcast against (..., n_bins)."""
    precision, step = data.grid.dtype, data.grid[1] - data.grid[0]
    off = (data.grid - np.asarray(centre, precision)) / np.asarray(width, precision)
    off *= off
    off *= -0.5
    np.exp(off, out=off)
    off *= np.asarray(step / np.sqrt(2 * np.pi) / width, precision)
    return np.asarray(off)


def _joint(data: Data, model: Mixture) -> Real:
    """Weight times probability, (n_headings, k + 2, n_bins)."""
    weights = data.by_row(model.weights, axis=-2)
    joint = np.empty((*weights.shape, len(data.grid)), data.grid.dtype)
    joint[..., :-OTHERS, :] = kernels(data, model.azimuths, model.amplitudes, model.widths)
    joint[..., -OTHERS, :] = _normal(data, 0.0, DIFFUSE)
    joint[..., -1, :] = 1 / len(data.grid)
    joint *= weights[..., None]
    return joint


def _claimed(data: Data, model: Mixture) -> Real:
    """Counts that every source claims of every bin, (n_headings, k + 2, n_bins)."""
    joint = _joint(data, model)
    joint *= (data.counts / (joint.sum(axis=-2) + TINY))[..., None, :]
    return joint
