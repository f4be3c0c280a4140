"""What a voice is measured by: cepstra of the frames that are loud, pitch of those that are also periodic.

Mel-frequency cepstra as in Davis and Mermelstein, "Comparison of parametric representations for monosyllabic word
recognition", IEEE Trans. ASSP 28 (1980); pitch by the window-corrected autocorrelation of Boersma, "Accurate
short-term analysis of the fundamental frequency", Proc. Inst. Phonetic Sciences Amsterdam 17 (1993).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dct, idct, irfft, rfft

from ross_payload.dsp.recording_limits import HIGHEST_RATE
from ross_payload.errors import AudioError
from ross_payload.interfaces import Real

RATE = 16_000  # [Hz] at which voices are compared
HOP = 160  # [samples], 10 ms
FRAME = 512  # [samples], 32 ms
PITCH_FRAME = 640  # [samples], 40 ms: two and a half periods at 62.5 Hz
BANDS = 30
BAND_EDGES = (100.0, 7000.0)  # [Hz]
CEPSTRA = 24  # c1..c24; c0 is loudness and stays out
DELTA_GAIN = 3.0  # brings the slopes to the size of the cepstra
FLOOR = 10**-2.0  # of the mean band power: what lies below is hidden by noise or by a separator anyway
PITCH_RANGE = (60.0, 400.0)  # [Hz]
HUM_EDGES = (65.0, 75.0)  # [Hz]: below is hum of the mains, wind and drift, above are voices
PERIODICITY = 0.45  # normalised autocorrelation from which a frame is voiced
LOUDNESS = 10**-2.5  # of the 95th percentile of the frame power: softer frames are pauses or leakage


@dataclass(frozen=True, slots=True)
class Features:
    """What is heard of a voice in a recording."""

    cepstra: Real  # c1.. and their slopes, of the loud frames, float32 (n_loud, 2 * CEPSTRA)
    pitch: Real  # natural logarithm of F0 / 1 Hz, of the loud and periodic frames, (n_voiced,)

    @property
    def seconds(self) -> float:
        """Voiced time [s]."""
        return len(self.pitch) * HOP / RATE


def analyse(voice: Real, rate: int) -> Features:
    """Measure a recording (n_samples,) at ``rate`` [Hz]; silence has no frames.

    Raises
    ------
    AudioError
        When the recording is empty, not one channel, not finite, or sampled below 16 or above 192 kHz.

    Examples
    --------
    >>> tone = sum(np.sin(2 * np.pi * 125 * k * np.arange(16000) / 16000) for k in range(1, 20))
    >>> round(float(np.exp(np.median(analyse(tone, 16000).pitch))))
    125
    """
    samples = at_rate(checked(voice, rate), rate)
    loudness = np.asarray(np.mean(_frames(np.diff(samples, prepend=samples[:1]), FRAME) ** 2, axis=1))
    loud = loudness > LOUDNESS * np.percentile(loudness, 95)
    periodicity, pitch = _pitch(samples, loud)
    return Features(_cepstra(_power(samples), loud), pitch[periodicity > PERIODICITY])


def checked(voice: Real, rate: int) -> Real:
    """Return the recording as float64, or say what is wrong with it."""
    samples = np.asarray(voice, dtype=np.float64)
    if samples.ndim != 1:
        raise AudioError(f"voice: expected one channel (n_samples,), got shape {samples.shape}")
    if rate < RATE:
        raise AudioError(f"voice: expected a rate of at least {RATE} Hz, got {rate} Hz")
    if rate > HIGHEST_RATE:
        raise AudioError(f"voice: expected a rate of at most {HIGHEST_RATE} Hz, got {rate} Hz")
    if not samples.size:
        raise AudioError("voice: expected a recording, got 0 s")
    if not np.isfinite(samples).all():
        wrong = int(np.count_nonzero(~np.isfinite(samples)))
        raise AudioError(f"voice: expected finite samples, got {wrong} that are NaN or infinite")
    return samples


def at_rate(samples: Real, rate: int) -> Real:
    """Resample from ``rate`` to RATE [Hz]."""
    if rate == RATE:
        return samples
    from scipy.signal import resample_poly  # noqa: PLC0415  takes as long as all the rest of the payload

    common = math.gcd(rate, RATE)
    return np.asarray(resample_poly(samples, RATE // common, rate // common))


def without_hum(samples: Real) -> Real:
    """Take out of samples (n,) at RATE what lies below HUM_EDGES; a cosine transform has no jump from end to start.

    Examples
    --------
    Half a second of a tone of 50 Hz, and another one of 100 Hz:

    >>> time = np.arange(8000) / RATE
    >>> [round(float(without_hum(np.cos(2 * np.pi * f * time)).std()), 2) for f in (50, 100)]
    [0.0, 0.71]
    """
    frequencies = np.arange(samples.size) * (RATE / (2 * samples.size))
    low, high = HUM_EDGES
    return np.asarray(
        idct(dct(samples, norm="ortho") * np.clip((frequencies - low) / (high - low), 0, 1), norm="ortho")
    )


def mel_filters() -> Real:
    """Return triangles of equal width on the mel scale, (BANDS, FRAME // 2 + 1), from BAND_EDGES[0] to [1]."""
    low, high = (1127 * np.log1p(edge / 700) for edge in BAND_EDGES)
    edges = 700 * np.expm1(np.linspace(low, high, BANDS + 2) / 1127)
    frequencies = np.arange(FRAME // 2 + 1) * RATE / FRAME
    rising = (frequencies - edges[:-2, None]) / (edges[1:-1] - edges[:-2])[:, None]
    falling = (edges[2:, None] - frequencies) / (edges[2:] - edges[1:-1])[:, None]
    return np.asarray(np.maximum(0, np.minimum(rising, falling)))


def _frames(samples: Real, size: int) -> Real:
    """Cut frames centred on every HOP-th sample, (n_samples // HOP + 1, size)."""
    padded = np.pad(samples, size // 2)
    return np.lib.stride_tricks.sliding_window_view(padded, size)[: len(samples) // HOP * HOP + 1 : HOP]


def _power(samples: Real) -> Real:
    emphasised = samples - 0.97 * np.concatenate([samples[:1], samples[:-1]])
    spectrum = rfft(_frames(emphasised, FRAME) * np.hanning(FRAME), axis=1)
    return np.asarray(np.abs(spectrum) ** 2 @ mel_filters().T)


def _cepstra(power: Real, loud: NDArray[np.bool_]) -> Real:
    """Return cepstra and slopes of the loud frames of band powers (n_frames, BANDS).

    The floor is relative to the mean of the loud frames, so that the level of the recording cancels. Slopes are
    regressions over five frames.
    """
    if not loud.any():
        return np.zeros((0, 2 * CEPSTRA), np.float32)
    log_power = np.log(power / power[loud].mean() + FLOOR)
    cepstra = dct(log_power, type=2, norm="ortho", axis=1)[:, 1 : CEPSTRA + 1]
    around = np.pad(cepstra, ((2, 2), (0, 0)), mode="edge")
    slope = (2 * (around[4:] - around[:-4]) + around[3:-1] - around[1:-3]) / 10
    return np.hstack([cepstra, DELTA_GAIN * slope])[loud].astype(np.float32)


def _pitch(samples: Real, loud: NDArray[np.bool_]) -> tuple[Real, Real]:
    """Return periodicity in [0, 1] and log F0 of the loud frames, (n_loud,)."""
    window = np.hanning(PITCH_FRAME)
    frames = _frames(samples, PITCH_FRAME)[loud]
    frames = (frames - frames.mean(axis=1, keepdims=True)) * window
    correlation, of_window = _autocorrelation(frames), _autocorrelation(window)
    shortest, longest = int(RATE / PITCH_RANGE[1]), int(RATE / PITCH_RANGE[0])
    lags = np.arange(shortest, longest + 1)
    energy = correlation[:, :1] + np.finfo(float).tiny
    normalised = correlation[:, lags] / energy * (of_window[0] / of_window[lags])
    best = np.argmax(normalised - 0.01 * np.log2(lags / shortest), axis=1)  # of two octaves, the higher pitch
    periodicity = np.take_along_axis(normalised, best[:, None], axis=1)[:, 0]
    return periodicity, np.log(RATE / lags[best])


def _autocorrelation(frames: Real) -> Real:
    size = 2 * PITCH_FRAME
    return np.asarray(irfft(np.abs(rfft(frames, size, axis=-1)) ** 2, size, axis=-1))
