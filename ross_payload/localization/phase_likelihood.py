"""How likely the phases of some bins are for a source at every azimuth, and for nobody.

A bin that one source has for itself has the phase ``2 pi f tau`` with ``tau = (d / v_p) a cos(azimuth - heading)``,
also above the frequency where that wraps, and an error whose standard deviation grows with the root of the frequency.

Talkers share bins. Where another source has a part ``u`` of the power, the expected cross-spectrum is
``(1 - u) exp(j phi) + u exp(j phi')``. Below 2 kHz the phases of two sources at microphones 5 cm apart are so near that
such a bin is as coherent as any other, and its delay lies a part ``u`` of the way to the other source. A quiet talker
with a low voice has few other bins: without this it seems to be where nobody is. How often bins are shared, and the
errors, were chosen on simulated rooms with recorded voices (decision 112).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import i0e

from ross_payload.interfaces import Real
from ross_payload.localization.phase_statistics import FrameStatistics, Hearing
from ross_payload.localization.talker_motion import AZIMUTHS

N_DELAYS = 101
DELAYS = np.linspace(-1.0, 1.0, N_DELAYS)  # [d / v_p]
PARTS = np.array([0.06, 0.17, 0.38])  # of the power that another source has in a bin, as often as SHARED says
BELOW = np.array([450.0, 700.0, 1000.0, 2000.0])  # [Hz], up to which frequencies the rows of SHARED hold
SHARED = np.array([[0.18, 0.15, 0.14], [0.16, 0.12, 0.09], [0.14, 0.085, 0.065], [0.125, 0.065, 0.05]])
BANDS = np.array([700.0, 1400.0, 2800.0])  # between the bands in which every source has shares of its own [Hz]
N_BANDS = len(BANDS) + 1
GROUP = 8  # bins whose densities are multiplied before the logarithm
ROUNDS = 8  # of expectation maximisation
TINY = 1e-12
LEAST = np.float32(1e-4)  # density: no bin speaks against anything by more than nine nats
ANYWHERE = 0.5  # share of what is from nobody that has a delay at least: an echo
PLANE = 0.97  # amplitude of the delays in a plane with echoes, for which errors and thresholds were chosen


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """What is known of the sources before the frames are heard."""

    unit: float  # d / v_p [s]
    azimuths: Real  # likeliest ones [rad], (k,)
    elevations: Real  # their cosines, (k,)
    shares: Real  # of the bins, (k,)
    wet: bool  # in reverberation
    amplitude: float  # of all delays in this room: reflections draw them to 0 by this factor


@dataclass(frozen=True, slots=True, eq=False)
class Likelihood:
    """What some frames say: density of every bin's phase for every azimuth of every source.

    Azimuths with one delay at every heading of these frames are told apart by nothing, and are one case. The number of
    bins is a multiple of `GROUP`; they count alike.
    """

    density: tuple[Real, ...]  # by source, (n, n_cases)
    case: tuple[NDArray[np.intp], ...]  # by source: which of them an azimuth is, (n_azimuths,)
    nobody: Real  # density of every bin's phase for what is from no source, (n,)
    band: NDArray[np.intp]  # of every bin, (n,)
    count: float  # effective, of every bin

    def marginal(self, source: int, places: Real) -> Real:
        """Density of every bin's phase for a source that is believed to be somewhere, (n,)."""
        density, case = self.density[source], self.case[source]
        return np.asarray(density @ np.bincount(case, places, density.shape[1]).astype(np.float32))

    def log(self, densities: Real) -> Real:
        """Log-likelihood of all bins, (..., n, n_cases) -> (..., n_cases)."""
        *more, n, cases = densities.shape
        grouped = np.maximum(densities, LEAST).reshape(*more, GROUP, n // GROUP, cases)
        return np.asarray(self.count * np.log(np.multiply.reduce(grouped, axis=-3)).sum(axis=-2))

    def shares(self, before: Real, marginal: Real, drawn: float) -> Real:
        """Share of every source and of nobody in the bins of every band, (n_hypotheses, k + 1, n_bands).

        Parameters
        ----------
        before
            Shares that are expected, (k + 1, n_bands).
        marginal
            Density of every bin's phase, (n_hypotheses, k + 1, n).
        drawn
            Counts by which shares are drawn to those of before.
        """
        counts = self.count * (self.band[:, None] == np.arange(N_BANDS)).astype(np.float32)
        prior = (drawn * before).astype(np.float32)
        shares = np.repeat(before.astype(np.float32)[None], len(marginal), axis=0)
        for _ in range(ROUNDS):
            joint = shares[..., self.band] * marginal
            shares = (joint / (joint.sum(axis=1, keepdims=True) + TINY)) @ counts + prior
            shares = shares / shares.sum(axis=1, keepdims=True)
        return shares


def excess(amplitude: float) -> float:
    """By how much more reflections draw delays to 0 than in a plane."""
    return max(PLANE - amplitude, 0.0)


def likelihood(statistics: FrameStatistics, scene: Scene, hearing: Hearing) -> Likelihood:
    """How likely the phases are for all azimuths of all sources."""
    statistics, tables, found = _looked_at(statistics, scene, hearing)
    cells: dict[float, tuple[NDArray[np.intp], NDArray[np.intp]]] = {}
    density, case = [], []
    for elevation, table in zip(scene.elevations.tolist(), tables, strict=True):
        if elevation not in cells:
            delays = scene.amplitude * elevation * np.cos(AZIMUTHS - statistics.headings[:, None])
            unique, index = np.unique(_nearest(delays), axis=1, return_inverse=True)
            cells[elevation] = unique, index.reshape(-1)
        unique, index = cells[elevation]
        density.append(np.take_along_axis(table, unique[statistics.bundle], axis=1))
        case.append(index)
    return replace(found, density=tuple(density), case=tuple(case))


def at_rest(statistics: FrameStatistics, scene: Scene, amplitudes: Real, hearing: Hearing) -> tuple[Likelihood, Real]:
    """How likely the phases are if every source is where the scene has it, for several amplitudes of all delays.

    Errors, and how sources share bins, are those for the amplitude of the scene.

    Returns
    -------
    tuple
        A likelihood that knows no azimuths, and the density of every bin's phase, (n_amplitudes, k + 1, n).
    """
    statistics, tables, found = _looked_at(statistics, scene, hearing)
    delays = scene.elevations[:, None] * np.cos(scene.azimuths[:, None] - statistics.headings[statistics.bundle])
    cells, bins = _nearest(amplitudes[:, None, None] * delays), np.arange(len(statistics.phases))
    own = [table[bins, cells[:, source]] for source, table in enumerate(tables)]
    nobody = np.broadcast_to(found.nobody, (len(amplitudes), len(bins)))
    return found, np.stack([*own, nobody], axis=1)


def _nearest(delays: Real) -> NDArray[np.intp]:
    return np.asarray(np.round((delays + 1) / (DELAYS[1] - DELAYS[0])), dtype=np.intp)


def _looked_at(
    statistics: FrameStatistics, scene: Scene, hearing: Hearing
) -> tuple[FrameStatistics, list[Real], Likelihood]:
    """The bins that are looked at, density of their phases for every delay of every source, and all but azimuths."""
    statistics = statistics.evenly(hearing.used, GROUP)
    turned = (2 * np.pi * scene.unit * statistics.frequencies).astype(np.float32)
    tables, nobody = _tables(statistics, turned, scene, hearing)
    band = np.searchsorted(BANDS, statistics.frequencies)
    return statistics, tables, Likelihood((), (), nobody, band, float(statistics.weights[0]))


def _tables(statistics: FrameStatistics, turned: Real, scene: Scene, hearing: Hearing) -> tuple[list[Real], Real]:
    """Density of every phase for every delay of every source, (n, n_delays) each, and for nobody, (n,)."""
    off = np.cos(statistics.phases.astype(np.float32)[:, None] - turned[:, None] * DELAYS.astype(np.float32)) - 1
    error = hearing.error[scene.wet] + hearing.echoic * excess(scene.amplitude)
    variance = hearing.noise**2 + error**2 * turned
    alone, beside = _von_mises(off, 1 / variance), _von_mises(off, 1 / (hearing.wider**2 * variance))
    row = np.searchsorted(BELOW, statistics.frequencies)
    shared = SHARED[np.minimum(row, len(BELOW) - 1)].astype(np.float32)
    own = (1 - shared.sum(axis=1))[:, None] * alone
    plain = own + shared.sum(axis=1)[:, None] * beside
    nobody = (1 - ANYWHERE) / (2 * np.pi) + ANYWHERE * plain.mean(axis=1)
    low = np.flatnonzero(row < len(BELOW))
    if len(scene.azimuths) < 2 or not len(low):
        return [plain] * len(scene.azimuths), nobody.astype(np.float32)
    delays = scene.elevations * np.cos(scene.azimuths - statistics.headings.mean()) * scene.amplitude
    tables = []
    for source in range(len(delays)):
        table = plain.copy()
        table[low] = own[low]
        for column, drawn in enumerate(_drawn(source, delays, scene.shares)):
            table[low] += shared[low, column, None] * (beside[low] @ drawn)
        tables.append(table)
    return tables, nobody.astype(np.float32)


def _von_mises(off: Real, kappa: Real) -> Real:
    kappa = kappa[:, None]
    return np.asarray(np.exp(kappa * off) / (2 * np.pi * i0e(kappa)), np.float32)


def _drawn(source: int, delays: Real, shares: Real) -> Real:
    """Which delay (rows) a bin has whose source has a delay (columns), when another has some of it, (n_parts, n, n)."""
    drawn = np.zeros((len(PARTS), N_DELAYS, N_DELAYS), np.float32)
    row, column, parts = np.arange(len(PARTS))[:, None], np.arange(N_DELAYS), PARTS[:, None]
    others = np.delete(np.arange(len(delays)), source)
    for other, odds in zip(others, shares[others] / shares[others].sum(), strict=True):
        place = ((1 - parts) * DELAYS + parts * delays[other] + 1) / (DELAYS[1] - DELAYS[0])
        below = np.clip(np.floor(place).astype(int), 0, N_DELAYS - 2)
        drawn[row, below, column] += odds * (1 - place + below)
        drawn[row, below + 1, column] += odds * (place - below)
    return drawn
