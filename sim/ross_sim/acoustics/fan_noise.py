"""The sound of a fan: broadband noise and the tones at which its blades pass, made rather than recorded."""

from __future__ import annotations

import numpy as np

from ross_payload.interfaces import Real, Samples

PERIOD = 20.0  # after which it repeats, without a seam [s]
CORNER, LOWEST = 150.0, 40.0  # its power falls by 6 dB per octave above the one and ends below the other [Hz]
BLADES = 7
TONES = 4  # harmonics; the power of each is a quarter of that of the one before
TONAL = 0.1  # share of the power


def fan(rate: int, rng: np.random.Generator, seconds: float = PERIOD) -> Samples:
    """One period of the noise of a fan at ``rate`` [Hz], of unit power, (n,).

    The broadband part is drawn in the frequency domain, so that it goes on from the last sample to the first. The shaft
    turns 18 to 24 times per second, in whole periods also.

    >>> noise = fan(16000, np.random.default_rng(0), seconds=2.0)
    >>> noise.shape, round(float(np.mean(noise**2)), 3)
    ((32000,), 1.0)
    """
    n = round(seconds * rate)
    frequencies = np.fft.rfftfreq(n, 1 / rate)
    strength = (frequencies >= LOWEST) / np.sqrt(1 + (frequencies / CORNER) ** 2)
    phases = rng.uniform(0, 2 * np.pi, frequencies.size)
    broadband = np.fft.irfft(strength * np.exp(1j * phases), n)
    passing = round(BLADES * rng.uniform(18, 24) * seconds)  # cycles in a period
    turned = 2 * np.pi * np.arange(n) / n
    shifts = rng.uniform(0, 2 * np.pi, TONES)
    tonal = sum(2.0**-k * np.sin((k + 1) * passing * turned + shift) for k, shift in enumerate(shifts))
    parts = np.sqrt(1 - TONAL) * _unit(broadband) + np.sqrt(TONAL) * _unit(np.asarray(tonal))
    return np.asarray(_unit(parts), dtype=np.float32)


def _unit(signal: Real) -> Real:
    return np.asarray(signal / np.sqrt(np.mean(signal**2)))
