"""Density of ITDs in one orientation: weighted histogram, kernel density, prominent peaks.

Prominence is that of `scipy.signal.find_peaks`; importing that package would double the time that the payload takes to
start.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ross_payload.interfaces import Real

MARGIN = 1.5  # the grid ends here, in units of d / v_p: errors of the ITD spill over the possible
N_BINS = 61


def itd_grid(spacing: float, speed_of_sound: float, n_bins: int = N_BINS) -> Real:
    """Centres of the ITD bins [s], (n_bins,), from -1.5 to 1.5 d / v_p.

    >>> itd_grid(343.0, 343.0, 5).tolist()
    [-1.5, -0.75, 0.0, 0.75, 1.5]
    """
    return np.linspace(-MARGIN, MARGIN, n_bins) * spacing / speed_of_sound


def histogram(itd: Real, weight: Real, grid: Real) -> Real:
    """Weight per ITD bin, (n_bins,), shared linearly between the two nearest bins; what lies outside the grid is lost.

    >>> histogram(np.array([0.25, 1.0, 9.0]), np.array([4.0, 1.0, 1.0]), np.array([0.0, 1.0, 2.0])).tolist()
    [3.0, 2.0, 0.0]
    """
    place = (itd - grid[0]) / (grid[1] - grid[0])
    inside = (place >= 0) & (place <= len(grid) - 1) & (weight > 0)
    place, weight = place[inside], weight[inside]
    left = np.minimum(place.astype(int), len(grid) - 2)
    share = place - left
    low = np.bincount(left, weight * (1 - share), len(grid))
    return np.asarray(low + np.bincount(left + 1, weight * share, len(grid)), float)  # integers when all is lost


def histograms(itd: Real, weight: Real, grid: Real, frames: int) -> Real:
    """`histogram` of every ``frames`` columns of ``itd`` and ``weight`` (n_rows, n_frames), (n_blocks, n_bins).

    >>> histograms(np.array([[0.0, 1.0, 1.0]]), np.ones((1, 3)), np.array([0.0, 1.0, 2.0]), 2).tolist()
    [[1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
    """
    n_blocks, n_bins = -(-itd.shape[1] // frames), len(grid)
    place = (itd - grid[0]) / (grid[1] - grid[0])
    row, frame = np.nonzero((place >= 0) & (place <= n_bins - 1) & (weight > 0))
    place, weight = place[row, frame], weight[row, frame]
    left = np.minimum(place.astype(int), n_bins - 2)
    share, cell = place - left, frame // frames * n_bins + left
    counts = np.bincount(cell, weight * (1 - share), n_blocks * n_bins)
    counts = counts + np.bincount(cell + 1, weight * share, n_blocks * n_bins)
    return np.asarray(counts.reshape(n_blocks, n_bins), float)


def kde(counts: Real, grid: Real, bandwidth: float) -> Real:
    """Kernel density of a histogram: Gaussian kernel of standard deviation ``bandwidth`` [s], (n_bins,), sums to 1.

    All zero when the histogram is.
    """
    smooth = gaussian_filter1d(counts, bandwidth / (grid[1] - grid[0]), mode="constant")
    total = smooth.sum()
    return np.asarray(smooth / total if total > 0 else smooth)


def prominent_peaks(density: Real, grid: Real, prominence: float = 0.1) -> tuple[float, ...]:
    """ITDs [s] of the peaks that stand out by at least ``prominence`` times the highest, the highest first.

    >>> prominent_peaks(np.array([0, 1, 0.95, 1.01, 0, 5, 0]), np.arange(7.0), 0.15)
    (5.0, 3.0)
    """
    if not density.max(initial=0.0) > 0:
        return ()
    padded = np.pad(density, 1)
    edges = np.concatenate([[0], np.flatnonzero(np.diff(padded)) + 1, [len(padded)]])  # of plateaus
    first, last = edges[1:-2], edges[2:-1] - 1
    height = padded[first]
    is_peak = (height > padded[first - 1]) & (height > padded[last + 1])
    places = ((first + last) // 2)[is_peak]
    least = prominence * density.max()
    peaks = [int(place) for place in places if padded[place] - _saddle(padded, place) >= least]
    return tuple(float(grid[peak - 1]) for peak in sorted(peaks, key=lambda peak: -padded[peak]))


def _saddle(values: Real, peak: int) -> float:
    """Return how far one must climb down, on the better side, to climb higher than a peak or leave the density."""
    higher = np.flatnonzero(values > values[peak])
    left, right = higher[higher < peak], higher[higher > peak]
    begin, end = (left[-1] if left.size else 0), (right[0] if right.size else len(values))
    return float(max(values[begin : peak + 1].min(), values[peak:end].min()))
