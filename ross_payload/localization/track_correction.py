"""Correct what is believed of all sources by the phases of some frames.

The phases are a mixture over the sources and nobody. The share of every source in these frames, band by band, is found
by expectation maximisation under what a hypothesis predicts. Sources are corrected in turn, each given what is believed
of the others (variational factorisation); with one source that has left this is exact but for the shares. A source may
be silent, or have a quarter of its share. A hypothesis is weighed by how well it has predicted the phases.

Where a source rests is heard, too: its place is corrected within what was told of it, and forgotten towards that. A
hypothesis in which somebody has left and stands still would otherwise know that place better than the one in which
it never left.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, rfft

from ross_payload.interfaces import Real
from ross_payload.localization.phase_likelihood import TINY, Likelihood, Scene, likelihood
from ross_payload.localization.phase_statistics import FrameStatistics, Hearing
from ross_payload.localization.talker_motion import N_AZIMUTHS
from ross_payload.localization.track_hypotheses import Hypothesis, Tracks

SOMETIMES = 0.01  # nobody talks or is silent for sure
SOFT = 4  # a source that is heard has its share of the bins, or one so many times smaller
LOUD = 50.0  # a place is at most so much likelier than the likeliest one before [nat]
BLUR = np.radians(1.0)  # of where somebody rests, beside what was heard [rad]


@dataclass(slots=True, eq=False)
class _Correction:
    """Hypotheses while their sources are corrected in turn."""

    left: list[dict[int, Real]]  # densities by hypothesis and source, (n_rates, n_azimuths)
    weights: Real  # before, (n_hypotheses,)
    talking: Real  # (n_hypotheses, k)
    rests: Real  # (k, n_azimuths)
    shares: Real  # by bin, (n_hypotheses, k + 1, n)
    marginal: Real  # density of every bin's phase, (n_hypotheses, k + 1, n)
    log: Real = field(default_factory=lambda: np.zeros(0))  # likelihood of the frames, (n_hypotheses,)

    @property
    def mixture(self) -> Real:
        """Density of every bin's phase, (n_hypotheses, n)."""
        return np.asarray(np.einsum("hkn,hkn->hn", self.shares, self.marginal) + np.float32(TINY))

    def correct(self, source: int, found: Likelihood, keep: float, home_density: Real) -> None:
        """Correct one source in all hypotheses, given what is believed of the others there."""
        mixture, part = self.mixture, self.shares[:, source]
        self.log -= found.log(mixture[..., None])[:, 0]
        others = np.maximum(mixture - part * self.marginal[:, source], TINY) / np.maximum(1 - part, TINY)
        gone = np.array([source in left for left in self.left])
        rest, away = np.flatnonzero(~gone), np.flatnonzero(gone)
        here, anywhere = self.marginal[rest, source][..., None], found.density[source][None]
        voiced, each = _cases(here, others[rest], part[rest], self.talking[rest, source], found)
        self._apply_at_rest(source, rest, voiced[:, 0], each[:, 0])
        voiced, each = _cases(anywhere, others[away], part[away], self.talking[away, source], found)
        for row, talks, either in zip(away.tolist(), voiced, each, strict=True):
            self._apply(source, row, talks, either, found)
        if len(rest):
            best = rest[self.weights[rest].argmax()][None]
            talking = self.talking[best, source]
            _, each = _cases(anywhere, others[best], part[best], talking, found)
            log = keep * np.log(self.rests[source] + TINY) + (1 - keep) * np.log(home_density + TINY)
            log += self.weights[rest].sum() * each[0][found.case[source]]
            after = np.exp(log - log.max())
            self.rests[source] = after / after.sum()

    def _apply_at_rest(self, source: int, rows: NDArray[np.intp], talks: Real, either: Real) -> None:
        """Correct one source where it rests, by the log-likelihoods that it talks, and that it does or is silent."""
        self.talking[rows, source] = np.clip(np.exp(np.minimum(talks - either, LOUD)), SOMETIMES, 1 - SOMETIMES)
        self.log[rows] += either

    def _apply(self, source: int, row: int, talks: Real, either: Real, found: Likelihood) -> None:
        """Correct one source that has left in one hypothesis, by the same of all places."""
        belief = self.left[row][source]
        places, case = belief.sum(axis=0), found.case[source]
        talks, either = talks[case], either[case]
        highest = float(either[places > TINY].max())
        gain = np.exp(np.minimum(either - highest, LOUD))
        total = float(places @ gain) + TINY
        talking = float(places @ np.exp(np.minimum(talks - highest, LOUD))) / total
        self.talking[row, source] = np.clip(talking, SOMETIMES, 1 - SOMETIMES)
        self.log[row] += highest + np.log(total)
        after = belief * gain.astype(np.float32)
        self.left[row][source] = after / after.sum()
        self.marginal[row, source] = found.marginal(source, self.left[row][source].sum(axis=0))


def _cases(density: Real, others: Real, part: Real, talking: Real, found: Likelihood) -> tuple[Real, Real]:
    """Log-likelihood of every case of a source, (n_rows, n_cases): that it talks, and that it does or is silent.

    A source that talks has its ``part`` of the bins or less; what the others have then is ``others``, both (n_rows, n).
    """
    alone, odds = others[..., None], talking[:, None]
    more = part[..., None] * (density - alone)
    talks = np.log(odds / 2) + np.logaddexp(found.log(alone + more), found.log(alone + more / SOFT))
    return talks, np.logaddexp(talks, np.log(1 - odds) + found.log(alone))


def correct(tracks: Tracks, statistics: FrameStatistics, hearing: Hearing) -> tuple[Tracks, list[Hypothesis]]:
    """Return what is believed after some frames, and its hypotheses, whose weights sum to 1, before they are merged."""
    shares = tracks.shares[:-1].mean(axis=1) + SOMETIMES
    scene = Scene(tracks.unit, tracks.azimuths, tracks.elevations, shares, tracks.wet, tracks.amplitude)
    found = likelihood(statistics, scene, hearing)
    state, shares = _begin(tracks, found, hearing)
    keep = float(np.exp(-statistics.seconds / hearing.homes))
    for source in range(len(tracks.homes)):
        state.correct(source, found, keep, tracks.home_densities[source])
    log = np.log(state.weights) + state.log
    weights = np.exp(log - log.max())
    parts = zip((weights / weights.sum()).tolist(), state.left, state.talking, strict=True)
    own = state.shares[:, :-1] * state.marginal[:, :-1] / state.mixture[:, None]
    telling = found.count * -np.log1p(-np.minimum(own, 1 - 1e-6)).sum(axis=-1)
    keep = float(np.exp(-statistics.seconds / hearing.recent))
    mixed = keep * tracks.shares + (1 - keep) * np.tensordot(state.weights, shares, 1) + 0.01 / len(tracks.shares)
    after = replace(
        tracks,
        rests=state.rests,
        shares=mixed / mixed.sum(axis=0),
        ages=np.where(state.weights @ telling >= hearing.talks, 0.0, tracks.ages),
        heading=float(statistics.headings[-1]),
    )
    return after, [Hypothesis(*part) for part in parts]


def widened(rests: Real) -> Real:
    """Where sources that rest are heard, (k, n_azimuths): not more sharply than a place can be known."""
    orders = np.arange(N_AZIMUTHS // 2 + 1)
    wide = np.maximum(irfft(rfft(rests) * np.exp(-0.5 * (orders * BLUR) ** 2), N_AZIMUTHS), 0.0)
    return np.asarray(wide / wide.sum(axis=-1, keepdims=True))


def _begin(tracks: Tracks, found: Likelihood, hearing: Hearing) -> tuple[_Correction, Real]:
    """Return the hypotheses before they are corrected, and the shares by band, (n_hypotheses, k + 1, n_bands)."""
    hypotheses, k = tracks.hypotheses, len(tracks.homes)
    rests = widened(tracks.rests)
    still = np.stack([*(found.marginal(source, rests[source]) for source in range(k)), found.nobody])
    marginal = np.repeat(still[None], len(hypotheses), axis=0)
    for row, each in enumerate(hypotheses):
        for source, belief in each.left.items():
            marginal[row, source] = found.marginal(source, belief.sum(axis=0))
    shares = found.shares(tracks.shares, marginal, hearing.share)
    state = _Correction(
        left=[dict(each.left) for each in hypotheses],
        weights=np.array([each.weight for each in hypotheses]),
        talking=np.stack([each.talking for each in hypotheses]),
        rests=tracks.rests.copy(),
        shares=np.ascontiguousarray(shares[..., found.band]),
        marginal=marginal,
    )
    state.log = found.log(state.mixture[..., None])[:, 0]
    return state, shares
