"""What sounds far away in the open: many voices all around, and a car that passes."""

from __future__ import annotations

import math

import numpy as np

from ross_payload.interfaces import Real, Samples
from ross_sim.acoustics.sines import sines

Place = tuple[float, float, float]

PERIOD = 20.0  # after which a made sound repeats [s]
AROUND = 12  # directions that babble comes from
AT_ONCE = 3  # voices in each
SYLLABLES = (40, 120)  # cycles of their loudness per period
VOICE = (120.0, 500.0, 2.0)  # speech-shaped: rises to the one, falls above the other [Hz] as this power of frequency
REACH = 4.0  # a car is heard until it is so many times as far away as where it is nearest
TURNS = math.radians(2.0)  # between neighbouring places of its way, seen from the array [rad]
TYRES = 900.0  # the noise of tyres is loudest here [Hz]


def babble_places(distance: float) -> tuple[Place, ...]:
    """Where the voices of babble are, all around at ``distance`` [m]."""
    turns = 2 * math.pi * (np.arange(AROUND) + 0.5) / AROUND
    return tuple((distance * math.cos(turn), distance * math.sin(turn), 0.0) for turn in turns)


def babble(rate: int, rng: np.random.Generator, recording: Samples | None = None) -> list[Samples]:
    """Voices from every direction of `babble_places`, (n,) each; a ``recording`` is heard from anywhere at once.

    What is made is noise with the spectrum of speech whose loudness follows syllables, some voices to a direction.
    """
    if recording is not None:
        return [np.roll(recording, int(rng.integers(recording.size))) for _ in range(AROUND)]
    return [
        np.asarray(sum(_voice(rate, rng) for _ in range(AT_ONCE)), dtype=np.float32) for _ in range(AROUND)
    ]  # fmt: skip


def _voice(rate: int, rng: np.random.Generator) -> Real:
    n = round(PERIOD * rate)
    low, high, slope = VOICE
    frequencies = np.fft.rfftfreq(n, 1 / rate)
    strength = np.minimum(frequencies / low, 1) * (1 + (frequencies / high) ** 2) ** (-slope / 2)
    steady = np.fft.irfft(strength * np.exp(1j * rng.uniform(0, 2 * np.pi, frequencies.size)), n)
    cycles = rng.integers(*SYLLABLES, 8)
    loudness = sines(cycles, rng.uniform(0, 2 * np.pi, cycles.size), n)
    return np.asarray(steady * np.maximum(loudness, 0))


def car_way(azimuth: float, distance: float) -> tuple[tuple[Place, ...], Real]:
    """Places of a car along its way [m], and how far along each is [m], (n_places,); 0 where it is nearest.

    The way is straight and passes the array at ``distance`` [m] in the direction ``azimuth`` [rad]. Seen from the
    array neighbouring places are 2 degrees apart, so that what is heard between two is the mean of both.
    """
    end = math.acos(1 / REACH)
    angles = np.linspace(-end, end, 2 * math.ceil(end / TURNS) + 1)
    along = distance * np.tan(angles)
    ahead = np.array([math.cos(azimuth), math.sin(azimuth)])
    aside = np.array([-ahead[1], ahead[0]])
    places = distance * ahead + along[:, None] * aside
    return tuple((float(x), float(y), 0.0) for x, y in places), along


def tyres(rate: int, rng: np.random.Generator) -> Samples:
    """One period of the noise of tyres on a road, of unit power, (n,)."""
    n = round(PERIOD * rate)
    octaves = np.log2(np.maximum(np.fft.rfftfreq(n, 1 / rate), 1.0) / TYRES)
    strength = np.exp(-0.5 * octaves**2)
    noise = np.fft.irfft(strength * np.exp(1j * rng.uniform(0, 2 * np.pi, octaves.size)), n)
    return np.asarray(noise / np.sqrt(np.mean(noise**2)), dtype=np.float32)
