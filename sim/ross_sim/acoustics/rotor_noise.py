"""The sound of rotors, made rather than recorded: tones at a blade-pass frequency that wanders, and broadband noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ross_payload.interfaces import Real, Samples
from ross_sim.acoustics.sines import sines

PERIOD = 20.0  # after which it repeats, without a seam [s]
SPREAD = 0.03  # of the mean speeds of the rotors, one standard deviation
WANDER = 0.01  # of one rotor's speed over time, one standard deviation
SLOWEST, FASTEST = 1, 12  # cycles per period in which the speed wanders
TONES = 24  # harmonics; their amplitudes fall as 1 / k
TONAL = 0.5  # share of the power
PEAK, WIDTH, EVEN = 2000.0, 1.2, 0.1  # broadband: where it is loudest [Hz], its spread [octaves], its even part
LOWEST = 40.0  # nothing is below [Hz]


@dataclass(frozen=True, slots=True, eq=False)
class RotorSound:
    """One period of one rotor."""

    sound: Samples  # of unit power, (n,)
    speed: Real  # revolutions per second at every sample, (n,)


def rotor(rate: int, rpm: float, blades: int, rng: np.random.Generator, seconds: float = PERIOD) -> RotorSound:
    """Make one period of the noise of a rotor at ``rate`` [Hz], of unit power.

    Its mean speed is drawn around ``rpm`` [1/min]; the speed wanders by one percent in slow waves. The tones are
    harmonics of the speed times ``blades``, their phases those of the shaft; the broadband part is drawn in the
    frequency domain, so that it goes on from the last sample to the first.

    >>> made = rotor(16000, 6000.0, 2, np.random.default_rng(0), seconds=4.0)
    >>> made.sound.shape, round(float(np.mean(made.sound**2)), 3)
    ((64000,), 1.0)
    """
    n = round(seconds * rate)
    cycles = np.arange(SLOWEST, FASTEST + 1)
    strengths, shifts = rng.standard_normal(cycles.size), rng.uniform(0, 2 * np.pi, cycles.size)
    waves = sines(cycles, shifts, n, strengths)
    waves *= WANDER / np.sqrt(np.mean(np.square(waves)))
    whole = round(rpm / 60 * (1 + SPREAD * rng.standard_normal()) * seconds)  # revolutions in a period
    speed = whole / seconds * (1 + waves - waves.mean())
    phase = 2 * np.pi * blades * (np.cumsum(speed) - speed) / rate
    highest = int(rate / 2 / (1.1 * blades * speed.max()))
    tonal = _harmonics(phase, rng.uniform(0, 2 * np.pi, min(TONES, highest)))
    parts = np.sqrt(TONAL) * _unit(tonal) + np.sqrt(1 - TONAL) * _unit(_broadband(n, rate, rng))
    return RotorSound(np.asarray(_unit(parts), dtype=np.float32), speed)


def _harmonics(phase: Real, shifts: Real) -> Real:
    """The sum of sin(k phase + shift) / k over k = 1, 2, ...: powers of one phasor cost less than sines."""
    fundamental = np.exp(1j * phase)
    tone, heard = np.ones_like(fundamental), np.zeros_like(phase)
    for k, shift in enumerate(shifts, 1):
        tone *= fundamental
        heard += (tone.imag * np.cos(shift) + tone.real * np.sin(shift)) / k
    return heard


def _broadband(n: int, rate: int, rng: np.random.Generator) -> Real:
    frequencies = np.fft.rfftfreq(n, 1 / rate)
    octaves = np.log2(np.maximum(frequencies, 1.0) / PEAK)
    strength = (frequencies >= LOWEST) * (np.exp(-0.5 * (octaves / WIDTH) ** 2) + EVEN)
    return np.asarray(np.fft.irfft(strength * np.exp(1j * rng.uniform(0, 2 * np.pi, frequencies.size)), n))


def _unit(signal: Real) -> Real:
    return np.asarray(signal / np.sqrt(np.mean(np.square(signal))))
