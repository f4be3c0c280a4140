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
TINY = 1e-12


@dataclass(frozen=True, slots=True)
class Vote:
    """A global azimuth from one peak of one orientation, Eq. (total_rot)."""

    azimuth: float  # [rad]
    weight: float  # in (0, 1]
    rotation: int  # r, the orientation that decided


@dataclass(frozen=True, slots=True)
class Test:
    """How the hypotheses are tested."""

    __test__ = False  # not a test of pytest

    gate: float = 0.1  # a predicted ITD is heard when a peak is at most so far off [d / v_p]; 0: prediction alone
    weighted: bool = True  # votes count by how clearly the test decides and how well the ITD tells the angle


def local_aoas(itds: Sequence[float], unit: float) -> Real:
    """Magnitude of the AoA [rad] of ITDs [s], (n,); ``unit`` is d / v_p [s]; impossible ITDs are left out.

    >>> np.rad2deg(local_aoas([0.5, -1.1, 7.0], 1.0)).round(6).tolist()
    [60.0, 180.0]
    """
    cosines = np.array([itd / unit for itd in itds if abs(itd) <= OUTSIDE * unit])
    return np.asarray(np.arccos(np.clip(cosines, -1, 1)))


def votes(before: Observation, after: Observation, rotation: int, unit: float, test: Test) -> list[Vote]:
    """Global azimuths from the peaks of two successive orientations, Eqs. (ITD-est), (MLE_rth), (total_rot).

    Every peak of the first is predicted at the second under both hypotheses; the hypothesis at whose ITD the second
    density is higher wins, and the peak heard there says where exactly. A rotation by a multiple of pi tells nothing.
    """
    turned = after.heading - before.heading
    magnitudes = local_aoas(before.peaks, unit)
    if abs(np.sin(turned)) < BLIND or not len(magnitudes):
        return []
    hypotheses = np.stack([magnitudes, -magnitudes]) - turned  # local AoAs after the rotation
    predicted = unit * np.cos(hypotheses)
    density = np.interp(predicted, after.grid, after.density, left=0.0, right=0.0)
    winner = density.argmax(axis=0)
    sources = np.arange(len(magnitudes))
    clear = np.abs(density[0] - density[1]) / (density.sum(axis=0) + TINY)
    found = []
    for source, local, heard in zip(sources, hypotheses[winner, sources], predicted[winner, sources], strict=True):
        exact = _measured(float(local), float(heard), after.peaks, unit, test.gate)
        if exact is not None and clear[source] > 0:
            weight = float(clear[source] * np.abs(np.sin(exact))) if test.weighted else 1.0
            found.append(Vote(exact + after.heading, max(weight, TINY), rotation))
    return found


def _measured(local: float, predicted: float, peaks: Sequence[float], unit: float, gate: float) -> float | None:
    """Local AoA [rad] of the peak heard at the predicted ITD, on the predicted side; None when none is heard there."""
    if not gate:
        return local
    near = [peak for peak in peaks if abs(peak - predicted) <= gate * unit]
    if not near:
        return None
    peak = min(near, key=lambda peak: abs(peak - predicted))
    return float(np.copysign(local_aoas([peak], unit)[0], np.sin(local)))


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
