"""All orientations at once: K and every azimuth from the ITD densities at all headings (`joint`).

Histograms of trustworthy ITDs (`itd`) are explained as one mixture over all orientations (`mixture`): sources are
added where the likelihood gains most, refined by expectation maximisation, and taken away again while the likelihood
loses less than a ghost would gain by chance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ross_payload.angles import difference, wrap
from ross_payload.dsp import mixture
from ross_payload.dsp.density import histogram, itd_grid, kde, prominent_peaks
from ross_payload.dsp.itd import Trust, band_limits, weighted_itd
from ross_payload.errors import ConfigError
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.interfaces import Complex, Observation, Real

MAX_SOURCES = 6
GRID = np.deg2rad(np.arange(-180.0, 180.0, 4.0))  # azimuths tried [rad]


@dataclass(frozen=True, slots=True)
class Tuning:
    """The few numbers that decide how many sources there are."""

    count: float = 0.5  # effective counts per unit of weight: neighbouring bins are not independent
    width: float = 0.1  # kernel of a new source [d / v_p]
    bandwidth: float = 0.04  # of the published density [d / v_p]
    base: float = 8.0  # log-likelihood that a source must be worth [nat]
    share: float = 0.03  # and this much per effective count [nat]
    apart: float = np.deg2rad(15.0)  # nearer than this two sources are one


@dataclass(frozen=True, slots=True)
class Joint:
    """The explorer; see `mixture` for the model."""

    spacing: float
    speed_of_sound: float
    overlap: float = 0.75
    trust: Trust = field(default_factory=Trust)
    tuning: Tuning = field(default_factory=Tuning)
    name: str = "joint"

    def observe(self, spectrogram: Complex, frequencies: Real, heading: float, noise_psd: Real | None) -> Observation:
        """Condense one orientation into a histogram of trustworthy ITDs; see `interfaces.Explorer`."""
        grid = itd_grid(self.spacing, self.speed_of_sound)
        low, high = band_limits(self.spacing, self.speed_of_sound)
        band = (frequencies >= low) & (frequencies <= high)
        frame_period = (1 - self.overlap) / (frequencies[1] - frequencies[0])
        noise = None if noise_psd is None else noise_psd[band]
        itd, weight = weighted_itd(spectrogram[:, band], frequencies[band], frame_period, noise, self.trust)
        counts = histogram(itd, weight, grid)
        density = kde(counts, grid, self.tuning.bandwidth * self.spacing / self.speed_of_sound)
        return Observation(heading, grid, density, float(counts.sum()), prominent_peaks(density, grid), counts)

    def estimate(self, observations: Sequence[Observation]) -> Estimate:
        """Estimate K and all azimuths from every orientation heard so far; see `interfaces.Explorer`."""
        if not observations:
            return Estimate(())
        data = self.data(observations)
        model = self.fit(data)
        return Estimate(self._sources(data, model), directness=model.directness if len(model.azimuths) else None)

    def data(self, observations: Sequence[Observation]) -> mixture.Data:
        """Histograms of all orientations with ITDs in units of d / v_p."""
        counts = np.stack([observation.features for observation in observations]) * self.tuning.count
        headings = np.array([observation.heading for observation in observations])
        return mixture.Data(observations[0].grid * self.speed_of_sound / self.spacing, headings, counts)

    def fit(self, data: mixture.Data) -> mixture.Mixture:
        """Add sources, then take away those that explain too little."""
        model = mixture.Mixture(np.zeros(0), np.zeros(0), np.ones((len(data.headings), 1)))
        for _ in range(MAX_SOURCES + 2):
            gain, share = mixture.gains(data, model, GRID, self.tuning.width)
            best = int(gain.argmax())
            if gain[best] < self.tuning.base / 2:
                break
            added = mixture.add(model, GRID[best], self.tuning.width, np.maximum(share[:, best], 0.01))
            model = mixture.refine(data, added, 8)
        return self._prune(data, mixture.refine(data, model, 20))

    def _prune(self, data: mixture.Data, model: mixture.Mixture) -> mixture.Mixture:
        worth = self.tuning.base + self.tuning.share * data.counts.sum()
        while len(model.azimuths):
            losses, reduced = self.losses(data, model)
            least = int(losses.argmin())
            if losses[least] >= worth and len(model.azimuths) <= MAX_SOURCES and not self._close(model):
                break
            model = mixture.refine(data, reduced[least], 10)
        return model

    def _close(self, model: mixture.Mixture) -> bool:
        apart = np.abs(difference(model.azimuths[:, None], model.azimuths)) + 9 * np.eye(len(model.azimuths))
        return bool(apart.min() < self.tuning.apart)

    def losses(self, data: mixture.Data, model: mixture.Mixture) -> tuple[Real, list[mixture.Mixture]]:
        """Log-likelihood [nat] that each source is worth, and the models without it."""
        reduced = [mixture.refine(data, mixture.remove(model, k), 5) for k in range(len(model.azimuths))]
        full = mixture.log_likelihood(data, model)
        return np.array([full - mixture.log_likelihood(data, other) for other in reduced]), reduced

    def _sources(self, data: mixture.Data, model: mixture.Mixture) -> tuple[SourceEstimate, ...]:
        sigmas = mixture.sigmas(data, model)
        weights = np.average(model.weights, axis=0, weights=data.counts.sum(axis=1) + 1e-9)
        found = [
            SourceEstimate(wrap(float(azimuth)), float(min(sigma, np.pi)), 1.0, True, float(weight))
            for azimuth, sigma, weight in zip(model.azimuths, sigmas, weights[:-1], strict=True)
        ]
        return tuple(sorted(found, key=lambda source: -source.weight))


@dataclass(frozen=True, slots=True)
class Factory:
    """Makes explorers; the object behind the entry point ``joint``."""

    name: str = "joint"

    def make(self, spacing: float, speed_of_sound: float) -> Joint:
        """Make an explorer for an array; frames overlap by three quarters.

        Raises
        ------
        ConfigError
            When a number is not positive and finite.
        """
        for what, value in (("spacing", spacing), ("speed of sound", speed_of_sound)):
            if not 0 < value < np.inf:
                raise ConfigError(f"{what} = {value:g}: a positive number is wanted")
        return Joint(spacing, speed_of_sound)


explorer = Factory()
