"""Trustworthy bins as theory makes them: each hears one of the sources, with the error of a phase that is expected."""

import numpy as np

from ross_payload.localization.phase_statistics import HEARING, FrameStatistics

SPACING, SPEED = 0.05, 343.0  # [m], [m/s]
STEP = 0.25  # that some bins stand for [s]


def phases(azimuths, heading, rng, n=60, *, amplitude=1.0, wet=False):
    """Bins of sources at azimuths [deg] in a room that draws delays to 0 by a factor."""
    frequencies = rng.uniform(300, 6000, n)
    delay = amplitude * SPACING / SPEED * np.cos(np.radians(rng.choice(azimuths, n)) - heading)
    error = np.sqrt(HEARING.noise**2 + HEARING.error[wet] ** 2 * 2 * np.pi * frequencies * SPACING / SPEED)
    phase = 2 * np.pi * frequencies * delay + error * rng.standard_normal(n)
    wrapped = np.angle(np.exp(1j * phase))
    return FrameStatistics(STEP, np.array([heading]), np.zeros(n, np.intp), frequencies, wrapped, np.full(n, 0.3))
