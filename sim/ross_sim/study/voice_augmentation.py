"""What happens to a voice between the mouth and the voice print: other talkers, masks, noise, rooms, filters."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import uniform_filter
from scipy.signal import butter, fftconvolve, resample_poly, sosfilt

from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Real

RATE = 16_000  # [Hz]
TRANSFORM = Stft(rate=RATE, frame=2048, hop=512)


def at_speed(voice: Real, speed: float) -> Real:
    """Play ``voice`` (n,) faster, and so higher in pitch and formants: another talker of the same accent."""
    return np.asarray(resample_poly(voice, 100, round(100 * speed)))


def excerpt(voice: Real, seconds: float, rng: np.random.Generator) -> Real:
    """Cut a random piece that is not mostly a pause."""
    length = int(seconds * RATE)
    if len(voice) <= length:
        return voice
    piece = voice[:length]
    for _ in range(20):
        start = int(rng.integers(len(voice) - length))
        piece = voice[start : start + length]
        if _rms(piece) > 0.4 * _rms(voice):
            break
    return piece


def noisy(voice: Real, snr_db: float, rng: np.random.Generator) -> Real:
    """Add white noise at a signal-to-noise ratio [dB]."""
    return voice + rng.standard_normal(len(voice)) * _rms(voice) * 10 ** (-snr_db / 20)


def reverberant(voice: Real, rng: np.random.Generator) -> Real:
    """Add a random exponential tail, T60 0.1 to 0.5 s, 0 to 8 dB below the direct sound."""
    n = int(rng.uniform(0.1, 0.5) * RATE)
    tail = rng.standard_normal(n) * 10 ** (-3 * np.arange(n) / n)
    tail *= 10 ** (-rng.uniform(0, 8) / 20) / np.linalg.norm(tail)
    tail[0] = 1
    return np.asarray(fftconvolve(voice, tail)[: len(voice)])


def muffled(voice: Real, rng: np.random.Generator) -> Real:
    """Low-pass at 3.4 to 6.5 kHz, third order."""
    return np.asarray(sosfilt(butter(3, rng.uniform(3400, 6500), "low", fs=RATE, output="sos"), voice))


def coloured(voice: Real, rng: np.random.Generator) -> Real:
    """Filter by a random smooth response of some dB, as of another microphone."""
    frequencies = np.fft.rfftfreq(len(voice), 1 / RATE)
    mel = np.log1p(frequencies / 700) / np.log1p(RATE / 1400)
    gain_db = sum(rng.normal() * 2.9 / np.sqrt(k) * np.cos(np.pi * k * mel) for k in (1, 2, 3))
    return np.fft.irfft(np.fft.rfft(voice) * 10 ** (gain_db / 20), len(voice))


def masked(voice: Real, others: Sequence[Real], rng: np.random.Generator) -> Real:
    """Separate ``voice`` from a mixture with others and white noise by a ratio mask that leaks 8 to 22 dB below.

    The mask is smoothed over 3 x 3 bins in most cases, binary in a quarter of them: the artefacts of separators.
    """
    n, snr_db, leakage = len(voice), rng.uniform(12, 22), 10 ** (-rng.uniform(8, 22) / 10)
    sources = [voice / _rms(voice)]
    for other in others:
        piece = np.resize(excerpt(other, n / RATE, rng), n)
        sources.append(piece / _rms(piece) * 10 ** (rng.uniform(-2, 2) / 20))
    mixture = noisy(np.sum(sources, axis=0), snr_db, rng)
    spectra = np.abs(TRANSFORM.analyse(np.array(sources))) ** 2
    heard = TRANSFORM.analyse(mixture)
    total = np.maximum(spectra.sum(axis=0), np.abs(heard) ** 2) + np.finfo(float).tiny
    mask = (spectra[0] + leakage * spectra[1:].sum(axis=0)) / total
    if rng.random() < 0.7:
        mask = uniform_filter(mask, 3)
    if rng.random() < 0.25:
        mask = (mask > 0.5).astype(float)
    return np.asarray(TRANSFORM.synthesise(heard * mask, n))


def disturbed(voice: Real, others: Sequence[Real], rng: np.random.Generator) -> Real:
    """Let something happen to ``voice``: nothing, noise, a room, a filter, or (three times in eight) a separator."""
    if rng.random() < 0.3:
        voice = coloured(voice, rng)
    match int(rng.integers(8)):
        case 0:
            return voice
        case 1:
            return noisy(voice, rng.uniform(8, 22), rng)
        case 2:
            return reverberant(voice, rng)
        case 3:
            return noisy(reverberant(voice, rng), rng.uniform(10, 20), rng)
        case 4:
            return muffled(voice, rng)
        case _:
            return masked(voice, [others[i] for i in rng.choice(len(others), 2, replace=False)], rng)


def _rms(voice: Real) -> float:
    return float(np.sqrt(np.mean(voice**2))) + 1e-12
