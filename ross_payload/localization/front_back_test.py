"""One step of the Markov chain of Algorithm 1: two orientations and the rotation between them tell front from back.

A peak at ITD delta is a source at +arccos(delta v_p / d) or at minus that. After a rotation the two would be heard at
two different ITDs; the density heard there decides (a binary hypothesis test with equal priors).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ross_payload.interfaces import Observation, Real

BLIND = np.sin(np.deg2rad(4.0))  # sine of a rotation that moves the two hypotheses apart too little to test
OUTSIDE = 1.2  # an ITD beyond this [d / v_p] belongs to no source
TINY = 1e-9  # the weight of an undecided test before the power is taken


@dataclass(frozen=True, slots=True)
class Vote:
    """A global azimuth from one peak of one orientation, Eq. (total_rot)."""

    azimuth: float  # [rad]
    weight: float  # in (0, 1]
    rotation: int  # r, the orientation that decided


@dataclass(frozen=True, slots=True)
class Trial:
    """How the hypotheses are tested; power 0 and one way is the paper's test."""

    power: float = 0.7  # of the clearness of a test as the weight of its vote; 0: all votes count alike
    both_ways: bool = True  # the peaks of the later orientation are tested against the earlier one too


def local_aoas(itds: Sequence[float], unit: float) -> Real:
    """Magnitude of the AoA [rad] of ITDs [s], (n,); ``unit`` is d / v_p [s]; impossible ITDs are left out.

    >>> np.rad2deg(local_aoas([0.5, -1.1, 7.0], 1.0)).round(6).tolist()
    [60.0, 180.0]
    """
    cosines = np.array([itd / unit for itd in itds if abs(itd) <= OUTSIDE * unit])
    return np.asarray(np.arccos(np.clip(cosines, -1, 1)))


def votes(before: Observation, after: Observation, rotation: int, unit: float, trial: Trial) -> list[Vote]:
    """Global azimuths from two successive orientations, Eqs. (ITD-est), (MLE_rth), (total_rot)."""
    found = decided(before, after, rotation, unit, trial.power)
    return found + (decided(after, before, rotation, unit, trial.power) if trial.both_ways else [])


def decided(here: Observation, there: Observation, rotation: int, unit: float, power: float) -> list[Vote]:
    """Global azimuths from the peaks of one orientation, front told from back by the density of another.

    Every peak is predicted there under both hypotheses; the one at whose ITD the density is higher wins. A rotation by
    a multiple of pi tells nothing. With ``p`` and ``q`` the two densities and theta the local AoA the weight is
    ``(|p - q| / (p + q) |sin theta|) ** power``: how clear the test is, and how well an ITD tells an angle.
    """
    turned = there.heading - here.heading
    magnitudes = local_aoas(here.peaks, unit)
    if abs(np.sin(turned)) < BLIND or not len(magnitudes):
        return []
    hypotheses = np.stack([magnitudes, -magnitudes])
    predicted = unit * np.cos(hypotheses - turned)
    density = np.interp(predicted, there.grid, there.density, left=0.0, right=0.0)
    local = np.where(density[0] >= density[1], magnitudes, -magnitudes)
    total = density.sum(axis=0)
    clear = np.abs(density[0] - density[1]) / np.maximum(total, np.finfo(float).tiny)
    weights = np.maximum(clear * np.sin(magnitudes), TINY) ** power
    return [
        Vote(float(azimuth), float(weight), rotation)
        for azimuth, weight in zip((local + here.heading)[total > 0], weights[total > 0], strict=True)
    ]


def refined(density: Real, grid: Real, peak: float) -> float:
    """Top [s] of the parabola through the logarithms of a peak's bin and its neighbours: exact for a Gaussian.

    >>> round(refined(np.exp(-((np.arange(5.0) - 2.2) ** 2)), np.arange(5.0), 2.0), 9)
    2.2
    """
    place = int(np.abs(grid - peak).argmin())
    if not 0 < place < len(grid) - 1 or not density[place - 1 : place + 2].min() > 0:
        return peak
    left, top, right = np.log(density[place - 1 : place + 2])
    bend = left - 2 * top + right
    return float(peak + (grid[1] - grid[0]) * (left - right) / 2 / bend) if bend < 0 else peak
