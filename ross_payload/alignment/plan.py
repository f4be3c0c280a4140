"""Where to turn: the heading at which one source separates best from all others (paper, Sec. III-B).

A source with azimuth theta and elevation eps, heard at heading phi, has the TDOA
``tau = (d / v_p) cos(eps) cos(theta - phi)``. A heading matters modulo pi only: half a turn changes the sign of every
TDOA. `plan` takes the heading with the best predicted gain (`gain`); `paper_rules` keeps the paper's equations.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from ross_payload.alignment.predicted_gain import FINE, distances, gain_of, phasors
from ross_payload.dsp.steering import ALIAS
from ross_payload.events import AlignmentCandidate, SourceEstimate
from ross_payload.interfaces import Complex, Real
from ross_payload.pointing import nearest_joints

ENOUGH = 0.25  # [dB] a turn must promise more than this, and limits that cost more are said to limit
ALIASED = 0.05  # TDOAs closer than this share of d / v_p count as one
POSING = 100.0  # [dB] less for a heading at which the target poses with another source
USELESS = 0.02  # an isolation below this share of d / v_p isolates nothing
HEADINGS: Real = np.pi * np.arange(180) / 180  # of the curves of a plan [rad]
SAME = 1e-9  # of angles [rad] and gains [dB]: the nearer heading wins among equals


@dataclass(frozen=True, slots=True)
class Plan:
    """Where to turn, and why."""

    candidates: tuple[AlignmentCandidate, ...]  # in order of travel
    headings: Real  # [rad], (n_headings,), over [0, pi)
    isolation: Real  # [s], (n_sources, n_headings)
    gain_db: Real  # predicted SI-SDRi [dB], (n_sources, n_headings)


@dataclass(frozen=True, slots=True)
class Turn:
    """Where the array is and how far the joint may go [rad]."""

    base: float  # heading at joint angle 0
    joint: float
    lower: float  # -inf when the actuator turns without end
    upper: float  # inf likewise

    @property
    def here(self) -> float:
        """Joint angle inside the limits that is nearest to the present one."""
        return min(max(self.joint, self.lower), self.upper)

    def goals(self, headings: ArrayLike) -> Real:
        """Joint angles that give the headings modulo pi with the least travel; without those out of reach."""
        return nearest_joints(np.asarray(headings) - self.base, self.joint, self.lower, self.upper, np.pi)


@dataclass(frozen=True, slots=True, eq=False)
class Geometry:
    """Where the sources are, and what that means at a heading."""

    sources: Complex  # phasors, (n_sources,)
    unit: float  # d / v_p [s]
    directness: float | None
    beside: Complex | None = None  # phasors of what sounds and is no talker, (n,)
    share: float = 0.0  # its power over that of the interferers

    def isolation(self, headings: ArrayLike) -> Real:
        """Isolation of every source [s], (n_sources, n_headings); 2 d / v_p for a single one."""
        apart = distances(self.sources, headings)
        every = np.arange(len(self.sources))
        apart[every, every] = 2.0
        return np.asarray(self.unit * apart.min(axis=1, initial=2.0))

    def gain_db(self, headings: ArrayLike) -> Real:
        """Predicted SI-SDRi of every source [dB], (n_sources, n_headings)."""
        return gain_of(self.sources, headings, self.directness, self.beside, self.share)

    def candidate(self, source: int, rule: str, turn: Turn, joint: float) -> AlignmentCandidate:
        """One source at one joint angle [rad]."""
        heading = turn.base + joint
        isolation, gain = self.isolation([heading])[source, 0], self.gain_db([heading])[source, 0]
        return AlignmentCandidate(
            source, heading, joint, float(isolation), rule, self._aliased(source, heading), float(gain)
        )

    def _aliased(self, source: int, heading: float) -> tuple[int, ...]:
        """Interferers with the TDOA of another interferer."""
        apart = distances(self.sources, [heading])[..., 0]
        pairs = combinations((k for k in range(len(apart)) if k != source), 2)
        return tuple(sorted({k for pair in pairs if apart[pair] <= ALIASED for k in pair}))


def isolation(
    azimuths: ArrayLike, headings: ArrayLike, spacing: float, speed_of_sound: float, elevations: ArrayLike | None = None
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
    return Geometry(phasors(azimuths, elevations), spacing / speed_of_sound, None).isolation(headings)


def plan(
    sources: Sequence[SourceEstimate],
    turn: Turn,
    unit: float,
    directness: float | None = None,
    *,
    beside: Complex | None = None,
    share: float = 0.0,
) -> Plan:
    """Choose for every source, as the target, the heading with the best predicted gain; in order of travel.

    ===========  =======================================================================
    rule         when
    ===========  =======================================================================
    stay         no reachable heading promises 0.25 dB more than the present one
    gain         the best of all headings is in reach, or one within 0.25 dB of it
    limited      the limits cost more than that: the best reachable heading
    ===========  =======================================================================

    Headings are tried every half degree, at the present joint angle and at the limits. One at which the target poses
    with another source counts only when there is no other; a source is left out when no reachable heading isolates it
    at all.

    Parameters
    ----------
    sources : sequence of SourceEstimate
        What the explorer believes.
    turn : Turn
        Where the array is, and the limits of its joint.
    unit : float
        d / v_p [s].
    directness : float or None
        1 in the open, less in reverberation, which is assumed when it is not known.
    beside, share
        Phasors (n,) of what sounds and is no talker, as rotors are, and its power over that of a target's interferers.

    Examples
    --------
    >>> talkers = [SourceEstimate(np.deg2rad(a), 0.01, 1.0, True) for a in (0, 100, -120)]
    >>> planned = plan(talkers, Turn(base=0.0, joint=0.0, lower=-3.0, upper=3.0), unit=0.05 / 343)
    >>> [(c.source, c.rule, round(float(np.rad2deg(c.joint)))) for c in planned.candidates]
    [(0, 'stay', 0), (2, 'gain', 53), (1, 'gain', -65)]
    """
    scene = replace(geometry_of(sources, unit, directness), beside=beside, share=share)
    chosen = _best(scene, turn) if sources and turn.lower <= turn.upper else []
    found = [scene.candidate(i, rule, turn, goal) for i, (rule, goal) in enumerate(chosen)]
    useful = in_order((c for c in found if c.isolation >= USELESS * unit), turn)
    return Plan(useful, HEADINGS, scene.isolation(HEADINGS), scene.gain_db(HEADINGS))


def geometry_of(sources: Sequence[SourceEstimate], unit: float, directness: float | None) -> Geometry:
    """What an explorer believes, as a geometry; ``unit`` is d / v_p [s]."""
    z = phasors([source.azimuth for source in sources], [source.elevation or 0.0 for source in sources])
    return Geometry(z, unit, directness)


def in_order(found: Iterable[AlignmentCandidate], turn: Turn) -> tuple[AlignmentCandidate, ...]:
    """Candidates in order of travel."""
    return tuple(sorted(found, key=lambda c: (abs(c.joint - turn.joint), c.source)))


def _best(scene: Geometry, turn: Turn) -> list[tuple[str, float]]:
    """Rule and joint angle [rad] of every source."""
    grid = np.arange(0, np.pi - FINE / 2, FINE)
    ends = [end for end in (turn.lower, turn.upper) if np.isfinite(end)]
    joints = np.array([turn.here, *turn.goals(grid), *ends])
    chosen = []
    for worth, best in zip(_worth(scene, turn.base + joints), _worth(scene, grid).max(axis=1), strict=True):
        if worth[0] >= worth.max() - ENOUGH:
            chosen.append(("stay", turn.here))
        else:
            equals = joints[worth >= worth.max() - SAME]
            rule = "gain" if worth.max() >= best - ENOUGH else "limited"
            chosen.append((rule, float(equals[np.abs(equals - turn.joint).argmin()])))
    return chosen


def _worth(scene: Geometry, headings: Real) -> Real:
    """Predicted gain [dB], much less where a source poses with another one, (n_sources, n_headings)."""
    return scene.gain_db(headings) - POSING * (scene.isolation(headings) < ALIAS * scene.unit)
