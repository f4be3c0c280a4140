"""What one heading tells about the array: phase and level between the microphones in every frequency bin.

The frames are longer than a room rings, so that each bin has one transfer function from a source at rest to each
microphone. Then the coherence over time tells sound from what is independent at the microphones, whatever the room;
the room shows in how the phase varies from bin to bin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Complex, Real, Samples

FRAME = 0.256  # [s], rounded to a power of two in samples
LOWEST = 300.0  # [Hz]: rumble and mains hum lie below
HIGHEST = 8000.0  # [Hz]
BELOW_HALF = 0.95  # of half the rate: converters cut off what is above
PIECE = 16  # frames that are added at once: no sum of them takes long
OVERLAPPED = 0.95  # independent frames per frame: Hann windows that overlap by half (Welch 1967)
FULL = 1 - 2**-15  # what a 16-bit converter says at full scale
HEARD = 0.025  # mean share of the power that both microphones have in common where a sound is heard
TINY = 1e-20


@dataclass(frozen=True, slots=True)
class HeadingSpectrum:
    """What both microphones heard at one heading."""

    heading: float  # [rad]
    frequencies: Real  # [Hz], (n_freqs,)
    phase: Complex  # of microphone 2 against microphone 1, of modulus 1, (n_freqs,)
    weight: Real  # share of the power that both have in common, 0 to 1, (n_freqs,)
    level_db: Real  # of microphone 2 over microphone 1 [dB], (n_freqs,)
    power_db: float  # mean of both in the band [dB re full scale]
    coherence: float  # mean of the weights, near 0 when there is only noise of the microphones
    clipped: bool = False  # samples at full scale


def heading_spectrum(samples: Samples, rate: int, heading: float) -> HeadingSpectrum | None:
    """Condense what was heard at rest at one heading [rad]; samples (2, n). None when it is shorter than two frames.

    The weight is the magnitude-squared coherence less what independent noise would have by chance (Carter 1987):
    ``(n C - 1) / (n - 1)`` of n independent frames.
    """
    frame = 2 ** round(math.log2(FRAME * rate))
    stft = Stft(rate, frame, frame // 2)
    if samples.shape[1] < 2 * frame:
        return None
    band = (stft.frequencies >= LOWEST) & (stft.frequencies <= min(HIGHEST, BELOW_HALF * rate / 2))
    cross, first, second, count = _sums(samples, stft, band)
    coherence = np.abs(cross) ** 2 / (first * second + TINY**2)
    independent = max(OVERLAPPED * count, 2.0)
    common = (independent * coherence - 1) / (independent - 1)
    power = float(np.mean(first + second)) / (2 * count * frame)
    return HeadingSpectrum(
        heading=heading,
        frequencies=stft.frequencies[band],
        phase=cross / (np.abs(cross) + TINY),
        weight=np.where(first * second > 0, np.clip(common, 0.0, 1.0), 0.0),
        level_db=10 * np.log10((second + TINY) / (first + TINY)),
        power_db=10 * math.log10(power + TINY),
        coherence=float(common.mean()),
        clipped=bool(np.abs(samples).max() >= FULL),
    )


def _sums(samples: Samples, stft: Stft, band: NDArray[np.bool_]) -> tuple[Complex, Real, Real, int]:
    """Cross-spectrum of microphone 2 with 1, and both power spectra, summed over the whole frames."""
    n = int(np.count_nonzero(band))
    cross, first, second = np.zeros(n, complex), np.zeros(n), np.zeros(n)
    count = (samples.shape[1] - stft.frame) // stft.hop + 1
    for begin in range(0, count, PIECE):
        some = range(begin, min(begin + PIECE, count))
        frames = np.stack([samples[:, i * stft.hop : i * stft.hop + stft.frame] for i in some], axis=1)
        spectra = np.fft.rfft(frames * np.hanning(stft.frame), axis=-1)[..., band]
        cross += (spectra[1] * spectra[0].conj()).sum(axis=0)
        first += (np.abs(spectra[0]) ** 2).sum(axis=0)
        second += (np.abs(spectra[1]) ** 2).sum(axis=0)
    return cross, first, second, count
