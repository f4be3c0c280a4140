"""How talkers move, as seen from the array: they rest, set out, keep their rate, turn back, stop.

A particle is one way in which all sources may be: azimuths, rates, and where each rested last.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from ross_payload.angles import difference
from ross_payload.interfaces import Real

TINY = 1e-12


@dataclass(frozen=True, slots=True)
class Motion:
    """How people move, as seen from the array."""

    sets_out: float = 0.04  # who rests begins to walk [1/s]
    tries: float = 6.0  # so many more particles set out, each with so much less weight
    stops: float = 0.05  # who walks stops [1/s]
    turns: float = 0.1  # who walks turns back [1/s]
    changes: float = 0.1  # who walks takes any other rate [1/s]
    mirrored: float = 0.01  # who walks did so on the other side of the axis [1/s]
    another: float = 1.0  # of two with one delay it was the other one who set out [1/s]
    one: float = 0.15  # what counts as one delay there [d / v_p]
    anywhere: float = 0.0005  # whoever it is may be anywhere [1/s]: so that what was lost can be found
    slowest: float = np.radians(1.5)  # rate [rad/s]
    fastest: float = np.radians(20.0)  # rate [rad/s]
    steady: float = np.radians(1.0)  # of a rate, per root second [rad/s^1.5]
    sway: float = np.radians(0.4)  # of an azimuth, per root second [rad/s^0.5]
    aside: float = 1.0  # two people are not in one direction [1/s]
    elbows: float = np.radians(10.0)  # nearer than this [rad]


MOTION = Motion()


@dataclass(frozen=True, slots=True, eq=False)
class Particles:
    """Many ways in which all sources may be, each with its weight."""

    azimuths: Real  # [rad], (n_particles, k)
    rates: Real  # [rad/s], (n_particles, k)
    homes: Real  # where it rested last [rad], (n_particles, k)
    weights: Real  # sum to 1, (n_particles,)


def moved(
    before: Particles, seconds: float, heading: float, random: np.random.Generator, motion: Motion = MOTION
) -> Particles:
    """Let every particle live for ``seconds``, while the axis of the array points to a heading [rad]."""
    azimuths, rates = before.azimuths, before.rates
    walks, shape = rates != 0, rates.shape
    draw = random.random(shape)
    fresh = random.uniform(motion.slowest, motion.fastest, shape) * random.choice([-1.0, 1.0], shape)
    fresh = np.where(random.random(shape) < 0.5, fresh / 2, fresh)  # slow ones are more
    limits = np.cumsum([motion.stops, motion.turns, motion.changes]) * seconds
    changed = np.select([draw < limit for limit in limits], [np.zeros(shape), -rates, fresh], rates)
    changed = changed + (changed != 0) * motion.steady * np.sqrt(seconds) * random.standard_normal(shape)
    odds = motion.sets_out * seconds
    tried = min(motion.tries * odds, 0.5)
    out = ~walks & (draw < tried)
    ratio = np.where(walks, 1.0, np.where(out, odds / tried, (1 - odds) / (1 - tried))).prod(axis=1)
    rates = np.where(walks, changed, np.where(out, fresh, 0.0))
    azimuths = azimuths + rates * seconds + motion.sway * np.sqrt(seconds) * random.standard_normal(shape)
    draw = random.random(shape)
    flipped = (draw < motion.mirrored * seconds) & (rates != 0)
    azimuths, rates = np.where(flipped, 2 * heading - azimuths, azimuths), np.where(flipped, -rates, rates)
    homes = np.where((rates == 0) & walks, azimuths, before.homes)
    after = Particles(azimuths, rates, homes, before.weights)
    after = _another(after, heading, random.random(len(azimuths)) / max(motion.another * seconds, TINY), motion.one)
    lost = draw > 1 - motion.anywhere * seconds
    azimuths = np.where(lost, random.uniform(-np.pi, np.pi, shape), after.azimuths)
    apart = np.abs(difference(azimuths[:, :, None], azimuths[:, None]))
    close = (apart < motion.elbows).sum(axis=(1, 2)) - shape[1]
    weights = before.weights * ratio * np.exp(-0.5 * motion.aside * seconds * close)
    return Particles(azimuths, after.rates, homes, weights / weights.sum())


def _another(particles: Particles, heading: float, drawn: Real, one: float) -> Particles:
    """Let another source have set out instead: one that rests and whose home has the same delay.

    It is where the mirror image of the first one is, or where that one is itself when their homes are on one side; the
    first one is at home. What is heard at this heading does not tell the two apart.
    """
    azimuths, rates, homes = particles.azimuths.copy(), particles.rates.copy(), particles.homes
    delays = np.cos(homes - heading)
    pairs = list(permutations(range(rates.shape[1]), 2))
    drawn = drawn * len(pairs)  # particles below 1 consider the first pair, those below 2 the second
    for number, (walker, other) in enumerate(pairs):
        meant = (drawn >= number) & (drawn < number + 1)
        meant &= (rates[:, walker] != 0) & (rates[:, other] == 0)
        meant &= np.abs(delays[:, walker] - delays[:, other]) < one
        same = np.sin(homes[:, walker] - heading) * np.sin(homes[:, other] - heading) > 0
        mirrored = np.where(same, azimuths[:, walker], 2 * heading - azimuths[:, walker])
        rate = np.where(same, rates[:, walker], -rates[:, walker])
        azimuths[:, other] = np.where(meant, mirrored, azimuths[:, other])
        rates[:, other] = np.where(meant, rate, rates[:, other])
        azimuths[:, walker] = np.where(meant, homes[:, walker], azimuths[:, walker])
        rates[:, walker] = np.where(meant, 0.0, rates[:, walker])
    return replace(particles, azimuths=azimuths, rates=rates)
