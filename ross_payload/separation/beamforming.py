"""Adaptive beamformers towards known directions: MVDR (Capon 1969) and LCMV (Frost 1972)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ross_payload.dsp.steering import directions_of, steering_vectors
from ross_payload.interfaces import Complex, Groups, Scene

LOADING = 1e-3  # of the diagonal, relative to the mean of the diagonal
NOISE_GAIN = 3.0  # most that a null may amplify white noise


def covariance_of(spectrogram: Complex) -> Complex:
    """Mean of x x^H over the frames, loaded on the diagonal, (n_freqs, 2, 2); silent bins get the identity.

    Parameters
    ----------
    spectrogram
        (2, n_freqs, n_frames).
    """
    frames = np.moveaxis(spectrogram, 0, 1).astype(np.complex128)
    matrices = frames @ np.swapaxes(frames.conj(), 1, 2) / max(frames.shape[-1], 1)
    level = 0.5 * np.trace(matrices, axis1=1, axis2=2).real
    matrices = matrices / np.where(level > 0, level, 1)[:, None, None]
    return np.asarray(matrices + np.where(level > 0, LOADING, 1)[:, None, None] * np.eye(2))


def mvdr_weights(covariances: Complex, steering: Complex) -> Complex:
    """Weights w = R^-1 a / (a^H R^-1 a): least output power with gain 1 towards a (Capon 1969), (n_freqs, 2).

    Parameters
    ----------
    covariances
        R, (n_freqs, 2, 2), regular.
    steering
        a, (n_freqs, 2).

    Examples
    --------
    In white noise it is the delayed sum:

    >>> mvdr_weights(np.eye(2)[None] + 0j, np.array([[1.0, 1j]])).tolist()
    [[(0.5+0j), 0.5j]]
    """
    towards = np.linalg.solve(covariances, steering[..., None])[..., 0]
    return np.asarray(towards / (steering.conj() * towards).sum(axis=-1, keepdims=True))


def lcmv_weights(covariances: Complex, constraints: Complex) -> Complex:
    """Weights with gain 1 towards the first direction and 0 towards the second one, (n_freqs, 2).

    w = R^-1 C (C^H R^-1 C)^-1 [1, 0]^T (Frost 1972); two microphones have no freedom left, and w = C^-H [1, 0]^T.
    Where both directions look so alike that |w|^2, the gain of white noise, would exceed 3, the null is given up and
    the weights are those of `mvdr_weights` (the white noise constraint of Cox et al. 1987).

    Parameters
    ----------
    covariances
        R, (n_freqs, 2, 2), regular.
    constraints
        C = [a_1, a_2], (n_freqs, 2, 2).
    """
    (a, b), (c, d) = np.moveaxis(constraints, 0, -1)
    determinant = (a * d - b * c).conj()
    loudest = (np.abs(b) ** 2 + np.abs(d) ** 2) / NOISE_GAIN
    distinct = np.abs(determinant) ** 2 >= np.maximum(loudest, np.finfo(float).tiny)
    nulls = np.stack([d, -b], axis=-1).conj() / np.where(distinct, determinant, 1)[:, None]
    return np.where(distinct[:, None], nulls, mvdr_weights(covariances, constraints[..., 0]))


class Mvdr:
    """The separator: one beam per group, which lets it pass and everything else as little as possible."""

    name = "mvdr"

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate a recording (2, n_freqs, n_frames) into groups of sources that share a TDOA.

        Raises
        ------
        ConfigError
            When the TDOAs are not known.
        """
        members, waves = _directions(scene, self.name)
        covariances = covariance_of(spectrogram)
        weights = [mvdr_weights(covariances, waves[..., k]) for k in range(len(members))]
        return Groups(_beams(weights, spectrogram), members, self.name)


class Lcmv:
    """The separator: one beam per group with a null towards the other one, if there are two."""

    name = "lcmv"

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate a recording (2, n_freqs, n_frames) into groups of sources that share a TDOA.

        Raises
        ------
        ConfigError
            When the TDOAs are not known.
        """
        members, waves = _directions(scene, self.name)
        if len(members) != 2:
            why = f"MVDR: {len(members)} group{'s' * (len(members) != 1)}, and two microphones have one null"
            return replace(mvdr.batch(spectrogram, scene), method=self.name, why=why)
        covariances = covariance_of(spectrogram)
        weights = [lcmv_weights(covariances, waves[..., order]) for order in ([0, 1], [1, 0])]
        return Groups(_beams(weights, spectrogram), members, self.name)


def _directions(scene: Scene, name: str) -> tuple[tuple[tuple[int, ...], ...], Complex]:
    """Members of every group and its steering vector, (n_freqs, 2, n_groups)."""
    members, delays = directions_of(scene, name)
    return members, steering_vectors(scene.frequencies, delays)


def _beams(weights: list[Complex], spectrogram: Complex) -> Complex:
    """Outputs w^H x, (n_groups, n_freqs, n_frames)."""
    first, second = spectrogram
    beams = [w[:, :1].conj() * first + w[:, 1:].conj() * second for w in weights]
    return np.array(beams, spectrogram.dtype).reshape(len(weights), *first.shape)


mvdr = Mvdr()
lcmv = Lcmv()
