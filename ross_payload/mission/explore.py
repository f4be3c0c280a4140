"""Explore: rotate in steps, listen at each, find K and every azimuth (Algorithm 1 with all orientations at once).

Where it is wanted the array does not pause: `explore_turning`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from ross_payload.angles import wrap, wrap_axis
from ross_payload.calibration.consistency import contradiction
from ross_payload.calibration.cross_spectrum import HEARD, heading_spectrum
from ross_payload.calibration.delay_residuals import finer_contradiction
from ross_payload.events import ArrayContradicted, Doubted, Estimate, State
from ross_payload.mission.context import Context, FrameChanged, Step, listen
from ross_payload.mission.explore_turning import explore_turning
from ross_payload.mission.heading_control import BEARABLE
from ross_payload.mission.heading_hold import face
from ross_payload.mission.orientation_scan import certain, matched, orientation, say_belief
from ross_payload.mission.pipeline import Visits, promising, visit

STEADY = math.radians(3.0)  # a heading that is followed so closely is one [rad]
SAME = 0.5  # of a step: an alignment so near to an orientation of the schedule takes its place


def lead_in(context: Context) -> Step[None]:
    """Listen before anything turns: the quiet, when there is one, tells the noise."""
    context.enter(State.LEAD_IN)
    context.keep_lead_in(*(yield from listen(context, context.settings.lead_in)))


def explore(context: Context) -> Step[tuple[Estimate, int | None]]:
    """Visit orientations until the explorer is certain or the schedule ends; return its last belief.

    When the frame of the headings changes meanwhile, what was heard is forgotten and the exploration begins again.

    In a pipelined mission a promising alignment takes the place of the next orientation. When the target is recognised
    there the exploration ends at once, and its source is returned as well.
    """
    left = context.settings.max_restarts
    while True:
        context.drop_frame()
        context.explored, context.observations, context.beliefs, context.unvisited = [], [], [], []
        context.heard_since, context.reconsidered = [], None
        try:
            explorer = context.tools.turning
            found = yield from (_orientations(context) if explorer is None else explore_turning(context, explorer))
            check_array(context)
            return found
        except FrameChanged as changed:
            if not left:
                raise
            left -= 1
            context.publish(Doubted(context.time, changed.reason))


def check_array(context: Context) -> None:
    """Say when what was heard contradicts what is configured of the array."""
    settings = context.settings
    explored = (heading_spectrum(each.samples, settings.rate, each.heading) for each in context.explored)
    spectra = [each for each in explored if each is not None and each.coherence >= HEARD]
    found = contradiction(spectra, settings.spacing, settings.speed_of_sound, level=settings.level)
    wider, roll_off = (None, None) if found.geometry or not settings.level else _finer(context)
    if found or wider is not None or roll_off is not None:
        told = ArrayContradicted(
            context.time,
            found.spacing if wider is None else wider * settings.spacing,
            settings.spacing,
            found.gain_db,
            found.inverted,
            found.delay,
            found.fixed,
            roll_off,
        )
        context.publish(told)


def _finer(context: Context) -> tuple[float | None, float | None]:
    """Times by which the array is wider than configured, and its difference of roll-off [Hz], by what rested."""
    settings = context.settings
    heard = ((each.heading, each.samples) for each in context.explored if each.spread <= STEADY and not each.deaf)
    believed = context.beliefs[-1] if context.beliefs else Estimate(())
    return finer_contradiction(heard, believed, settings.rate, settings.spacing / settings.speed_of_sound)


def _orientations(context: Context) -> Step[tuple[Estimate, int | None]]:
    """Visit what is scheduled as joint angles for where the base is now; the headings that they give are meant."""
    visits, zero = Visits(), context.pointing.zero
    todo = [(zero + joint, joint) for joint in schedule(context)]
    while todo and not (context.beliefs and certain(context)):
        promise = promising(context, visits) if context.settings.pipelined else None
        if promise is None:
            yield from _step(context, *_nearest(context, todo))
            say_belief(context, final=not todo or certain(context))
            continue
        todo = [each for each in todo if not _same(context, each[0], promise.candidate.heading)]
        source = yield from visit(context, promise, visits, last=not todo)
        if source is not None:
            return context.beliefs[-1], source
    context.unvisited = [] if context.settings.pipelined else todo
    return context.beliefs[-1], None


def explore_on(context: Context, known: Estimate) -> Step[Estimate | None]:
    """Visit the orientations that the exploration has left out, until the explorer is certain of somebody not known.

    Returns what it believes then; None when none was left out.
    """
    belief: Estimate | None = None
    while context.unvisited:
        yield from _step(context, *_nearest(context, context.unvisited))
        belief = context.beliefs[-1]
        found = bool(added(known, belief)) and certain(context)
        say_belief(context, final=found or not context.unvisited)
        if found:
            break
    return belief


def added(known: Estimate, belief: Estimate) -> set[int]:
    """Return the sources of a belief that are none of those known."""
    return set(range(belief.k)) - set(matched(known.azimuths, belief).values())


def _nearest(context: Context, todo: list[tuple[float, float]]) -> tuple[float, float]:
    """Take the heading and joint angle [rad] with the least travel out of those that are left."""
    here = context.pointing

    def travel(each: tuple[float, float]) -> float:
        heading, joint = each
        return round(abs(joint - here.joint - wrap(here.zero - heading + joint)), 9)

    nearest = min(todo, key=travel)
    todo.remove(nearest)
    return nearest


def _step(context: Context, heading: float, joint: float) -> Step[None]:
    r = len(context.explored)
    if r or abs(joint - context.pointing.joint) > BEARABLE:
        context.enter(State.EXPLORE_TURN, f"rotation {r} of {context.settings.max_rotations}")
        yield from face(context, heading, joint, f"rotation {r}")
    context.enter(State.EXPLORE_LISTEN, f"orientation {r}")
    yield from orientation(context, context.settings.unit)


def _same(context: Context, heading: float, other: float) -> bool:
    """Whether two headings give nearly one axis; half a turn tells nothing new."""
    return abs(wrap_axis(heading - other)) < SAME * context.settings.rotation


def schedule(context: Context) -> Iterator[float]:
    """Joint angles [rad] of the exploration: equal steps from here, first towards the side with more room.

    What does not fit on that side is taken on the other, stepping away from the start. Where the joint stands outside
    its limits, as at a switch beyond them, the nearer limit is the start.
    """
    settings = context.settings
    start = min(max(context.pointing.joint, settings.lower), settings.upper)
    room_up, room_down = settings.upper - start, start - settings.lower
    sign = 1.0 if room_up >= min(room_down, settings.max_rotations * settings.rotation) else -1.0
    ahead = int(((room_up if sign > 0 else room_down) + 1e-9) // settings.rotation)
    behind = int(((room_down if sign > 0 else room_up) + 1e-9) // settings.rotation)
    first = range(1, min(ahead, settings.max_rotations) + 1)
    second = range(1, min(behind, settings.max_rotations - len(first)) + 1)
    yield start
    yield from (start + sign * k * settings.rotation for k in first)
    yield from (start - sign * k * settings.rotation for k in second)
