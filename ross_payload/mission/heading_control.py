"""The control law of following: which joint angle keeps the axis at a heading while the base turns."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from ross_payload.angles import wrap_axis
from ross_payload.pointing import Pointing

STILL = 1e-9  # [rad]: what has turned by less has not turned
LEAD = 0.15  # [s] that a correction looks ahead: half of a small move, and half of the time until the next one
NEAR = math.radians(2)  # off the heading, or the tolerance when that is wider, when a turn ends
DWELL = 0.2  # [s] near the heading that end a turn: less, and the joint may only be passing by
BEARABLE = math.radians(5)  # off the heading at a limit of the joint


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
    here: Pointing = field(default_factory=Pointing)  # the latest

    def next_goal(self) -> float | None:
        """Return the joint angle to send now [rad], if any; it is no longer due then."""
        due, self.due = self.due, None
        return due

    def update(self, time: float, here: Pointing) -> None:
        """Note where the array points at ``time`` [s]; another joint angle is due when the heading needs one."""
        self.here = here
        near = abs(wrap_axis(self.heading - here.heading)) <= max(self.tolerance, NEAR)
        self.near_since = min(self.near_since, time) if near else math.inf
        wanted = self._wanted()
        goal = min(max(wanted, self.lower), self.upper)
        if abs(wanted - self.goal) > self.tolerance and abs(goal - self.goal) > STILL:
            self.goal, self.due, self.corrected = goal, goal, True

    def unreachable(self) -> bool:
        """Whether a limit keeps the joint further from the heading than can be borne."""
        wanted = self._wanted()
        return max(wanted - self.upper, self.lower - wanted) > BEARABLE

    def there(self, time: float, here: Pointing, *, settled: bool) -> bool:
        """Whether a turn is over: at rest, or near the heading for a while with no large move to come."""
        if self.due is not None:
            return False
        if settled or not self.corrected:
            return settled
        return time - self.near_since >= DWELL and abs(self.goal - here.joint) <= 2 * max(self.tolerance, NEAR)

    def _wanted(self) -> float:
        """Joint angle [rad] that gives the heading soon, of the branch of the present goal."""
        return self.goal + wrap_axis(self.heading - self.here.zero - self.here.base_rate * LEAD - self.goal)
