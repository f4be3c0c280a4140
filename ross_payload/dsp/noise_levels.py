"""How the level of noise rises and falls for all frequencies together, as wind does in gusts.

In every frame the level is a low quantile over the frequencies of the power over the usual PSD; the usual PSD is the
same quantile over time of the power over the level. Talk is loud in some of the bins of a frame and in some of the
frames of a bin, so that neither quantile follows it.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d

from ross_payload.interfaces import Complex, Real

QUANTILE = 0.15
LOWEST, HIGHEST = 80.0, 8000.0  # of the frequencies that are looked at [Hz]
SMOOTHED = 9  # frames
ITERATIONS = 4
SILENT = 1e-20  # least power


def noise_levels(spectrogram: Complex, frequencies: Real) -> Real:
    """Power of the noise of every frame over its usual one, the same for all frequencies, (n_frames,).

    Parameters
    ----------
    spectrogram
        (2, n_freqs, n_frames).
    frequencies
        [Hz], (n_freqs,).
    """
    heard = (frequencies >= LOWEST) & (frequencies <= HIGHEST)
    powers = np.log((np.abs(spectrogram[:, heard]) ** 2).mean(axis=0) + SILENT)
    level = np.zeros(spectrogram.shape[2])
    if not powers.size:
        return np.asarray(np.exp(level), dtype=np.float32)
    for _ in range(ITERATIONS):
        usual = np.quantile(powers - level, QUANTILE, axis=1, keepdims=True)
        level = uniform_filter1d(np.quantile(powers - usual, QUANTILE, axis=0), SMOOTHED, mode="nearest")
        level -= np.median(level)
    return np.asarray(np.exp(level), dtype=np.float32)
