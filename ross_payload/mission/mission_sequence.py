"""The mission from start to end: explore, align, exploit, and start again when the target's score drops."""

from __future__ import annotations

from ross_payload.errors import PluginError
from ross_payload.events import Doubted, Estimate, Finished, Outcome, SourcesEstimated, State
from ross_payload.interfaces import Mission, Output, Result
from ross_payload.mission.align import align
from ross_payload.mission.context import Context, Ended, FrameChanged, Step, hop
from ross_payload.mission.exploit import DROPPED, OUTSCORED, Search, run, search, search_among
from ross_payload.mission.explore import added, explore_on, lead_in
from ross_payload.mission.orientation_scan import matched
from ross_payload.mission.reconsideration import reconsider
from ross_payload.mission.settings import Settings, Tools
from ross_payload.mission.slip_detection import survey


def mission(settings: Settings, tools: Tools, informed: Estimate | None = None, target: int | None = None) -> Mission:
    """Find the target, turn so that its interferers have the same delay, and keep listening.

    Prime it with ``next``; then send one Input for every Output. It returns a Result, and its last Output carries the
    Finished event and asks for a stop of the motion.

    Parameters
    ----------
    settings, tools
        The numbers, and what to hear and decide with.
    informed
        Where the sources are, told from outside: nothing is explored, unless the target is not recognised among them
        or its score drops. None: explore.
    target
        Which of these sources is visited first.
    """
    context = Context(settings, tools)
    try:
        yield from hop(context)
        yield from lead_in(context)
        result = yield from attempts(context, informed, target)
    except PluginError as error:  # a separator, an explorer or a network of others
        context.enter(State.FAULT, str(error))
        result = Result(Outcome.FAULT, str(error))
    except Ended as ended:
        context.enter(State.FAULT if ended.outcome is Outcome.FAULT else State.STOPPED, ended.reason)
        result = Result(ended.outcome, ended.reason)
    else:
        context.enter(State.DONE, result.reason)
    context.publish(Finished(context.time, result.outcome, result.reason))
    yield Output(tuple(context.pending), stop=True)
    return result


def attempts(context: Context, informed: Estimate | None, target: int | None) -> Step[Result]:
    """Find the target and listen to it; start again when it is lost, or when the frame of the headings changes."""
    dropped = 0
    for left in reversed(range(context.settings.max_restarts + 1)):
        try:
            source, why, held = yield from _attempt(context, informed, target, doubts=left > 0)
        except FrameChanged as changed:
            if not left:
                raise
            context.drop_frame()
            context.publish(Doubted(context.time, changed.reason))
            informed = target = None
            continue
        if held:
            return Result(Outcome.TARGET_FOUND, f"source {source} is the target")
        if source is None and (informed is None or not left):
            return _no_target(context, why)
        if source is not None:
            dropped += 1
        if informed is not None and left:
            context.publish(Doubted(context.time, why))
        informed = target = None
    return _no_target(context, f"gave up after {dropped} attempts: {why}")


def _no_target(context: Context, why: str) -> Result:
    """Say that the target was not found, unless nobody would have been."""
    fault = context.hearing.fault()
    if fault:
        return Result(Outcome.FAULT, f"cannot tell whether the target is there: {fault}")
    return Result(Outcome.NO_TARGET, why)


def _attempt(
    context: Context, informed: Estimate | None, target: int | None, *, doubts: bool
) -> Step[tuple[int | None, str, bool]]:
    """Return the target's source or why there is none, and whether it was heard to the end.

    When a voice turns out not to be the target's as soon as it is heard longer, the candidates that are left come next.
    """
    estimate, source = yield from _where(context, informed)
    among = None
    if source is None:
        among, why = _whom(context, estimate, target)
        if among is None:
            return None, why, False
        among, source = yield from _sought(context, among)
        if source is None:
            among, source = yield from _sought_on(context, among)
        estimate = among.estimate
    if source is None:
        estimate, _ = reconsider(context, estimate, None)
        return None, f"none of the {estimate.k} voices is the target's", False
    while True:
        why = yield from run(context, estimate, source, among, doubts=doubts)
        at_once = context.evidence is not None  # fell below the criterion as soon as it was heard longer
        believed, source = context.believed or (estimate, source)
        other = None
        if why in {DROPPED, OUTSCORED} and at_once and among is not None:
            if added(among.estimate, believed):  # meanwhile, and whoever it is has not been visited either
                among = _newcomers(context, among, believed)
            elif believed.k != among.estimate.k:
                _say_estimate(context, among.estimate)
            among, other = yield from _sought(context, among)
            estimate = among.estimate
        if other is None:
            return source, why, not why
        source = other


def _sought(context: Context, among: Search) -> Step[tuple[Search, int | None]]:
    """Search; where nobody is recognised, search among the sources of the second-best explanation, if there is one.

    Returns among whom the target was found at last, and its source. Only who is not in the best explanation is visited:
    all the others have been heard, and what was heard of them goes on to count. When the second explanation does not
    hold the target either, the best one is believed again.
    """
    source, rival = (yield from search(context, among)), among.estimate.rival
    if source is not None or rival is None:
        return among, source
    if not added(among.estimate, rival):
        return among, None
    _say_estimate(context, rival)
    other = _newcomers(context, among, rival)
    source = (yield from search(context, other)) if other.left else None
    if source is not None:
        return other, source
    _say_estimate(context, among.estimate)
    return among, None


def _sought_on(context: Context, among: Search) -> Step[tuple[Search, int | None]]:
    """Where nobody is recognised, explore what was left out, and search among those who are found then.

    Returns as `_sought`. A source that has been heard is not visited again: what was heard of them goes on to count.
    """
    belief = yield from explore_on(context, among.estimate)
    if belief is None:
        return among, None
    if not added(among.estimate, belief):
        among.estimate = belief
        return among, None
    other = _newcomers(context, among, belief)
    return other, ((yield from search(context, other)) if other.left else None)


def _newcomers(context: Context, among: Search, estimate: Estimate) -> Search:
    """Begin to look for the target among the sources of another estimate who have not been visited yet."""
    known = matched(among.estimate.azimuths, estimate)
    other = search_among(context, estimate, align(context, estimate), known=among.evidence.renamed(known))
    visited = set(known.values()) - {known[each.source] for each in among.left if each.source in known}
    other.left = [candidate for candidate in other.left if candidate.source not in visited]
    other.first = None if among.first is None else known.get(among.first)
    other.longer = {known[each] for each in among.longer if each in known}
    other.returned = {known[each] for each in among.returned if each in known}
    return other


def _say_estimate(context: Context, estimate: Estimate) -> None:
    context.publish(SourcesEstimated(context.time, estimate, context.rotations, final=True))


def _where(context: Context, informed: Estimate | None) -> Step[tuple[Estimate, int | None]]:
    """Say what is told from outside, or explore; return it and, when the exploration has found it, the target."""
    if informed is None:
        return (yield from survey(context))
    context.publish(SourcesEstimated(context.time, informed, rotations=0, final=True, informed=True))
    return informed, None


def _whom(context: Context, estimate: Estimate, target: int | None) -> tuple[Search | None, str]:
    """Return among whom to search for the target, or None and why."""
    if not estimate.sources:
        return None, "nobody is talking"
    candidates = align(context, estimate)
    if not candidates:
        return None, f"no heading within the limits isolates any of the {estimate.k} sources"
    return search_among(context, estimate, candidates, target), ""
