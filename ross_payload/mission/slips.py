"""Notice that the array has slipped: every azimuth shifts by one angle, since people do not move together.

Nothing on the wire of an open loop tells that steps were lost, nor does an encoder on the motor's side tell that a
clutch has slipped. The talkers do: where all of them are found turned by the same angle, the array was turned.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ross_payload.angles import difference, wrap
from ross_payload.dsp.turned import common_turn
from ross_payload.events import Estimate, Slipped, SourcesEstimated
from ross_payload.interfaces import Output
from ross_payload.mission.context import Context, Listening, Step, exchange, hop, obey
from ross_payload.mission.explore import explore
from ross_payload.mission.orient import observe

FEWEST = 2  # sources whose shifts can agree
AGREE = math.radians(2)  # between the shifts of two sources [rad]
SUSPICIOUS = 2.0  # so much likelier than none is a turn that is looked into [nat]; found under 0.7 without a slip
LEAST, MOST = math.radians(3), math.radians(45)  # of a shift that is believed [rad]


def survey(context: Context) -> Step[tuple[Estimate, int | None]]:
    """Explore; where everybody has shifted together since the last time, say so and put the zero right.

    Returns the estimate and, when the exploration has found the target, its source.
    """
    before = context.surveyed
    estimate, source = yield from explore(context)
    earth = context.here.attitude.known
    shift = common_shift(before[0], estimate) if before is not None and before[1] == earth else None
    if shift is not None:
        estimate = yield from _put_right(context, estimate, shift)
    context.surveyed = estimate, earth
    return estimate, source


def suspicion(context: Context, estimate: Estimate, heard: Listening) -> str:
    """Say when all sources seem to have turned together while nobody told the array to; empty when they do not."""
    if estimate.k < FEWEST:
        return ""
    settings = context.settings
    angle, gain = common_turn(observe(context, heard), estimate, settings.spacing, settings.speed_of_sound)
    if gain < SUSPICIOUS or abs(angle) < LEAST:
        return ""
    return f"all sources appear to have shifted together by {abs(math.degrees(angle)):.0f} deg"


def common_shift(before: Estimate, after: Estimate) -> float | None:
    """Return the angle [rad] by which every azimuth has shifted, None when they did not, or each by its own.

    The least such angle is taken, and only one that is larger than talkers sway and smaller than an eighth of a turn:
    other people who stand where a shift would put them are a matter of chance.
    """
    old, new = (np.array([source.azimuth for source in each.sources]) for each in (before, after))
    if len(old) != len(new) or len(old) < FEWEST:
        return None
    for shift in sorted((wrap(azimuth - old[0]) for azimuth in new), key=abs):
        off = difference(new[None, :], old[:, None] + shift)
        nearest = np.abs(off).argmin(axis=1)
        rest = off[np.arange(len(old)), nearest]
        if len(set(nearest.tolist())) == len(old) and np.ptp(rest) <= AGREE:
            common = shift + float(rest.mean())
            return common if LEAST <= abs(common) <= MOST else None
    return None


def turned(estimate: Estimate, angle: float) -> Estimate:
    """Return an estimate with every azimuth turned by an angle [rad]."""
    sources = tuple(replace(source, azimuth=wrap(source.azimuth + angle)) for source in estimate.sources)
    return replace(estimate, sources=sources)


def _put_right(context: Context, estimate: Estimate, shift: float) -> Step[Estimate]:
    """Have the zero found again or the headings corrected, and turn back what was heard with the wrong ones."""
    context.say(Slipped(context.time, shift))
    obey(context, (yield from exchange(context, Output(slipped=shift))).orders)
    while not context.here.settled:
        yield from hop(context)
    context.explored = [replace(heard, heading=heard.heading - shift) for heard in context.explored]
    estimate = turned(estimate, -shift)
    context.holding = None
    context.say(SourcesEstimated(context.time, estimate, rotations=len(context.explored) - 1, final=True))
    return estimate
