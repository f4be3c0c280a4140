"""Whether to turn a little while listening, because talkers have moved: predicted gain, and what a turn would tell.

Two microphones cannot tell a source from its mirror image in the axis of the array, and two sources with one delay
cannot be told apart when one of them sets out. Both are clear after a turn of a few degrees. A heading is therefore
worth the predicted gain of the target, averaged over what is possible, and the more, the better it tells apart what is
possible of an unclear source.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ross_payload.alignment.predicted_gain import gain_of, phasors
from ross_payload.dsp.steering import ALIAS
from ross_payload.interfaces import Complex, Real

TELLS = 6.0  # worth of telling two ways apart that are equally likely [dB]
SEES = 6.0  # worth of hearing an unclear source move [dB]
SIDEWAYS = 3.0  # how far off the axis a source must be for that: a third of it at 22 degrees, two thirds at 37
UNCLEAR = np.radians(8.0)  # standard deviation of a wholly unclear azimuth, on one side [rad]
APART = 0.12  # two delays so far apart are told apart [d / v_p]
POSING = 6.0  # less for a heading at which the target poses with another source [dB]


@dataclass(frozen=True, slots=True, eq=False)
class Beliefs:
    """Where the sources may be."""

    odds: Real  # of the ways in which all may be, summing to 1, (n_ways,)
    ways: Real  # azimuths then [rad], (n_ways, k)
    azimuths: Real  # likeliest ones [rad], (k,)
    sigmas: Real  # of each around it, the other side of the axis left out [rad], (k,)
    elevations: Real  # their cosines, (k,)
    directness: float | None  # 1 in the open, less in reverberation, which is assumed when it is not known


def worth(beliefs: Beliefs, source: int, headings: Real) -> Real:
    """What every heading [rad] is worth for a source [dB], (n_headings,): predicted gain, and what it tells."""
    gains = [_gain(phasors(way) * beliefs.elevations, source, headings, beliefs.directness) for way in beliefs.ways]
    return np.asarray(beliefs.odds @ np.array(gains) + resolving_value(beliefs, headings))


def resolving_value(beliefs: Beliefs, headings: Real) -> Real:
    """What headings [rad] are worth because they tell where unclear sources are [dB], (n_headings,).

    Three things make a heading tell more: two ways in which all may be have other delays, whoever has them; a source
    that is unclear is not near the axis, where its delay hardly changes with its azimuth; no two sources have one
    delay, since whichever of them moves then would seem to be either.
    """
    axis = np.asarray(headings)
    delays = np.sort(beliefs.elevations[:, None] * np.cos(beliefs.ways[:, :, None] - axis), axis=1)
    value = np.zeros(len(axis))
    for one, two in combinations(range(len(delays)), 2):
        odds = 4 * beliefs.odds[one] * beliefs.odds[two]
        value += TELLS * odds * _apart(np.abs(delays[one] - delays[two]).max(axis=0))
    unclear = np.minimum((beliefs.sigmas / UNCLEAR) ** 2, 1.0)
    value += SEES * unclear @ (1 - np.exp(-SIDEWAYS * np.sin(beliefs.azimuths[:, None] - axis) ** 2))
    own = beliefs.elevations[:, None] * np.cos(beliefs.azimuths[:, None] - axis)
    for one, two in combinations(range(len(own)), 2):
        value += 1.5 * SEES * _apart(own[one] - own[two])
    return np.asarray(value)


def _apart(difference: Real) -> Real:
    return np.asarray(1 - np.exp(-((difference / APART) ** 2)))


def _gain(sources: Complex, source: int, headings: Real, directness: float | None) -> Real:
    tau = (sources[:, None] * np.exp(-1j * np.asarray(headings))).real
    near = np.abs(np.delete(tau, source, axis=0) - tau[source])
    poses = (near < ALIAS).any(axis=0)
    return np.asarray(gain_of(sources, headings, directness)[source] - POSING * poses)
