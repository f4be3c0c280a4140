"""What the vehicle itself sounds like: what a lead-in tells of noise that comes from rotors, or is not white otherwise.

The covariance of the noise is re-estimated in every recording (`noise_field`); the lead-in tells where to begin, how
far the noise departs from Gaussian, and whether it is worth the effort: white noise needs no covariance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter, uniform_filter1d

from ross_payload.dsp.covariance import outer
from ross_payload.dsp.noise import frame_levels
from ross_payload.dsp.noise_field import coherence, noise_field, whitened
from ross_payload.dsp.noise_levels import noise_levels
from ross_payload.dsp.rotor_tones import raised
from ross_payload.dsp.rotors import Rotors
from ross_payload.interfaces import Complex, Marks, Real

LOUD = 0.95  # quantile of local whitened powers that tells how far noise departs from Gaussian
GAUSSIAN = 2.2  # that quantile in Gaussian noise, frames that overlap by three quarters, over the mean
BANDS = 9  # bins over which it is smoothed
AROUND = (1, 3)  # bins by frames of a local power
DIRECTED = 0.35  # coherence between `CLEAR` frequencies above which noise has a direction
CLEAR = (500.0, 3000.0)  # [Hz]
VOICES = (100.0, 4000.0)  # [Hz]
COLOURED = 10.0  # range of the PSD in these frequencies above which noise is not white [dB]
STEADY = 18.0  # 1.0 - 0.1 quantile of frame levels of noise, at most: what varies more is talk [dB]
FEWEST = 8  # frames that tell something
NEAR = (3, 5)  # bins by frames of a local coherence
ONE = 0.8  # coherence of loud bins above which they come from one place
TOP = 0.9  # quantile of powers above which bins are loud


@dataclass(frozen=True, slots=True, eq=False)
class EgoNoise:
    """What a lead-in tells of the noise of the vehicle, for one STFT."""

    rotors: Rotors | None  # None: nobody says where they are
    directed: Real  # share of the noise that comes from the rotors, (n_freqs,)
    outliers: Real  # how far the loud bins of the noise exceed those of Gaussian noise, (n_freqs,), 1 or more
    gusty: bool = False  # not coherent, as wind, whose level changes within a second at all frequencies together

    def field(
        self, spectrogram: Complex, frequencies: Real, period: float, heading: float, tonal: Marks | None = None
    ) -> Real:
        """Coordinates of the noise covariance of every bin (n_freqs, 4, n_frames), at a heading of the vehicle.

        ``tonal`` says where tones of rotors are, as `ross_payload.dsp.rotor_tones.tones` does; None: nobody knows.
        """
        shape = None if self.rotors is None else self.rotors.shape(frequencies, heading, self.directed)
        found = _field(spectrogram, frequencies, period, shape, gusty=self.gusty)
        return found if tonal is None else raised(found, spectrogram, frequencies, tonal)


def learnt(
    lead_in: Complex, frequencies: Real, period: float, heading: float, rotors: Rotors | None
) -> EgoNoise | None:
    """What a lead-in in which nobody talks tells of the noise; None when that is white, or when somebody talks.

    Parameters
    ----------
    lead_in
        Spectrogram (2, n_freqs, n_frames).
    frequencies
        [Hz], (n_freqs,).
    period
        Time between frames [s].
    heading
        Of the array in the frame of the vehicle [rad].
    """
    inner = lead_in[..., 1:-1]  # the frames at the ends are partly empty
    band = (frequencies >= CLEAR[0]) & (frequencies <= CLEAR[1])
    if inner.shape[-1] < FEWEST or not band.any():
        return None
    levels = 10 * np.log10(np.maximum(frame_levels(inner[:, band]), 1e-30))
    observed = outer(inner)
    if np.ptp(np.quantile(levels, (0.1, 0.9))) > STEADY and _talk(observed[band]):
        return None
    mean = observed.mean(axis=2, keepdims=True)
    voices = (frequencies >= VOICES[0]) & (frequencies <= VOICES[1])
    power = 10 * np.log10(np.maximum(_smooth(mean[:, 0, 0] + mean[:, 1, 0])[voices], 1e-30))
    gusty = bool(np.median(coherence(mean)[band]) < DIRECTED)
    if gusty and np.ptp(power) < COLOURED:
        return None
    directed = np.zeros(len(frequencies))
    if rotors is not None:
        whole = rotors.shape(frequencies, heading, np.ones(len(frequencies)))[:, :, None]
        directed = np.clip(_smooth(coherence(mean)[:, 0]) / np.maximum(_smooth(coherence(whole)[:, 0]), 0.1), 0, 1)
    loudness = whitened(observed, _field(inner, frequencies, period, None, gusty=gusty)) / 2
    loud = np.quantile(uniform_filter(loudness, AROUND), LOUD, axis=1) / GAUSSIAN
    return EgoNoise(rotors, directed, np.maximum(_smooth(loud), 1.0), gusty)


def _field(spectrogram: Complex, frequencies: Real, period: float, shape: Real | None, *, gusty: bool) -> Real:
    """The noise field; of noise in gusts after its level has been made even."""
    if not gusty:
        return noise_field(spectrogram, frequencies, period, shape)
    level = noise_levels(spectrogram, frequencies)
    even = (spectrogram / np.sqrt(level)).astype(spectrogram.dtype)
    return np.asarray(noise_field(even, frequencies, period, shape) * level)


def _talk(observed: Real) -> bool:
    """Whether the loud bins of (n_freqs, 4, n_frames) come from one place each, as those of talk do, not of wind."""
    power = observed[:, 0] + observed[:, 1]
    near = uniform_filter(observed, (NEAR[0], 1, NEAR[1]))
    return bool(np.median(coherence(near)[power >= np.quantile(power, TOP)]) > ONE)


def _smooth(values: Real) -> Real:
    return np.asarray(uniform_filter1d(values, BANDS, mode="nearest"))
