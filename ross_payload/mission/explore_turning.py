"""Explore without a pause: the array turns back and forth and is heard meanwhile; every T_unit the explorer is asked.

Every hop has the heading at both its ends, whoever turns the array: joint, vehicle or wind.
"""

from __future__ import annotations

import math

from ross_payload.events import Estimate, State, TurnStarted
from ross_payload.interfaces import TurningExplorer
from ross_payload.mission.context import Context, Step, hop, turn
from ross_payload.mission.heard_turning import HeardTurning
from ross_payload.mission.orientation_scan import believe, certain, observe_turned, say_belief
from ross_payload.mission.pipeline import Visits, promising, visit
from ross_payload.mission.sweep import Sweep, sweep_from

FAR = 0.9  # of the longest time that a move may take: between two ends it is 0.8 at most


def explore_turning(context: Context, explorer: TurningExplorer) -> Step[tuple[Estimate, int | None]]:
    """Turn until the explorer is certain, or the whole turn is over, and brake; return its last belief.

    In a pipelined mission a promising alignment is visited between two periods, as it is between two orientations. When
    the target is recognised there its source is returned as well.
    """
    context.keep_frame()
    sweep, visits, left = sweep_from(context.settings, context.pointing.joint), Visits(), context.settings.periods
    turning, before = HeardTurning(context.settings.rate), list(context.explored)
    while left and not (context.beliefs and certain(context)):
        promise = promising(context, visits) if context.settings.pipelined else None
        if promise is not None:
            source = yield from visit(context, promise, visits, last=False)
            if source is not None:
                return context.beliefs[-1], source
            turning, before, sweep.due = HeardTurning(context.settings.rate), list(context.explored), True
            continue
        if sweep.due and _is_far(context, sweep):
            yield from _to_sweep(context, sweep)
            turning, before = HeardTurning(context.settings.rate), list(context.explored)  # it was not heard meanwhile
        yield from _period(context, sweep, turning)
        left -= 1
        believe(context, observe_turned(context, explorer, turning.period()))
        context.explored = [*before, *turning.pieces(context.settings.rotation)]
        say_belief(context, final=not left or certain(context))
    yield from hop(context, halt=True)
    return context.beliefs[-1], None


def _is_far(context: Context, sweep: Sweep) -> bool:
    """Whether the way to the next end is too long at the rate of the sweep.

    So it may be from beyond a limit, and after an alignment that was visited; not where it has come to rest a little
    beyond the other end.
    """
    settings = context.settings
    return abs(sweep.goal - context.pointing.joint) > FAR * settings.longest_move * sweep.rate


def _to_sweep(context: Context, sweep: Sweep) -> Step[None]:
    """Turn to where it turns back and forth."""
    goal = min(max(context.pointing.joint, min(sweep.ends)), max(sweep.ends))
    context.enter(State.EXPLORE_TURN, "to where it turns back and forth")
    yield from turn(context, goal, "to where it turns back and forth")


def _period(context: Context, sweep: Sweep, turning: HeardTurning) -> Step[None]:
    """Hear T_unit while the array turns."""
    rate, number = math.degrees(sweep.rate), len(context.observations) + 1
    context.holding = None
    context.enter(State.EXPLORE_TURN, f"turning at {rate:g} deg/s, period {number} of {context.settings.periods}")
    turning.begin()
    wanted = round(context.settings.unit * context.settings.rate)
    while turning.samples < wanted:
        goal = sweep.next_goal()
        if goal is not None:
            context.publish(TurnStarted(context.time, goal, context.pointing.at(goal), "turning while it listens"))
        turning.add((yield from hop(context, goal=goal, rate=sweep.rate)))
        sweep.update(settled=context.here.settled)
