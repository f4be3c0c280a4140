"""Local Gaussian model: known directions, unknown PSDs, multichannel Wiener output.

Every bin is x ~ N(0, sum_k v_k R_k + n I) with a spatial covariance R_k per group and frequency, the noise PSD n, and a
source PSD v_k per bin (Duong, Vincent, Gribonval 2010; multiplicative updates as in Sawada et al. 2013).
"""

from __future__ import annotations

import numpy as np

from ross_payload.dsp.covariance import ROOT2, adjugate, diffuse, direct, outer
from ross_payload.dsp.noise import guessed_psd
from ross_payload.dsp.smooth import average
from ross_payload.dsp.steering import ALIAS, groups_of
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Complex, Groups, Real, Scene

UPDATES = 20
SMOOTHED = range(3, 18)  # updates after which the PSDs are smoothed
FLOOR = 1e-8  # of every PSD, relative to the mean power of the mixture
DIFFUSE = 0.1  # diffuse part of a covariance when nothing is known of the room


def source_psds(observed: Real, covariances: Real, noise_psd: Real) -> Real:
    """Maximum-likelihood PSDs of sources with known covariances, smoothed over neighbouring bins.

    Multiplicative updates v_k <- v_k sqrt(x^H S^-1 R_k S^-1 x / tr(S^-1 R_k)) with S = sum_k v_k R_k. For two
    microphones the fraction is t - tr(R_k adj(x x^H)) / tr(R_k adj(S)) with t = tr(adj(S) x x^H) / det(S)
    (Cayley-Hamilton), so that one matrix product per update is enough. In between, v <- sqrt(v average(v)) over 3 x 3
    bins.

    Parameters
    ----------
    observed
        Coordinates of x x^H, (n_freqs, 4, n_frames).
    covariances
        Coordinates of every R_k, the noise last, (n_freqs, n_groups + 1, 4).
    noise_psd
        n, (n_freqs,).

    Returns
    -------
    ndarray
        v, the noise last, (n_freqs, n_groups + 1, n_frames).
    """
    n_groups = covariances.shape[1] - 1
    cross = covariances @ adjugate(observed, axis=1)
    gram = covariances @ np.swapaxes(adjugate(covariances), 1, 2)
    psds = np.empty_like(cross)
    psds[:, :n_groups] = 0.5 * (observed[:, :1] + observed[:, 1:2]) / n_groups + FLOOR
    psds[:, n_groups:] = noise_psd[:, None, None]
    sources = psds[:, :n_groups]
    for update in range(UPDATES):
        mixed = gram @ psds
        total = 2 * (psds * cross).sum(axis=1) / (psds * mixed).sum(axis=1)
        sources *= np.sqrt(np.maximum(total[:, None] - cross[:, :n_groups] / mixed[:, :n_groups], 0))
        if update in SMOOTHED:
            np.sqrt(sources * average(sources), out=sources)
        np.maximum(sources, FLOOR, out=sources)
    return psds


def wiener(spectrogram: Complex, psds: Real, covariances: Real) -> Complex:
    """Multichannel Wiener output v_k e_1^T R_k S^-1 x of every group at microphone 1, (n_groups, n_freqs, n_frames).

    Parameters
    ----------
    spectrogram
        (2, n_freqs, n_frames).
    psds, covariances
        As of `source_psds`, the noise last.
    """
    total = np.swapaxes(covariances, 1, 2) @ psds
    inverse = adjugate(total, axis=1) / (total[:, :1] * total[:, 1:2] - 0.5 * (total[:, 2:] ** 2).sum(1, keepdims=True))
    cross = (inverse[:, 2] + 1j * inverse[:, 3]) / ROOT2
    first, second = spectrogram
    white = np.stack([inverse[:, 0] * first + cross * second, cross.conj() * first + inverse[:, 1] * second])
    signals = []
    for psd, matrix in zip(np.swapaxes(psds, 0, 1)[:-1], np.swapaxes(covariances, 0, 1)[:-1], strict=True):
        across = ((matrix[:, 2] + 1j * matrix[:, 3]) / ROOT2).astype(white.dtype)
        signals.append(psd * (matrix[:, :1] * white[0] + across[:, None] * white[1]))
    return np.stack(signals)


class Gaussian:
    """The separator: local Gaussian model from known TDOAs."""

    name = "gaussian"

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate a recording (2, n_freqs, n_frames) into groups of sources that share a TDOA.

        Raises
        ------
        ConfigError
            When the TDOAs are not known.
        """
        if scene.tau is None:
            raise ConfigError("the local Gaussian model needs the TDOA of every source, found none")
        tau = np.asarray(scene.tau, float)
        members = groups_of(tau, ALIAS * scene.spacing / scene.speed_of_sound)
        power = float((np.abs(spectrogram) ** 2).mean()) if spectrogram.size else 0.0
        if not members or not power > 0:
            return Groups(np.zeros((len(members), *spectrogram.shape[1:]), spectrogram.dtype), members, self.name)
        unit = (spectrogram / np.sqrt(power)).astype(np.complex64)
        noise = scene.noise_psd / power if scene.noise_psd is not None else guessed_psd(unit)
        noise = np.maximum(noise, FLOOR).astype(np.float32)
        covariances = _covariances(scene, np.array([tau[list(group)].mean() for group in members]))
        psds = source_psds(outer(unit).astype(np.float32), covariances, noise)
        signals = wiener(unit, psds, covariances) * np.float32(np.sqrt(power))
        share = psds[:, :-1] / psds.sum(axis=1, keepdims=True)
        return Groups(signals.astype(spectrogram.dtype), members, self.name, masks=np.swapaxes(share, 0, 1))


def _covariances(scene: Scene, tau: Real) -> Real:
    part = DIFFUSE if scene.directness is None else 0.5 * (1 - scene.directness) + 0.01
    waves = direct(scene.frequencies, tau)
    field = diffuse(scene.frequencies, scene.spacing, scene.speed_of_sound)[:, None]
    noise = np.broadcast_to([1.0, 1.0, 0.0, 0.0], field.shape)
    return np.concatenate([(1 - part) * waves + part * field, noise], axis=1).astype(np.float32)


separator = Gaussian()
