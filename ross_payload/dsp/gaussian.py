"""Local Gaussian model: directions known, covariances learnt, PSDs per bin, multichannel Wiener output.

Every bin is x ~ N(0, sum_k v_k R_k + n I) with a spatial covariance R_k per group and frequency, the noise PSD n, and a
source PSD v_k per bin (Duong, Vincent, Gribonval 2010; multiplicative updates as in Sawada et al. 2013).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ross_payload.dsp.covariance import ROOT2, adjugate, diffuse, direct, outer
from ross_payload.dsp.noise import guessed_psd
from ross_payload.dsp.smooth import averaged_rows
from ross_payload.dsp.spatial import learn
from ross_payload.dsp.steering import directions_of
from ross_payload.dsp.stft import band
from ross_payload.interfaces import Complex, Groups, Real, Scene

UPDATES = 20
UNSMOOTHED = 2  # updates before the smoothing begins
AT_ONCE = 10000  # time-frequency bins worked on together: they stay in the cache
FLOOR = 1e-8  # of every PSD, relative to the mean power of the mixture
ACTIVE = 1.15  # bins with less than this many times the noise hold nobody
DRY, WET = (0.03, 0.5), (0.4, 0.3)  # (diffuse part, anchor) in the open and in reverberation
ASTRAY = (0.008, 0.013)  # energy that no direction explains, in the open and in reverberation
CLEAR, LOUD = 30.0, 4.0  # it is measured in bins this many times above the noise, and above the mean of the frequency
VOICE = (500.0, 4000.0)  # and between these frequencies [Hz]


def source_psds(observed: Real, covariances: Real, noise_psd: Real) -> Real:
    """PSDs of sources with known covariances, smoothed over neighbouring bins.

    Multiplicative updates v_k <- v_k x^H S^-1 R_k S^-1 x / tr(S^-1 R_k) with S = sum_k v_k R_k. For two microphones
    the fraction is t - tr(R_k adj(x x^H)) / tr(R_k adj(S)) with t = tr(adj(S) x x^H) / det(S) (Cayley-Hamilton), so
    that one matrix product per update is enough. All but the first are smoothed: the geometric mean of the update
    and of the 3 x 3 average before it.

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
    other = psds.copy()
    height = max(AT_ONCE // max(psds.shape[2], 1), 1)
    for update in range(UPDATES):
        for low in range(0, len(psds), height):
            rows = slice(low, low + height)
            sources = _updated(psds[rows], cross[rows], gram[rows])
            if update >= UNSMOOTHED:
                sources *= averaged_rows(psds[:, :n_groups], low, low + height)
                np.sqrt(sources, out=sources)
            np.maximum(sources, FLOOR, out=other[rows, :n_groups])
        psds, other = other, psds
    return psds


def _updated(psds: Real, cross: Real, gram: Real) -> Real:
    """One multiplicative update of the sources alone, (n_freqs, n_groups, n_frames)."""
    mixed = gram @ psds
    total = 2 * np.einsum("fkt,fkt->ft", psds, cross) / np.einsum("fkt,fkt->ft", psds, mixed)
    ratio = np.asarray(cross[:, :-1] / mixed[:, :-1])
    np.subtract(total[:, None], ratio, out=ratio)
    np.maximum(ratio, 0, out=ratio)
    ratio *= psds[:, :-1]
    return ratio


def directness_of(observed: Real, frequencies: Real, waves: Real, noise_psd: Real) -> float:
    """How much every strong bin looks like one of the plane waves: 1 in the open, 0 in strong reverberation.

    The median over strong bins of the part of their energy that is orthogonal to the steering vector that fits best.

    Parameters
    ----------
    observed
        Coordinates of x x^H, (n_freqs, 4, n_frames).
    waves
        Coordinates of a a^H of every group, (n_freqs, n_groups, 4).
    """
    power = observed[:, 0] + observed[:, 1]
    least = np.maximum(2 * CLEAR * noise_psd, LOUD * power.mean(axis=1))
    strong = (power > least[:, None]) & band(frequencies, *VOICE)[:, None]
    if not strong.any():
        return 1.0
    orthogonal = (waves @ adjugate(observed, axis=1)).min(axis=1)[strong] / (2 * power[strong])
    return float(np.clip((ASTRAY[1] - np.median(orthogonal)) / (ASTRAY[1] - ASTRAY[0]), 0, 1))


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
        members, delays = directions_of(scene, "the local Gaussian model")
        shape = (len(members), *spectrogram.shape[1:])
        signals, masks = np.zeros(shape, spectrogram.dtype), np.zeros(shape, np.float32)
        power = float((np.abs(spectrogram) ** 2).mean()) if spectrogram.size else 0.0
        if members and power > 0:
            unit = (spectrogram / np.sqrt(power)).astype(np.complex64)
            noise = guessed_psd(unit) if scene.noise_psd is None else scene.noise_psd / power
            noise = np.maximum(noise, FLOOR).astype(np.float32)
            active = (np.abs(unit) ** 2).mean(axis=(0, 2)) > ACTIVE * noise
            part = replace(scene, frequencies=scene.frequencies[active], tau=delays)
            if active.any():
                found, masks[:, active] = _separated(unit[:, active], part, noise[active])
                signals[:, active] = found * np.sqrt(power)
        return Groups(signals, members, self.name, masks=masks)


def _separated(unit: Complex, scene: Scene, noise_psd: Real) -> tuple[Complex, Real]:
    """Signals and Wiener masks, both (n_groups, n_freqs, n_frames), of one group per TDOA."""
    _, covariances, psds = fitted(unit, scene, noise_psd)
    masks = np.swapaxes(psds[:, :-1] / psds.sum(axis=1, keepdims=True), 0, 1)
    return wiener(unit, psds, covariances), masks


def fitted(unit: Complex, scene: Scene, noise_psd: Real) -> tuple[Real, Real, Real]:
    """Coordinates of x x^H, of every covariance, and the PSDs: the arguments and the result of `source_psds`.

    Parameters
    ----------
    unit
        Mixture of mean power 1, (2, n_freqs, n_frames).
    scene
        Its ``tau`` are those of the groups [s], (n_groups,).
    noise_psd
        (n_freqs,).
    """
    observed = outer(unit).astype(np.float32)
    waves = direct(scene.frequencies, np.asarray(scene.tau)).astype(np.float32)
    direct_part = scene.directness
    if direct_part is None:
        direct_part = directness_of(observed, scene.frequencies, waves, noise_psd)
    share, anchor = (direct_part * dry + (1 - direct_part) * wet for dry, wet in zip(DRY, WET, strict=True))
    field = diffuse(scene.frequencies, scene.spacing, scene.speed_of_sound).astype(np.float32)[:, None]
    covariances = learn(observed, (1 - share) * waves + share * field, noise_psd, anchor)
    white = np.broadcast_to(np.array([1, 1, 0, 0], np.float32), field.shape)
    covariances = np.concatenate([covariances, white], axis=1)
    return observed, covariances, source_psds(observed, covariances, noise_psd)


separator = Gaussian()
