"""Algorithm 1 of the paper: peaks, hypothesis tests along a Markov chain of rotations, K-means (`markov`).

The chain gives every peak of every orientation an azimuth (`chain`); clusters of these azimuths (`clusters`) are the
sources. The paper leaves the criterion on the inertia open; here K minimises inertia + penalty K, and a cluster is a
source when it holds its share of what one source could hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from ross_payload.angles import wrap
from ross_payload.dsp.density import histogram, itd_grid, kde, prominent_peaks
from ross_payload.dsp.itd import RULED, Trust, band_limits, itd_per_bin, period_of, weighted_itd
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.interfaces import Complex, Observation, Real
from ross_payload.localization import front_back_test
from ross_payload.localization.clusters import Cluster, k_means

TRUSTS = (Trust(), RULED)
N_BINS = 241
UNCHANGED = 2  # times that K must stay the same
HALF_TURN = np.pi - 1e-6  # total rotation at which Algorithm 1 ends [rad]
BIAS = np.deg2rad(0.5)  # what reflections add to every azimuth, however long one listens [rad]
ALONE = np.deg2rad(5.0)  # standard deviation of a vote that nobody confirms [rad]
STEEP = 3.0  # of the confidence over the logarithm of votes over those wanted


@dataclass(frozen=True, slots=True)
class Rule:
    """The numbers that the paper leaves open."""

    bandwidth: float = 0.045  # of the KDE [d / v_p]
    prominence: float = 0.01  # of a peak, as a share of the highest
    trial: front_back_test.Trial = field(default_factory=front_back_test.Trial)
    spread: float = np.deg2rad(16.0)  # one more cluster must save the inertia of one mean vote so far off [rad]
    share: float = 0.2  # of the votes that one source could have, in mean votes, that a source must hold
    most: int = 16  # clusters tried
    evidence: float = 0.001  # mean weight of a bin; an orientation with less heard nobody


@dataclass(frozen=True, slots=True)
class Markov:
    """The explorer: what it needs to know about the array, and its settings."""

    spacing: float
    speed_of_sound: float
    trusts: tuple[Trust, ...] = TRUSTS  # a histogram each; none: one in which every bin counts one, as in the paper
    rule: Rule = field(default_factory=Rule)
    name: str = "markov"

    @property
    def unit(self) -> float:
        """The largest ITD, d / v_p [s]."""
        return self.spacing / self.speed_of_sound

    def observe(
        self,
        spectrogram: Complex,
        frequencies: Real,
        heading: float,
        noise_psd: Real | None,
        *,
        frame_period: float | None = None,
    ) -> Observation:
        """Fit the ITDs of one orientation with a KDE and find its prominent peaks; see `interfaces.Explorer`."""
        grid = itd_grid(self.spacing, self.speed_of_sound, N_BINS)
        low, high = band_limits(self.spacing, self.speed_of_sound)
        band = (frequencies >= low) & (frequencies <= high)
        if not spectrogram.shape[-1] or not band.any():
            return Observation(heading, grid, np.zeros_like(grid), 0.0)
        noise = None if noise_psd is None else noise_psd[band]
        itds = self._itds(spectrogram[:, band], frequencies[band], period_of(frequencies, frame_period), noise)
        counts = [histogram(*itd_and_weight, grid) for itd_and_weight in itds]
        weight = float(counts[0].sum())
        if weight < self.rule.evidence * band.sum() * spectrogram.shape[-1]:
            return Observation(heading, grid, np.zeros_like(grid), weight)
        even = np.sum([count / max(count.sum(), 1.0) for count in counts], axis=0)
        density = kde(even, grid, self.rule.bandwidth * self.unit)
        peaks = prominent_peaks(density, grid, self.rule.prominence)
        return Observation(
            heading, grid, density, weight, tuple(front_back_test.refined(density, grid, peak) for peak in peaks)
        )

    def estimate(self, observations: Sequence[Observation]) -> Estimate:
        """Run the chain over all orientations, in the order in which they were heard; see `interfaces.Explorer`."""
        pairs = enumerate(pairwise(observations), start=1)
        found = [
            vote
            for r, (before, after) in pairs
            for vote in front_back_test.votes(before, after, r, self.unit, self.rule.trial)
        ]
        if not found:
            return Estimate(self._unresolved(observations[-1]) if observations else ())
        turned = sum(abs(after.heading - before.heading) for before, after in pairwise(observations))
        return Estimate(self._sources(found), turned >= HALF_TURN or self._settled(found, len(observations) - 1))

    def _itds(
        self, spectrogram: Complex, frequencies: Real, period: float, noise_psd: Real | None
    ) -> list[tuple[Real, Real]]:
        """ITD [s] and weight of every bin, once for every histogram."""
        if not self.trusts:
            return [(itd_per_bin(spectrogram, frequencies), (np.abs(spectrogram).min(axis=0) > 0).astype(float))]
        return [weighted_itd(spectrogram, frequencies, period, noise_psd, trust) for trust in self.trusts]

    def _clusters(self, votes: Sequence[front_back_test.Vote]) -> list[tuple[Cluster, float]]:
        """Clusters that are sources, each with its votes over those that it must hold."""
        weights = np.array([vote.weight for vote in votes])
        weights = weights / weights.mean()
        possible = max(vote.rotation for vote in votes) * (2 if self.rule.trial.both_ways else 1)
        found = k_means(np.array([vote.azimuth for vote in votes]), weights, self.rule.spread**2, self.rule.most)
        held = [cluster.weight / (self.rule.share * possible) for cluster in found]
        return [(cluster, share) for cluster, share in zip(found, held, strict=True) if share >= 1]

    def _sources(self, votes: Sequence[front_back_test.Vote]) -> tuple[SourceEstimate, ...]:
        """Cluster means, the one with the most votes first."""
        clusters = self._clusters(votes)
        total = sum(cluster.weight for cluster, _ in clusters)
        found = [
            SourceEstimate(
                azimuth=wrap(cluster.mean),
                sigma=_sigma(cluster),
                confidence=float(1 / (1 + share**-STEEP)),
                resolved=True,
                weight=cluster.weight / total,
            )
            for cluster, share in clusters
        ]
        return tuple(sorted(found, key=lambda source: -source.weight))

    def _settled(self, votes: Sequence[front_back_test.Vote], rotations: int) -> bool:
        """The stop rule: somebody is there, and K has not changed for two times."""
        if rotations <= UNCHANGED:
            return False
        earlier = [[vote for vote in votes if vote.rotation <= rotations - back] for back in range(UNCHANGED + 1)]
        counts = {len(self._clusters(past)) if past else 0 for past in earlier}
        return len(counts) == 1 and 0 not in counts

    def _unresolved(self, seen: Observation) -> tuple[SourceEstimate, ...]:
        """Every peak of one orientation in front: nothing tells front from back yet."""
        aoas = front_back_test.local_aoas(seen.peaks, self.unit)
        sigmas = self.rule.bandwidth / np.maximum(np.sin(aoas), np.sqrt(self.rule.bandwidth))
        return tuple(
            SourceEstimate(wrap(seen.heading + float(aoa)), float(sigma), 0.5, resolved=False, weight=1 / len(aoas))
            for aoa, sigma in zip(aoas, sigmas, strict=True)
        )


def _sigma(cluster: Cluster) -> float:
    """Standard deviation of a cluster's mean [rad]; a vote alone is trusted within 5 deg."""
    n = len(cluster.members)
    variance = (n * cluster.spread**2 + ALONE**2) / n
    return float(np.hypot(np.sqrt(variance / n), BIAS))
