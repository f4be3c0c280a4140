"""Face a heading and keep facing it while the vehicle yaws: the joint turns against the base.

A heading holds in the frame of the azimuths, so the joint angle for it changes with the base. With a base at rest
nothing is ever off, and a turn ends when the actuator has settled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ross_payload.angles import circular_mean, difference, wrap
from ross_payload.dsp.dc_offset import without_offset
from ross_payload.events import AlignmentCandidate, State, TurnStarted
from ross_payload.interfaces import UNHEARD, AudioFlag, Input, Samples
from ross_payload.mission.context import Context, Listening, Step, hop, speeds_by_hop
from ross_payload.mission.heading_control import STILL, Follower
from ross_payload.mission.hearing import identical
from ross_payload.pointing import nearest_joint, nearest_limit

MARGIN = math.radians(20)  # to the limits of the joint, where there is a choice: room to follow
TURN_TIMEOUT_S = 20.0  # [s] that a turn may take on a vehicle that does not let it end
OTHER_END = "near a limit: turning to the other end of the axis"
REALIGNED = "sources have moved"
LOOKING = "looking whether anybody has moved"
MOST_CLIPPED, MOST_MISSING = 0.1, 0.02  # of a period's hops: with more a voice is 3 dB less clean than is expected
MOST_DEAF = 0.1  # of a period's hops: with more it tells of no direction
MOST_BACK = 3  # times that one listening period begins again


def face(context: Context, heading: float, joint: float, reason: str) -> Step[None]:
    """Turn to a heading [rad] and follow it until the axis points there; what is heard meanwhile passes by.

    ``joint`` [rad] gives the heading where the base was when the heading was chosen.
    """
    here = context.pointing
    moved = abs(wrap(here.zero - heading + joint)) > STILL
    goal = reach(context, heading) if moved else joint
    context.keep_frame()
    context.publish(TurnStarted(context.time, goal, here.at(goal), reason))
    context.holding = follower = _follower(context, heading, goal)
    follower.due, latest = goal, context.time + TURN_TIMEOUT_S
    while not follower.there(context.time, context.pointing, settled=context.here.settled):
        if follower.corrected and context.time >= latest:
            return
        yield from hop(context, goal=follower.next_goal())
        follower.update(context.time, context.pointing)


def face_alignment(context: Context, candidate: AlignmentCandidate) -> Step[None]:
    """Turn to the heading that isolates a source, and follow it as `face` does."""
    context.enter(State.ALIGN_TURN, f"source {candidate.source}, {candidate.rule}")
    yield from face(context, candidate.heading, candidate.joint, f"alignment for source {candidate.source}")


def reach(context: Context, heading: float) -> float:
    """Return the joint angle [rad] for a heading modulo pi: with room to follow, then with the least travel.

    Where the limits exclude the heading, the limit that comes nearest to it.
    """
    here, lower, upper = context.pointing, context.settings.lower, context.settings.upper
    angle = heading - here.zero
    for margin in (MARGIN, 0.0):
        joint = nearest_joint(angle, here.joint, lower + margin, upper - margin, math.pi)
        if joint is not None:
            return joint
    return nearest_limit(angle, lower, upper, math.pi)


def attend(context: Context, seconds: float) -> Step[Listening]:
    """Hear ``seconds`` of audio at the heading that was faced, or at the present one, and follow it meanwhile.

    When a limit of the joint gets in the way, the array turns half round and the period begins again.
    """
    context.keep_frame()
    if context.holding is None:
        context.holding = _follower(context, context.pointing.heading, context.pointing.joint)
    wanted, period, left = round(seconds * context.settings.rate), _Period(), MOST_BACK
    while period.samples < wanted:
        now = yield from hop(context, goal=context.holding.next_goal())
        period.add(now, deaf=context.hearing.deaf)
        context.holding.update(context.time, now.pointing)
        _track(context, now)
        if left and context.holding.unreachable():
            period, left = _Period(), left - 1
            yield from face(context, context.holding.heading, context.pointing.joint, OTHER_END)
    return period.listening()


def _track(context: Context, now: Input) -> None:
    """Let the tracker hear a hop, and turn a little when that is worth it; what is heard meanwhile counts."""
    if context.tracker is None:
        return
    context.tracker.deaf = context.hearing.deaf or identical(now.block.samples)  # which passes for a move at once
    event, settings = context.tracker.hear(now, context.time), context.settings
    if event is not None:
        context.publish(event)
    heading = context.tracker.heading_for(
        context.time, now.pointing, settings.lower, settings.upper, settled=now.settled
    )
    if heading is not None:
        goal = now.pointing.joint + wrap(heading - now.pointing.heading)
        reason = REALIGNED if context.tracker.anybody else LOOKING
        context.publish(TurnStarted(context.time, goal, heading, reason))
        context.holding = _follower(context, heading, goal)
        context.holding.due = goal


def _follower(context: Context, heading: float, goal: float) -> Follower:
    settings = context.settings
    return Follower(heading, goal, settings.follow, settings.lower, settings.upper)


@dataclass(slots=True)
class _Period:
    """What is heard of one listening period."""

    blocks: list[Samples] = field(default_factory=list)
    headings: list[float] = field(default_factory=list)  # in the middle of every hop [rad]
    last: float = 0.0  # heading at the end [rad]
    aboard: list[float] = field(default_factory=list)  # at the end of every hop, frame of the vehicle [rad]
    speeds: list[tuple[float, ...]] = field(default_factory=list)  # of the rotors at the beginning of every hop [1/s]
    samples: int = 0
    clipped: int = 0  # hops
    missing: int = 0  # hops with samples that never came, or were no numbers
    deaf: int = 0  # hops, as of `Hearing`

    def add(self, hop: Input, *, deaf: bool) -> None:
        self.blocks.append(hop.block.samples)
        self.headings.append(hop.heading_start + wrap(hop.pointing.heading - hop.heading_start) / 2)
        self.last = hop.pointing.heading
        self.aboard.append(hop.pointing.heading - hop.pointing.base)
        self.speeds.append(hop.attitude.rotor_speeds)
        self.samples += hop.block.samples.shape[1]
        self.deaf += deaf
        if hop.block.flags:
            self.clipped += AudioFlag.CLIPPED in hop.block.flags
            self.missing += bool(hop.block.flags & UNHEARD)

    def listening(self) -> Listening:
        """All of it, at the mean heading; at the heading itself when nothing has turned."""
        samples = without_offset(np.concatenate(self.blocks, axis=1))
        n = len(self.blocks)
        damaged = self.clipped > MOST_CLIPPED * n or self.missing > MOST_MISSING * n
        deaf = self.deaf > MOST_DEAF * n
        aboard, speeds = circular_mean(self.aboard), speeds_by_hop(self.speeds)
        if np.abs(difference(self.headings, self.last)).max() <= STILL:
            return Listening(self.last, samples, aboard=aboard, rotor_speeds=speeds, damaged=damaged, deaf=deaf)
        mean = circular_mean(self.headings)
        spread = float(np.abs(difference(self.headings, mean)).max())
        headings = np.array(self.headings)
        return Listening(mean, samples, spread, headings, aboard, speeds, damaged=damaged, deaf=deaf)
