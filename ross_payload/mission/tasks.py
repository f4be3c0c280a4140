"""The tasks of a live mission: what an operator can order, one at a time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ross_payload import orders
from ross_payload.angles import wrap
from ross_payload.errors import ConfigError
from ross_payload.events import Estimate, Outcome, SourceEstimate, SourcesEstimated, State
from ross_payload.interfaces import Output, Real, Result, Samples
from ross_payload.mission.align import align
from ross_payload.mission.context import Context, Ended, Step, exchange, hop, listen, obey, turn
from ross_payload.mission.enrol_talker import NotEnrolled, enrol_source
from ross_payload.mission.exploit import deliver
from ross_payload.mission.explore import lead_in
from ross_payload.mission.heading_control import BEARABLE
from ross_payload.mission.heading_hold import attend, face, face_alignment
from ross_payload.mission.manual_pointing import by_hand, unreachable
from ross_payload.mission.mission_sequence import attempts
from ross_payload.mission.orientation_scan import matched
from ross_payload.mission.slip_detection import survey
from ross_payload.plugin_results import MOST_SOURCES
from ross_payload.pointing import nearest_joint

TOLD_SIGMA = math.radians(2.0)  # of an azimuth that somebody tells [rad]
LEAST_NOISE = 0.5  # [s] that tell anything about a noise
HOMING = 120.0  # [s] that finding the zero may take
FAULT = 2.0  # [s] that a fault may last which begins while the zero is found
OUTSIDE = "this heading is outside the limits of the joint"
MISSED = "the vehicle turned away: this heading was not reached"
TOO_MANY = f"{MOST_SOURCES} sources are known, none of them there: explore first"
NO_CONSENT = "nobody is enrolled who has not agreed to it"
STILL_FAULTY = (orders.Home,)  # may be ordered while there is a fault
WITHOUT_TOOLS = (orders.Park, orders.Home, orders.TurnTo, orders.Point, orders.MeasureNoise)  # which use no plug-in


@dataclass(frozen=True, slots=True)
class Memory:
    """What outlives a task."""

    estimate: Estimate | None = None
    earth: bool = False  # the frame of its azimuths
    explored: bool = False  # it was heard, not told
    unfinished: bool = False  # an exploration that has not come to its end has told other sources since
    noise: Samples | None = None  # heard at rest while nobody talked, (2, n)
    noise_aboard: float = 0.0  # heading in the frame of the vehicle where it was heard [rad]
    noise_speeds: Real | None = None  # of the rotors meanwhile [1/s], (n_hops, n_rotors)
    stopped: bool = False  # by an order, and not re-armed
    samples: int = 0  # heard since the session began
    starting: bool = False  # nothing was ordered yet, and the actuator has not been well yet
    pending: bool = False  # the task to begin with waits for the actuator


class TaskRefused(Exception):
    """The task turns out to be impossible; says why."""


def refusal(context: Context, memory: Memory, task: orders.Task, *, stopped: bool, fault: str) -> str:
    """Return why a task cannot be begun; empty when it can."""
    known = _known(context, memory)
    source = task.source if isinstance(task, orders.ListenTo | orders.Enrol) else None
    impossible = {
        "stopped: re-arm first": stopped,
        f"fault: {fault}": bool(fault) and not isinstance(task, STILL_FAULTY),
        "no target voice is enrolled": isinstance(task, (orders.Seek, orders.Informed))
        and context.tools.voiceprint is None,
        "no source is known: explore first": source is not None and known is None,
        "there is no such source": source is not None and known is not None and not 0 <= source < known.k,
        NO_CONSENT: isinstance(task, orders.Enrol) and not task.consent,
        "neither a source nor an azimuth is told": isinstance(task, orders.Enrol) and task.source is task.azimuth,
        TOO_MANY: known is not None and known.k >= MOST_SOURCES and _adds(task, known),
        OUTSIDE: isinstance(task, orders.TurnTo) and _joint_for(context, task.heading) is None,
    }
    if why := next((reason for reason, true in impossible.items() if true), ""):
        return why
    if isinstance(task, orders.Enrol):
        return _unusable_model(context)
    return unreachable(task, context.here) if isinstance(task, orders.Point) else ""


def _adds(task: orders.Task, known: Estimate) -> bool:
    """Whether a task tells of a source that is none of those known."""
    azimuth = task.azimuth if isinstance(task, orders.ListenAt | orders.Enrol) else None
    return azimuth is not None and not matched([azimuth], known)


def _unusable_model(context: Context) -> str:
    """Return why nobody can be enrolled at present; empty when somebody can."""
    try:
        context.tools.voice_model()
    except ConfigError as error:  # it was removed meanwhile, or another one was added
        return str(error)
    return ""


def perform(context: Context, memory: Memory, task: orders.Task) -> Step[Result]:
    """Perform one task.

    Raises
    ------
    TaskRefused
        When it turns out to be impossible.
    Ended
        When an order or a fault ends it.
    """
    context.lead_in, context.lead_in_aboard = memory.noise, memory.noise_aboard
    context.lead_in_speeds = memory.noise_speeds
    if memory.explored and memory.estimate is not None:
        context.surveyed = memory.estimate, memory.earth
    match task:
        case orders.Explore():
            step = _explore(context)
        case orders.Seek():
            step = _seek(context, _known(context, memory), None)
        case orders.Informed():
            step = _seek(context, _informed_estimate(task.azimuths), task.first)
        case orders.ListenTo() | orders.ListenAt():
            step = _listen(context, *_whom(context, memory, task))
        case orders.Enrol():
            step = _enrol(context, memory, task)
        case orders.TurnTo():
            step = _point(context, task.heading)
        case orders.Point():
            step = by_hand(context, task)
        case orders.Park():
            step = _park(context)
        case orders.Home():
            step = _home(context)
        case orders.MeasureNoise():
            step = _measure(context, task.seconds)
        case _:
            raise TaskRefused(f"{type(task).__name__} is not a task of this payload")
    return (yield from step)


def _explore(context: Context) -> Step[Result]:
    yield from _quiet(context)
    estimate, _ = yield from survey(context)
    if not estimate.k and (fault := context.hearing.fault()):
        return Result(Outcome.FAULT, f"cannot tell whether anybody is there: {fault}")
    return Result(Outcome.COMPLETED, f"{estimate.k} sources found")


def _seek(context: Context, known: Estimate | None, first: int | None) -> Step[Result]:
    if known is not None:
        context.keep_frame()
    yield from _quiet(context)
    return (yield from attempts(context, known, first))


def _known(context: Context, memory: Memory) -> Estimate | None:
    """The estimate of an earlier task, unless the frame of its azimuths is gone."""
    if context.last is None or memory.estimate is None or context.last.pointing.earth != memory.earth:
        return None
    return memory.estimate


def _informed_estimate(azimuths: Sequence[float]) -> Estimate:
    share = 1 / len(azimuths)
    told = (SourceEstimate(wrap(a), TOLD_SIGMA, confidence=1.0, resolved=True, weight=share) for a in azimuths)
    return Estimate(tuple(told), certain=True)


def _quiet(context: Context) -> Step[None]:
    """Listen before anything turns, unless the noise was measured on request."""
    yield from hop(context)
    if context.lead_in is None:
        yield from lead_in(context)


def _whom(context: Context, memory: Memory, task: orders.ListenTo | orders.ListenAt) -> tuple[Estimate, int]:
    """Return an estimate and which of its sources is meant."""
    known = _known(context, memory)
    if isinstance(task, orders.ListenTo):
        if known is None:
            raise TaskRefused("no source is known: explore first")
        return known, task.source
    near = matched([task.azimuth], known) if known is not None else {}
    if known is not None and near:
        return known, near[0]
    others = () if known is None else known.sources
    estimate = Estimate((*others, *_informed_estimate([task.azimuth]).sources), certain=True)
    context.publish(SourcesEstimated(context.time, estimate, rotations=0, final=True, informed=True))
    return estimate, estimate.k - 1


def _listen(context: Context, estimate: Estimate, source: int) -> Step[Result]:
    """Turn to the alignment for a source and listen to it, whoever it is."""
    context.keep_frame()
    yield from _quiet(context)
    own = next((c for c in align(context, estimate) if c.source == source), None)
    if own is None:
        raise TaskRefused(f"no heading within the limits isolates source {source}")
    yield from face_alignment(context, own)
    context.enter(State.RUN, f"source {source}")
    context.track(estimate, source)
    runs, done = context.settings.runs, 0
    while runs == 0 or done < runs:
        heard = yield from attend(context, context.settings.run)
        deliver(context, estimate, source, context.samples - heard.samples.shape[1], heard)
        done += 1
    return Result(Outcome.COMPLETED, f"listened to source {source}")


def _enrol(context: Context, memory: Memory, task: orders.Enrol) -> Step[Result]:
    """Enrol whom an order means, who agrees to it."""
    told = orders.ListenTo(task.source) if task.source is not None else orders.ListenAt(task.azimuth or 0.0)
    estimate, source = _whom(context, memory, told)
    context.keep_frame()
    yield from _quiet(context)
    try:
        return (yield from enrol_source(context, estimate, source, task))
    except NotEnrolled as error:
        raise TaskRefused(str(error)) from error


def _point(context: Context, heading: float) -> Step[Result]:
    yield from hop(context)
    joint = _joint_for(context, heading)  # as the base stands now: not the opposite heading, which is the same axis
    if joint is None:
        raise TaskRefused(OUTSIDE)
    context.enter(State.TURN, "heading ordered")
    yield from face(context, heading, joint, "heading ordered")
    if abs(wrap(heading - _pointed(context))) > max(BEARABLE, context.settings.follow):
        raise TaskRefused(OUTSIDE if _joint_for(context, heading) is None else MISSED)
    return Result(Outcome.COMPLETED, "heading reached")


def _pointed(context: Context) -> float:
    """Return the heading that was turned to [rad]: of the goal where the actuator says that it is there.

    How near an actuator comes to its goal is its own to say, as `resolution_deg` tells.
    """
    holding, here = context.holding, context.pointing
    if holding is None or holding.due is not None or not context.here.settled:
        return here.heading
    return here.at(holding.goal)


def _park(context: Context) -> Step[Result]:
    yield from hop(context)
    context.enter(State.TURN, "parking")
    yield from turn(context, context.settings.park, "parking")
    return Result(Outcome.COMPLETED, "parked")


def _joint_for(context: Context, heading: float) -> float | None:
    """Return the joint angle nearest to here that points the axis to a heading [rad], None outside the limits."""
    here = context.pointing
    return nearest_joint(heading - here.zero, here.joint, context.settings.lower, context.settings.upper)


def _home(context: Context) -> Step[Result]:
    """Find the zero and arm again; the fault that made it necessary is still there when it begins."""
    context.enter(State.TURN, "finding the zero of the joint")
    end = context.samples + round(HOMING * context.settings.rate)
    heard = yield from exchange(context, Output(home=True))
    obey(context, heard.orders)
    last, was_well = end, False
    while (heard.fault or not heard.settled) and context.samples < last:  # nothing settles before it is armed
        heard = yield from exchange(context, Output(rearm=not was_well))
        obey(context, heard.orders)
        was_well = was_well or not heard.fault
        if was_well:  # what begins now is another fault, and finding the zero does not clear it
            last = min(last, context.samples + round(FAULT * context.settings.rate)) if heard.fault else end
    if heard.fault:
        raise Ended(Outcome.FAULT, heard.fault)
    return Result(Outcome.COMPLETED, "zero found")


def _measure(context: Context, seconds: float) -> Step[Result]:
    yield from hop(context)
    context.enter(State.NOISE)
    heard, speeds = yield from listen(context, max(seconds or context.settings.lead_in, LEAST_NOISE))
    context.keep_lead_in(heard, speeds)
    context.say_noise(quiet=True)
    return Result(Outcome.COMPLETED, f"noise measured for {heard.shape[1] / context.settings.rate:g} s")
