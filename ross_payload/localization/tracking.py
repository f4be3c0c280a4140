"""Track the azimuths of sources from frame to frame: a particle filter over all sources together.

A particle says where every source is and how fast it moves. That is more than a Kalman filter can hold: two microphones
hear only ``cos(azimuth - heading)``, so a source that walks past the axis of the array may have gone on or turned back;
and when one of two sources with one delay sets out, it may be either. What is possible stays so until the array turns
or the walk tells.

*Prediction.* A source rests, sets out, keeps its rate, turns back, stops. Who is silent spreads.

*Correction.* The phases between the microphones in trustworthy bins are a mixture: of every source von Mises around
``2 pi f tau`` with ``tau = (d / v_p) a cos(azimuth - heading)``, also above the frequency where that wraps, and of
nobody evenly spread. The share of every source in these frames is found by expectation maximisation under what is
predicted. A particle is weighed by how well the mixture explains the phases with all sources where it has them: what
somebody else explains does not draw a source away. Systematic resampling (Kitagawa 1996) follows when few are left.

Random numbers follow from the seed and the number of steps: the same frames give the same tracks.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import i0e

from ross_payload.alignment.predicted_gain import OPEN
from ross_payload.angles import difference, wrap
from ross_payload.events import Estimate
from ross_payload.interfaces import Real
from ross_payload.localization.phase_statistics import HEARING, FrameStatistics, Hearing
from ross_payload.localization.talker_motion import MOTION, Motion, Particles, moved

PARTICLES = 2500
N_AZIMUTHS = 180
STEP = 2 * np.pi / N_AZIMUTHS  # of the grid on which beliefs are told [rad]
AZIMUTHS = np.arange(N_AZIMUTHS) * STEP  # [rad]
SMOOTH = np.radians(3.0)  # of the beliefs there [rad]
PEAK = np.radians(16.0)  # to either side of the peak that is averaged [rad]
LEAST = np.radians(0.5)  # standard deviation of what is known best [rad]
TINY = 1e-12

DELAYS = np.linspace(-1.0, 1.0, 201)  # [d / v_p]


@dataclass(frozen=True, slots=True, eq=False)
class Tracks:
    """What is believed of all sources at one time."""

    particles: Particles
    steps: int  # so far
    seed: int
    heading: float  # of the array when it was last heard [rad]
    elevations: Real  # cosines, (k,)
    shares: Real  # of the bins, the last is nobody's, (k + 1,)
    ages: Real  # since each was heard [s], (k,)
    unit: float  # d / v_p [s]
    wet: bool  # in reverberation

    @property
    def places(self) -> Real:
        """Probability of every azimuth of the grid, smoothed, (k, n_azimuths)."""
        cells = np.round(self.particles.azimuths / STEP).astype(int) % N_AZIMUTHS
        counts = np.zeros((cells.shape[1], N_AZIMUTHS))
        for source, cell in enumerate(cells.T):
            counts[source] = np.bincount(cell, self.particles.weights, N_AZIMUTHS)
        smooth = np.exp(-0.5 * (np.arange(N_AZIMUTHS // 2 + 1) * SMOOTH) ** 2)
        return np.maximum(np.fft.irfft(np.fft.rfft(counts, axis=1) * smooth, N_AZIMUTHS, axis=1), 0.0)

    @property
    def azimuths(self) -> Real:
        """Likeliest azimuth of every source [rad], in (-pi, pi]: the mean around the highest peak, (k,)."""
        peaks = AZIMUTHS[self.places.argmax(axis=1)]
        off = difference(self.particles.azimuths, peaks)
        near = self.particles.weights[:, None] * (np.abs(off) <= PEAK)
        means = (near * off).sum(axis=0) / (near.sum(axis=0) + TINY)
        return np.array([wrap(float(azimuth)) for azimuth in peaks + means])

    @property
    def sigmas(self) -> Real:
        """Root mean square deviation of the azimuth from the likeliest one [rad], other peaks included, (k,)."""
        off = difference(self.particles.azimuths, self.azimuths)
        return np.asarray(np.sqrt(self.particles.weights @ off**2 + LEAST**2))

    @property
    def rates(self) -> Real:
        """Mean rate of every source around its likeliest azimuth [rad/s], (k,)."""
        near = self.particles.weights[:, None] * (np.abs(difference(self.particles.azimuths, self.azimuths)) <= PEAK)
        return np.asarray((near * self.particles.rates).sum(axis=0) / (near.sum(axis=0) + TINY))

    def gone(self, azimuths: Real, by: float, heard: float) -> NDArray[np.bool_]:
        """Which particle has which source away from an azimuth of its own [rad], (n_particles, k).

        By more than ``by`` [rad], and so that its delay at this heading differs by more than ``heard`` [d / v_p].
        """
        places = self.particles.azimuths
        delays = np.cos(places - self.heading) - np.cos(azimuths - self.heading)
        return np.asarray(
            (np.abs(difference(places, azimuths)) > by) & (np.abs(self.elevations * delays) > heard), dtype=np.bool_
        )


def begin(estimate: Estimate, spacing: float, speed_of_sound: float, seed: int = 0) -> Tracks:
    """Begin with what an exploration has found: its azimuths and sigmas, and everybody at rest."""
    azimuths = np.array([source.azimuth for source in estimate.sources])
    sigmas = np.maximum([source.sigma for source in estimate.sources], np.radians(0.5))
    k, random = len(azimuths), np.random.default_rng([seed, 0])
    places = azimuths + sigmas * random.standard_normal((PARTICLES, k))
    return Tracks(
        particles=Particles(places, np.zeros((PARTICLES, k)), places, np.full(PARTICLES, 1 / PARTICLES)),
        steps=0,
        seed=seed,
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
    random = np.random.default_rng([tracks.seed, tracks.steps + 1])
    particles = moved(tracks.particles, seconds, tracks.heading, random, motion)
    return replace(tracks, particles=particles, steps=tracks.steps + 1, ages=tracks.ages + seconds)


def _correct(tracks: Tracks, heard: FrameStatistics, hearing: Hearing) -> Tracks:
    likelihood, counts = _likelihood(tracks, heard, hearing), heard.weights  # (n, n_delays)
    log_weights = np.log(tracks.particles.weights + TINY)
    cells = [_cells(tracks, heading, hearing) for heading in heard.headings]  # (n_particles, k) each
    marginal = np.empty((len(tracks.ages) + 1, len(counts)))
    marginal[-1] = 1 / (2 * np.pi)
    bundles = [np.flatnonzero(heard.bundle == index) for index in range(len(cells))]
    for cell, bins in zip(cells, bundles, strict=True):
        place = np.stack([np.bincount(each, tracks.particles.weights, len(DELAYS)) for each in cell.T])
        marginal[:-1, bins] = place @ likelihood[bins].T
    shares = _shares(tracks.shares, marginal, counts, hearing.share)
    for cell, bins in zip(cells, bundles, strict=True):
        table = likelihood[bins].T  # (n_delays, n)
        mixed = sum(share * table[each] for share, each in zip(shares, cell.T, strict=False))
        log_weights += np.log(mixed + shares[-1] / (2 * np.pi)) @ counts[bins]
    weights = _tempered(log_weights)
    total = shares @ marginal + TINY
    own = shares[:-1, None] * marginal[:-1] / total
    talks = -np.log1p(-np.minimum(own, 1 - TINY)) @ counts >= hearing.talks
    keep = np.exp(-heard.seconds / hearing.recent)
    mixed_shares = keep * tracks.shares + (1 - keep) * shares + 0.01 / len(shares)
    after = replace(
        tracks,
        particles=replace(tracks.particles, weights=weights),
        shares=mixed_shares / mixed_shares.sum(),
        ages=np.where(talks, 0.0, tracks.ages),
        heading=float(heard.headings[-1]),
    )
    return _resampled(after, talks)


def _tempered(log_weights: Real) -> Real:
    """Weights that sum to 1, flattened until a twentieth of the particles count: nothing is decided in one step."""
    for _ in range(8):
        weights = np.exp(log_weights - log_weights.max())
        weights /= weights.sum()
        if 1 / (weights**2).sum() >= len(weights) / 20:
            break
        log_weights = log_weights / 1.5
    return np.asarray(weights)


def _resampled(tracks: Tracks, talks: NDArray[np.bool_]) -> Tracks:
    """Draw particles by their weights; what is possible of a source that says nothing is not thinned out."""
    particles = tracks.particles
    n = len(particles.weights)
    if 1 / (particles.weights**2).sum() > n / 2:
        return tracks
    offset = np.random.default_rng([tracks.seed, tracks.steps, 1]).random()
    chosen = np.searchsorted(np.cumsum(particles.weights), (np.arange(n) + offset) / n).clip(max=n - 1)
    kept = Particles(particles.azimuths[chosen], particles.rates[chosen], particles.homes[chosen], np.full(n, 1 / n))
    return replace(tracks, particles=kept)


def _likelihood(tracks: Tracks, heard: FrameStatistics, hearing: Hearing) -> Real:
    """Probability density of every phase for every delay of the grid, von Mises, (n, n_delays)."""
    turned = 2 * np.pi * tracks.unit * heard.frequencies
    variance = hearing.noise**2 + (turned * hearing.spread[tracks.wet]) ** 2
    kappa = (1 / variance)[:, None]
    off = np.cos(heard.phases[:, None] - turned[:, None] * DELAYS) - 1
    return np.asarray(np.exp(kappa * off) / (2 * np.pi * i0e(kappa)))


def _cells(tracks: Tracks, heading: float, hearing: Hearing) -> NDArray[np.intp]:
    """Delay of every source of every particle, as an index into the grid, (n_particles, k)."""
    delay = hearing.directness[tracks.wet] * tracks.elevations * np.cos(tracks.particles.azimuths - heading)
    return np.asarray(np.round((delay + 1) / (DELAYS[1] - DELAYS[0])), dtype=np.intp)


def _shares(before: Real, marginal: Real, counts: Real, drawn: float) -> Real:
    """Share of every source and of nobody in these frames, (k + 1,)."""
    shares = before
    for _ in range(8):
        joint = shares[:, None] * marginal
        shares = (joint / (joint.sum(axis=0) + TINY)) @ counts + drawn * before
        shares = shares / shares.sum()
    return shares
