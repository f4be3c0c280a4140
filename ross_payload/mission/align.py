"""Where the mission would turn: the plan for an estimate, and what its candidates and the present heading are worth."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ross_payload.alignment.plan import Plan, Turn, isolation, plan
from ross_payload.alignment.predicted_gain import predicted_gain
from ross_payload.events import AlignmentCandidate, AlignmentPlanned, Estimate
from ross_payload.mission.context import Context

PER_RADIAN = 1.0  # [s] that turning takes, about
ROTORS = 0.5  # what leaks of rotors, as a share of the interferers: their covariance is known, so that less does
ENOUGH_LESS_DB = 1.0  # [dB] that the present heading may promise less than the best one


def planned(context: Context, estimate: Estimate) -> Plan:
    """Plan where to turn, nearest first."""
    settings, here = context.settings, context.pointing
    turn = Turn(here.heading - here.joint, here.joint, settings.lower, settings.upper)
    unit, rotors = settings.spacing / settings.speed_of_sound, context.tools.rotors
    if rotors is None or context.tools.plan is not plan or context.noise_of_explorer() is None:
        return context.tools.plan(estimate.sources, turn, unit, estimate.directness)
    return plan(estimate.sources, turn, unit, estimate.directness, beside=rotors.phasors(here.base), share=ROTORS)


def align(context: Context, estimate: Estimate) -> tuple[AlignmentCandidate, ...]:
    """Plan where to turn, nearest first, and say so."""
    found = planned(context, estimate)
    context.publish(AlignmentPlanned(context.time, found.candidates, found.headings, found.isolation))
    return found.candidates


def here(context: Context, estimate: Estimate, source: int, rule: str) -> AlignmentCandidate:
    """Return what the present heading is worth for a source."""
    settings, now = context.settings, context.pointing
    azimuths, elevations = estimate.azimuths, estimate.elevations
    apart = isolation(azimuths, [now.heading], settings.spacing, settings.speed_of_sound, elevations)
    gain = predicted_gain(azimuths, [now.heading], elevations, estimate.directness)
    return AlignmentCandidate(
        source, now.heading, now.joint, float(apart[source, 0]), rule, gain_db=float(gain[source, 0])
    )


def alignment_of(context: Context, estimate: Estimate, source: int) -> AlignmentCandidate | None:
    """Return the alignment for one source, or None when no heading within the limits sets it apart."""
    candidates = planned(context, estimate).candidates
    return next((candidate for candidate in candidates if candidate.source == source), None)


def good_here(context: Context, estimate: Estimate, source: int) -> bool:
    """Whether the present heading promises nearly as much for a source as its own alignment."""
    own = alignment_of(context, estimate, source)
    if own is None or own.gain_db is None:
        return True
    return (here(context, estimate, source, own.rule).gain_db or 0.0) >= own.gain_db - ENOUGH_LESS_DB


def next_visit(
    context: Context, candidates: Sequence[AlignmentCandidate], scores: Mapping[int, float]
) -> AlignmentCandidate:
    """Return the candidate that promises the most per second that a visit takes, with the turn.

    Scores are log-likelihood ratios: of two that are alike the nearer one comes first, and who is much likelier is
    worth a longer turn. A source that nobody has heard alone yet is undecided.
    """

    def promise(candidate: AlignmentCandidate) -> float:
        seconds = context.settings.check + PER_RADIAN * abs(candidate.joint - context.pointing.joint)
        return scores.get(candidate.source, context.settings.criterion) - math.log(seconds)

    return max(candidates, key=promise)
