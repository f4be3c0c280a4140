"""From a plan to the exact edges of a step-and-direction interface.

A step counter follows the plan: it goes to n + 1 at the instant at which the plan crosses n + 1/2 steps, found in
closed form. Each step is a pulse; a change of direction waits for its hold and set-up times.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ross_payload.actuators.motion import Trapezoid
from ross_payload.actuators.tb6600.pulse_segments import EDGE, Edges, PulseLine
from ross_payload.interfaces import Real

Signs = NDArray[np.signedinteger[Any]]


@dataclass(frozen=True, slots=True)
class PulseTiming:
    """What the driver keeps between edges [s], and how it is wired."""

    width: float  # of a STEP pulse
    setup: float  # from a DIRECTION edge to the next STEP
    hold: float  # from the end of a STEP to a DIRECTION edge
    period: float  # from STEP to STEP at least
    up: bool = True  # level of DIRECTION that counts up

    @property
    def reversal(self) -> float:
        """From a STEP to one in the other direction at least [s]."""
        return max(self.period, self.width + self.hold + self.setup)


@dataclass(frozen=True, slots=True)
class LineState:
    """What the edges handed over so far leave behind."""

    count: int = 0  # of the step counter
    direction: int = 0  # +1, -1, or 0 before the first DIRECTION edge
    last_step: float = -math.inf  # rising edge [s]
    last_turn: float = -math.inf  # DIRECTION edge [s]


@dataclass(frozen=True, slots=True, eq=False)
class EdgeTrain:
    """Edges and steps of a plan that nobody has handed over yet; times on the Clock [s]."""

    edges: Edges  # (n_edges,)
    steps: Real  # rising edges, (n_steps,)
    signs: Signs  # +1 or -1 per step, (n_steps,)
    end: float  # of the plan or of its last edge, whichever is later


def step_times(plan: Trapezoid, resolution: float, count: int) -> tuple[Real, Signs]:
    """Times [s] since the start of the plan and signs of all its steps, both (n_steps,).

    Half a second per radian, one radian per step: the counter moves half-way between.

    >>> times, signs = step_times(Trapezoid(0.0, 2.0, speed=2.0, acceleration=1e9), 1.0, 0)
    >>> times.round(6).tolist(), signs.tolist()
    ([0.25, 0.75], [1, 1])
    """
    times: list[Real] = [np.empty(0)]
    signs: list[Signs] = [np.empty(0, dtype=np.int64)]
    for phase in plan.phases:
        start, end = phase.position, phase.at(phase.begin + phase.duration)[0]
        sign = 1 if end >= start else -1
        target = sign * math.floor(sign * end / resolution + 0.5)
        n = max(sign * (target - count), 0)
        levels = (count + sign * (np.arange(n) + 0.5)) * resolution
        times.append(phase.crossings(np.clip(levels, min(start, end), max(start, end))))
        signs.append(np.full(n, sign))
        count += sign * n
    return np.concatenate(times), np.concatenate(signs)


def train(plan: Trapezoid, begin: float, lines: LineState, timing: PulseTiming, resolution: float) -> EdgeTrain:
    """Lay out the edges of a plan that begins at ``begin`` [s], after what ``lines`` left behind.

    A pulse that is high at ``begin`` is ended as it should be.
    """
    times, signs = step_times(plan, resolution, lines.count)
    before = np.concatenate([[lines.direction], signs[:-1]]) if len(signs) else signs
    turns = signs != before
    times = _spaced(begin + times, turns, begin, lines, timing)
    fall = lines.last_step + timing.width
    falls = np.concatenate([[fall] if fall > begin else [], times + timing.width])
    edges = np.concatenate(
        [
            _edges(falls, PulseLine.STEP, np.zeros(len(falls), dtype=bool)),
            _edges(times[turns] - timing.setup, PulseLine.DIRECTION, (signs[turns] > 0) == timing.up),
            _edges(times, PulseLine.STEP, np.ones(len(times), dtype=bool)),
        ]
    )
    edges = edges[np.argsort(edges["time"], kind="stable")]
    last = float(edges["time"][-1]) if len(edges) else begin
    return EdgeTrain(edges, times, signs, max(begin + plan.duration, last))


def after(lines: LineState, edges: Edges, steps: Real, signs: Signs, timing: PulseTiming) -> LineState:
    """What the wires are left with when ``edges`` [s on the Clock] with these steps have been handed over."""
    turns = edges[edges["line"] == PulseLine.DIRECTION]
    return LineState(
        count=lines.count + int(signs.sum()),
        direction=(1 if turns["level"][-1] == timing.up else -1) if len(turns) else lines.direction,
        last_step=float(steps[-1]) if len(steps) else lines.last_step,
        last_turn=float(turns["time"][-1]) if len(turns) else lines.last_turn,
    )


def _spaced(times: Real, turns: NDArray[np.bool_], begin: float, lines: LineState, timing: PulseTiming) -> Real:
    """Delay steps as little as the gaps ask for: t_i = max(t_i, t_(i-1) + gap_i), as one running maximum."""
    if not len(times):
        return times
    gaps = np.where(turns, timing.reversal, timing.period)
    earliest = max(lines.last_step + gaps[0], lines.last_turn + timing.setup, begin + timing.setup * turns[0])
    total = np.cumsum(gaps) - gaps[0]
    times = np.concatenate([[max(times[0], earliest)], times[1:]])
    return np.asarray(np.maximum.accumulate(times - total) + total)


def _edges(times: Real, line: PulseLine, levels: NDArray[np.bool_]) -> Edges:
    edges = np.empty(len(times), dtype=EDGE)
    edges["time"], edges["line"], edges["level"] = times, line, levels
    return edges
