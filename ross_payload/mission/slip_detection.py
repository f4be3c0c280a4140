"""Notice that the array has slipped: every azimuth shifts by one angle, since people do not move together.

Nothing on the wire of an open loop tells that steps were lost, nor does an encoder on the motor's side tell that a
clutch has slipped. The talkers do: where all of them are found turned by the same angle, the array was turned.
"""

from __future__ import annotations

import math
from dataclasses import replace

from ross_payload.angles import wrap
from ross_payload.events import Estimate, Slipped, SourcesEstimated
from ross_payload.interfaces import Output
from ross_payload.localization.rotation_estimate import FEWEST, LEAST, common_shift, common_turn
from ross_payload.localization.sectors import shifted
from ross_payload.mission.context import Context, Listening, Step, exchange, hop, obey
from ross_payload.mission.explore import explore
from ross_payload.mission.orientation_scan import observe

SUSPICIOUS = 2.0  # so much likelier than none is a turn that is looked into [nat]; found under 0.7 without a slip


def survey(context: Context) -> Step[tuple[Estimate, int | None]]:
    """Explore; where everybody has shifted together since the last time, say so and put the zero right.

    Returns the estimate and, when the exploration has found the target, its source.
    """
    before = context.surveyed
    estimate, source = yield from explore(context)
    earth = context.pointing.earth
    shift = common_shift(before[0], estimate) if before is not None and before[1] == earth else None
    if shift is not None:
        estimate = yield from _put_right(context, estimate, shift)
    context.surveyed = estimate, earth
    return estimate, source


def suspicion(context: Context, estimate: Estimate, listening: Listening) -> str:
    """Say when all sources seem to have turned together while nobody told the array to; empty when they do not."""
    if estimate.k < FEWEST or listening.deaf:
        return ""
    settings = context.settings
    angle, gain = common_turn(observe(context, listening), estimate, settings.spacing, settings.speed_of_sound)
    if gain < SUSPICIOUS or abs(angle) < LEAST:
        return ""
    return f"all sources appear to have shifted together by {abs(math.degrees(angle)):.0f} deg"


def turned(estimate: Estimate, angle: float) -> Estimate:
    """Return an estimate with every azimuth turned by an angle [rad]."""
    sources = tuple(replace(source, azimuth=wrap(source.azimuth + angle)) for source in estimate.sources)
    rival = None if estimate.rival is None else turned(estimate.rival, angle)
    return replace(estimate, sources=sources, rival=rival)


def _put_right(context: Context, estimate: Estimate, shift: float) -> Step[Estimate]:
    """Have the zero found again or the headings corrected, and turn back what was heard with the wrong ones."""
    context.publish(Slipped(context.time, shift))
    obey(context, (yield from exchange(context, Output(slipped=shift))).orders)
    while not context.here.settled:
        yield from hop(context)
    context.explored = [replace(heard, heading=heard.heading - shift) for heard in context.explored]
    context.observations = [shifted(seen, -shift) for seen in context.observations]
    context.beliefs = [turned(belief, -shift) for belief in context.beliefs]
    estimate = turned(estimate, -shift)
    context.holding = None
    context.publish(SourcesEstimated(context.time, estimate, rotations=context.rotations, final=True))
    return estimate
