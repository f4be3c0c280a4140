"""Wind in two microphones: low frequencies, each microphone on its own, in gusts that come to both."""

from __future__ import annotations

import numpy as np

from ross_payload.interfaces import Real, Samples

PERIOD = 20.0  # after which it repeats, without a seam [s]
LOWEST, CORNER = 20.0, 80.0  # its power falls above the one by SLOPE and ends below the other [Hz]
SLOPE = 5 / 3  # exponent of the power of turbulence over frequency (Kolmogorov 1941)
GUSTS = 6.0  # of the level, one standard deviation [dB]
SLOW = (1, 10)  # cycles per period of the gusts: the shortest takes 2 s
SCREEN_DB, SCREEN_FROM = 12.0, 100.0  # what a windscreen takes at any frequency, and 6 dB per octave more above [Hz]


def wind(
    rate: int,
    rng: np.random.Generator,
    *,
    gusts: bool = True,
    windscreen: bool = False,
    seconds: float = PERIOD,
    recording: Samples | None = None,
) -> Samples:
    """One period of wind at ``rate`` [Hz] in two microphones, (2, n), of unit power before the windscreen.

    Turbulence passes either microphone at other times, so that the two are not coherent. Gusts are slower than the
    way from one microphone to the other: their level is one for both. A ``recording`` (n,) takes the place of the
    turbulence and has its own gusts; microphone 2 hears it half a recording later.

    >>> noise = wind(16000, np.random.default_rng(0), gusts=False, seconds=4.0)
    >>> noise.shape, np.mean(noise**2, axis=1).round(2).tolist()
    ((2, 64000), [1.0, 1.0])
    """
    if recording is not None:
        turbulence = np.stack([recording, np.roll(recording, recording.size // 2)]).astype(float)
    else:
        n = round(seconds * rate)
        frequencies = np.fft.rfftfreq(n, 1 / rate)
        strength = (frequencies >= LOWEST) * (1 + (frequencies / CORNER) ** 2) ** (-SLOPE / 4)
        phases = rng.uniform(0, 2 * np.pi, (2, frequencies.size))
        turbulence = np.fft.irfft(strength * np.exp(1j * phases), n)
        if gusts:
            turbulence = turbulence * 10 ** (gust_levels(n, rng) / 20)
    unit = turbulence / np.sqrt(np.mean(turbulence**2, axis=1, keepdims=True))
    return np.asarray(_screened(unit, rate) if windscreen else unit, dtype=np.float32)


def gust_levels(n: int, rng: np.random.Generator) -> Real:
    """Level of the gusts over one period [dB], (n,), mean 0, without a seam."""
    cycles = np.arange(SLOW[0], SLOW[1] + 1)
    strengths, shifts = rng.standard_normal(cycles.size), rng.uniform(0, 2 * np.pi, cycles.size)
    turned = 2 * np.pi * np.arange(n) / n
    waves = np.asarray(sum(s * np.sin(c * turned + p) for c, s, p in zip(cycles, strengths, shifts, strict=True)))
    return np.asarray(GUSTS * waves / np.sqrt(np.mean(waves**2)))


def _screened(signal: Real, rate: int) -> Real:
    frequencies = np.fft.rfftfreq(signal.shape[1], 1 / rate)
    taken = 10 ** (-SCREEN_DB / 20) / np.maximum(frequencies / SCREEN_FROM, 1.0)
    return np.asarray(np.fft.irfft(np.fft.rfft(signal) * taken, signal.shape[1]))
