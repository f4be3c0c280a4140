"""Spatial covariances of two microphones as four real coordinates.

A Hermitian matrix H is written as h = (H11, H22, sqrt(2) Re H12, sqrt(2) Im H12), so that tr(A B) = a . b, and the
adjugate, which is det(H) times the inverse, as (H22, H11, -sqrt(2) Re H12, -sqrt(2) Im H12). Everything that a local
Gaussian model needs then is real matrix products: no complex arithmetic, no inverses.
"""

from __future__ import annotations

import numpy as np

from ross_payload.interfaces import Complex, Real

ROOT2 = float(np.sqrt(2))


def outer(spectrogram: Complex) -> Real:
    """Coordinates of x x^H of every bin: (2, n_freqs, n_frames) -> (n_freqs, 4, n_frames).

    >>> outer(np.array([[[1.0]], [[1j]]])).ravel().round(4).tolist()
    [1.0, 1.0, 0.0, -1.4142]
    """
    first, second = spectrogram
    cross = ROOT2 * first * second.conj()
    return np.stack([np.abs(first) ** 2, np.abs(second) ** 2, cross.real, cross.imag], axis=1)


def adjugate(matrices: Real, axis: int = -1) -> Real:
    """Coordinates of the adjugate of matrices whose four coordinates lie along ``axis``.

    >>> adjugate(np.array([1.0, 2.0, 3.0, 4.0])).tolist()
    [2.0, 1.0, -3.0, -4.0]
    """
    first, second, real, imag = np.moveaxis(matrices, axis, 0)
    return np.stack([second, first, -real, -imag], axis=axis)


def determinant(matrices: Real) -> Real:
    """Determinant of matrices (..., 4): H11 H22 - |H12|^2, (...).

    >>> float(determinant(np.array([2.0, 3.0, 0.0, 2.0])))
    4.0
    """
    return np.asarray(matrices[..., 0] * matrices[..., 1] - 0.5 * (matrices[..., 2] ** 2 + matrices[..., 3] ** 2))


def direct(frequencies: Real, tau: Real) -> Real:
    """Covariance a a^H of plane waves with TDOA tau [s], trace 2, (n_freqs, n_sources, 4).

    >>> direct(np.array([1000.0]), np.array([0.25e-3])).ravel().round(4).tolist()
    [1.0, 1.0, 0.0, -1.4142]
    """
    phase = 2 * np.pi * frequencies[:, None] * tau
    ones = np.ones_like(phase)
    return np.stack([ones, ones, ROOT2 * np.cos(phase), -ROOT2 * np.sin(phase)], axis=-1)


def diffuse(frequencies: Real, spacing: float, speed_of_sound: float) -> Real:
    """Covariance of a spherically diffuse field: coherence sinc(2 f d / v_p), trace 2, (n_freqs, 4).

    >>> diffuse(np.array([0.0, 3430.0]), 0.05, 343.0).round(4).tolist()
    [[1.0, 1.0, 1.4142, 0.0], [1.0, 1.0, 0.0, 0.0]]
    """
    coherence = np.sinc(2 * frequencies * spacing / speed_of_sound)
    ones = np.ones_like(coherence)
    return np.stack([ones, ones, ROOT2 * coherence, np.zeros_like(coherence)], axis=-1)
