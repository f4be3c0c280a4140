"""ITD of every time-frequency bin, and how far to trust each: energy, onset, local coherence.

The weights follow three findings about rooms: bins near the noise floor tell nothing; the direct sound comes first, so
rising energy is direct and what decays is reverberation (precedence); and where one source rules a small neighbourhood
of bins its 2 x 2 covariance has rank 1, so the coherence there is near 1 (direct-path dominance, Nadiri and Rafaely
2014).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter, uniform_filter1d

from ross_payload.dsp.stft import band
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Complex, Real

TINY = 1e-30  # power that stands for silence when there is nothing else
SILENCE = 1e-10  # and below this share of the loudest
ALARMS = 3e-5  # mean weight of bins that hold nothing but noise, at most
RAISED = np.linspace(1.0, 3.0, 21)  # noise PSDs that are tried, relative to the one measured
LOW = 500.0  # lowest frequency used [Hz]: below it a phase error is a large ITD error


@dataclass(frozen=True, slots=True)
class Trust:
    """What counts as trustworthy."""

    neighbourhood: tuple[int, int] = (1, 3)  # bins by frames, see `around`, over which the covariance is averaged
    coherence: float = 0.98  # weight 0 below this local coherence
    decay: float = 0.060  # time in which the power of a room's tail is taken to fall to 1/e [s]
    quiet: float = 0.1  # quantile over time that stands for the noise when nobody measured it
    floor: float = 2.0  # power over the noise below which a bin has weight 0


STEP = 0.25  # from one frame of a neighbourhood to the next, as a share of a frame
STRICT = Trust(coherence=0.995)  # for what tells how many sources there are
RULED = Trust(neighbourhood=(3, 3), coherence=0.99)  # for what tells where: bins that one source rules


def around(trust: Trust, frequencies: Real, frame_period: float) -> tuple[int, int]:
    """Bins by frames over which a covariance is averaged: more frames where they overlap by more than three quarters.

    Their noise is nearly the same, and few of them are coherent whatever they hold.

    >>> around(Trust(), np.array([500.0, 525.0]), 0.01), around(Trust(), np.array([500.0, 525.0]), 0.004)
    ((1, 3), (1, 5))
    """
    bins, frames = trust.neighbourhood
    step = frame_period * float(frequencies[1] - frequencies[0]) if len(frequencies) > 1 else STEP
    return bins, max(2 * round((frames - 1) / 2 * STEP / step) + 1, frames)


def local_mean(values: Real, size: tuple[int, int]) -> Real:
    """Average (n_freqs, n_frames) over ``size`` bins by frames `around` each."""
    return np.asarray(uniform_filter(values, size, mode="nearest"))


def itd_per_bin(spectrogram: Complex, frequencies: Real) -> Real:
    """Estimate the ITD [s] of every bin with f > 0, (n_freqs, n_frames); > 0 when microphone 2 leads, Eq. (1).

    Examples
    --------
    Microphone 2 leads by an eighth of a period of 1 kHz:

    >>> itd_per_bin(np.exp(1j * np.array([[[0.0]], [[np.pi / 4]]])), np.array([1000.0])).round(9).tolist()
    [[0.000125]]
    """
    reference, other = spectrogram
    return _itd(other * reference.conj(), frequencies)


def check_array(spacing: float, speed_of_sound: float) -> None:
    """Raise a ConfigError unless d [m] and v_p [m/s] are positive and finite."""
    for what, value in (("spacing", spacing), ("speed of sound", speed_of_sound)):
        if not 0 < value < np.inf:
            raise ConfigError(f"{what}: expected a positive number, got {value:g}")


def band_limits(spacing: float, speed_of_sound: float) -> tuple[float, float]:
    """Lowest and highest frequency [Hz] used; the highest is the spatial aliasing limit v_p / (2 d).

    A wide array whose limit lies near the low cut is heard from a quarter of the limit on.

    >>> band_limits(0.05, 343.0)
    (500.0, 3430.0)
    """
    high = speed_of_sound / (2 * spacing)
    return min(LOW, high / 4), high


def weighted_itd(
    spectrogram: Complex, frequencies: Real, frame_period: float, noise_psd: Real | None, trust: Trust
) -> tuple[Real, Real]:
    """Local ITD [s] and weight in [0, 1] of every bin, both (n_freqs, n_frames).

    The ITD is the phase of the cross-spectrum averaged over the neighbourhood, divided by 2 pi f. The weight is the
    product of energy above noise, onset, coherence and f / max f (an ITD is as precise as its frequency is high).

    Parameters
    ----------
    spectrogram : (2, n_freqs, n_frames)
        Only bins with f > 0.
    frequencies : (n_freqs,)
        [Hz].
    frame_period : float
        Time between frames [s].
    noise_psd : (n_freqs,) or None
        E|noise|^2 per bin; None takes a low quantile over time.
    trust : Trust
        What counts as trustworthy.
    """
    cross, power, clear = _clear(spectrogram, frequencies, frame_period, trust)
    noise = lowest_psd(power, trust) if noise_psd is None else noise_psd[:, None]
    return _itd(cross, frequencies), _energy(power, noise, trust) * clear


def raised_psd(
    quiet: Complex, frequencies: Real, frame_period: float, noise_psd: Real, limits: tuple[float, float]
) -> Real:
    """Noise PSD raised until bins of noise alone have hardly any weight, (n_freqs,).

    Coherence keeps white noise out at any level. A fan has a direction: where it is a little louder than on average it
    would pass for somebody who talks softly all the time. The rate of false alarms is kept constant, as in a radar
    receiver (CFAR, Finn and Johnson 1968).

    Parameters
    ----------
    quiet : (2, n_freqs, n_frames)
        Nothing but noise.
    frequencies : (n_freqs,)
        [Hz].
    frame_period : float
        Time between frames [s].
    noise_psd : (n_freqs,)
        E|noise|^2 per bin.
    limits : (2,)
        Lowest and highest frequency that count [Hz].
    """
    used = band(frequencies, *limits)
    _, power, clear = _clear(quiet[:, used], frequencies[used], frame_period, STRICT)
    weights = [(_energy(power, by * noise_psd[used, None], STRICT) * clear).mean() for by in RAISED]
    return np.asarray(noise_psd * RAISED[np.argmax(np.array([*weights[:-1], 0.0]) <= ALARMS)])


def _clear(spectrogram: Complex, frequencies: Real, frame_period: float, trust: Trust) -> tuple[Complex, Real, Real]:
    """Local cross-spectrum and power of every bin, and its weight but for the energy, (n_freqs, n_frames) each."""
    reference, other = spectrogram
    product = other * reference.conj()
    size = around(trust, frequencies, frame_period)
    cross = local_mean(product.real, size) + 1j * local_mean(product.imag, size)
    first, second = (local_mean(np.abs(channel) ** 2, size) for channel in spectrogram)
    silence = TINY + SILENCE * max(first.max(), second.max())  # running sums leave rounding errors where nothing is
    first, second = np.maximum(first, silence), np.maximum(second, silence)
    power = (first + second) / 2
    coherence = np.abs(cross) / np.maximum(np.sqrt(first * second), TINY)
    onset = np.maximum(1 - tail(power, np.exp(-frame_period / trust.decay)) / power, 0)
    return cross, power, onset * (coherence > trust.coherence) * (frequencies / frequencies.max())[:, None]


def _energy(power: Real, noise: Real, trust: Trust) -> Real:
    return np.asarray(np.maximum(1 - trust.floor * noise / power, 0))


def period_of(frequencies: Real, period: float | None) -> float:
    """Time between frames [s]; that of frames that overlap by three quarters when nobody tells it.

    >>> period_of(np.array([0.0, 25.0]), None), period_of(np.array([0.0, 25.0]), 0.03)
    (0.01, 0.03)
    """
    return float(0.25 / (frequencies[1] - frequencies[0])) if period is None else period


def tail(power: Real, decay: float) -> Real:
    """What is left of the past: ``tail(t) = decay max(tail(t - 1), power(t - 1))``, (n_freqs, n_frames).

    >>> tail(np.array([[8.0, 1.0, 1.0]]), 0.5).tolist()
    [[0.0, 4.0, 2.0]]
    """
    left, past = np.zeros_like(power), np.zeros_like(power[:, 0])
    for frame in range(power.shape[1] - 1):
        past = decay * np.maximum(past, power[:, frame])
        left[:, frame + 1] = past
    return left


def lowest_psd(power: Real, trust: Trust) -> Real:
    """Noise PSD from the quietest frames, smoothed over frequency, (n_freqs, 1)."""
    quiet = np.quantile(power, trust.quiet, axis=1, keepdims=True)
    return np.asarray(1.2 * uniform_filter1d(quiet, 15, axis=0))


def lowest_noise(spectrogram: Complex, frequencies: Real, frame_period: float, trust: Trust) -> Real:
    """Noise PSD from the quietest frames of (2, n_freqs, n_frames), as `weighted_itd` guesses it, (n_freqs,)."""
    power = local_mean((np.abs(spectrogram) ** 2).mean(axis=0), around(trust, frequencies, frame_period))
    return lowest_psd(power, trust)[:, 0]


def _itd(cross: Complex, frequencies: Real) -> Real:
    return np.asarray(np.angle(cross) / (2 * np.pi * frequencies[:, None]))
