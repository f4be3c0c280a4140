"""DUET: every bin belongs to the source whose delay fits it best (Yilmaz and Rickard 2004)."""

from __future__ import annotations

import numpy as np

from ross_payload.dsp.noise import guessed_psd
from ross_payload.dsp.smoothing import average
from ross_payload.dsp.steering import ALIAS, directions_of, steering_vectors
from ross_payload.dsp.stft import aliasing_limit, band
from ross_payload.interfaces import Complex, Groups, Real, Scene

GRID = 181  # delays tried by the blind search
LOWEST = 100.0  # frequency used by the blind search [Hz]


def masks_of(spectrogram: Complex, frequencies: Real, tau: Real) -> Real:
    """Binary masks by the smallest residual |x_2 - exp(j 2 pi f tau) x_1|^2, (n_sources, n_freqs, n_frames).

    It is the likelihood of one plane wave in white noise: the delay whose delayed sum is the loudest wins.
    """
    first, second = spectrogram
    cross = second * first.conj()
    phase = steering_vectors(frequencies, tau)[:, 1].T.conj().astype(cross.dtype)
    score = np.stack([(cross * shift[:, None]).real for shift in phase])
    winner = score.argmax(axis=0)
    return np.asarray(winner == np.arange(len(tau))[:, None, None], np.float32)


def blind_delays(spectrogram: Complex, scene: Scene) -> Real:
    """The K highest separate peaks [s] of the power-weighted delay histogram below the aliasing limit, rising."""
    longest = scene.spacing / scene.speed_of_sound
    use = band(scene.frequencies, LOWEST, aliasing_limit(scene.spacing, scene.speed_of_sound))
    first, second = spectrogram[:, use]
    delay = np.angle(second * first.conj()) / (2 * np.pi * scene.frequencies[use][:, None])
    weight = np.abs(first * second) * scene.frequencies[use][:, None]
    inside = np.abs(delay) <= 1.1 * longest
    edges = np.linspace(-1.1 * longest, 1.1 * longest, GRID + 1)
    counts, _ = np.histogram(delay[inside], edges, weights=weight[inside])
    kernel = np.hanning(11)
    density, centres = np.convolve(counts, kernel / kernel.sum(), "same"), (edges[1:] + edges[:-1]) / 2
    found: list[float] = []
    for _ in range(scene.n_sources):
        if not density.max() > 0:
            break
        best = float(centres[density.argmax()])
        found.append(best)
        density[np.abs(centres - best) < 1.5 * ALIAS * longest] = 0
    return np.sort(np.clip(np.array(found), -longest, longest))


class Duet:
    """The separator: binary masks from delays, known or found in the mixture."""

    name = "duet"

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate a recording (2, n_freqs, n_frames) into groups of sources that share a TDOA.

        Each output is the delayed sum of both microphones, within its mask, times a Wiener gain against the noise.
        """
        if scene.tau is None:
            tau = blind_delays(spectrogram, scene)
            members: tuple[tuple[int, ...], ...] = tuple(() for _ in tau)
        else:
            members, tau = directions_of(scene, self.name)
        if not len(tau):
            return Groups(np.zeros((0, *spectrogram.shape[1:]), spectrogram.dtype), members, self.name)
        masks = masks_of(spectrogram, scene.frequencies, tau)
        noise = scene.noise_psd if scene.noise_psd is not None else guessed_psd(spectrogram)
        shifts = steering_vectors(scene.frequencies, tau)[:, 1].T.conj().astype(spectrogram.dtype)
        beams = 0.5 * (spectrogram[0] + shifts[:, :, None] * spectrogram[1])
        gains = masks * _gains(beams * masks, 0.5 * noise)
        return Groups(beams * gains, members, self.name, masks=gains)


def _gains(beams: Complex, noise_psd: Real) -> Real:
    """Wiener gains 1 - noise / power, the power averaged over 3 x 3 bins, in [0, 1]."""
    power = np.stack([average(np.abs(beam) ** 2) for beam in beams])
    noise = noise_psd[:, None].astype(power.dtype)
    heard = power > noise
    return np.asarray(np.where(heard, 1 - noise / np.where(heard, power, 1), 0))


separator = Duet()
