"""Sources confirmed, dropped or added while the mission listens to one of them.

What is heard at the alignments tells the explorer as much as orientations do. It is asked to explain all of it, the
exploration and what came after, by the sources that are believed in: every confidence is then that of everything
heard. A source that is most probably nobody is dropped; all others stay where they are. Where there may be more talkers
the explanation has a rival: who is somebody beyond doubt in it, beside everybody who is believed in, is added.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ross_payload.angles import difference
from ross_payload.events import Estimate, SourceEstimate, SourcesEstimated, SourcesReconsidered
from ross_payload.interfaces import Real
from ross_payload.mission.context import Context, Listening
from ross_payload.mission.orientation_scan import matched, observe

DROPPED = 0.35  # probability that a source is somebody, below which it is dropped
ADDED = 0.9  # probability that a source of the rival is somebody, from which on it is added
APART = np.deg2rad(30.0)  # from every source that is known; nearer a talker is found in two parts, now and then [rad]
SAME = np.deg2rad(15.0)  # a source of both explanations is in one place, or nearly [rad]
SPOT = np.deg2rad(0.5)  # headings nearer than this are one [rad]
MOST = 4  # T_unit heard at one heading that count, the latest: none may outweigh the exploration
EVERY = 10.0  # [s] between two times that the explorer is asked, at least; then ever longer, as less is new


def keep(context: Context, listening: Listening) -> None:
    """Let the explorer hear a listening period after the exploration, each T_unit at rest as one observation."""
    if context.tools.reconsidering is None or not context.observations or _moved(context) or listening.deaf:
        return
    for take in takes(listening, round(context.settings.unit * context.settings.rate)):
        seen = observe(context, take)
        here = [each for each in context.heard_since if abs(difference(each.heading, seen.heading)) <= SPOT]
        if len(here) >= MOST:
            context.heard_since = [each for each in context.heard_since if each is not here[0]]
        context.heard_since.append(seen)


def takes(listening: Listening, unit: int) -> Iterator[Listening]:
    """Cut what was heard into takes of ``unit`` samples at one heading each, shorter where it rested less at one.

    While it turned it is not taken, nor what is shorter than half of ``unit``.
    """
    n, headings = listening.samples.shape[1], listening.headings
    if headings is None:
        headings = np.full(1, listening.heading)
    edges = np.round(np.linspace(0, n, len(headings) + 1)).astype(int)
    for first, last in _stretches(headings):
        begin, end = int(edges[first]), int(edges[last])
        length = min(unit, end - begin)
        if 2 * length < unit:
            continue
        aboard = listening.aboard + float(difference(headings[first], listening.heading))
        for start in range(begin, end - length + 1, length):
            samples = listening.samples[:, start : start + length]
            yield replace(
                listening, heading=float(headings[first]), samples=samples, spread=0.0, headings=None, aboard=aboard,
                rotor_speeds=None,
            )  # fmt: skip


def _stretches(headings: Real) -> Iterator[tuple[int, int]]:
    """First and one after the last of the hops between which the heading stays.

    >>> list(_stretches(np.array([0.0, 0.0, 0.1, 0.2, 0.2, 0.2])))
    [(0, 2), (2, 3), (3, 6)]
    """
    first = 0
    for place in range(1, len(headings) + 1):
        if place == len(headings) or abs(difference(headings[place], headings[first])) > SPOT:
            yield first, place
            first = place


def reconsider(context: Context, estimate: Estimate, source: int | None) -> tuple[Estimate, dict[int, int]]:
    """Ask the explorer about all that was heard, and say what it believes.

    Returns what it believes in now, and what the sources were called before, {before: now}. ``source``, which sounds
    like the target, is never dropped.
    """
    everybody, explorer = {k: k for k in range(estimate.k)}, context.tools.reconsidering
    if explorer is None or not _due(context, estimate):
        return estimate, everybody
    first = context.time if context.reconsidered is None else context.reconsidered[0]
    context.reconsidered = first, context.time
    seen = [*context.observations, *context.heard_since]
    renewed = reassessed(estimate, explorer.reconsider(seen, estimate))
    if renewed is None:
        return estimate, everybody
    dropped = doubtful(renewed, source)
    context.publish(SourcesReconsidered(context.time, renewed, dropped))
    if dropped:
        return _without(context, renewed, dropped)
    more = joined(renewed)
    if more is not None:
        context.publish(SourcesEstimated(context.time, more, context.rotations, final=True))
        return more, everybody
    if context.tracker is not None:
        context.tracker.anchor = renewed
    return renewed, everybody


def joined(estimate: Estimate) -> Estimate | None:
    """The estimate with those of its rival who are no sources of its own, after them; None when one of them is doubted.

    None, too, when its own are not all in the rival, or nobody else is.

    >>> def told(*pairs, rival=None):
    ...     return Estimate(tuple(SourceEstimate(a, 0.1, c, True) for a, c in pairs), rival=rival)
    >>> rival = told((0.1, 1.0), (1.0, 0.95), (2.0, 1.0))
    >>> [source.azimuth for source in joined(told((2.0, 1.0), (0.0, 1.0), rival=rival)).sources]
    [2.0, 0.0, 1.0]
    >>> joined(told((0.0, 1.0), rival=told((0.1, 1.0), (1.0, 0.8))))
    >>> joined(told((2.0, 1.0), (0.0, 1.0), rival=told((0.1, 1.0), (1.0, 0.95), (-2.0, 1.0))))
    """
    if estimate.rival is None:
        return None
    again = set(matched(estimate.azimuths, estimate.rival, SAME).values())
    new = [each for index, each in enumerate(estimate.rival.sources) if index not in again]
    if not new or len(again) < estimate.k:
        return None
    apart = np.abs(difference(estimate.azimuths[:, None], [each.azimuth for each in new]))
    if apart.min() < APART or min(each.confidence for each in new) < ADDED:
        return None
    return replace(estimate, sources=(*estimate.sources, *new), rival=None)


def reassessed(before: Estimate, now: Estimate | None) -> Estimate | None:
    """The sources of an estimate with their confidences in a later explanation of as many, and its rival.

    A source that is not in it any more has none. Where there is no such explanation nothing is known: None.

    >>> told = [Estimate(tuple(SourceEstimate(a, 0.1, c, True) for a, c in pairs)) for pairs in (
    ...     ((0.0, 0.8), (2.0, 0.6)), ((-2.5, 0.5), (0.1, 0.9)))]
    >>> [source.confidence for source in reassessed(*told).sources]
    [0.9, 0.0]
    """
    if now is None or not now.sources:
        return None
    places = now.azimuths
    sources = tuple(_again(source, now, places) for source in before.sources)
    return replace(before, sources=sources, rival=now.rival)


def doubtful(estimate: Estimate, source: int | None) -> tuple[int, ...]:
    """Which sources are most probably nobody, ``source`` not among them; never all."""
    found = [k for k, each in enumerate(estimate.sources) if each.confidence < DROPPED and k != source]
    return tuple(found) if len(found) < estimate.k else ()


def _again(source: SourceEstimate, now: Estimate, places: Real) -> SourceEstimate:
    apart = np.abs(difference(places, source.azimuth))
    confidence = now.sources[int(apart.argmin())].confidence if apart.min() <= SAME else 0.0
    return replace(source, confidence=confidence)


def _without(context: Context, estimate: Estimate, dropped: Sequence[int]) -> tuple[Estimate, dict[int, int]]:
    """Go on without some sources: what was heard of the others counts as before."""
    left = [k for k in range(estimate.k) if k not in dropped]
    names = {old: new for new, old in enumerate(left)}
    estimate = replace(estimate, sources=tuple(estimate.sources[k] for k in left))
    context.publish(SourcesEstimated(context.time, estimate, context.rotations, final=True))
    if context.evidence is not None:
        context.evidence = context.evidence.renamed(names)
    return estimate, names


def _due(context: Context, estimate: Estimate) -> bool:
    if not context.heard_since or not estimate.k or _moved(context):
        return False
    if context.reconsidered is None:
        return True
    first, latest = context.reconsidered
    return context.time - latest >= max(EVERY, latest - first)


def _moved(context: Context) -> bool:
    """Whether a source has left the place where the exploration found it."""
    return context.tracker is not None and context.tracker.acts
