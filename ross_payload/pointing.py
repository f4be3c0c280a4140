"""Where the array points: heading = yaw of the base + joint angle + offset, and the joint angle for a heading."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ross_payload.angles import wrap

Real = NDArray[np.floating[Any]]

SAME_ANGLE = 1e-9  # angles that differ by less are one [rad]
RATE_SPAN_S = 0.1  # over which the rate of the base is taken
ROUNDING_S = 1e-9  # of times
FASTEST = 5.0  # rate of a base [rad/s]: what jumps faster was put right, and has not turned


@dataclass(frozen=True, slots=True)
class Pointing:
    """Where the array points at one moment.

    The sum of its three parts is the heading; a joint that has slipped is corrected in the offset.

    >>> here = Pointing(time=2.0, joint=0.5, base=1.0, offset=0.25, earth=True)
    >>> here.heading, here.zero, here.at(0.0)
    (1.75, 1.25, 1.25)
    """

    time: float = 0.0  # on the Clock [s]
    joint: float = 0.0  # joint angle as the actuator reports it [rad], unwrapped
    base: float = 0.0  # yaw of the base [rad], 0 when it is not known
    offset: float = 0.0  # calibrated, less what the reported joint angle is ahead of the true one [rad]
    earth: bool = False  # headings are in the earth frame, else in that of the mount
    base_rate: float = 0.0  # of the yaw of the base [rad/s]

    @property
    def heading(self) -> float:
        """Where the axis from microphone 1 to microphone 2 points [rad], unwrapped."""
        return self.base + self.joint + self.offset

    @property
    def zero(self) -> float:
        """Heading at joint angle 0 [rad]."""
        return self.heading - self.joint

    def at(self, joint: float) -> float:
        """Return the heading at another joint angle [rad] while the base stays."""
        return self.heading + joint - self.joint


class BaseRate:
    """How fast the base turns, from where it pointed over the last 0.1 s.

    >>> rate = BaseRate()
    >>> [round(rate.update(0.01 * hop, 3.1 + 0.005 * hop, earth=True), 6) for hop in range(3)]
    [0.0, 0.5, 0.5]
    """

    def __init__(self) -> None:
        self._trail: deque[tuple[float, float]] = deque()  # time [s], yaw [rad]
        self._earth = False

    def update(self, time: float, yaw: float, *, earth: bool) -> float:
        """Note the yaw [rad] at ``time`` [s]; return its rate [rad/s], 0 where another frame begins."""
        if earth != self._earth or (self._trail and abs(wrap(yaw - self._trail[-1][1])) > self._most(time)):
            self._trail.clear()
        self._earth = earth
        self._trail.append((time, yaw))
        while time - self._trail[0][0] > RATE_SPAN_S + ROUNDING_S:
            self._trail.popleft()
        begin, first = self._trail[0]
        return wrap(yaw - first) / (time - begin) if time > begin else 0.0

    def _most(self, time: float) -> float:
        """Return how far a base can have turned since the last time [rad]."""
        return FASTEST * (time - self._trail[-1][0])


def nearest_joints(angles: ArrayLike, near: float, lower: float, upper: float, period: float = 2 * np.pi) -> Real:
    """Joint angles equal to ``angles`` modulo ``period``, inside the limits and nearest to ``near`` [rad].

    Angles that no turn brings inside the limits are left out; infinite limits are none.

    >>> nearest_joints([0.1, 3.0], near=6.0, lower=-4.0, upper=4.0).tolist()
    [0.1, 3.0]
    >>> nearest_joints([0.1, 3.0], near=0.0, lower=-1.0, upper=1.0, period=np.pi).round(6).tolist()
    [0.1, -0.141593]
    """
    joint = np.asarray(angles, dtype=float)
    lowest = np.ceil((lower - joint) / period - SAME_ANGLE)
    highest = np.floor((upper - joint) / period + SAME_ANGLE)
    inside = lowest <= highest
    turns = np.clip(np.round((near - joint) / period), lowest, highest)
    return np.asarray(np.clip(joint + period * turns, lower, upper)[inside])


def nearest_joint(angle: float, near: float, lower: float, upper: float, period: float = 2 * np.pi) -> float | None:
    """One joint angle of `nearest_joints`, None when no turn brings it inside the limits.

    >>> nearest_joint(0.25, 6.0, -10.0, 10.0) == 0.25 + 2 * np.pi, nearest_joint(2.0, 0.0, -1.0, 1.0)
    (True, None)
    """
    found = nearest_joints([angle], near, lower, upper, period)
    return float(found[0]) if found.size else None


def nearest_limit(angle: float, lower: float, upper: float, period: float = 2 * np.pi) -> float:
    """Return the limit that comes nearest to an angle modulo ``period`` [rad].

    >>> nearest_limit(3.0, -1.0, 1.0), nearest_limit(-6.0, -1.0, 1.0), nearest_limit(3.0, -1.0, 1.0, np.pi)
    (1.0, 1.0, -1.0)
    """

    def away(limit: float) -> float:
        return abs(float(angle - limit - period * np.round((angle - limit) / period)))

    return min((lower, upper), key=away)
