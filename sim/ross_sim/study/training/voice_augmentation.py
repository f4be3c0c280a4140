"""Voices to train on made of those there are: excerpts, other speeds, other microphones."""

from __future__ import annotations

import numpy as np
from scipy.signal import resample_poly

from ross_payload.interfaces import Real

RATE = 16_000  # [Hz]


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


def coloured(voice: Real, rng: np.random.Generator) -> Real:
    """Filter by a random smooth response of some dB, as of another microphone."""
    frequencies = np.fft.rfftfreq(len(voice), 1 / RATE)
    mel = np.log1p(frequencies / 700) / np.log1p(RATE / 1400)
    gain_db = sum(rng.normal() * 2.9 / np.sqrt(k) * np.cos(np.pi * k * mel) for k in (1, 2, 3))
    return np.fft.irfft(np.fft.rfft(voice) * 10 ** (gain_db / 20), len(voice))


def _rms(voice: Real) -> float:
    return float(np.sqrt(np.mean(voice**2))) + 1e-12
