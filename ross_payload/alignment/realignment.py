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

TELLS = 6.0  # worth of telling the two sides of a source apart that is on either with equal probability [dB]
SEES = 2.0  # worth of hearing an unclear source move [dB]
UNCLEAR = np.radians(8.0)  # standard deviation of a wholly unclear azimuth, on one side [rad]
NEAR = np.radians(40.0)  # that counts as one side [rad]
APART = 0.12  # two delays so far apart are told apart [d / v_p]
POSING = 6.0  # less for a heading at which the target poses with another source [dB]


@dataclass(frozen=True, slots=True)
class Sides:
    """What is believed of every source: on either side of the axis, and how likely the other side is."""

    azimuths: Real  # likelier side [rad], (k,)
    mirrored: Real  # other side [rad], (k,)
    doubt: Real  # probability of the other side, 0 to 0.5, (k,)


@dataclass(frozen=True, slots=True, eq=False)
class Beliefs:
    """Where every source may be."""

    azimuths: Real  # of the grid [rad], (n_azimuths,)
    places: Real  # probabilities on it, rows sum to 1, (k, n_azimuths)
    elevations: Real  # their cosines, (k,)
    directness: float | None  # 1 in the open, less in reverberation, which is assumed when it is not known


def sides(beliefs: Beliefs, heading: float) -> Sides:
    """Split what is believed at the axis of the array, which points to a heading [rad]."""
    azimuths, places = beliefs.azimuths, beliefs.places
    left = np.sin(azimuths - heading) >= 0
    shares = np.stack([places[:, left].sum(axis=1), places[:, ~left].sum(axis=1)])
    unit = np.exp(1j * azimuths)
    means = np.stack([np.angle(places[:, part] @ unit[part]) for part in (left, ~left)])
    order = np.argsort(-shares, axis=0, kind="stable")
    best, other = np.take_along_axis(means, order, axis=0)
    return Sides(best, other, shares.min(axis=0))


def worth(beliefs: Beliefs, source: int, heading: float, headings: Real) -> Real:
    """What every heading [rad] is worth for a source [dB], (n_headings,), as seen from the present ``heading`` [rad].

    The predicted gain is averaged over nobody on the other side of the axis and each one alone there.
    """
    seen = sides(beliefs, heading)
    flips = [np.zeros(len(seen.doubt), bool), *np.eye(len(seen.doubt), dtype=bool)]
    odds = np.array([1.0, *(seen.doubt / np.maximum(1 - seen.doubt, 0.5))])
    gains = [
        _gain(
            phasors(np.where(flip, seen.mirrored, seen.azimuths)) * beliefs.elevations,
            source,
            headings,
            beliefs.directness,
        )
        for flip in flips
    ]
    return np.asarray(odds @ np.array(gains) / odds.sum() + told(beliefs, heading, headings))


def told(beliefs: Beliefs, heading: float, headings: Real) -> Real:
    """What headings [rad] are worth because they tell where unclear sources are [dB], (n_headings,).

    Three things make a heading tell more: the two sides of a source have other delays; a source that is unclear is not
    near the axis, where its delay hardly changes with its azimuth; no two sources have one delay, since whichever of
    them moves then would seem to be either.
    """
    seen, axis = sides(beliefs, heading), np.asarray(headings)
    azimuths, places, elevations = beliefs.azimuths, beliefs.places, beliefs.elevations
    own, other = (
        elevations[:, None] * np.cos(each[:, None] - axis) for each in (seen.azimuths, seen.mirrored)
    )  # (k, n_headings)
    doubt = 4 * seen.doubt * (1 - seen.doubt)
    off = np.angle(np.exp(1j * (azimuths - seen.azimuths[:, None])))
    near = places * (np.abs(off) < NEAR)
    unclear = np.minimum((near * off**2).sum(axis=1) / near.sum(axis=1) / UNCLEAR**2, 1.0)
    value = TELLS * doubt @ _apart(own - other)
    value += SEES * unclear @ (1 - np.exp(-10 * np.sin(seen.azimuths[:, None] - axis) ** 2))
    for one, two in combinations(range(len(places)), 2):
        value += 1.5 * SEES * _apart(own[one] - own[two])
    return np.asarray(value)


def _apart(difference: Real) -> Real:
    return np.asarray(1 - np.exp(-((difference / APART) ** 2)))


def _gain(sources: Complex, source: int, headings: Real, directness: float | None) -> Real:
    tau = (sources[:, None] * np.exp(-1j * np.asarray(headings))).real
    near = np.abs(np.delete(tau, source, axis=0) - tau[source])
    poses = (near < ALIAS).any(axis=0)
    return np.asarray(gain_of(sources, headings, directness)[source] - POSING * poses)
