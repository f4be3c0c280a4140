"""Sums of sines that repeat, by one inverse Fourier transform."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ross_payload.interfaces import Real


def sines(cycles: ArrayLike, shifts: ArrayLike, n: int, strengths: ArrayLike = 1.0) -> Real:
    """The sum of ``strengths * sin(2 pi cycles t / n + shifts)`` over t = 0 to n - 1, (n,).

    Parameters
    ----------
    cycles
        In the whole period, (n_sines,), each from 1 to less than half of ``n``.
    shifts
        Phases at t = 0 [rad], (n_sines,).
    n
        Samples of the period.
    strengths
        Amplitudes, (n_sines,) or one for all.

    >>> sines([1], [0.0], 4).round(6).tolist()
    [0.0, 1.0, 0.0, -1.0]
    """
    spectrum = np.zeros(n // 2 + 1, complex)
    np.add.at(spectrum, np.asarray(cycles), -0.5j * n * np.asarray(strengths) * np.exp(1j * np.asarray(shifts)))
    return np.asarray(np.fft.irfft(spectrum, n))
