"""The motion law that every driver plans with: constant acceleration up, constant speed, constant acceleration down.

Pure arithmetic on frozen values: no clock, no wire. A plan may begin while moving, so that a new goal replaces the
old one with continuous velocity, through a reversal where it must.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ross_payload.interfaces import Real


def braking_distance(speed: float, acceleration: float) -> float:
    """Distance [rad] from ``speed`` [rad/s] to rest, v^2 / (2 a).

    >>> braking_distance(4.0, 2.0)
    4.0
    """
    return speed**2 / (2 * acceleration)


@dataclass(frozen=True, slots=True)
class Phase:
    """A stretch of constant acceleration whose velocity does not change sign."""

    begin: float  # since the start of the plan [s]
    duration: float  # [s]
    position: float  # at its begin [rad]
    velocity: float  # at its begin [rad/s]
    acceleration: float  # signed [rad/s^2]

    def at(self, t: float) -> tuple[float, float]:
        """Position [rad] and velocity [rad/s] at ``t`` [s] since the start of the plan."""
        t = t - self.begin
        velocity = self.velocity + self.acceleration * t
        return self.position + (self.velocity + velocity) / 2 * t, velocity

    def crossings(self, levels: Real) -> Real:
        """Times [s] since the start of the plan at which the position crosses ``levels`` [rad], (n,) -> (n,).

        The root of ``levels = p + v t + a t^2 / 2`` in the form ``2 d / (v + sign sqrt(v^2 + 2 a d))`` with
        ``d = levels - p``, which does not cancel when a is small. The levels must lie within the phase.

        >>> Phase(0.0, 2.0, 0.0, 0.0, 2.0).crossings(np.array([1.0, 4.0])).tolist()
        [1.0, 2.0]
        """
        distance = levels - self.position
        root = np.sqrt(np.maximum(self.velocity**2 + 2 * self.acceleration * distance, 0.0))
        speed = abs(self.velocity) + root
        t = np.divide(2 * np.abs(distance), speed, out=np.zeros_like(speed), where=speed > 0)
        return np.asarray(self.begin + np.minimum(t, self.duration))


@dataclass(frozen=True)
class Trapezoid:
    """The fastest move from ``start`` to rest at ``goal`` [rad] within a speed and an acceleration.

    A plan that begins with more than ``speed`` slows down to it first; one that cannot stop before the goal, or moves
    away from it, brakes, reverses and comes back.

    Parameters
    ----------
    start, goal : float
        Positions [rad].
    speed, acceleration : float
        Caps, > 0 [rad/s], [rad/s^2].
    velocity : float
        At the start [rad/s], signed.

    Examples
    --------
    One radian at 1 rad/s and 2 rad/s^2: half a second up, half a second at full speed, half a second down.

    >>> move = Trapezoid(0.0, 1.0, speed=1.0, acceleration=2.0)
    >>> move.duration
    1.5
    >>> move.at(0.5), move.at(1.0), move.at(9.0)
    ((0.25, 1.0), (0.75, 1.0), (1.0, 0.0))
    """

    start: float
    goal: float
    speed: float
    acceleration: float
    velocity: float = 0.0
    phases: tuple[Phase, ...] = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "phases", _phases(self))

    @classmethod
    def to_rest(cls, position: float, velocity: float, acceleration: float) -> Trapezoid:
        """Brake from ``velocity`` [rad/s] at ``position`` [rad] as fast as allowed.

        >>> Trapezoid.to_rest(1.0, -2.0, 2.0).goal
        0.0
        """
        goal = position + math.copysign(braking_distance(velocity, acceleration), velocity)
        return cls(position, goal, max(abs(velocity), math.ulp(1.0)), acceleration, velocity)

    @classmethod
    def still(cls, position: float) -> Trapezoid:
        """Stay at ``position`` [rad].

        >>> Trapezoid.still(1.0).at(5.0), Trapezoid.still(1.0).duration
        ((1.0, 0.0), 0.0)
        """
        return cls(position, position, speed=1.0, acceleration=1.0)

    @property
    def duration(self) -> float:
        """Time [s] until rest at the goal."""
        return self.phases[-1].begin + self.phases[-1].duration if self.phases else 0.0

    def at(self, t: float) -> tuple[float, float]:
        """Position [rad] and velocity [rad/s] at ``t`` [s]; as at 0 before, exactly the goal and 0 at the end."""
        t = max(t, 0.0)
        if t >= self.duration:
            return self.goal, 0.0
        return next(phase for phase in reversed(self.phases) if phase.begin <= t).at(t)


@dataclass(frozen=True, slots=True)
class Motion:
    """A plan and when it begins [s]."""

    plan: Trapezoid
    begin: float

    @property
    def end(self) -> float:
        """When it is over [s]."""
        return self.begin + self.plan.duration

    def at(self, time: float) -> tuple[float, float]:
        """Position [rad] and velocity [rad/s] at ``time`` [s]."""
        return self.plan.at(time - self.begin)


def _phases(move: Trapezoid) -> tuple[Phase, ...]:
    """Chain the accelerations of a plan into phases, split where the velocity passes zero."""
    phases: list[Phase] = []
    begin, position, velocity = 0.0, move.start, move.velocity
    for duration, acceleration in _accelerations(move):
        turn = -velocity / acceleration if acceleration else math.inf
        after = velocity + acceleration * duration
        parts = ((turn, 0.0), (duration - turn, after)) if 0.0 < turn < duration else ((duration, after),)
        for part, reached in parts:
            if part > 0.0:
                phases.append(Phase(begin, part, position, velocity, acceleration))
                position += (velocity + reached) / 2 * part
                begin, velocity = begin + part, reached
    return tuple(phases)


def _accelerations(move: Trapezoid) -> list[tuple[float, float]]:
    """Solve for (duration [s], acceleration [rad/s^2]) of the ramp to the peak, the cruise and the braking.

    Mirrored so that the peak is positive: from v0 over a distance D the peak is sqrt(a D + v0^2 / 2) when the cap
    allows it, from equating the distances of both ramps.
    """
    a, cap = move.acceleration, move.speed
    stop = move.start + math.copysign(braking_distance(move.velocity, a), move.velocity)
    sign = math.copysign(1.0, move.goal - stop if move.goal != stop else move.velocity)
    distance, v0 = sign * (move.goal - move.start), sign * move.velocity
    peak = math.sqrt(max(a * distance + v0**2 / 2, 0.0))
    if peak <= cap or math.isclose(peak, v0, rel_tol=1e-12):
        return [(max(peak - v0, 0.0) / a, sign * a), (peak / a, -sign * a)]
    ramp = (cap**2 - v0**2) / (2 * a) * math.copysign(1.0, cap - v0)
    cruise = max(distance - ramp - braking_distance(cap, a), 0.0) / cap
    return [(abs(cap - v0) / a, math.copysign(sign * a, sign * (cap - v0))), (cruise, 0.0), (cap / a, -sign * a)]
