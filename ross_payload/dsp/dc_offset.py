"""The constant part of what a microphone gives: it would begin and end with every period, as a click from ahead."""

from __future__ import annotations

import numpy as np

from ross_payload.interfaces import Samples

LEAST = 0.1  # of the RMS: the mean of a sound that lasts is smaller


def without_offset(samples: Samples) -> Samples:
    """Return samples (..., n) less the mean of every channel in which that is an offset.

    >>> without_offset(np.array([[3.0, 5.0], [3.0, -3.0]], np.float32)).tolist()
    [[-1.0, 1.0], [3.0, -3.0]]
    """
    if not samples.size:
        return samples
    mean = samples.mean(axis=-1, keepdims=True, dtype=np.float64)
    power = np.mean(np.square(samples, dtype=np.float64), axis=-1, keepdims=True)
    offset = np.where(mean**2 > LEAST**2 * power, mean, 0.0)
    return samples - offset.astype(samples.dtype) if offset.any() else samples
