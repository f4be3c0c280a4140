"""Track the azimuths of sources from frame to frame: a multiple-hypothesis filter over all sources together.

A hypothesis says which sources have left the place where they rested; the others are there, and do not drift. What it
believes of every source that has left is a point-mass density over azimuth and rate (Bucy and Senne 1971): two
microphones hear only ``cos(azimuth - heading)``, so a source that walks past the axis of the array may have gone on
or turned back, and when one of two sources with one delay sets out, it may be either. The first is in the density,
the second in the weights of hypotheses (Reid 1979); both stay possible until the array turns or the walk tells.

*Prediction.* A source that has left rests, sets out, keeps its rate, turns back, stops. Another one sets out: part of
a hypothesis becomes the one in which that source has left, too. Hypotheses with the same sources are merged.

*Correction.* The phases between the microphones in trustworthy bins are a mixture: of every source von Mises around
``2 pi f tau`` with ``tau = (d / v_p) a cos(azimuth - heading)``, also above the frequency where that wraps, and of
nobody evenly spread. The share of every source in these frames is found by expectation maximisation under what a
hypothesis predicts. With one source that has left this is exact but for the shares; several are corrected in turn,
each given what is believed of the others (variational factorisation). A hypothesis is weighed by how well it has
predicted the phases.

Nothing is drawn at random: the same frames give the same tracks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import i0e

from ross_payload.alignment.predicted_gain import OPEN
from ross_payload.angles import difference
from ross_payload.events import Estimate
from ross_payload.interfaces import Real
from ross_payload.localization.phase_statistics import HEARING, FrameStatistics, Hearing
from ross_payload.localization.talker_motion import (
    AZIMUTHS,
    MOTION,
    N_AZIMUTHS,
    REST,
    Motion,
    around,
    fresh_rates,
    moved,
    talks,
)
from ross_payload.localization.track_hypotheses import Hypothesis, Members, Tracks

PLACE = np.radians(1.5)  # of where somebody rests, beside that of the exploration [rad]
MOST = 8  # hypotheses
UNLIKELY = 1e-4  # least weight of a hypothesis: phases that echoes share tell less than they seem to
ANYWHERE = 0.5  # share of what is from nobody that has a delay at least: two sources in one bin, an echo
SOMETIMES = 0.01  # nobody talks or is silent for sure
TINY = 1e-12
DELAYS = np.linspace(-1.0, 1.0, 201)  # [d / v_p]


def begin(estimate: Estimate, spacing: float, speed_of_sound: float) -> Tracks:
    """Begin with what an exploration has found: its azimuths and sigmas, and everybody at rest."""
    azimuths = np.array([source.azimuth for source in estimate.sources])
    k = len(azimuths)
    return Tracks(
        hypotheses=(Hypothesis(1.0, {}, np.ones(k)),),
        homes=azimuths,
        rests=np.array([around(s.azimuth, float(np.hypot(s.sigma, PLACE))) for s in estimate.sources]).reshape(
            k, N_AZIMUTHS
        ),
        heading=0.0,
        elevations=np.cos([source.elevation or 0.0 for source in estimate.sources]),
        shares=np.full(k + 1, 1 / (k + 1)),
        ages=np.zeros(k),
        unit=spacing / speed_of_sound,
        wet=estimate.directness is None or estimate.directness < OPEN,
    )


def step(tracks: Tracks, heard: FrameStatistics, motion: Motion = MOTION, hearing: Hearing = HEARING) -> Tracks:
    """Return what is believed at the end of some frames: predict, then correct by what was heard in them."""
    if not len(tracks.ages):
        return tracks
    ahead = predict(tracks, heard.seconds, motion)
    return _correct(ahead, heard, hearing) if len(heard.weights) else ahead


def predict(tracks: Tracks, seconds: float, motion: Motion = MOTION) -> Tracks:
    """Return what is believed ``seconds`` later when nothing is heard."""
    seconds = round(seconds, 6)
    parts: list[Hypothesis] = []
    out = 1 - float(np.exp(-motion.sets_out * seconds))
    back = 1 - float(np.exp(-motion.settles * seconds))
    for each in tracks.hypotheses:
        left, weight, talking = {}, each.weight, talks(each.talking, seconds, motion)
        for source, belief in each.left.items():
            left[source] = moved(belief, seconds, motion)
            left[source], kept = _aside(tracks, left, source, seconds, motion)
            weight *= kept
        for source in range(len(tracks.homes)):
            rest = {other: belief for other, belief in left.items() if other != source}
            if source in left:  # who has come back
                near = np.abs(difference(AZIMUTHS, tracks.homes[source])) <= 2 * PLACE
                share = back * float(left[source][REST, near].sum())
                belief = left[source].copy()
                belief[REST, near] *= 1 - back
                left[source] = belief / belief.sum()
                parts.append(Hypothesis(weight * share, rest, talking))
                weight *= 1 - share
            else:
                fresh = fresh_rates()[:, None] * tracks.rests[source]
                parts.append(Hypothesis(weight * out, {**left, source: fresh}, talking))
                weight *= 1 - out
        parts.append(Hypothesis(weight, dict(left), talking))
    return replace(tracks, hypotheses=_merged(parts), ages=tracks.ages + seconds)


def _aside(tracks: Tracks, left: dict[int, Real], source: int, seconds: float, motion: Motion) -> tuple[Real, float]:
    """Make it unlikely that somebody who has left is where somebody else rests; return how likely it was before."""
    others = [home for k, home in enumerate(tracks.homes) if k != source and k not in left]
    factor = np.ones(N_AZIMUTHS)
    for home in others:
        factor[np.abs(difference(AZIMUTHS, home)) < motion.elbows] *= np.exp(-motion.aside * seconds)
    after = left[source] * factor
    kept = float(after.sum())
    return after / kept, kept


def _merged(parts: Sequence[Hypothesis]) -> tuple[Hypothesis, ...]:
    """Hypotheses with the same members become one; the likeliest are kept, none of them as unlikely as it seems."""
    groups: dict[Members, list[Hypothesis]] = {}
    for part in parts:
        groups.setdefault(part.members, []).append(replace(part, weight=max(part.weight, TINY)))
    totals = {members: sum(part.weight for part in group) for members, group in groups.items()}
    kept = sorted(totals, key=lambda members: (-totals[members], len(members), members))[:MOST]
    whole = sum(totals[members] for members in kept)
    weights = {members: max(totals[members] / whole, UNLIKELY) for members in kept}
    whole = sum(weights.values())
    found = []
    for members in kept:
        odds = [part.weight / totals[members] for part in groups[members]]
        mixed = list(zip(odds, groups[members], strict=True))
        left = {k: sum((odd * part.left[k] for odd, part in mixed), np.zeros(())) for k in members}
        talking = sum((odd * part.talking for odd, part in mixed), np.zeros(()))
        found.append(Hypothesis(weights[members] / whole, left, np.asarray(talking)))
    return tuple(found)


def _either(density: Real, others: Real, share: float, counts: Real, talking: float) -> tuple[Real, Real]:
    """Log-likelihood of every case of a source, (n_cases,): that it talks, and that it does or is silent.

    Who talks has its share of the bins, or a quarter of it; what the others have then is ``others`` (n,).
    """
    alone = others / max(1 - share, TINY)
    rest = (alone + TINY).astype(density.dtype)[:, None]
    loud, soft = (counts @ np.log(part * density + (1 - part) * rest) for part in (share, share / 4))
    heard = np.log(talking / 2) + np.logaddexp(loud, soft)
    return heard, np.logaddexp(heard, np.log(1 - talking) + counts @ np.log(alone + TINY))


@dataclass(slots=True, eq=False)
class _Evidence:
    """What some frames say: density of every bin's phase for every azimuth of every source.

    Azimuths with one delay at every heading of these frames are told apart by nothing, and are computed once.
    """

    density: list[Real]  # by source, (n, n_cases)
    case: list[NDArray[np.intp]]  # by source: which of them an azimuth is, (n_azimuths,)
    counts: Real  # effective, (n,)
    nobody: Real  # density of every bin's phase for what is from no source, (n,)

    def marginal(self, source: int, places: Real) -> Real:
        """Density of every bin's phase for a source that is believed to be somewhere, (n,)."""
        density, case = self.density[source], self.case[source]
        return np.asarray(density @ np.bincount(case, places, density.shape[1]).astype(density.dtype))


def _correct(tracks: Tracks, heard: FrameStatistics, hearing: Hearing) -> Tracks:
    evidence = _evidence(tracks, heard, hearing)
    k = len(tracks.homes)
    at_rest = np.stack([evidence.marginal(source, tracks.rests[source]) for source in range(k)])
    found, logs, shares, telling = [], [], np.zeros(k + 1), np.zeros(k)
    for each in tracks.hypotheses:
        after, log, own, tells = _corrected(each, at_rest, tracks.shares, evidence, hearing)
        found.append(after)
        logs.append(np.log(each.weight) + log)
        shares += each.weight * own
        telling += each.weight * tells
    weights = np.exp(np.array(logs) - max(logs))
    weights /= weights.sum()
    corrected = [replace(each, weight=weight) for each, weight in zip(found, weights.tolist(), strict=True)]
    keep = np.exp(-heard.seconds / hearing.recent)
    mixed = keep * tracks.shares + (1 - keep) * shares + 0.01 / len(shares)
    return replace(
        tracks,
        hypotheses=_merged(corrected),
        shares=mixed / mixed.sum(),
        ages=np.where(telling >= hearing.talks, 0.0, tracks.ages),
        heading=float(heard.headings[-1]),
    )


def _corrected(
    hypothesis: Hypothesis, at_rest: Real, before: Real, evidence: _Evidence, hearing: Hearing
) -> tuple[Hypothesis, float, Real, Real]:
    """Correct one hypothesis; return it, the log-likelihood of the frames, shares, and how each source was heard."""
    counts = evidence.counts
    marginal = np.vstack([at_rest, evidence.nobody[None]])
    left, talking = dict(hypothesis.left), hypothesis.talking.copy()
    for source, belief in left.items():
        marginal[source] = evidence.marginal(source, belief.sum(axis=0))
    shares = _shares(before, marginal, counts, hearing.share)
    log = float(counts @ np.log(shares @ marginal + TINY))
    for source in range(len(at_rest)):
        mixture = shares @ marginal + TINY
        log -= float(counts @ np.log(mixture))
        others = np.maximum(mixture - shares[source] * marginal[source], TINY)
        away = source in left
        density = evidence.density[source] if away else marginal[source][:, None]
        places = left[source].sum(axis=0) if away else np.ones(1)
        heard, each = _either(density, others, float(shares[source]), counts, float(talking[source]))
        if away:
            heard, each = heard[evidence.case[source]], each[evidence.case[source]]
        highest = float(each[places > TINY].max())
        gain = np.exp(np.minimum(each - highest, 50.0))
        total = float(places @ gain) + TINY
        talking[source] = np.clip(places @ np.exp(np.minimum(heard - highest, 50.0)) / total, SOMETIMES, 1 - SOMETIMES)
        log += highest + np.log(total)
        if away:
            left[source] = left[source] * gain
            left[source] /= left[source].sum()
            marginal[source] = evidence.marginal(source, left[source].sum(axis=0))
    own = shares[:-1, None] * marginal[:-1] / (shares @ marginal + TINY)
    tells = -np.log1p(-np.minimum(own, 1 - TINY)) @ counts
    return Hypothesis(hypothesis.weight, left, talking), log, shares, np.asarray(tells)


def _evidence(tracks: Tracks, heard: FrameStatistics, hearing: Hearing) -> _Evidence:
    """Density of every phase for every azimuth of every source, von Mises."""
    turned = 2 * np.pi * tracks.unit * heard.frequencies
    variance = hearing.noise**2 + (turned * hearing.spread[tracks.wet]) ** 2
    kappa = (1 / variance)[:, None]
    off = np.cos((heard.phases[:, None] - turned[:, None] * DELAYS).astype(np.float32)) - 1
    table = np.exp(kappa.astype(np.float32) * off) / (2 * np.pi * i0e(kappa)).astype(np.float32)  # (n, n_delays)
    bins = np.arange(len(turned))[:, None]
    counts = heard.weights * min(1.0, hearing.tells * heard.seconds / max(float(heard.weights.sum()), TINY))
    made: dict[float, tuple[Real, NDArray[np.intp]]] = {}
    for elevation in tracks.elevations.tolist():
        if elevation not in made:
            cells = _cells(heard.headings, elevation, hearing.directness[tracks.wet])
            unique, case = np.unique(cells, axis=1, return_inverse=True)
            made[elevation] = table[bins, unique[heard.bundle]], case.reshape(-1)
    both = [made[elevation] for elevation in tracks.elevations.tolist()]
    nobody = ((1 - ANYWHERE) / (2 * np.pi) + ANYWHERE * table.mean(axis=1)).astype(np.float64)
    return _Evidence([density for density, _ in both], [case for _, case in both], counts, nobody)


def _cells(headings: Real, elevation: float, directness: float) -> NDArray[np.intp]:
    """Delay of every azimuth at every heading, as an index into the grid, (n_headings, n_azimuths)."""
    delay = directness * elevation * np.cos(AZIMUTHS - headings[:, None])
    return np.asarray(np.round((delay + 1) / (DELAYS[1] - DELAYS[0])), dtype=np.intp)


def _shares(before: Real, marginal: Real, counts: Real, drawn: float) -> Real:
    """Share of every source and of nobody in these frames, (k + 1,)."""
    shares = before
    for _ in range(8):
        joint = shares[:, None] * marginal
        shares = (joint / (joint.sum(axis=0) + TINY)) @ counts + drawn * before
        shares = shares / shares.sum()
    return shares
