"""Separate what was heard while sources moved, or the array turned: piece by piece, with what held in each.

A separator is told one delay per source. A period is therefore cut where a delay has changed by as much as makes
another source of it, every piece is separated with the delays in its middle, and the voices are faded into one another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ross_payload.angles import circular_mean, wrap
from ross_payload.dsp.steering import ALIAS
from ross_payload.events import Estimate
from ross_payload.interfaces import Groups, Real
from ross_payload.mission.context import Context, Listening
from ross_payload.mission.identify_target import Identification, judged, recognise, separate
from ross_payload.mission.voice_evidence import Evidence

SHORTEST = 0.5  # piece [s]
AROUND = 0.5  # heard before and after a piece to learn from [s]
FADE = 0.05  # from one piece to the next [s]


@dataclass(frozen=True, slots=True)
class Piece:
    """A stretch of a period in which nothing has moved by much."""

    first: int  # sample of the period
    last: int  # and the one after its end
    heading: float  # [rad]
    azimuths: Real  # [rad], (k,)


def recognise_moving(
    context: Context, estimate: Estimate, start: int, listening: Listening, evidence: Evidence | None = None
) -> Identification:
    """Separate and score a period that began with sample ``start``; in one piece unless somebody has moved.

    What was heard before counts, too: ``evidence``. Whoever stands well apart in the longest piece adds to it.
    """
    tracker = context.tracker
    rate, n = context.settings.rate, listening.samples.shape[1]
    if tracker is None or not (tracker.acts or tracker.turned > start / rate):
        if tracker is not None:
            tracker.forget((start + n) / rate)
        return recognise(context, estimate, listening, evidence)
    hops = 1 if listening.headings is None else len(listening.headings)
    count = max(hops, round(100 * n / rate))
    edges = np.round(np.linspace(0, n, count + 1)).astype(int)
    middles = (edges[1:] + edges[:-1]) / 2
    headings = _headings(listening, middles)
    azimuths = tracker.azimuths_at((start + middles) / rate)
    tracker.forget((start + n) / rate)
    found = pieces(azimuths, headings, edges, round(SHORTEST * rate))
    longest = max(found, key=lambda piece: piece.last - piece.first)
    there = _with_azimuths(estimate, longest.azimuths)
    return judged(context, there, longest.heading, _joined(context, estimate, listening, found), evidence)


def pieces(azimuths: Real, headings: Real, edges: Real, shortest: int) -> list[Piece]:
    """Cut a period where a delay has changed by more than tells two sources apart.

    Parameters
    ----------
    azimuths : (k, n)
        Of every source [rad].
    headings : (n,)
        Of the array [rad].
    edges : (n + 1,)
        Samples at the beginnings of the n parts, and at the end.
    shortest
        Length of a piece, at least [samples].

    Examples
    --------
    >>> still, walks = np.zeros(10), np.radians(np.linspace(60, 100, 10))
    >>> [(p.first, p.last) for p in pieces(np.stack([still, walks]), np.zeros(10), np.arange(0, 110, 10), 20)]
    [(0, 20), (20, 40), (40, 60), (60, 80), (80, 100)]
    >>> len(pieces(np.zeros((2, 10)), np.zeros(10), np.arange(0, 110, 10), 20))
    1
    """
    delays = np.cos(azimuths - headings)
    cuts = [0]
    for place in range(1, delays.shape[1]):
        moved = np.abs(delays[:, place] - delays[:, cuts[-1]]).max(initial=0.0) > ALIAS
        if moved and edges[place] - edges[cuts[-1]] >= shortest <= edges[-1] - edges[place]:
            cuts.append(place)
    found = []
    for begin, end in pairwise([*cuts, delays.shape[1]]):
        middle = (begin + end) // 2
        heading = circular_mean(headings[begin:end])
        found.append(Piece(int(edges[begin]), int(edges[end]), heading, azimuths[:, middle]))
    return found


def _headings(listening: Listening, middles: Real) -> Real:
    if listening.headings is None:
        return np.full(len(middles), listening.heading)
    n, hops = listening.samples.shape[1], len(listening.headings)
    return np.interp(middles, (np.arange(hops) + 0.5) * n / hops, np.unwrap(listening.headings))


def _joined(context: Context, estimate: Estimate, listening: Listening, found: Sequence[Piece]) -> tuple[Groups, Real]:
    """Separate every piece; return the groups and their voices (n_groups, n_samples) over the whole period."""
    rate, n = context.settings.rate, listening.samples.shape[1]
    around, fade = round(AROUND * rate), round(FADE * rate)
    made: list[Groups] = []
    voices = np.zeros((estimate.k, n), np.float32)  # of the group that holds every source
    for piece in found:
        begin, end = max(piece.first - around, 0), min(piece.last + around, n)
        aboard = listening.aboard + piece.heading - listening.heading
        speeds = listening.speeds(begin, end)
        heard = Listening(piece.heading, listening.samples[:, begin:end], aboard=aboard, rotor_speeds=speeds)
        groups, parts = separate(context, _with_azimuths(estimate, piece.azimuths), heard)
        weight = _window(piece, np.arange(begin, end), n, fade)
        for group, part in zip(groups.members, parts, strict=True):
            for source in group:
                voices[source, begin:end] += weight * part
        made.append(groups)
    together = _together([groups.members for groups in made], estimate.k)
    pieces = "" if len(made) == 1 else f"in {len(made)} pieces"
    reasons = "; ".join(dict.fromkeys(groups.why for groups in made if groups.why))
    why = ", ".join(filter(None, (reasons, pieces)))
    joined = Groups(np.zeros((len(together), 1, 0), complex), together, made[-1].method, why)
    return joined, voices[[members[0] for members in together]]


def _with_azimuths(estimate: Estimate, azimuths: Real) -> Estimate:
    """The same sources elsewhere [rad], (k,)."""
    places = zip(estimate.sources, azimuths, strict=True)
    return replace(estimate, sources=tuple(replace(each, azimuth=wrap(float(azimuth))) for each, azimuth in places))


def _window(piece: Piece, samples: Real, n: int, fade: int) -> Real:
    rise = 1.0 if piece.first == 0 else np.clip((samples - piece.first) / fade + 0.5, 0, 1)
    fall = 1.0 if piece.last == n else np.clip((piece.last - samples) / fade + 0.5, 0, 1)
    return np.asarray(rise * fall * np.ones(len(samples)), np.float32)


def _together(partitions: Sequence[Sequence[tuple[int, ...]]], k: int) -> tuple[tuple[int, ...], ...]:
    """Sources that were in one group in every piece; one that is in no group is alone, with a voice of nothing.

    >>> _together([((0, 1), (2,)), ((0, 1), (2,))], 3), _together([((0, 1), (2,)), ((0,), (1, 2))], 3)
    (((0, 1), (2,)), ((0,), (1,), (2,)))
    >>> _together([((0, 1), ())], 3)
    ((0, 1), (2,))
    """
    history = [
        tuple(next((g for g in groups if source in g), (source,)) for groups in partitions) for source in range(k)
    ]
    return tuple(tuple(source for source in range(k) if history[source] == each) for each in dict.fromkeys(history))
