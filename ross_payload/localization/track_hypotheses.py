"""What is believed of all sources at one time: hypotheses of which have left, and densities of where they went."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from ross_payload.angles import difference, wrap
from ross_payload.interfaces import Real
from ross_payload.localization.room_amplitude import RoomAmplitude
from ross_payload.localization.talker_motion import AZIMUTHS, N_AZIMUTHS, RATES, REST

PEAK = np.radians(30.0)  # to either side of the peak that is averaged [rad]
LEAST = np.radians(0.5)  # standard deviation of what is known best [rad]
SMOOTH = np.radians(3.0)  # of densities before their peak is looked for [rad]
TOLD = 0.02  # weight of a hypothesis from which on it is told as a way in which everybody may be
SECOND = 0.1  # probability beside the highest peak from which on there is a second one
MOST_WAYS = 10
TINY = 1e-12

Members = tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Hypothesis:
    """Which sources have left their places, and what is believed of them."""

    weight: float
    left: dict[int, Real]  # by source: density over rates and azimuths, (n_rates, n_azimuths), summing to 1
    talking: Real  # probability that each source talks, (k,)

    @property
    def members(self) -> Members:
        """The sources that have left."""
        return tuple(sorted(self.left))


@dataclass(frozen=True, eq=False)  # no slots: what is asked for often is kept
class Tracks:
    """What is believed of all sources at one time."""

    hypotheses: tuple[Hypothesis, ...]  # weights sum to 1
    homes: Real  # where each rested, as was told [rad], (k,)
    home_densities: Real  # of that on the grid, (k, n_azimuths)
    rests: Real  # and what was heard since: where each is heard at rest, (k, n_azimuths)
    heading: float  # of the array when it was last heard [rad]
    elevations: Real  # cosines, (k,)
    shares: Real  # of the bins of every band, the last is nobody's, (k + 1, n_bands)
    ages: Real  # since each was heard [s], (k,)
    unit: float  # d / v_p [s]
    wet: bool  # in reverberation
    amplitude: float  # of all delays in this room: reflections draw them to 0 by this factor
    room: RoomAmplitude | None = None  # what is heard of it, as long as it is not known

    @cached_property
    def mixed(self) -> Real:
        """Density of every source over rates and azimuths, (k, n_rates, n_azimuths)."""
        mixed = np.zeros((len(self.homes), len(RATES), N_AZIMUTHS), np.float32)
        for each in self.hypotheses:
            for source in range(len(mixed)):
                if source in each.left:
                    mixed[source] += each.weight * each.left[source]
                else:
                    mixed[source, REST] += each.weight * self.rests[source]
        return mixed

    @cached_property
    def places(self) -> Real:
        """Probability of every azimuth of the grid, (k, n_azimuths)."""
        return np.asarray(self.mixed.sum(axis=1, dtype=float))

    @cached_property
    def azimuths(self) -> Real:
        """Likeliest azimuth of every source [rad], in (-pi, pi]: the mean around the highest peak, (k,)."""
        return _likeliest(self.places)

    @property
    def sigmas(self) -> Real:
        """Root mean square deviation of the azimuth from the likeliest one [rad], other peaks included, (k,)."""
        off = difference(AZIMUTHS, self.azimuths[:, None])
        return np.asarray(np.sqrt((self.places * off**2).sum(axis=1) + LEAST**2))

    @property
    def spreads(self) -> Real:
        """Standard deviation around the likeliest azimuth alone [rad], other peaks left out, (k,)."""
        off = difference(AZIMUTHS, self.azimuths[:, None])
        near = self.places * (np.abs(off) <= PEAK)
        return np.asarray(np.sqrt((near * off**2).sum(axis=1) / (near.sum(axis=1) + TINY) + LEAST**2))

    @property
    def held(self) -> Real:
        """Probability that a source is near its likeliest azimuth, (k,)."""
        near = np.abs(difference(AZIMUTHS, self.azimuths[:, None])) <= PEAK
        return np.asarray((self.places * near).sum(axis=1))

    @property
    def ways(self) -> tuple[Real, Real]:
        """The likeliest ways in which all sources may be: probabilities (n,), summing to 1, and azimuths [rad], (n, k).

        Of a source with two peaks, as on both sides of the axis, either is another way.
        """
        found = []
        for each in self.hypotheses:
            if each.weight < TOLD:
                continue
            options = [
                _peaks(each.left[k].sum(axis=0)) if k in each.left else [(1.0, float(home))]
                for k, home in enumerate(self.homes)
            ]
            found += [
                (each.weight * float(np.prod([odds for odds, _ in way])), [azimuth for _, azimuth in way])
                for way in product(*options)
            ]
        found = sorted(found, key=lambda way: -way[0])[:MOST_WAYS]
        weights = np.array([weight for weight, _ in found])
        return weights / weights.sum(), np.array([azimuths for _, azimuths in found])

    @property
    def rates(self) -> Real:
        """Mean rate of every source around its likeliest azimuth [rad/s], (k,)."""
        near = np.abs(difference(AZIMUTHS, self.azimuths[:, None])) <= PEAK
        found = (self.mixed * near[:, None]).sum(axis=2)
        return np.asarray(found @ RATES / (found.sum(axis=1) + TINY))

    def gone(self, azimuths: Real, by: float, delay: float) -> tuple[Real, float]:
        """Probability that every source, (k,), and that any, is away from an azimuth of its own [rad].

        By more than ``by`` [rad], and so that its delay at this heading differs by more than ``delay`` [d / v_p].
        """
        delays = np.cos(AZIMUTHS - self.heading) - np.cos(azimuths - self.heading)[:, None]
        away = (np.abs(difference(AZIMUTHS, azimuths[:, None])) > by) & (
            np.abs(self.elevations[:, None] * delays) > delay
        )
        each, anybody = np.zeros(len(azimuths)), 0.0
        for hypothesis in self.hypotheses:
            odds = np.array(
                [
                    (hypothesis.left[k].sum(axis=0) if k in hypothesis.left else self.rests[k]) @ away[k]
                    for k in range(len(azimuths))
                ]
            )
            each += hypothesis.weight * odds
            anybody += hypothesis.weight * float(1 - np.prod(1 - odds))
        return each, anybody


def _likeliest(places: Real) -> Real:
    orders = np.arange(N_AZIMUTHS // 2 + 1)
    smooth = np.fft.irfft(np.fft.rfft(places, axis=1) * np.exp(-0.5 * (orders * SMOOTH) ** 2), N_AZIMUTHS, axis=1)
    peaks = AZIMUTHS[smooth.argmax(axis=1)]
    off = difference(AZIMUTHS, peaks[:, None])
    near = places * (np.abs(off) <= PEAK)
    means = (near * off).sum(axis=1) / (near.sum(axis=1) + TINY)
    return np.array([wrap(float(azimuth)) for azimuth in peaks + means])


def _peaks(places: Real) -> list[tuple[float, float]]:
    """One azimuth or two [rad] where somebody may be, each with its probability; ``places`` (n_azimuths,) sums to 1."""
    first = float(_likeliest(places[None])[0])
    other = np.where(np.abs(difference(AZIMUTHS, first)) <= PEAK, 0.0, places)
    beside = float(other.sum())
    if beside < SECOND:
        return [(1.0, first)]
    return [(1 - beside, first), (beside, float(_likeliest(other[None])[0]))]
