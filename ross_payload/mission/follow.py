"""Face a heading and keep facing it while the vehicle yaws: the joint turns against the base.

A heading holds in the frame of the azimuths, so the joint angle for it changes with the base. With a base at rest
nothing is ever off, and a turn ends when the actuator has settled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ross_payload.angles import circular_mean, difference, wrap, wrap_axis
from ross_payload.events import TurnStarted
from ross_payload.interfaces import Input, Samples
from ross_payload.mission.context import Context, Listening, Step, hop
from ross_payload.mission.follower import STILL, Follower, base

MARGIN = math.radians(20)  # to the limits of the joint, where there is a choice: room to follow
PATIENCE = 20.0  # [s] that a turn may take on a vehicle that does not let it end
MOST_BACK = 3  # times that one listening period begins again


def face(context: Context, heading: float, joint: float, reason: str) -> Step[None]:
    """Turn to a heading [rad] and follow it until the axis points there; what is heard meanwhile passes by.

    ``joint`` [rad] gives the heading where the base was when the heading was chosen.
    """
    here = context.here
    moved = abs(wrap(base(here) - heading + joint)) > STILL
    goal = reach(context, heading) if moved else joint
    context.keep_frame()
    context.say(TurnStarted(context.time, goal, here.heading_end + goal - here.joint, reason))
    context.holding = follower = _follower(context, heading, goal)
    follower.due, latest = goal, context.time + PATIENCE
    while not follower.there(context.time, context.here):
        if follower.corrected and context.time >= latest:
            return
        heard = yield from hop(context, goal=follower.take())
        follower.note(context.time, heard)


def reach(context: Context, heading: float) -> float:
    """Return the joint angle [rad] for a heading modulo pi: with room to follow, then with the least travel.

    Where the limits exclude the heading, the limit that comes nearest to it.
    """
    settings, here = context.settings, context.here
    nearest = here.joint + wrap_axis(heading - here.heading_end)
    goals = [goal for goal in nearest + np.pi * np.arange(-4, 5) if settings.lower <= goal <= settings.upper]
    if not goals:
        return min((settings.lower, settings.upper), key=lambda end: abs(wrap_axis(nearest - end)))

    def cost(goal: float) -> tuple[bool, float]:
        return min(goal - settings.lower, settings.upper - goal) < MARGIN, abs(goal - here.joint)

    return float(min(goals, key=cost))


def attend(context: Context, seconds: float) -> Step[Listening]:
    """Hear ``seconds`` of audio at the heading that was faced, or at the present one, and follow it meanwhile.

    When a limit of the joint gets in the way, the array turns half round and the period begins again.
    """
    context.keep_frame()
    if context.holding is None:
        context.holding = _follower(context, context.here.heading_end, context.here.joint)
    wanted, period, left = round(seconds * context.settings.rate), _Period(), MOST_BACK
    while period.samples < wanted:
        heard = yield from hop(context, goal=context.holding.take())
        period.add(heard)
        context.holding.note(context.time, heard)
        if left and context.holding.unreachable():
            period, left = _Period(), left - 1
            yield from face(
                context, context.holding.heading, heard.joint, "near a limit: turning to the other end of the axis"
            )
    return period.listening()


def _follower(context: Context, heading: float, goal: float) -> Follower:
    settings = context.settings
    return Follower(heading, goal, settings.follow, settings.lower, settings.upper)


@dataclass(slots=True)
class _Period:
    """What is heard of one listening period."""

    blocks: list[Samples] = field(default_factory=list)
    headings: list[float] = field(default_factory=list)  # in the middle of every hop [rad]
    last: float = 0.0  # heading at the end [rad]
    samples: int = 0

    def add(self, heard: Input) -> None:
        self.blocks.append(heard.block.samples)
        self.headings.append(heard.heading_start + wrap(heard.heading_end - heard.heading_start) / 2)
        self.last = heard.heading_end
        self.samples += heard.block.samples.shape[1]

    def listening(self) -> Listening:
        """All of it, at the mean heading; at the heading itself when nothing has turned."""
        samples = np.concatenate(self.blocks, axis=1)
        if np.abs(difference(self.headings, self.last)).max() <= STILL:
            return Listening(self.last, samples)
        mean = circular_mean(self.headings)
        return Listening(mean, samples, float(np.abs(difference(self.headings, mean)).max()))
