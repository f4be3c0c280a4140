"""How talkers move, as seen from the array: they rest, set out, keep their rate, turn back, stop.

A belief about one talker who has left its place is a point-mass density on a grid of rates and azimuths, (n_rates,
n_azimuths). It is moved by its rates in the Fourier domain, so that the grid itself does not spread it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.fft import irfft, rfft

from ross_payload.angles import difference
from ross_payload.interfaces import Complex, Real

N_AZIMUTHS = 360
STEP = 2 * np.pi / N_AZIMUTHS  # of the grid [rad]
AZIMUTHS = np.arange(N_AZIMUTHS) * STEP  # [rad]
RATES = np.radians([-19.0, -15.0, -12.0, -9.5, -7.5, -5.5, -3.5, -1.5, 0.0, 1.5, 3.5, 5.5, 7.5, 9.5, 12.0, 15.0, 19.0])
REST = int(np.flatnonzero(RATES == 0)[0])  # the rate of a source at rest
TINY = 1e-30


@dataclass(frozen=True, slots=True)
class Motion:
    """How people move, as seen from the array."""

    sets_out: float = 0.04  # a source at rest begins to walk [1/s]
    stops: float = 0.05  # a walking source stops [1/s]
    turns: float = 0.2  # it turns back [1/s]
    changes: float = 0.1  # it takes any other rate [1/s]
    anywhere: float = 0.0005  # who has left its place may be anywhere [1/s]: so that what was lost can be found
    settles: float = 0.2  # a source that rests where it was at first is taken to be there as before [1/s]
    begins: float = 0.4  # who is silent begins to talk [1/s]
    ends: float = 0.15  # who talks falls silent [1/s]
    steady: float = np.radians(1.0)  # of a rate, per root second [rad/s^1.5]
    sway: float = np.radians(1.0)  # of an azimuth, per root second [rad/s^0.5]
    aside: float = 1.0  # two people are not in one direction [1/s]
    elbows: float = np.radians(10.0)  # nearer than this [rad]


MOTION = Motion()


@lru_cache(1)
def fresh_rates() -> Real:
    """How fast somebody walks who sets out: slow rates are likelier, (n_rates,)."""
    width = np.gradient(RATES)
    density = np.where(np.abs(RATES) <= np.radians(10.0), 2.0, 1.0) * width
    density[REST] = 0.0
    return np.asarray(density / density.sum())


@lru_cache(16)
def _changes(seconds: float, motion: Motion) -> Real:
    """Probability of every rate (rows) after every rate (columns), (n_rates, n_rates)."""
    n, fresh = len(RATES), fresh_rates()
    width = np.gradient(RATES)
    drift = motion.steady * np.sqrt(seconds)
    walks = np.arange(n) != REST
    near = np.zeros((n, n))
    for place in range(n - 1):  # neighbours exchange what a random walk of the rate would
        for one, two in ((place, place + 1), (place + 1, place)):
            gap = abs(RATES[one] - RATES[two])
            near[two, one] = min(drift**2 / (2 * gap * width[one]), 0.25)
    near[REST, :] = near[:, REST] = 0.0
    near += np.diag(1 - near.sum(axis=0))
    stops, turns, changes = (1 - np.exp(-rate * seconds) for rate in (motion.stops, motion.turns, motion.changes))
    out = 1 - np.exp(-motion.sets_out * seconds)
    after = (1 - stops - turns - changes) * near + turns * np.eye(n)[::-1] + changes * fresh[:, None]
    after[REST] += stops
    after[:, REST] = np.where(walks, out * fresh, 1 - out)
    return np.asarray(after, np.float32)


@lru_cache(16)
def _travel(seconds: float, sway: float) -> Complex:
    """Fourier coefficients of how every rate moves an azimuth, (n_rates, n_azimuths // 2 + 1)."""
    orders = np.arange(N_AZIMUTHS // 2 + 1)
    return np.asarray(
        np.exp(-1j * orders * RATES[:, None] * seconds - 0.5 * orders**2 * sway**2 * seconds), np.complex64
    )


def moved(belief: Real, seconds: float, motion: Motion = MOTION) -> Real:
    """Let somebody live for ``seconds``: what is believed then, (..., n_rates, n_azimuths), summing to 1."""
    spectra = rfft(_changes(seconds, motion) @ belief) * _travel(seconds, motion.sway)
    after = np.maximum(irfft(spectra, N_AZIMUTHS), 0.0)
    lost, whole = motion.anywhere * seconds, after.sum(axis=(-2, -1), keepdims=True)
    anywhere = lost / N_AZIMUTHS * after.sum(axis=-1, keepdims=True)
    return np.asarray(((1 - lost) * after + anywhere) / whole)


def around(azimuth: float, sigma: float) -> Real:
    """Gaussian density on the grid around an azimuth [rad], (n_azimuths,), summing to 1."""
    density = np.exp(-0.5 * (difference(AZIMUTHS, azimuth) / sigma) ** 2)
    return np.asarray(density / density.sum())


def talks(before: Real, seconds: float, motion: Motion = MOTION) -> Real:
    """Probability that somebody talks ``seconds`` later, for the probabilities that they do now, (k,)."""
    total = motion.begins + motion.ends
    mean = motion.begins / total
    return np.asarray(mean + (before - mean) * np.exp(-total * seconds))
