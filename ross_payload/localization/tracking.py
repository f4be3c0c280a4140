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
somebody else explains does not draw a source away. Where exactly somebody rests tells nothing of who walks: all
particles that have a source at rest share one likelihood for it (Rao-Blackwellisation), and its place is drawn anew
by itself. Otherwise chance in what a loud source says would select among the few particles that have a quiet one
walk. Systematic resampling (Kitagawa 1996) follows when few are left, by the roots of the weights.

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
PEAK = np.radians(30.0)  # to either side of the peak that is averaged [rad]
LEAST = np.radians(0.5)  # standard deviation of what is known best [rad]
FEWEST = 1 / 200  # share of the particles that counts after a step at least
TINY = 1e-12

N_RESTS = 120
REST = 2 * np.pi / N_RESTS  # who rests is within one and a half of these [rad]
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
    particles, resting = tracks.particles, _resting(tracks.particles)
    cells = [_cells(tracks, heading, hearing) for heading in heard.headings]  # (n_particles, k) each
    bundles = [np.flatnonzero(heard.bundle == index) for index in range(len(cells))]
    marginal = np.empty((len(tracks.ages) + 1, len(counts)))
    rested = np.empty((len(tracks.ages), len(counts)))
    marginal[-1] = 1 / (2 * np.pi)
    for cell, bins in zip(cells, bundles, strict=True):
        marginal[:-1, bins] = _places(cell, particles.weights) @ likelihood[bins].T
        rested[:, bins] = _places(cell, particles.weights[:, None] * resting + TINY) @ likelihood[bins].T
    shares = _shares(tracks.shares, marginal, counts, hearing.share)
    log_weights = np.log(particles.weights + TINY)
    alone = np.zeros(resting.shape)
    total = shares @ marginal + TINY
    for cell, bins in zip(cells, bundles, strict=True):
        table = np.concatenate([likelihood[bins].T[None].repeat(len(rested), 0), rested[:, None, bins]], axis=1)
        log_weights += _explained(np.where(resting, len(DELAYS), cell), table, shares) @ counts[bins]
        for k, share in enumerate(shares[:-1]):
            others = total[bins] - share * marginal[k, bins]
            alone[:, k] += (np.log(share * likelihood[bins].T + others) @ counts[bins])[cell[:, k]]
    weights = _tempered(log_weights)
    own = shares[:-1, None] * marginal[:-1] / total
    talks = -np.log1p(-np.minimum(own, 1 - TINY)) @ counts >= hearing.talks
    keep = np.exp(-heard.seconds / hearing.recent)
    mixed_shares = keep * tracks.shares + (1 - keep) * shares + 0.01 / len(shares)
    random = np.random.default_rng([tracks.seed, tracks.steps, 1])
    settled = _settled(replace(particles, weights=weights), resting, alone, random)
    return replace(
        tracks,
        particles=_resampled(settled, random),
        shares=mixed_shares / mixed_shares.sum(),
        ages=np.where(talks, 0.0, tracks.ages),
        heading=float(heard.headings[-1]),
    )


def _places(cells: NDArray[np.intp], weights: Real) -> Real:
    """Probability of every delay for every source, (k, n_delays)."""
    each = np.broadcast_to(weights.reshape(len(cells), -1), cells.shape)
    found = np.stack([np.bincount(cell, one, len(DELAYS)) for cell, one in zip(cells.T, each.T, strict=True)])
    return np.asarray(found / found.sum(axis=1, keepdims=True))


def _resting(particles: Particles) -> NDArray[np.bool_]:
    """Which particle has which source at rest where it mostly rests, (n_particles, k)."""
    still = particles.rates == 0
    cells = np.round(particles.azimuths / REST).astype(int) % N_RESTS
    found = np.zeros(still.shape, dtype=np.bool_)
    for k, cell in enumerate(cells.T):
        counts = np.bincount(cell, particles.weights * still[:, k], N_RESTS)
        peak = (counts + np.roll(counts, 1) + np.roll(counts, -1)).argmax()
        found[:, k] = still[:, k] & (np.abs(difference(particles.azimuths[:, k], peak * REST)) <= 1.5 * REST)
    return found


def _explained(cells: NDArray[np.intp], table: Real, shares: Real) -> Real:
    """Log-likelihood of every bin for every particle, (n_particles, n): computed once for those that are alike.

    ``table`` (k, n_delays + 1, n) has the likelihood of every delay, and of being at rest at the end.
    """
    alike = np.zeros(len(cells), dtype=np.intp)
    for cell in cells.T:
        alike = np.unique(alike * table.shape[1] + cell, return_inverse=True)[1]
    first = np.unique(alike, return_index=True)[1]
    mixed = sum(share * rows[each] for share, rows, each in zip(shares, table, cells[first].T, strict=False))
    return np.asarray(np.log(mixed + shares[-1] / (2 * np.pi))[alike])


def _settled(particles: Particles, resting: NDArray[np.bool_], alone: Real, random: np.random.Generator) -> Particles:
    """Draw anew where those are who rest, every source by itself: their places tell nothing of who walks.

    ``alone`` (n_particles, k) is the log-likelihood of the place of one source, the others being anywhere.
    """
    azimuths, homes = particles.azimuths.copy(), particles.homes.copy()
    for k, still in enumerate(resting.T):
        of = np.flatnonzero(still)
        if not len(of):
            continue
        chosen = of[_drawn(_tempered(np.log(particles.weights[of] + TINY) + alone[of, k]), random)]
        random.shuffle(chosen)
        azimuths[of, k], homes[of, k] = azimuths[chosen, k], homes[chosen, k]
    return replace(particles, azimuths=azimuths, homes=homes)


def _drawn(weights: Real, random: np.random.Generator) -> NDArray[np.intp]:
    """Indices by systematic sampling, (n,)."""
    n = len(weights)
    return np.searchsorted(np.cumsum(weights), (np.arange(n) + random.random()) / n).clip(max=n - 1)


def _tempered(log_weights: Real) -> Real:
    """Weights that sum to 1, flattened until at least a few particles count: nothing is decided by one."""
    for _ in range(8):
        weights = np.exp(log_weights - log_weights.max())
        weights /= weights.sum()
        if 1 / (weights**2).sum() >= len(weights) * FEWEST:
            break
        log_weights = log_weights / 1.5
    return np.asarray(weights)


def _resampled(particles: Particles, random: np.random.Generator) -> Particles:
    """Draw particles by the root of their weights, so that what is unlikely now is not soon forgotten."""
    weights = particles.weights
    if 1 / (weights**2).sum() > len(weights) / 2:
        return particles
    root = np.sqrt(weights) / np.sqrt(weights).sum()
    chosen = _drawn(root, random)
    left = weights[chosen] / root[chosen]
    return Particles(particles.azimuths[chosen], particles.rates[chosen], particles.homes[chosen], left / left.sum())


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
