"""Pipelined: go to a promising alignment before the exploration ends; the turn is one more orientation.

What is heard there serves twice: for the explorer as an orientation, for separator and voice print as a T_check. Only a
belief that survives the visit is run with. While it runs the explorer goes on hearing, and what was wrong is mended.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np

from ross_payload.angles import difference
from ross_payload.events import AlignmentCandidate, Checked, Estimate, State
from ross_payload.mission.align import align, good_here, here, next_visit, planned
from ross_payload.mission.context import Context, Listening, Step
from ross_payload.mission.heading_hold import face_alignment
from ross_payload.mission.identify_target import Identification, recall, recognise
from ross_payload.mission.orientation_scan import certain, matched, observe, orientation, say_belief, steady
from ross_payload.mission.voice_evidence import Evidence

CLEAR = 0.2  # least isolation at the alignment [d / v_p]
SPOT = np.deg2rad(0.5)  # headings nearer than this are one [rad]


@dataclass(frozen=True, slots=True)
class PromisingVisit:
    """An alignment worth a visit, and what the exploration has heard of every source."""

    candidate: AlignmentCandidate
    recalled: Evidence


@dataclass(slots=True)
class Visits:
    """The alignments visited by one exploration."""

    count: int = 0
    rejected: list[float] = field(default_factory=list)  # azimuths [rad] of sources that are not the target


def promising(context: Context, visits: Visits) -> PromisingVisit | None:
    """Return the alignment worth a visit instead of the next orientation, or None.

    The belief must be steady; the alignment must set its source apart clearly, and the source must not have been
    rejected before. The likelier one by what the exploration has heard comes first, and of the like the nearer one.
    """
    if not steady(context.beliefs) or visits.count >= context.settings.max_rotations:
        return None
    estimate = context.beliefs[-1]
    clear = CLEAR * context.settings.spacing / context.settings.speed_of_sound
    rejected = set(matched(visits.rejected, estimate).values())
    candidates = [c for c in planned(context, estimate).candidates if c.isolation >= clear and c.source not in rejected]
    if not candidates:
        return None
    recalled = recall(context, estimate)
    return PromisingVisit(next_visit(context, candidates, recalled.scores), recalled)


def visit(context: Context, promise: PromisingVisit, visits: Visits, *, last: bool) -> Step[int | None]:
    """Turn to an alignment and listen; return the target's source when it is recognised and the belief survives."""
    before, candidate = context.beliefs[-1], promise.candidate
    align(context, before)
    yield from face_alignment(context, candidate)
    context.enter(State.CHECK, f"source {candidate.source}")
    after = yield from orientation(context, max(context.settings.unit, context.settings.check))
    visits.count += 1
    own = matched(before.azimuths, after)
    if candidate.source not in own:
        say_belief(context, final=last or certain(context))
        return None
    context.evidence = promise.recalled.renamed(own)
    found = recognise(context, after, context.explored[-1], context.evidence)
    target = None if found.best is None else found.scores[found.best].members[0]
    if target != own[candidate.source]:
        visits.rejected.append(before.sources[candidate.source].azimuth)
    survives = target is not None and after.k == before.k and good_here(context, after, target)
    say_belief(context, final=survives or last or certain(context))
    align(context, after)
    _say_checked(context, after, own[candidate.source], candidate.rule, found)
    return target if survives else None


def _part(listening: Listening, begin: int, end: int) -> Listening:
    """What was heard between two samples, as at one heading."""
    samples, speeds = listening.samples[:, begin:end], listening.speeds(begin, end)
    return replace(listening, samples=samples, headings=None, rotor_speeds=speeds)


def mend(context: Context, estimate: Estimate, source: int, listening: Listening) -> tuple[Estimate, int]:
    """Ask the explorer about what a run has heard; return what to believe now and which source is the target.

    Every T_unit of the run takes the place of what was heard on arrival once: no heading may weigh more than another.
    When most of them agree on another K, the belief is theirs.
    """
    explorer = context.tools.explorer
    spot = SPOT + listening.spread
    earlier = [seen for seen in context.observations if abs(difference(seen.heading, listening.heading)) > spot]
    unit = round(context.settings.unit * context.settings.rate)
    starts = range(0, max(listening.samples.shape[1] - unit, 0) + 1, unit)
    takes = [observe(context, _part(listening, start, start + unit)) for start in starts]
    beliefs = [explorer.estimate([*earlier, take]) for take in takes]
    counts = Counter(belief.k for belief in beliefs)
    k, votes = counts.most_common(1)[0]
    mended = next(belief for belief in reversed(beliefs) if belief.k == k)
    own = matched([estimate.sources[source].azimuth], mended)
    if k == estimate.k or 2 * votes <= len(beliefs) or not own:
        return estimate, source
    context.beliefs.append(mended)
    say_belief(context, final=True)
    return mended, own[0]


def _say_checked(context: Context, estimate: Estimate, source: int, rule: str, found: Identification) -> None:
    groups, reached = found.groups, here(context, estimate, source, rule)
    context.publish(Checked(context.time, reached, found.scores, found.best, groups.method, groups.why))
