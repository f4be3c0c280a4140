"""Turning back and forth at a constant rate: where the joint turns back, and what it is told when."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ross_payload.mission.settings import Settings

HALF = math.pi  # turned to one side: half a turn shows every axis, and what is beyond it nothing new [rad]
IN_TIME = 0.8  # of the longest time that a move may take


@dataclass(slots=True)
class Sweep:
    """Turns between two joint angles, to the first one first; each time as far as one move may take."""

    ends: tuple[float, float]  # [rad]
    rate: float  # [rad/s]
    index: int = 0  # of the moves begun
    due: bool = True  # the goal has yet to be sent

    @property
    def goal(self) -> float:
        """Joint angle that is turned to [rad]."""
        return self.ends[self.index % 2]

    def next_goal(self) -> float | None:
        """Return the goal to be sent now [rad], if any; it is no longer due then."""
        due, self.due = self.due, False
        return self.goal if due else None

    def update(self, *, settled: bool) -> None:
        """Turn back where the goal that was sent is reached: where the joint has ``settled`` there."""
        if settled and not self.due:
            self.index += 1
            self.due = True


def sweep_from(settings: Settings, joint: float) -> Sweep:
    """Sweep over half a turn from a joint angle [rad] on, or over as much as the limits allow.

    It begins towards the side with more room. What does not fit there is turned on the other side of the start, which
    is the nearer limit where the joint stands outside.
    """
    joint = min(max(joint, settings.lower), settings.upper)
    span = min(HALF, IN_TIME * settings.longest_move * settings.turn_rate)
    room_up, room_down = settings.upper - joint, joint - settings.lower
    up = room_up >= min(room_down, span)
    if up:
        far = joint + min(room_up, span)
        return Sweep((far, max(far - span, settings.lower)), settings.turn_rate)
    far = joint - min(room_down, span)
    return Sweep((far, min(far + span, settings.upper)), settings.turn_rate)
