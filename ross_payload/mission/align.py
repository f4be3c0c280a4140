"""Where the mission would turn: the plan for an estimate, and the order in which to visit its candidates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ross_payload.dsp.alignment import Plan, isolation, plan
from ross_payload.events import AlignmentCandidate, AlignmentPlanned, Estimate
from ross_payload.mission.context import Context


def planned(context: Context, estimate: Estimate) -> Plan:
    """Plan where to turn, nearest first."""
    settings, here = context.settings, context.here
    return plan(
        estimate.sources,
        joint=here.joint,
        heading=here.heading_end,
        lower=settings.lower,
        upper=settings.upper,
        spacing=settings.spacing,
        speed_of_sound=settings.speed_of_sound,
    )


def align(context: Context, estimate: Estimate) -> tuple[AlignmentCandidate, ...]:
    """Plan where to turn, nearest first, and say so."""
    found = planned(context, estimate)
    context.say(AlignmentPlanned(context.time, found.candidates, found.headings, found.isolation))
    return found.candidates


def isolation_here(context: Context, estimate: Estimate, source: int) -> float:
    """Return the isolation of a source at the present heading [s]."""
    settings = context.settings
    curve = isolation(
        [source.azimuth for source in estimate.sources],
        [context.here.heading_end],
        settings.spacing,
        settings.speed_of_sound,
        [source.elevation or 0.0 for source in estimate.sources],
    )
    return float(curve[source, 0])


def in_order(
    candidates: Sequence[AlignmentCandidate], recalled: Mapping[int, float], criterion: float
) -> list[AlignmentCandidate]:
    """Recognised sources first, by score; the others as they are."""

    def rank(candidate: AlignmentCandidate) -> float:
        return -max(recalled.get(candidate.source, -np.inf), criterion)

    return sorted(candidates, key=rank)
