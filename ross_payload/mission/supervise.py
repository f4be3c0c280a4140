"""The mission from start to end: explore, align, exploit, and start again when the target's score drops."""

from __future__ import annotations

from ross_payload.events import Finished, Outcome, State
from ross_payload.interfaces import Mission, Output, Result
from ross_payload.mission.align import align
from ross_payload.mission.context import Context, Ended, Settings, Step, Tools, hop
from ross_payload.mission.exploit import run, search
from ross_payload.mission.explore import explore, lead_in


def mission(settings: Settings, tools: Tools) -> Mission:
    """Find the target, turn so that its interferers pose as one, and keep listening.

    Prime it with ``next``; then send one Input for every Output. It returns a Result, and its last Output carries the
    Finished event and asks for a stop of the motion.
    """
    context = Context(settings, tools)
    try:
        result = yield from _attempts(context)
    except Ended as ended:
        context.enter(State.FAULT if ended.outcome is Outcome.FAULT else State.STOPPED, ended.reason)
        result = Result(ended.outcome, ended.reason)
    else:
        context.enter(State.DONE, result.reason)
    context.say(Finished(context.time, result.outcome, result.reason))
    yield Output(tuple(context.pending), stop=True)
    return result


def _attempts(context: Context) -> Step[Result]:
    yield from hop(context)
    yield from lead_in(context)
    for _ in range(context.settings.max_restarts + 1):
        estimate, source = yield from explore(context)
        if not estimate.sources:
            return Result(Outcome.NO_TARGET, "nobody is talking")
        if source is None:
            candidates = align(context, estimate)
            if not candidates:
                return Result(Outcome.NO_TARGET, f"no heading within the limits sets any of {estimate.k} voices apart")
            source = yield from search(context, estimate, candidates)
        if source is None:
            return Result(Outcome.NO_TARGET, f"none of {estimate.k} voices is the target's")
        if (yield from run(context, estimate, source)):
            return Result(Outcome.TARGET_FOUND, f"source {source} is the target")
    return Result(Outcome.NO_TARGET, f"the target's score dropped {context.settings.max_restarts + 1} times")
