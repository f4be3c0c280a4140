"""By which angle all sources together have turned about the array: from one orientation, or between two estimates."""

from __future__ import annotations

import math

import numpy as np

from ross_payload.angles import difference, wrap
from ross_payload.dsp.steering import tdoa
from ross_payload.events import Estimate
from ross_payload.interfaces import Observation

FLOOR = 0.03  # of a density relative to its peak: a talker who pauses must not decide alone
WIDEST, STEP = math.radians(45), math.radians(1)  # of the angles that are tried [rad]
FEWEST = 2  # sources whose shifts can agree
AGREE = math.radians(2)  # between the shifts of two sources [rad]
LEAST, MOST = math.radians(3), math.radians(45)  # of a shift that is believed [rad]


def common_turn(seen: Observation, estimate: Estimate, spacing: float, speed_of_sound: float) -> tuple[float, float]:
    """Return the likeliest common turn of all sources [rad], and how much likelier than none it is [nat].

    Turned by an angle phi, the sources have the TDOAs ``tau_k(phi) = (d / v_p) cos(elevation_k) cos(azimuth_k + phi -
    heading)``; the phi is sought for which the ITD density D is highest there: ``max_phi sum_k log(floor +
    D(tau_k(phi)) / max D)``. One orientation does not tell its sign when sources lie alike on both sides of the axis.

    Two sources at 60 and -60 deg that are heard where 50 and -70 deg would be:

    >>> from ross_payload.events import SourceEstimate
    >>> grid = np.linspace(-1, 1, 201)
    >>> heard = sum(np.exp(-(((grid - np.cos(np.deg2rad(azimuth))) / 0.03) ** 2)) for azimuth in (50, -70))
    >>> sources = tuple(SourceEstimate(math.radians(azimuth), 0.01, 1.0, True) for azimuth in (60, -60))
    >>> angle, gain = common_turn(Observation(0.0, grid, heard, 1.0), Estimate(sources), 343.0, 343.0)
    >>> round(abs(math.degrees(angle))), gain > 3
    (10, True)

    Raises
    ------
    ValueError
        When the estimate has no sources.
    """
    if not estimate.sources:
        raise ValueError("sources: expected at least one, got none")
    turns = np.arange(-round(WIDEST / STEP), round(WIDEST / STEP) + 1) * STEP
    tau = tdoa(estimate.azimuths + turns[:, None], seen.heading, spacing, speed_of_sound, estimate.elevations)
    density = np.interp(tau, seen.grid, seen.density / max(float(seen.density.max()), math.ulp(1.0)))
    likelihood = np.log(density + FLOOR).sum(axis=1)
    best = int(likelihood.argmax())
    return float(turns[best]), float(likelihood[best] - likelihood[len(turns) // 2])


def common_shift(before: Estimate, after: Estimate) -> float | None:
    """Return the angle [rad] by which every azimuth has shifted, None when they did not, or each by its own.

    The least such angle is taken, and only one that is larger than talkers sway and smaller than an eighth of a turn:
    other people who stand where a shift would put them are a matter of chance.
    """
    old, new = before.azimuths, after.azimuths
    if len(old) != len(new) or len(old) < FEWEST:
        return None
    for shift in sorted((wrap(azimuth - old[0]) for azimuth in new), key=abs):
        off = difference(new[None, :], old[:, None] + shift)
        nearest = np.abs(off).argmin(axis=1)
        rest = off[np.arange(len(old)), nearest]
        if len(set(nearest.tolist())) == len(old) and np.ptp(rest) <= AGREE:
            common = shift + float(rest.mean())
            return common if LEAST <= abs(common) <= MOST else None
    return None
