"""Where in time and frequency the tones of rotors are whose speeds are known, and how far they exceed other noise.

The tones of a rotor are harmonics of its blade-pass frequency, blades times speed. Where those of several rotors lie so
close that they fill the spectrum nothing is gained by telling them from what is between, and they are no tones here.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d

from ross_payload.dsp.covariance import outer
from ross_payload.dsp.noise_field import BAND, QUANTILE, REFERENCE, whitened
from ross_payload.interfaces import Complex, Marks, Real

LOBE = 1.25  # bins to either side of a tone in which its main lobe is heard
UNCERTAIN = 0.004  # of a speed, one way: it changes while a frame lasts, and a report is rounded and late
FILLED = 0.6  # share of bins that are tones within one blade-pass frequency above which none is
LOUDER = (1.0, 100.0)  # bounds of how far tones exceed other noise
FEWEST = 8  # bins of tones in a band that tell how loud they are


def tones(frequencies: Real, period: float, n_frames: int, speeds: Real, *, seconds: float, blades: int) -> Marks:
    """Whether every bin holds a tone of a rotor, (n_freqs, n_frames).

    Parameters
    ----------
    frequencies
        [Hz], evenly spaced, (n_freqs,).
    period
        Time between frames [s]; the first ends so long after the beginning.
    speeds
        Of every rotor, evenly over the recording [1/s], (n_times, n_rotors); 0: it stands, or is not known.
    seconds
        Length of the recording [s].
    blades
        Of every rotor.

    Examples
    --------
    Two blades at 50 revolutions per second sound at 100, 200, 300 Hz:

    >>> found = tones(np.arange(0.0, 310.0, 10.0), 0.1, 3, np.array([[50.0]]), seconds=0.3, blades=2)
    >>> np.flatnonzero(found[:, 1]).tolist()
    [9, 10, 11, 19, 20, 21, 29, 30]
    """
    found = np.zeros((len(frequencies), n_frames), bool)
    turning = speeds[:, (speeds > 0).any(axis=0)]
    if not turning.size or len(frequencies) < 2:
        return found
    width = float(frequencies[1] - frequencies[0])
    at, told = (
        period * (1 + np.arange(n_frames)) - 0.5 / width,
        (np.arange(len(turning)) + 0.5) * seconds / len(turning),
    )
    for rotor in turning.T:
        blade_pass = blades * np.interp(at, told, rotor)
        known = blade_pass > 2 * width
        order = np.round(frequencies[:, None] / np.where(known, blade_pass, np.inf))
        off = np.abs(frequencies[:, None] - order * blade_pass)
        found |= known & (order > 0) & (off <= LOBE * width + UNCERTAIN * frequencies[:, None])
    usual = blades * float(turning[turning > 0].mean())
    share = uniform_filter1d(found.astype(np.float32), max(round(usual / width), 1), axis=0, mode="nearest")
    return np.asarray(found & (share <= FILLED))


def raised(field: Real, spectrogram: Complex, frequencies: Real, tonal: Marks) -> Real:
    """The covariance of the noise (n_freqs, 4, n_frames), larger in the bins of tones by what they exceed it.

    How far follows in bands of 190 Hz from a low quantile of the whitened powers, of tones over that of the rest.
    """
    if not tonal.any():
        return field
    power = whitened(outer(spectrogram), field)
    band = max(round(BAND / float(frequencies[1] - frequencies[0])), 1)
    larger = np.ones(len(frequencies), np.float32)
    for low in range(0, len(frequencies), band):
        rows = slice(low, low + band)
        tone, rest = power[rows][tonal[rows]], power[rows][~tonal[rows]]
        if tone.size >= FEWEST and rest.size >= FEWEST:
            larger[rows] = np.clip(_level(tone) / max(_level(rest), 1e-30), *LOUDER)
    return np.asarray(np.where(tonal[:, None], field * larger[:, None, None], field), dtype=field.dtype)


def _level(power: Real) -> float:
    """Level of noise by a low quantile of whitened powers, 1 where the covariance is right."""
    return float(np.quantile(power, QUANTILE)) / REFERENCE
