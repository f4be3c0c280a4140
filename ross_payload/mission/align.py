"""Where the mission would turn: the plan for an estimate, and the order in which to visit its candidates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ross_payload.dsp.alignment import Plan, isolation
from ross_payload.dsp.gain import predicted_gain
from ross_payload.events import AlignmentCandidate, AlignmentPlanned, Estimate
from ross_payload.mission.context import Context


def planned(context: Context, estimate: Estimate) -> Plan:
    """Plan where to turn, nearest first."""
    settings, here = context.settings, context.here
    return context.tools.plan(
        estimate.sources,
        joint=here.joint,
        heading=here.heading_end,
        lower=settings.lower,
        upper=settings.upper,
        spacing=settings.spacing,
        speed_of_sound=settings.speed_of_sound,
        directness=estimate.directness,
    )


def align(context: Context, estimate: Estimate) -> tuple[AlignmentCandidate, ...]:
    """Plan where to turn, nearest first, and say so."""
    found = planned(context, estimate)
    context.say(AlignmentPlanned(context.time, found.candidates, found.headings, found.isolation))
    return found.candidates


def here(context: Context, estimate: Estimate, source: int, rule: str) -> AlignmentCandidate:
    """Return what the present heading is worth for a source."""
    settings, now = context.settings, context.here
    azimuths = [source.azimuth for source in estimate.sources]
    elevations = [source.elevation or 0.0 for source in estimate.sources]
    apart = isolation(azimuths, [now.heading_end], settings.spacing, settings.speed_of_sound, elevations)
    gain = predicted_gain(azimuths, [now.heading_end], elevations, estimate.directness)
    return AlignmentCandidate(
        source, now.heading_end, now.joint, float(apart[source, 0]), rule, gain_db=float(gain[source, 0])
    )


def in_order(
    candidates: Sequence[AlignmentCandidate], recalled: Mapping[int, float], criterion: float
) -> list[AlignmentCandidate]:
    """Recognised sources first, by score; the others as they are."""

    def rank(candidate: AlignmentCandidate) -> float:
        return -max(recalled.get(candidate.source, -np.inf), criterion)

    return sorted(candidates, key=rank)
