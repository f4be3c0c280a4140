"""The paper's own rules for where to turn (Sec. III-B), to the letter.

Differences of TDOAs are sinusoids of the heading, so every extremum and every crossing has a closed form, and the
argmax of the isolation is exact.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations

import numpy as np

from ross_payload.alignment.plan import HEADINGS, SAME, Geometry, Plan, Turn, geometry_of, in_order
from ross_payload.alignment.predicted_gain import phasors
from ross_payload.events import SourceEstimate
from ross_payload.interfaces import Complex


def paper_plan(sources: Sequence[SourceEstimate], turn: Turn, unit: float, directness: float | None = None) -> Plan:
    """Choose for every source, as the target, the heading that the paper's equations give; in order of travel.

    ===========  ==================================================================================
    rule         when
    ===========  ==================================================================================
    stay         K <= 2: no rotation is needed
    bisector     K = 3: of the two interferers, which then pose as one, Eq. (alignment_ang_K3)
    argmax       K > 3: of the isolation min_k |tau_i - tau_k|, Eq. (alignment_ang_K4)
    limited      the limits exclude it: the reachable heading with the best isolation
    ===========  ==================================================================================

    In the paper the last candidate follows by exclusion after K - 1 rejected ones; the mission checks all. Parameters
    are those of `alignment.plan`; ``directness`` changes the predicted gains only.

    Examples
    --------
    >>> talkers = [SourceEstimate(np.deg2rad(a), 0.01, 1.0, True) for a in (0, 100, 40)]
    >>> planned = paper_plan(talkers, Turn(base=0.0, joint=0.0, lower=-3.0, upper=3.0), unit=0.05 / 343)
    >>> [(c.source, c.rule, round(float(np.rad2deg(c.joint)))) for c in planned.candidates]
    [(1, 'bisector', 20), (2, 'bisector', 50), (0, 'bisector', 70)]
    """
    scene = geometry_of(sources, unit, directness)
    found = []
    for source in range(len(sources)) if turn.lower <= turn.upper else ():
        rule, goal = _goal(source, scene, turn)
        found.append(scene.candidate(source, rule, turn, goal))
    return Plan(in_order(found, turn), HEADINGS, scene.isolation(HEADINGS), scene.gain_db(HEADINGS))


def aliasing_headings(
    azimuth_a: float, azimuth_b: float, elevation_a: float = 0.0, elevation_b: float = 0.0
) -> tuple[float, ...]:
    """Headings [rad], modulo pi and in [0, pi), at which two sources have one TDOA: ``tau_A = tau_B``.

    One heading; none is singled out, and the tuple is empty, when the two sources have one TDOA at every heading. With
    equal elevations it is the bisector, Eq. (alignment_ang_K3).

    >>> np.rad2deg(aliasing_headings(np.deg2rad(10), np.deg2rad(70))).round(6).tolist()
    [40.0]
    >>> np.rad2deg(aliasing_headings(0.0, np.pi / 2, elevation_b=np.pi / 3)).round(3).tolist()  # cos phi = sin(phi) / 2
    [63.435]
    """
    z = phasors([azimuth_a, azimuth_b], [elevation_a, elevation_b])
    return tuple(_zeros([z[0] - z[1]]))


def _goal(source: int, scene: Geometry, turn: Turn) -> tuple[str, float]:
    """Rule and joint angle [rad] of one source."""
    z = scene.sources
    if len(z) < 3:
        return "stay", turn.here
    others = np.delete(z, source)
    bisector = _zeros([complex(others[0] - others[1])]) if len(z) == 3 else []
    rule, wanted = ("bisector", bisector) if bisector else ("argmax", _argmax(source, scene))
    goals = turn.goals(wanted)
    if not goals.size:
        ends = [end for end in (turn.lower, turn.upper) if np.isfinite(end)]
        reachable = np.array([turn.here, *turn.goals(_extremes(source, z)), *ends])
        isolation = scene.isolation(turn.base + reachable)[source]
        rule, goals = "limited", reachable[isolation >= isolation.max() * (1 - SAME)]
    return rule, float(goals[np.abs(goals - turn.joint).argmin()])


def _argmax(source: int, scene: Geometry) -> list[float]:
    """Headings [rad] with the best isolation of a source."""
    headings = np.array(_extremes(source, scene.sources) or [0.0])
    isolation = scene.isolation(headings)[source]
    return [float(heading) for heading in headings[isolation >= isolation.max() * (1 - SAME)]]


def _extremes(source: int, z: Complex) -> list[float]:
    """Headings [rad] where the isolation of a source can have a maximum.

    ``|tau_i - tau_k|`` peaks where its derivative is 0; two of them cross where ``tau_k = tau_l`` or
    ``tau_i - tau_k = tau_l - tau_i``.
    """
    apart = z[source] - np.delete(z, source)
    crossings = [sign for a, b in combinations(apart, 2) for sign in (a - b, a + b)]
    return _zeros([*(1j * apart), *crossings])


def _zeros(phasors: Iterable[complex]) -> list[float]:
    """Headings in [0, pi) where ``Re(z exp(-j phi)) = 0``, one for every phasor that is not 0."""
    return [float((np.angle(z) + np.pi / 2) % np.pi) % np.pi for z in phasors if abs(z) > 0]
