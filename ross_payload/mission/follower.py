"""The control law of following: which joint angle keeps the axis at a heading while the base turns."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

from ross_payload.angles import wrap, wrap_axis
from ross_payload.interfaces import Input

STILL = 1e-9  # [rad]: what has turned by less has not turned
LEAD = 0.15  # [s] that a correction looks ahead: half of a small move, and half of the time until the next one
TRAIL = 0.1  # [s] over which the rate of the base is taken
NEAR = math.radians(2)  # off the heading, or the tolerance when that is wider, when a turn ends
DWELL = 0.2  # [s] near the heading that end a turn: less, and the joint may only be passing by
BEARABLE = math.radians(5)  # off the heading at a limit of the joint


def base(heard: Input) -> float:
    """Return the heading at joint angle 0 [rad]."""
    return heard.heading_end - heard.joint


@dataclass(slots=True)
class Follower:
    """Keeps one heading, modulo pi; asks for a move when the heading at the joint's goal is off by too much.

    It looks at where the joint is going, not where it is: neither latency nor a move in flight makes it ask twice.
    With a base at rest it never asks.
    """

    heading: float  # [rad]
    goal: float  # joint angle that was asked for last [rad]
    tolerance: float  # [rad]
    lower: float  # limits of the joint [rad]
    upper: float
    due: float | None = None  # joint angle that has yet to be sent [rad]
    corrected: bool = False
    near_since: float = math.inf  # time [s]
    trail: deque[tuple[float, float]] = field(default_factory=deque)  # time [s], heading at joint angle 0 [rad]

    def take(self) -> float | None:
        """Return the joint angle to send now [rad], if any."""
        due, self.due = self.due, None
        return due

    def note(self, time: float, heard: Input) -> None:
        """Take in what was heard until ``time`` [s]; another joint angle is due when the heading needs one."""
        self.trail.append((time, base(heard)))
        while time - self.trail[0][0] > TRAIL + STILL:
            self.trail.popleft()
        near = abs(wrap_axis(self.heading - heard.heading_end)) <= max(self.tolerance, NEAR)
        self.near_since = min(self.near_since, time) if near else math.inf
        wanted = self._wanted()
        goal = min(max(wanted, self.lower), self.upper)
        if abs(wanted - self.goal) > self.tolerance and abs(goal - self.goal) > STILL:
            self.goal, self.due, self.corrected = goal, goal, True

    def unreachable(self) -> bool:
        """Whether a limit keeps the joint further from the heading than can be borne."""
        wanted = self._wanted()
        return max(wanted - self.upper, self.lower - wanted) > BEARABLE

    def there(self, time: float, heard: Input) -> bool:
        """Whether a turn is over: at rest, or near the heading for a while with no large move to come."""
        if self.due is not None:
            return False
        if heard.settled or not self.corrected:
            return heard.settled
        return time - self.near_since >= DWELL and abs(self.goal - heard.joint) <= 2 * max(self.tolerance, NEAR)

    def _wanted(self) -> float:
        """Joint angle [rad] that gives the heading soon, of the branch of the present goal."""
        (begin, first), (end, last) = self.trail[0], self.trail[-1]
        rate = wrap(last - first) / (end - begin) if end > begin else 0.0
        return self.goal + wrap_axis(self.heading - last - rate * LEAD - self.goal)
