"""The spatial covariance of noise in every bin of a recording, found among the bins in which nobody talks.

Noise that has a direction, as that of rotors, is not white: its covariance has more to say than its PSD. It also
changes, with the heading of the array and with the throttle. So it is not kept but estimated from every recording:
people pause, in time and in frequency, and what is quiet for its frequency is noise. In every band of frequencies
and every second or so the covariance is the mean over the bins whose whitened power ``q = x^H N^-1 x`` is below `CUT`
times what it is in noise alone; the level of noise comes from a low quantile of q, in Gaussian noise that of a gamma
distribution of shape 2. Both are iterated (a trimmed covariance, Rousseeuw 1985; the quantile as of Martin 2001).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.special import gammaincinv

from ross_payload.dsp.covariance import ROOT2, adjugate, outer
from ross_payload.interfaces import Complex, Real

BAND = 190.0  # width of a band [Hz]
WINDOW = 0.75  # from one estimate to the next [s]; each sees as much to either side
QUANTILE = 0.25  # of whitened powers that is noise's in any case
CUT = 4.0  # whitened power of a bin, over the level of the noise, from which on somebody may talk there
ITERATIONS = 4
EVERY = 2  # frames that are looked at: neighbours overlap
COHERENT = 1.02  # no noise is more coherent than 1 / this
SINGULAR = 1e-4  # of the product of the powers: least determinant
SILENT = 1e-20  # least PSD
NOTHING = 1e-30  # least determinant of all
REFERENCE = float(gammaincinv(2, QUANTILE))
TRIMMED = float((1 - np.exp(-CUT) * (1 + CUT + CUT**2 / 2)) / (1 - np.exp(-CUT) * (1 + CUT)))  # E[q | q < CUT] / 2


@dataclass(frozen=True, slots=True, eq=False)
class _Grid:
    """Bands of frequencies and windows of frames that share one estimate."""

    band: int  # frequencies of one band
    centres: tuple[Real, Real]  # of bands [bins] and of windows [frames]
    windows: tuple[slice, ...]
    shape: tuple[int, int]  # frequencies, frames

    @classmethod
    def of(cls, n_freqs: int, n_frames: int, width: float, period: float) -> _Grid:
        band = max(round(BAND / width), 1)
        starts = np.arange(0, n_freqs, band)
        count = max(round(n_frames * period / WINDOW), 1)
        middle = (np.arange(count) + 0.5) * n_frames / count
        reach = n_frames / count
        windows = tuple(slice(max(int(c - reach), 0), min(int(c + reach) + 1, n_frames), EVERY) for c in middle)
        return cls(band, (np.minimum(starts + (band - 1) / 2, n_freqs - 1), middle), windows, (n_freqs, n_frames))

    def spread(self, values: Real) -> Real:
        """From (n_bands, n_windows, ...) to every bin, (n_freqs, n_frames, ...), straight in between."""
        return _between(_between(values, self.centres[0], self.shape[0], 0), self.centres[1], self.shape[1], 1)

    def level(self, values: Real) -> Real:
        """The level of noise by the low quantile of whitened powers (n_freqs, n), (n_bands,)."""
        whole = np.pad(values, ((0, -len(values) % self.band), (0, 0)), mode="edge").reshape(
            -1, self.band, values.shape[1]
        )
        return np.asarray(np.quantile(whole.reshape(len(whole), -1), QUANTILE, axis=1) / REFERENCE)

    def summed(self, values: Real) -> Real:
        """Sums over bands, from (n_freqs, ...) to (n_bands, ...)."""
        return np.asarray(np.add.reduceat(values, np.arange(0, self.shape[0], self.band), axis=0))


def noise_field(spectrogram: Complex, frequencies: Real, period: float, shape: Real | None = None) -> Real:
    """Coordinates of the covariance of the noise in every bin, (n_freqs, 4, n_frames).

    Parameters
    ----------
    spectrogram
        (2, n_freqs, n_frames).
    frequencies
        [Hz], (n_freqs,), evenly spaced.
    period
        Time between frames [s].
    shape
        What to begin with: coordinates of trace 2, (n_freqs, 4); None: white.
    """
    n_freqs, n_frames = spectrogram.shape[1:]
    if not n_frames:
        return np.zeros((n_freqs, 4, 0), np.float32)
    width = float(frequencies[1] - frequencies[0]) if n_freqs > 1 else BAND
    grid = _Grid.of(n_freqs, n_frames, width, period)
    observed = outer(spectrogram).astype(np.float32)
    power = 0.5 * (observed[:, 0] + observed[:, 1])
    psd = np.maximum(2 * np.quantile(power[:, ::EVERY], QUANTILE, axis=1) / REFERENCE, SILENT).astype(np.float32)
    white = np.broadcast_to(np.array([1, 1, 0, 0], np.float32), (n_freqs, 4))
    unit = np.broadcast_to((white if shape is None else shape)[:, :, None], observed.shape)
    for iteration in range(ITERATIONS):
        found = np.empty((len(grid.centres[0]), len(grid.windows), 4), np.float32)
        for index, frames in enumerate(grid.windows):
            found[:, index] = _quiet_mean(observed[..., frames], unit[..., frames], psd, grid)
        found = np.asarray(uniform_filter1d(found, 3, axis=0, mode="nearest"))
        found[..., :2] *= COHERENT
        unit = np.moveaxis(grid.spread(found), -1, 1)
        if iteration < ITERATIONS - 1:
            levels = np.quantile(whitened(observed[..., ::EVERY], unit[..., ::EVERY]), QUANTILE, axis=1) / REFERENCE
            psd = np.maximum(levels, SILENT).astype(np.float32)
    return np.asarray(unit * psd[:, None, None], dtype=np.float32)


def whitened(observed: Real, covariances: Real) -> Real:
    """Whitened power x^H N^-1 x of every bin, (n_freqs, n_frames): 2 on average where there is noise alone.

    Parameters
    ----------
    observed, covariances
        Coordinates of x x^H and of N, (n_freqs, 4, n_frames).

    Examples
    --------
    >>> white = np.array([[[2.0], [2.0], [0.0], [0.0]]])
    >>> whitened(outer(np.array([[[2.0 + 0j]], [[2.0 + 0j]]])), white).tolist()
    [[4.0]]
    """
    return np.asarray((observed * adjugate(covariances, axis=1)).sum(axis=1) / determinants(covariances))


def determinants(covariances: Real) -> Real:
    """Determinants of coordinates (n_freqs, 4, n_frames), at least a small part of the product of the powers."""
    first, second, real, imag = np.moveaxis(covariances, 1, 0)
    both = first * second
    return np.asarray(np.maximum(both - 0.5 * (real**2 + imag**2), SINGULAR * both + NOTHING))


def _quiet_mean(observed: Real, unit: Real, psd: Real, grid: _Grid) -> Real:
    """Mean over the quiet bins of x x^H over the PSD, in every band of one window, (n_bands, 4)."""
    power = whitened(observed, unit) / psd[:, None]
    level = np.repeat(grid.level(power), grid.band)[: len(psd)]
    quiet = power < CUT * level[:, None]
    count = np.maximum(grid.summed(quiet.sum(axis=1).astype(np.float32)), 1)
    total = grid.summed((observed * quiet[:, None]).sum(axis=2) / psd[:, None])
    return np.asarray(total / (count * np.float32(TRIMMED))[:, None])


def _between(values: Real, centres: Real, n: int, axis: int) -> Real:
    """Values at 0 .. n - 1 along an axis by straight lines between ``centres``; level outside."""
    place = np.interp(np.arange(n), centres, np.arange(len(centres)))
    first = np.minimum(place.astype(int), max(len(centres) - 2, 0))
    share = (place - first).astype(np.float32).reshape([n if index == axis else 1 for index in range(values.ndim)])
    after = np.minimum(first + 1, len(centres) - 1)
    return np.asarray(values.take(first, axis) * (1 - share) + values.take(after, axis) * share)


def coherence(covariances: Real) -> Real:
    """Magnitude of the coherence of both microphones, from coordinates (..., 4, n), (..., n).

    >>> coherence(np.array([[1.0], [1.0], [ROOT2 * 0.5], [0.0]])).round(3).tolist()
    [0.5]
    """
    first, second, real, imag = np.moveaxis(covariances, -2, 0)
    return np.asarray(np.sqrt((real**2 + imag**2) / np.maximum(first * second, SILENT)) / ROOT2)
