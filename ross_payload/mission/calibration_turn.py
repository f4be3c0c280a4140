"""Listen to one sound at headings all around: what self-calibration needs. Nothing is computed while it turns."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from ross_payload.angles import wrap
from ross_payload.calibration.cross_spectrum import HeadingSpectrum, heading_spectrum
from ross_payload.events import Finished, Outcome, State
from ross_payload.interfaces import Mission, Output, Result
from ross_payload.mission.context import Context, Ended, FrameChanged, Step, hop, turn
from ross_payload.mission.explore import schedule
from ross_payload.mission.heading_control import BEARABLE
from ross_payload.mission.heading_hold import attend, face
from ross_payload.mission.settings import Settings, Tools

WHOLE = 2 * math.pi


def stepped(settings: Settings, angle: float, headings: int) -> Settings:
    """Return settings with which `schedule` visits so many headings over a turn [rad], or over all of a smaller travel.

    Of a whole turn the last step would lead to the first heading, and is left out.
    """
    travel = settings.upper - settings.lower
    step = WHOLE / headings if angle >= WHOLE else angle / (headings - 1)
    step = min(step, travel / (headings - 1))
    return replace(settings, rotation=step, max_rotations=headings - 1)


def calibration_turn(settings: Settings, tools: Tools, seconds: float, spectra: list[HeadingSpectrum]) -> Mission:
    """Listen for ``seconds`` at every heading of the schedule, add what was heard to ``spectra``, and turn back.

    Prime it with ``next``; then send one Input for every Output. It returns a Result; its last Output asks for a stop.
    """
    context = Context(settings, tools)
    try:
        yield from hop(context)
        yield from _headings(context, list(schedule(context)), seconds, spectra)
        result = Result(Outcome.COMPLETED, f"listened at {len(spectra)} headings")
    except FrameChanged as changed:
        result = Result(Outcome.FAULT, changed.reason)
    except Ended as ended:
        result = Result(ended.outcome, ended.reason)
    fault = result.outcome is Outcome.FAULT
    state = State.FAULT if fault else State.STOPPED if result.outcome is Outcome.STOPPED else State.DONE
    context.enter(state, result.reason)
    context.publish(Finished(context.time, result.outcome, result.reason))
    yield Output(tuple(context.pending), stop=True)
    return result


def _headings(context: Context, joints: Sequence[float], seconds: float, spectra: list[HeadingSpectrum]) -> Step[None]:
    """Visit the nearest joint angle next, until all have been visited."""
    todo, start, zero = list(joints), context.pointing.joint, context.pointing.zero
    for number in range(1, len(joints) + 1):
        here = context.pointing.joint + wrap(context.pointing.zero - zero)
        joint = min(todo, key=lambda joint: round(abs(joint - here), 9))
        todo.remove(joint)
        if number > 1 or abs(joint - here) > BEARABLE:
            context.enter(State.EXPLORE_TURN, f"calibration, heading {number} of {len(joints)}")
            yield from face(context, zero + joint, joint, f"calibration, heading {number}")
        context.enter(State.EXPLORE_LISTEN, f"calibration, heading {number} of {len(joints)}")
        listening = yield from attend(context, seconds)
        found = heading_spectrum(listening.samples, context.settings.rate, listening.heading)
        if found is not None:
            spectra.append(found)
    context.drop_frame()
    back = min(max(start, context.settings.lower), context.settings.upper)  # it may have stood beyond a limit
    yield from turn(context, back, "back to where it was")
