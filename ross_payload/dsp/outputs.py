"""Whom each output of a blind separator holds, by the directions."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment

from ross_payload.dsp.steering import steering_vectors
from ross_payload.dsp.stft import band
from ross_payload.interfaces import Complex, Real

LOW, HIGH = 100.0, 6000.0  # where speech has a direction [Hz]


def outputs_of(cross: Complex, frequencies: Real, tau: Real) -> tuple[int, ...]:
    """The output that holds each group: the assignment with the largest sum of mean cos(phase - 2 pi f tau).

    Parameters
    ----------
    cross
        E[x_2 x_1*] of every output as heard by both microphones; only its phase counts, (n_freqs, n_outputs).
    frequencies
        [Hz], (n_freqs,).
    tau
        TDOA of every group [s], (n_groups,); at most as many as outputs.

    Examples
    --------
    A quarter of a cycle ahead and behind at 1 kHz:

    >>> outputs_of(np.array([[-1j, 1j]]), np.array([1000.0]), np.array([0.25e-3, -0.25e-3]))
    (1, 0)
    """
    use = band(frequencies, LOW, HIGH)
    use = use if use.any() else np.ones(frequencies.size, bool)
    size = np.abs(cross[use])
    phases = np.divide(cross[use], size, out=np.zeros_like(cross[use]), where=size > 0)
    expected = steering_vectors(frequencies[use], tau)[:, 1]
    agreement = (expected.conj().T @ phases).real
    return tuple(int(i) for i in linear_sum_assignment(agreement, maximize=True)[1])


def images_of(demixing: Complex) -> Complex:
    """E[x_2 x_1*] up to a factor of what each row of W lets through, from the columns of W^-1, (n_freqs, 2).

    >>> images_of(np.array([[[1.0, -1], [1, 1]]])).tolist()
    [[-1.0, 1.0]]
    """
    a, b, c, d = demixing.reshape(-1, 4).T
    first, second = (d, -c), (-b, a)  # columns of W^-1, times det W
    return np.stack([column[1] * np.conj(column[0]) for column in (first, second)], axis=1)
