"""What could be reached by someone who knows every source: upper bounds for the tables, never plug-ins.

Each takes the image of every source at both microphones and the noise, (n_sources, 2, n_samples) and (2, n_samples),
and returns every source as it would be cut out of their sum at microphone 1, (n_sources, n_samples).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ross_payload.dsp.covariance import outer
from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Complex, Real
from ross_payload.separation.local_gaussian_model import wiener

Oracle = Callable[[Real, Real, Stft], Real]
FLOOR = 1e-10  # of every PSD, relative to the mean power of the mixture
LOADING = 1e-4  # white part of every covariance


def ratio_masks(parts: Complex) -> Real:
    """Ideal ratio masks |S_k|^2 / sum_j |S_j|^2, (n, n_freqs, n_frames), in [0, 1]; they add up to 1 in sound.

    Parameters
    ----------
    parts
        Everything that adds up to the mixture at microphone 1, (n, n_freqs, n_frames).

    Examples
    --------
    >>> ratio_masks(np.array([[[3.0, 0.0]], [[1j, 0.0]]])).tolist()
    [[[0.9, 0.0]], [[0.1, 0.0]]]
    """
    powers = np.abs(parts) ** 2
    total = powers.sum(axis=0)
    return np.asarray(np.divide(powers, total, out=np.zeros_like(powers), where=total > 0))


def ideal_ratio_mask(images: Real, noise: Real, stft: Stft) -> Real:
    """Microphone 1 through the ideal ratio mask of every source (Narayanan and Wang 2013)."""
    parts = stft.analyse(np.concatenate([images[:, 0], noise[None, 0]]))
    return stft.synthesise(ratio_masks(parts)[:-1] * parts.sum(axis=0), images.shape[-1])


def multichannel_wiener(images: Real, noise: Real, stft: Stft) -> Real:
    """Multichannel Wiener filter R_k (sum_j R_j)^-1 x with the true covariances of the whole recording."""
    return _filtered(images, noise, stft, lambda psds: psds.mean(axis=-1, keepdims=True) + 0 * psds)


def varying_wiener(images: Real, noise: Real, stft: Stft) -> Real:
    """Multichannel Wiener filter v_k R_k (sum_j v_j R_j)^-1 x with the true PSD v_k of every bin."""
    return _filtered(images, noise, stft, lambda psds: psds)


def _filtered(images: Real, noise: Real, stft: Stft, at_hand: Callable[[Real], Real]) -> Real:
    parts = stft.analyse(np.concatenate([images, noise[None]]))
    power = float((np.abs(parts.sum(axis=0)) ** 2).mean())
    if not power > 0:
        return np.zeros((len(images), images.shape[-1]))
    parts = parts / np.sqrt(power)
    psds = at_hand(np.maximum((np.abs(parts) ** 2).mean(axis=1), FLOOR))
    covariances = np.stack([_covariance(part) for part in parts], axis=1)
    signals = wiener(parts.sum(axis=0), np.swapaxes(psds, 0, 1), covariances)
    return np.asarray(np.sqrt(power) * stft.synthesise(signals, images.shape[-1]))


def _covariance(part: Complex) -> Real:
    """Coordinates of the mean of x x^H over the frames, trace 2, slightly loaded, (n_freqs, 4)."""
    mean = outer(part).mean(axis=-1)
    level = 0.5 * (mean[:, :1] + mean[:, 1:2])
    white = np.array([1.0, 1.0, 0.0, 0.0])
    return np.asarray(np.where(level > 0, mean / np.where(level > 0, level, 1), white) + LOADING * white) / (
        1 + LOADING
    )


ORACLES: Mapping[str, Oracle] = {"irm": ideal_ratio_mask, "mwf": multichannel_wiener, "tvmwf": varying_wiener}
