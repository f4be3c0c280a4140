"""Where to turn: the heading at which one source stands apart from all others (paper, Sec. III-B).

A source with azimuth theta and elevation eps, heard at heading phi, has the TDOA
``tau = (d / v_p) cos(eps) cos(theta - phi) = Re(z exp(-j phi))``, with ``z = (d / v_p) cos(eps) exp(j theta)``.
Differences of TDOAs are sinusoids of the heading too, so every extremum and every crossing below has a closed form.
A heading matters modulo pi only: half a turn changes the sign of every TDOA.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ross_payload.events import AlignmentCandidate, SourceEstimate

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]

CLEARLY_BETTER = 2.0  # the curve must promise this many times the bisector's isolation to overrule it
SUFFICIENT = 0.7  # K = 2 stays where the isolation is at least this share of the best
ALIASED = 0.05  # TDOAs closer than this share of d / v_p count as one
USELESS = 0.02  # an isolation below this share of d / v_p isolates nothing
SAME = 1e-9  # isolations that differ by less (relative) are equal: the nearer heading wins


@dataclass(frozen=True, slots=True)
class Plan:
    """Where to turn, and why."""

    candidates: tuple[AlignmentCandidate, ...]  # in order of travel
    headings: Real  # [rad], (n_headings,), over [0, pi)
    isolation: Real  # [s], (n_sources, n_headings)


@dataclass(frozen=True, slots=True)
class _Turn:
    """Where the array is and how far the joint may go [rad]."""

    base: float  # heading at joint angle 0
    joint: float
    lower: float
    upper: float

    def goal(self, heading: float) -> float | None:
        """Joint angle inside the limits that gives the heading modulo pi with the least travel, or None."""
        joint = heading - self.base
        lowest, highest = np.ceil((self.lower - joint) / np.pi - SAME), np.floor((self.upper - joint) / np.pi + SAME)
        if not lowest <= highest:
            return None
        turns = np.clip(np.round((self.joint - joint) / np.pi), lowest, highest)
        return float(np.clip(joint + np.pi * turns, self.lower, self.upper))


def isolation(
    azimuths: ArrayLike,
    headings: ArrayLike,
    spacing: float,
    speed_of_sound: float,
    elevations: ArrayLike | None = None,
) -> Real:
    """Predict the isolation ``min_k |tau_i - tau_k|`` of every source at every heading, Eq. (alignment_ang_K4).

    Parameters
    ----------
    azimuths, elevations : array_like, (n_sources,)
        Where the sources are [rad]; elevations are 0 when not given.
    headings : array_like, (n_headings,)
        Headings of the array [rad].
    spacing, speed_of_sound : float
        d [m] and v_p [m/s].

    Returns
    -------
    numpy.ndarray, (n_sources, n_headings)
        Isolation [s]; a single source has the largest there is, 2 d / v_p.

    Examples
    --------
    Two talkers at +30 and -30 deg are one source to an array that points between them; across, it hears
    2 sin(30 deg) d / v_p = 1 between them with d / v_p = 1 s.

    >>> isolation(np.deg2rad([30, -30]), np.deg2rad([0, 90]), 343.0, 343.0).round(9).tolist()
    [[0.0, 1.0], [0.0, 1.0]]
    """
    return _isolation(_phasors(azimuths, elevations, spacing, speed_of_sound), headings, 2 * spacing / speed_of_sound)


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
    z = _phasors([azimuth_a, azimuth_b], [elevation_a, elevation_b], 1.0, 1.0)
    return tuple(_zeros([z[0] - z[1]]))


def plan(
    sources: Sequence[SourceEstimate],
    *,
    heading: float,
    joint: float,
    lower: float,
    upper: float,
    spacing: float,
    speed_of_sound: float,
    n_headings: int = 180,
) -> Plan:
    """Choose for every source, as the target, the heading that isolates it; in order of travel.

    ===========  =========================================================================================
    rule         when
    ===========  =========================================================================================
    stay         K = 1; K = 2 when the present heading has at least 0.7 of the best isolation
    bisector     K = 3: of the two interferers, which then pose as one
    argmax       of the isolation: K > 3, K = 2 that does not stay, and K = 3 when it promises at least twice
                 the bisector's isolation or the bisector is out of reach
    limited      the limits exclude all of these: the reachable heading with the best isolation
    ===========  =========================================================================================

    A source is left out when no reachable heading isolates it at all.

    Parameters
    ----------
    sources : sequence of SourceEstimate
        What the explorer believes.
    heading, joint : float
        Where the array points and the joint angle there [rad].
    lower, upper : float
        Limits of the joint angle [rad]; infinite when the actuator turns without end.
    spacing, speed_of_sound : float
        d [m] and v_p [m/s].
    n_headings : int
        Resolution of the returned curve; the choice itself is exact.

    Examples
    --------
    >>> talkers = [SourceEstimate(np.deg2rad(a), 0.01, 1.0, True) for a in (0, 100, -120)]
    >>> planned = plan(talkers, heading=0.0, joint=0.0, lower=-3.0, upper=3.0, spacing=0.05, speed_of_sound=343.0)
    >>> [(c.source, c.rule, round(float(np.rad2deg(c.joint)))) for c in planned.candidates]
    [(0, 'bisector', -10), (2, 'bisector', 50), (1, 'bisector', -60)]
    """
    z = _phasors([s.azimuth for s in sources], [s.elevation or 0.0 for s in sources], spacing, speed_of_sound)
    turn = _Turn(heading - joint, joint, lower, upper)
    found = [_candidate(i, z, turn, spacing / speed_of_sound) for i in range(len(z))] if lower <= upper else []
    candidates = sorted((c for c in found if c is not None), key=lambda c: (abs(c.joint - joint), c.source))
    headings = np.pi * np.arange(n_headings) / n_headings
    return Plan(tuple(candidates), headings, _isolation(z, headings, 2 * spacing / speed_of_sound))


def _candidate(source: int, z: Complex, turn: _Turn, unit: float) -> AlignmentCandidate | None:
    """Best admissible heading of one target; ``unit`` is d / v_p [s]."""
    for rule, headings in _preferences(source, z, turn, unit):
        goals = [goal for goal in map(turn.goal, headings) if goal is not None]
        if goals:
            joint = _best(source, z, goals, turn)
            heading = turn.base + joint
            gain = float(_isolation(z, [heading], 2 * unit)[source, 0])
            if gain >= USELESS * unit:
                return AlignmentCandidate(source, heading, joint, gain, rule, _aliased(source, z, heading, unit))
    return None


def _preferences(source: int, z: Complex, turn: _Turn, unit: float) -> Iterable[tuple[str, list[float]]]:
    """Rules and their headings, the one to try first first."""
    here = turn.base + min(max(turn.joint, turn.lower), turn.upper)
    if len(z) == 1:
        return [("stay", [here])]
    extremes = [*_extremes(source, z), here]
    peak = float(_isolation(z, extremes, 2 * unit)[source].max())
    argmax = [h for h in extremes if _isolation(z, [h], 2 * unit)[source, 0] >= peak * (1 - SAME)]
    rules = [("argmax", argmax), ("limited", [*extremes, turn.base + turn.lower, turn.base + turn.upper])]
    if len(z) == 2 and _isolation(z, [here], 2 * unit)[source, 0] >= SUFFICIENT * peak:
        return [("stay", [here])]
    if len(z) == 3:
        first, second = np.delete(z, source)
        bisector = _zeros([complex(first - second)])
        overruled = bool(bisector) and _isolation(z, bisector, 2 * unit)[source, 0] * CLEARLY_BETTER <= peak
        rules.insert(1 if overruled else 0, ("bisector", bisector))
    return rules


def _best(source: int, z: Complex, goals: list[float], turn: _Turn) -> float:
    """Goal with the best isolation; among equals the one with the least travel."""
    gains = _isolation(z, turn.base + np.array(goals), np.inf)[source]
    equals = [goal for goal, gain in zip(goals, gains, strict=True) if gain >= gains.max() * (1 - SAME)]
    return min(equals, key=lambda goal: abs(goal - turn.joint))


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


def _aliased(source: int, z: Complex, heading: float, unit: float) -> tuple[int, ...]:
    """Interferers with the TDOA of another interferer at a heading."""
    tau = (z * np.exp(-1j * heading)).real
    pairs = combinations((k for k in range(len(z)) if k != source), 2)
    return tuple(sorted({k for pair in pairs if abs(tau[pair[0]] - tau[pair[1]]) <= ALIASED * unit for k in pair}))


def _phasors(azimuths: ArrayLike, elevations: ArrayLike | None, spacing: float, speed_of_sound: float) -> Complex:
    cosine = 1.0 if elevations is None else np.cos(np.asarray(elevations, dtype=float))
    return np.asarray(spacing / speed_of_sound * cosine * np.exp(1j * np.asarray(azimuths, dtype=float)))


def _isolation(z: Complex, headings: ArrayLike, alone: float) -> Real:
    tau = (z[:, None] * np.exp(-1j * np.asarray(headings, dtype=float))).real
    apart = np.abs(tau[:, None] - tau[None])
    apart[np.arange(len(z)), np.arange(len(z))] = alone
    return np.asarray(apart.min(axis=1)) if len(z) else tau
