"""Where sources were estimated lately: an index may change from one estimate to the next, where a source is hardly."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ross_payload.ground.picture.known import Trail
from ross_protocols.pairs import wrap
from ross_protocols.values import Source

MOST_POINTS = 60  # of a trail
MOST_TRAILS = 64
PATIENCE = 12.0  # [s] that a trail stays without going on: a source is told again every 5 s
STRIDE = math.radians(20)  # that a source moves at most from one estimate to the next


def followed(trails: Sequence[Trail], source: Source, at: float) -> tuple[Trail, ...]:
    """Return the trails after a source of an estimate came ``at`` a time [s].

    It goes on with the nearest trail that nobody else of this estimate goes on with. One that nobody goes on with stays
    a while, for a source that is still on its way.
    """
    others = [trail for trail in trails if at - trail.at < PATIENCE]
    mine = [trail for trail in others if trail.estimate == source.estimate and trail.source == source.source]
    free = [trail for trail in others if trail.estimate != source.estimate and _apart(trail, source) < STRIDE]
    before = mine[0] if mine else min(free, key=lambda trail: _apart(trail, source), default=None)
    points = () if before is None else before.points
    if not points or points[-1][1] != source.azimuth:
        points = (*points, (at, source.azimuth))[-MOST_POINTS:]
    fresh = Trail(source.source, points, source.estimate, source.earth, at)
    kept = [trail for trail in others if trail is not before]
    return tuple(sorted([*kept, fresh], key=lambda trail: -trail.at)[:MOST_TRAILS])


def _apart(trail: Trail, source: Source) -> float:
    """Return how far a source is from the end of a trail [rad]; infinite: they count from different zeros."""
    return abs(wrap(trail.points[-1][1] - source.azimuth)) if trail.earth == source.earth else math.inf
