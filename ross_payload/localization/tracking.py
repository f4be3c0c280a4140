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

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import i0e

from ross_payload.alignment.predicted_gain import OPEN
from ross_payload.angles import difference, wrap
from ross_payload.dsp.itd import Trust, weighted_itd
from ross_payload.events import Estimate
from ross_payload.interfaces import Complex, Real

PARTICLES = 2500
N_AZIMUTHS = 180
STEP = 2 * np.pi / N_AZIMUTHS  # of the grid on which beliefs are told [rad]
AZIMUTHS = np.arange(N_AZIMUTHS) * STEP  # [rad]
SMOOTH = np.radians(3.0)  # of the beliefs there [rad]
PEAK = np.radians(16.0)  # to either side of the peak that is averaged [rad]
LEAST = np.radians(0.5)  # standard deviation of what is known best [rad]
TINY = 1e-12

DELAYS = np.linspace(-1.0, 1.0, 201)  # [d / v_p]
BUNDLE = np.radians(1.0)  # frames at headings within this are one [rad]


@dataclass(frozen=True, slots=True)
class Motion:
    """How people move, as seen from the array."""

    sets_out: float = 0.04  # who rests begins to walk [1/s]
    stops: float = 0.1  # who walks stops [1/s]
    turns: float = 0.15  # who walks turns back [1/s]
    changes: float = 0.15  # who walks takes any other rate [1/s]
    mirrored: float = 0.01  # who walks did so on the other side of the axis [1/s]
    another: float = 0.3  # of two with one delay it was the other one who set out [1/s]
    one: float = 0.15  # what counts as one delay there [d / v_p]
    anywhere: float = 0.0005  # whoever it is may be anywhere [1/s]: so that what was lost can be found
    slowest: float = np.radians(1.5)  # rate [rad/s]
    fastest: float = np.radians(20.0)  # rate [rad/s]
    steady: float = np.radians(1.0)  # of a rate, per root second [rad/s^1.5]
    sway: float = np.radians(0.4)  # of an azimuth, per root second [rad/s^0.5]
    aside: float = 1.0  # two people are not in one direction [1/s]
    elbows: float = np.radians(10.0)  # nearer than this [rad]


@dataclass(frozen=True, slots=True)
class Hearing:
    """How phases tell of azimuths."""

    trust: Trust = field(default_factory=lambda: Trust(neighbourhood=(1, 3), coherence=0.98))
    low: float = 300.0  # frequencies used [Hz]
    high: float = 8000.0  # [Hz]
    noise: float = 0.25  # standard deviation of a phase at any frequency [rad]
    spread: tuple[float, float] = (0.03, 0.06)  # of a delay, in the open and in reverberation [d / v_p]
    directness: tuple[float, float] = (1.0, 0.98)  # reflections draw delays to 0 by this factor
    share: float = 3.0  # counts by which shares are drawn to those of before
    recent: float = 2.0  # in which shares are forgotten [s]
    talks: float = 1.0  # counts of a source in the frames of one step, from which on it is heard
    count: float = 0.3  # effective counts per unit of weight: neighbouring bins are not independent
    most: int = 300  # bins of one step that are looked at; they count for the others


MOTION = Motion()
HEARING = Hearing()


@dataclass(frozen=True, slots=True)
class FrameStatistics:
    """The trustworthy bins of some frames."""

    seconds: float  # that the frames stand for
    headings: Real  # of the array, bundled [rad], (n_headings,)
    bundle: NDArray[np.intp]  # index of each bin's heading, (n,)
    frequencies: Real  # [Hz], (n,)
    phases: Real  # of microphone 2 against microphone 1 [rad], (n,)
    weights: Real  # effective counts, (n,)


@dataclass(frozen=True, slots=True, eq=False)
class Tracks:
    """What is believed of all sources at one time."""

    azimuths_of: Real  # of every particle [rad], (n_particles, k)
    rates_of: Real  # [rad/s], (n_particles, k)
    homes: Real  # where it rested last [rad], (n_particles, k)
    weights: Real  # of the particles, sum to 1, (n_particles,)
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
        cells = np.round(self.azimuths_of / STEP).astype(int) % N_AZIMUTHS
        counts = np.stack([np.bincount(cell, self.weights, N_AZIMUTHS) for cell in cells.T])
        smooth = np.exp(-0.5 * (np.arange(N_AZIMUTHS // 2 + 1) * SMOOTH) ** 2)
        return np.maximum(np.fft.irfft(np.fft.rfft(counts, axis=1) * smooth, N_AZIMUTHS, axis=1), 0.0)

    @property
    def azimuths(self) -> Real:
        """Likeliest azimuth of every source [rad], in (-pi, pi]: the mean around the highest peak, (k,)."""
        peaks = AZIMUTHS[self.places.argmax(axis=1)]
        off = difference(self.azimuths_of, peaks)
        near = self.weights[:, None] * (np.abs(off) <= PEAK)
        means = (near * off).sum(axis=0) / (near.sum(axis=0) + TINY)
        return np.array([wrap(float(azimuth)) for azimuth in peaks + means])

    @property
    def sigmas(self) -> Real:
        """Root mean square deviation of the azimuth from the likeliest one [rad], other peaks included, (k,)."""
        off = difference(self.azimuths_of, self.azimuths)
        return np.asarray(np.sqrt(self.weights @ off**2 + LEAST**2))

    @property
    def rates(self) -> Real:
        """Mean rate of every source around its likeliest azimuth [rad/s], (k,)."""
        near = self.weights[:, None] * (np.abs(difference(self.azimuths_of, self.azimuths)) <= PEAK)
        return np.asarray((near * self.rates_of).sum(axis=0) / (near.sum(axis=0) + TINY))

    def away(self, azimuths: Real, by: float) -> Real:
        """Probability that every source is more than ``by`` [rad] away from an azimuth of its own [rad], (k,)."""
        return np.asarray(self.weights @ (np.abs(difference(self.azimuths_of, azimuths)) > by))


def begin(estimate: Estimate, spacing: float, speed_of_sound: float, seed: int = 0) -> Tracks:
    """Begin with what an exploration has found: its azimuths and sigmas, and everybody at rest."""
    azimuths = np.array([source.azimuth for source in estimate.sources])
    sigmas = np.maximum([source.sigma for source in estimate.sources], np.radians(0.5))
    k, random = len(azimuths), np.random.default_rng([seed, 0])
    places = azimuths + sigmas * random.standard_normal((PARTICLES, k))
    return Tracks(
        azimuths_of=places,
        rates_of=np.zeros((PARTICLES, k)),
        homes=places,
        weights=np.full(PARTICLES, 1 / PARTICLES),
        steps=0,
        seed=seed,
        heading=0.0,
        elevations=np.cos([source.elevation or 0.0 for source in estimate.sources]),
        shares=np.full(k + 1, 1 / (k + 1)),
        ages=np.zeros(k),
        unit=spacing / speed_of_sound,
        wet=estimate.directness is None or estimate.directness < OPEN,
    )


def statistics(
    spectrogram: Complex,
    frequencies: Real,
    headings: Real,
    noise_psd: Real | None,
    *,
    period: float,
    skip: int = 0,
    still: NDArray[np.bool_] | None = None,
    hearing: Hearing = HEARING,
) -> FrameStatistics:
    """Pick the trustworthy bins of some frames.

    Parameters
    ----------
    spectrogram : (2, n_freqs, n_frames)
        Frames of about 43 ms that overlap by three quarters serve best.
    frequencies : (n_freqs,)
        [Hz].
    headings : (n_frames,)
        Of the array in the middle of every frame [rad].
    noise_psd : (n_freqs,) or None
        E|noise|^2 per bin; None takes a low quantile over these frames.
    period
        Time between frames [s].
    skip
        Frames at the beginning that were told before: they only tell which echoes are still to come.
    still : (n_frames,)
        Frames that count, the others were heard beside a motor; None: all.
    """
    band = (frequencies >= hearing.low) & (frequencies <= hearing.high)
    seconds = max((spectrogram.shape[-1] - skip) * period, 0.0)
    if not seconds or not band.any():
        return silence(seconds)
    noise = None if noise_psd is None else noise_psd[band]
    used = frequencies[band]
    itd, weight = weighted_itd(spectrogram[:, band], used, period, noise, hearing.trust)
    weight = weight[:, skip:] * (used.max() / used)[:, None]  # as precise as its frequency is high: the kernels say so
    weight = weight if still is None else weight * still[skip:]
    chosen = np.flatnonzero(weight > 0)
    every = max(len(chosen) / hearing.most, 1.0)
    chosen = chosen[np.arange(min(len(chosen), hearing.most)) * len(chosen) // max(min(len(chosen), hearing.most), 1)]
    row, frame = np.unravel_index(chosen, weight.shape)
    bundled = np.round(headings[skip:] / BUNDLE).astype(int)
    unique, index = np.unique(bundled, return_inverse=True)
    means = np.array([headings[skip:][bundled == each].mean() for each in unique])
    phases = 2 * np.pi * used[row] * itd[row, frame + skip]
    return FrameStatistics(seconds, means, index[frame], used[row], phases, hearing.count * every * weight[row, frame])


def silence(seconds: float) -> FrameStatistics:
    """Nothing was heard for ``seconds``, or not listened to."""
    none = np.zeros(0)
    return FrameStatistics(seconds, none, np.zeros(0, dtype=np.intp), none, none, none)


def step(tracks: Tracks, heard: FrameStatistics, motion: Motion = MOTION, hearing: Hearing = HEARING) -> Tracks:
    """Return what is believed at the end of some frames: predict, then correct by what was heard in them."""
    if not len(tracks.ages):
        return tracks
    ahead = predict(tracks, heard.seconds, motion)
    return _correct(ahead, heard, hearing) if len(heard.weights) else ahead


def predict(tracks: Tracks, seconds: float, motion: Motion = MOTION) -> Tracks:
    """Return what is believed ``seconds`` later when nothing is heard."""
    random = np.random.default_rng([tracks.seed, tracks.steps + 1])
    azimuths, rates = tracks.azimuths_of, tracks.rates_of
    walks, shape = rates != 0, rates.shape
    draw = random.random(shape)
    fresh = random.uniform(motion.slowest, motion.fastest, shape) * random.choice([-1.0, 1.0], shape)
    slow = random.random(shape) < 0.5  # half of them at less than half the fastest rate
    fresh = np.where(slow, fresh / 2, fresh)
    limits = np.cumsum([motion.stops, motion.turns, motion.changes]) * seconds
    changed = np.select([draw < limit for limit in limits], [np.zeros(shape), -rates, fresh], rates)
    changed = changed + (changed != 0) * motion.steady * np.sqrt(seconds) * random.standard_normal(shape)
    rates = np.where(walks, changed, np.where(draw < motion.sets_out * seconds, fresh, 0.0))
    azimuths = azimuths + rates * seconds + motion.sway * np.sqrt(seconds) * random.standard_normal(shape)
    draw = random.random(shape)
    flipped = (draw < motion.mirrored * seconds) & (rates != 0)
    azimuths, rates = np.where(flipped, 2 * tracks.heading - azimuths, azimuths), np.where(flipped, -rates, rates)
    homes = np.where((rates == 0) & walks, azimuths, tracks.homes)
    azimuths, rates = _another(tracks.heading, azimuths, rates, homes, random.random(len(azimuths)), motion, seconds)
    lost = draw > 1 - motion.anywhere * seconds
    azimuths = np.where(lost, random.uniform(-np.pi, np.pi, shape), azimuths)
    apart = np.abs(difference(azimuths[:, :, None], azimuths[:, None]))
    close = (apart < motion.elbows).sum(axis=(1, 2)) - shape[1]
    weights = tracks.weights * np.exp(-0.5 * motion.aside * seconds * close)
    return replace(
        tracks,
        azimuths_of=azimuths,
        rates_of=rates,
        homes=homes,
        weights=weights / weights.sum(),
        steps=tracks.steps + 1,
        ages=tracks.ages + seconds,
    )


def _another(
    heading: float, azimuths: Real, rates: Real, homes: Real, draw: Real, motion: Motion, seconds: float
) -> tuple[Real, Real]:
    """Let another source have set out instead: one that rests and whose home has the same delay.

    It is where the mirror image of the first one is, or where that one is itself when their homes are on one side; the
    first one is at home. What is heard at this heading does not tell the two apart.
    """
    azimuths, rates, k = azimuths.copy(), rates.copy(), rates.shape[1]
    delays = np.cos(homes - heading)
    pairs = [(i, j) for i in range(k) for j in range(k) if i != j]
    drawn = draw / max(motion.another * seconds, TINY) * max(len(pairs), 1)
    for number, (walker, other) in enumerate(pairs):
        meant = (drawn >= number) & (drawn < number + 1)
        meant &= (rates[:, walker] != 0) & (rates[:, other] == 0)
        meant &= np.abs(delays[:, walker] - delays[:, other]) < motion.one
        same = np.sin(homes[:, walker] - heading) * np.sin(homes[:, other] - heading) > 0
        mirrored = np.where(same, azimuths[:, walker], 2 * heading - azimuths[:, walker])
        rate = np.where(same, rates[:, walker], -rates[:, walker])
        azimuths[:, other] = np.where(meant, mirrored, azimuths[:, other])
        rates[:, other] = np.where(meant, rate, rates[:, other])
        azimuths[:, walker] = np.where(meant, homes[:, walker], azimuths[:, walker])
        rates[:, walker] = np.where(meant, 0.0, rates[:, walker])
    return azimuths, rates


def _correct(tracks: Tracks, heard: FrameStatistics, hearing: Hearing) -> Tracks:
    likelihood, counts = _likelihood(tracks, heard, hearing), heard.weights  # (n, n_delays)
    log_weights = np.log(tracks.weights + TINY)
    cells = [_cells(tracks, heading, hearing) for heading in heard.headings]  # (n_particles, k) each
    marginal = np.empty((len(tracks.ages) + 1, len(counts)))
    marginal[-1] = 1 / (2 * np.pi)
    bundles = [np.flatnonzero(heard.bundle == index) for index in range(len(cells))]
    for cell, bins in zip(cells, bundles, strict=True):
        place = np.stack([np.bincount(each, tracks.weights, len(DELAYS)) for each in cell.T])
        marginal[:-1, bins] = place @ likelihood[bins].T
    shares = _shares(tracks.shares, marginal, counts, hearing.share)
    for cell, bins in zip(cells, bundles, strict=True):
        table = likelihood[bins].T  # (n_delays, n)
        mixed = sum(share * table[each] for share, each in zip(shares, cell.T, strict=False))
        log_weights += np.log(mixed + shares[-1] / (2 * np.pi)) @ counts[bins]
    weights = _tempered(log_weights)
    total = shares @ marginal + TINY
    talks = (shares[:-1, None] * marginal[:-1] / total) @ counts >= hearing.talks
    keep = np.exp(-heard.seconds / hearing.recent)
    mixed_shares = keep * tracks.shares + (1 - keep) * shares + 0.01 / len(shares)
    after = replace(
        tracks,
        weights=weights,
        shares=mixed_shares / mixed_shares.sum(),
        ages=np.where(talks, 0.0, tracks.ages),
        heading=float(heard.headings[-1]),
    )
    return _resampled(after)


def _tempered(log_weights: Real) -> Real:
    """Weights that sum to 1, flattened until a twentieth of the particles count: nothing is decided in one step."""
    for _ in range(8):
        weights = np.exp(log_weights - log_weights.max())
        weights /= weights.sum()
        if 1 / (weights**2).sum() >= len(weights) / 20:
            break
        log_weights = log_weights / 1.5
    return np.asarray(weights)


def _resampled(tracks: Tracks) -> Tracks:
    n = len(tracks.weights)
    if 1 / (tracks.weights**2).sum() > n / 2:
        return tracks
    offset = np.random.default_rng([tracks.seed, tracks.steps, 1]).random()
    chosen = np.searchsorted(np.cumsum(tracks.weights), (np.arange(n) + offset) / n).clip(max=n - 1)
    return replace(
        tracks,
        azimuths_of=tracks.azimuths_of[chosen],
        rates_of=tracks.rates_of[chosen],
        homes=tracks.homes[chosen],
        weights=np.full(n, 1 / n),
    )


def _likelihood(tracks: Tracks, heard: FrameStatistics, hearing: Hearing) -> Real:
    """Probability density of every phase for every delay of the grid, von Mises, (n, n_delays)."""
    turned = 2 * np.pi * tracks.unit * heard.frequencies
    variance = hearing.noise**2 + (turned * hearing.spread[tracks.wet]) ** 2
    kappa = (1 / variance)[:, None]
    off = np.cos(heard.phases[:, None] - turned[:, None] * DELAYS) - 1
    return np.asarray(np.exp(kappa * off) / (2 * np.pi * i0e(kappa)))


def _cells(tracks: Tracks, heading: float, hearing: Hearing) -> NDArray[np.intp]:
    """Delay of every source of every particle, as an index into the grid, (n_particles, k)."""
    delay = hearing.directness[tracks.wet] * tracks.elevations * np.cos(tracks.azimuths_of - heading)
    return np.asarray(np.round((delay + 1) / (DELAYS[1] - DELAYS[0])), dtype=np.intp)


def _shares(before: Real, marginal: Real, counts: Real, drawn: float) -> Real:
    """Share of every source and of nobody in these frames, (k + 1,)."""
    shares = before
    for _ in range(8):
        joint = shares[:, None] * marginal
        shares = (joint / (joint.sum(axis=0) + TINY)) @ counts + drawn * before
        shares = shares / shares.sum()
    return shares
