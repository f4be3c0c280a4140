"""ITD of every time-frequency bin among noise that has a direction, and how far to trust each.

The noise is whitened first (Markovich, Gannot, Cohen 2009): where one source rules some neighbouring bins, the
principal eigenvector of their whitened covariance is the steering vector of that source seen through the whitening,
and undoing that gives its ITD, which the noise does not pull anywhere. A bin votes when it is louder than the noise
lets expect, and when nearly all of it lies along that one vector. What is not coherent, as wind, lies along none, and
what is as loud as the noise is noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ross_payload.dsp.covariance import ROOT2
from ross_payload.dsp.itd import TINY, Trust, around, local_mean, tail
from ross_payload.interfaces import Complex, Real

SINGULAR = 1e-4  # of the product of the powers: least determinant of a noise covariance


@dataclass(frozen=True, slots=True, eq=False)
class Whitening:
    """Lower triangular factor L of the noise covariance of every bin, N = L L^H; each (n_freqs, n_frames)."""

    first: Real  # L11
    across: Complex  # L21
    second: Real  # L22

    @classmethod
    def of(cls, field: Real) -> Whitening:
        """Factor coordinates of covariances, (n_freqs, 4, n_frames)."""
        one, two, real, imag = np.moveaxis(field, 1, 0)
        first = np.sqrt(np.maximum(one, TINY))
        across = (real - 1j * imag) / (ROOT2 * first)
        second = np.sqrt(np.maximum(two - np.abs(across) ** 2, SINGULAR * two + TINY))
        return cls(first, across, second)

    def apply(self, spectrogram: Complex) -> tuple[Complex, Complex]:
        """Whiten (2, n_freqs, n_frames): noise alone then has unit power in either channel."""
        first = spectrogram[0] / self.first
        return first, (spectrogram[1] - self.across * first) / self.second


def weighted_itd_in_noise(
    spectrogram: Complex, frequencies: Real, frame_period: float, field: Real, *, floor: Real | float, trust: Trust
) -> tuple[Real, Real]:
    """Local ITD [s] and weight in [0, 1] of every bin, both (n_freqs, n_frames); see `weighted_itd`.

    Parameters
    ----------
    spectrogram : (2, n_freqs, n_frames)
        Only bins with f > 0.
    frequencies : (n_freqs,)
        [Hz].
    frame_period : float
        Time between frames [s].
    field : (n_freqs, 4, n_frames)
        Coordinates of the covariance of the noise in every bin.
    floor
        Power over the noise below which a bin has weight 0; for every frequency (n_freqs,), or for all.
    trust : Trust
        Neighbourhood, coherence and decay.
    """
    whitening = Whitening.of(field)
    white = whitening.apply(spectrogram)
    size = around(trust, frequencies, frame_period)
    one, two = (local_mean(np.abs(channel) ** 2, size) for channel in white)
    product = white[1] * white[0].conj()
    cross = local_mean(product.real, size) + 1j * local_mean(product.imag, size)
    power = np.maximum((one + two) / 2, TINY)
    spread = np.sqrt(((one - two) / 2) ** 2 + np.abs(cross) ** 2)
    largest, least = power + spread, np.maximum(power - spread, 0)
    nearer = one >= two  # of the two equal forms of the eigenvector the one that cannot vanish
    u1 = np.where(nearer, largest - two, cross.conj())
    u2 = np.where(nearer, cross, largest - one)
    steered = whitening.across * u1 + whitening.second * u2
    itd = np.angle(steered * (whitening.first * u1).conj()) / (2 * np.pi * frequencies[:, None])
    energy = np.maximum(1 - np.reshape(floor, (-1, 1)) / power, 0)
    onset = np.maximum(1 - tail(power, np.exp(-frame_period / trust.decay)) / power, 0)
    ratio = (1 - trust.coherence) / (1 + trust.coherence)  # of the eigenvalues of two channels of this coherence
    weight = energy * onset * (least <= ratio * largest) * (frequencies / frequencies.max())[:, None]
    return np.asarray(itd), np.asarray(weight)
