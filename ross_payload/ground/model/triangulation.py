"""Where bearings of several payloads cross, and how sure that is.

Two bearings cross in one point of the plane, and K sources heard by two payloads in up to K x K: most of these are
ghosts. Geometry alone tells ghosts that lie behind an array from sources, no others. Whatever else there is counts as
evidence: a third payload that hears something in that direction, or nothing; the voice print; how strong a source is.
Assignments in which every source is used once share the probability, by their evidence; a crossing is a ghost when
another one of its sources is far more probable. Where nothing decides, none is called one.

The plane touches the ellipsoid (WGS84) at the first payload. For payloads and sources within 1 km of it that costs less
than 0.3 m up to 50 deg of latitude, and 0.6 m up to 70 deg.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

from ross_payload.ground.model.bearing_geometry import BearingLine, Crossing, Plane, cross_two, misses
from ross_payload.ground.model.jpda import marginals
from ross_payload.ground.model.payload_state import PayloadState
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.field_converters import clockwise

POSITION_SIGMA = 2.0  # of a payload's place, as satellites tell it [m]
MOST_SOURCES = 6  # of one payload that are crossed: those with the greatest weights
ALONE = 0.02  # weight of a source that the other payload does not hear
OTHER_TARGET = 0.05  # probability that a target is none, and of the others to be one, where no score is told
SURE = 4.0  # nat: a score does not tell more
STRENGTHS = math.log(4)  # sigma of how much stronger one payload hears a source than the other does
GHOST = 2.0  # times as probable as a ghost is another crossing with one of its sources
MISSED = 9.0  # squared sigmas at most by which one kind of evidence can speak against a crossing


@dataclass(frozen=True, slots=True)
class Bearing:
    """One direction in which one payload hears something."""

    who: ComponentId
    source: int
    latitude: float  # of the payload [rad]
    longitude: float  # of the payload [rad]
    azimuth: float  # counter-clockwise from north [rad]
    sigma: float  # of the azimuth [rad]
    position_sigma: float = POSITION_SIGMA  # in each direction [m]
    weight: float | None = None  # 0 to 1
    score: float | None = None  # [nat]
    target: bool = False


@dataclass(frozen=True, slots=True)
class Fix:
    """Where two bearings cross."""

    latitude: float  # [rad]
    longitude: float  # [rad]
    east: float  # of the first payload [m]
    north: float  # of the first payload [m]
    covariance: tuple[tuple[float, float], tuple[float, float]]  # east, north [m^2]
    payloads: tuple[ComponentId, ...]
    sources: tuple[int, ...]  # one of each payload
    ghost: bool
    probability: float

    def json(self) -> dict[str, Any]:
        """Return it as plain JSON, in degrees and metres."""
        return {
            "lat": math.degrees(self.latitude),
            "lon": math.degrees(self.longitude),
            "east": self.east,
            "north": self.north,
            "covariance": [list(row) for row in self.covariance],
            "payloads": [str(who) for who in self.payloads],
            "sources": list(self.sources),
            "ghost": self.ghost,
        }


def bearings_of(payload: PayloadState, latitude: float, longitude: float, mount: float | None) -> list[Bearing]:
    """Return the bearings of a payload that stands somewhere [rad]; none when nobody knows where north is.

    ``mount`` is the heading of the zero of its mount, clockwise from north [rad], where its own angles count from that.
    A source that is not told from its mirror image has two bearings.
    """
    found = []
    for source in payload.sources:
        turned = 0.0 if source.earth else None if mount is None else clockwise(mount)
        if turned is not None:
            found += [
                Bearing(
                    payload.who, source.source, latitude, longitude, azimuth + turned, source.sigma, POSITION_SIGMA,
                    source.weight, source.score, source.target,
                )
                for azimuth in ((source.azimuth,) if source.mirror is None else (source.azimuth, source.mirror))
            ]  # fmt: skip
    return found


def cross(bearings: Sequence[Bearing]) -> list[Fix]:
    """Return every crossing of the bearings of any two payloads, ghosts included.

    >>> north = Bearing(ComponentId(1, 191), 0, 0.0, 0.0, 0.0, 0.02)
    >>> east = Bearing(ComponentId(2, 191), 0, 0.0, 100 / 6378137, 0.7854, 0.02)
    >>> [(round(fix.east, 1), round(fix.north, 1), fix.ghost) for fix in cross([north, east])]
    [(0.0, 100.0, False)]
    """
    if not bearings:
        return []
    plane = Plane(bearings[0].latitude, bearings[0].longitude)
    by_payload: dict[ComponentId, list[Bearing]] = {}
    for bearing in bearings:
        by_payload.setdefault(bearing.who, []).append(bearing)
    strongest = {who: _strongest(bearings) for who, bearings in by_payload.items()}
    return [
        fix
        for one, other in combinations(strongest, 2)
        for fix in _pair(_Scene(plane, strongest[one], strongest[other], _others(strongest, one, other)))
    ]


@dataclass(frozen=True, slots=True)
class _Scene:
    """What two payloads hear, and the others beside them."""

    plane: Plane
    first: list[Bearing]
    second: list[Bearing]
    others: list[list[Bearing]]


def _pair(scene: _Scene) -> list[Fix]:
    """Return the crossings of two payloads, judged together."""
    plane = scene.plane
    found = [
        (a, b, at, _evidence(a, b, at, scene))
        for a in scene.first
        for b in scene.second
        if (at := cross_two(_line(a, plane), _line(b, plane))) is not None
    ]
    rows, columns = (sorted({bearing.source for bearing in bearings}) for bearings in (scene.first, scene.second))
    weights = [[0.0] * len(columns) for _ in rows]
    for a, b, _, evidence in found:
        weights[rows.index(a.source)][columns.index(b.source)] += evidence
    shares = marginals(weights, ALONE)
    fixes = []
    for a, b, at, evidence in found:
        row, column = rows.index(a.source), columns.index(b.source)
        fixes.append(_fix((a, b), at, plane, shares[row][column] * evidence / weights[row][column]))
    return [replace(fix, ghost=_outdone(fix, fixes)) for fix in fixes]


def _outdone(fix: Fix, fixes: list[Fix]) -> bool:
    """Tell whether another crossing of one of its sources is far more probable."""
    shared = (
        other.probability
        for other in fixes
        if any(mine == theirs for mine, theirs in zip(fix.sources, other.sources, strict=True))
    )
    return fix.probability * GHOST < max(shared)


def _evidence(a: Bearing, b: Bearing, at: Crossing, scene: _Scene) -> float:
    """Return the weight of two bearings as those of one source that is where they cross."""
    missed = sum(_missed(at, bearings, scene.plane) for bearings in scene.others)
    one, other = _target(a, scene.first), _target(b, scene.second)
    alike = 1.0 if one is None or other is None else one * other + (1 - one) * (1 - other)
    return math.exp(-(_strength(a, b) + missed) / 2) * alike


def _target(bearing: Bearing, bearings: list[Bearing]) -> float | None:
    """Return the probability that it is the enrolled voice, of which a score is the log-likelihood ratio."""
    if bearing.score is not None:
        return 1 / (1 + math.exp(-min(max(bearing.score, -SURE), SURE)))
    known = any(each.target for each in bearings)
    return None if not known else 1 - OTHER_TARGET if bearing.target else OTHER_TARGET


def _strength(a: Bearing, b: Bearing) -> float:
    if not (a.weight and b.weight and a.weight > 0 and b.weight > 0):
        return 0.0
    return min((math.log(a.weight / b.weight) / STRENGTHS) ** 2, MISSED)


def _missed(at: Crossing, bearings: list[Bearing], plane: Plane) -> float:
    """Return how far a crossing is from all that a third payload hears, in squared sigmas."""
    return min([MISSED, *(misses(_line(bearing, plane), at) for bearing in bearings)])


def _fix(pair: tuple[Bearing, Bearing], at: Crossing, plane: Plane, probability: float) -> Fix:
    latitude, longitude = plane.back(at.east, at.north)
    payloads, sources = tuple(each.who for each in pair), tuple(each.source for each in pair)
    return Fix(latitude, longitude, at.east, at.north, at.covariance, payloads, sources, False, probability)


def _line(bearing: Bearing, plane: Plane) -> BearingLine:
    east, north = plane.place(bearing.latitude, bearing.longitude)
    azimuth = bearing.azimuth + plane.turned(bearing.longitude)
    return BearingLine(east, north, azimuth, bearing.sigma, bearing.position_sigma)


def _strongest(bearings: list[Bearing]) -> list[Bearing]:
    weights = {bearing.source: bearing.weight or 0.0 for bearing in bearings}
    kept = sorted(weights, key=lambda source: -weights[source])[:MOST_SOURCES]
    return [bearing for bearing in bearings if bearing.source in kept]


def _others(strongest: dict[ComponentId, list[Bearing]], one: ComponentId, other: ComponentId) -> list[list[Bearing]]:
    return [bearings for who, bearings in strongest.items() if who not in (one, other)]
