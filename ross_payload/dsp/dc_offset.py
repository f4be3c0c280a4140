"""The constant part of what a microphone gives: it would begin and end with every period, as a click from ahead."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import binary_opening

from ross_payload.interfaces import Marks, Samples

LEAST = 0.1  # of the RMS: the mean of a sound that lasts is smaller
LASTING_S = 2.0  # of a stream, from which its mean tells; after a half of it the mean has to be twice as large
AVERAGED_S = 4.0  # time constant of the mean of a stream
SHORTEST_GAP = 16  # samples that are 0 in every channel: fewer are a soft sound's, so many never came


def without_offset(samples: Samples) -> Samples:
    """Return samples (n_channels, n) less the mean of every channel in which that is an offset.

    The zeros in the place of samples that never came stay, and tell nothing of the offset.

    >>> without_offset(np.array([[3.0, 5.0], [3.0, -3.0]], np.float32)).tolist()
    [[-1.0, 1.0], [3.0, -3.0]]
    """
    came = _came(samples)
    heard = samples if came.all() else samples[:, came]
    if not heard.size:
        return samples
    mean = heard.mean(axis=-1, keepdims=True, dtype=np.float64)
    power = np.mean(np.square(heard, dtype=np.float64), axis=-1, keepdims=True)
    offset = np.where(mean**2 > LEAST**2 * power, mean, 0.0)
    return samples - offset.astype(samples.dtype) * came if offset.any() else samples


def _came(samples: Samples) -> Marks:
    """Which samples are not zeros in the place of some that never came, (n,)."""
    silent: Marks = np.asarray(~samples.any(axis=0))
    gaps = binary_opening(silent, np.ones(SHORTEST_GAP, bool)) if silent.any() else silent
    return np.logical_not(gaps)


class OffsetFilter:
    """Takes the offset out of a stream: of every channel that was found to have one, its mean of late.

    Parameters
    ----------
    rate
        Sampling rate [Hz].
    n_channels
        Of the samples.

    >>> offset_filter, hop = OffsetFilter(16000, 1), np.full((1, 1600), 0.5, np.float32)
    >>> [float(offset_filter.push(hop)[0, -1]) for _ in range(4)]
    [0.5, 0.5, 0.0, 0.0]
    """

    def __init__(self, rate: int, n_channels: int) -> None:
        self._rate = rate
        self._heard = 0  # samples
        self._mean, self._power = np.zeros(n_channels), np.zeros(n_channels)
        self._found = np.zeros(n_channels, bool)
        self._offset = np.zeros(n_channels)  # at the end of the last samples

    def push(self, samples: Samples) -> Samples:
        """Take the next samples (n_channels, n); return them without the offset, which moves evenly from hop to hop."""
        n = samples.shape[-1]
        if not n:
            return samples
        self._heard += n
        weight = n / min(self._heard, AVERAGED_S * self._rate)
        self._mean += min(weight, 1.0) * (samples.mean(axis=-1, dtype=np.float64) - self._mean)
        self._power += min(weight, 1.0) * (np.mean(np.square(samples, dtype=np.float64), axis=-1) - self._power)
        least = LEAST * max(LASTING_S * self._rate / self._heard, 1.0)  # of the RMS
        self._found |= self._mean**2 > least**2 * self._power
        before, self._offset = self._offset, np.where(self._found, self._mean, 0.0)
        if not self._found.any():
            return samples
        moved = before[:, None] + (self._offset - before)[:, None] * np.arange(1, n + 1) / n
        corrected: Samples = samples - moved.astype(samples.dtype)
        return corrected

    def push_incomplete(self, samples: Samples) -> Samples:
        """Take samples of which some never came, zeros in every channel: those stay, and tell nothing of the offset."""
        came = samples.any(axis=0)
        corrected: Samples = samples - (self._offset[:, None] * came).astype(samples.dtype)
        return corrected
