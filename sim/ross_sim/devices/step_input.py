"""The opto inputs of a TB6600 module: turn edges into microsteps and check their timing.

Wanted times are those of the slowest common modules (PUL 2.5 us high and low, DIR 5 us before and after PUL,
ENA 5 us before DIR); a driver should stay well clear of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ross_payload.actuators.tb6600.pulse_segments import Edges, PulseLine
from ross_payload.interfaces import Real

ROUNDING = 1e-9  # of a time on the Clock, counted in the driver's favour [s]


@dataclass(frozen=True, slots=True)
class Wanted:
    """Least times of the module [s]."""

    high: float = 2.5e-6  # STEP high
    low: float = 2.5e-6  # STEP low
    setup: float = 5e-6  # DIRECTION to STEP
    hold: float = 5e-6  # STEP to DIRECTION
    lead: float = 5e-6  # ENABLE to DIRECTION or STEP


@dataclass(frozen=True, slots=True)
class Violation:
    """A rule that an edge broke."""

    rule: str
    found: float  # [s]
    wanted: float  # [s]
    time: float  # of the edge [s]

    def __str__(self) -> str:
        """Say it in one line."""
        return f"{self.rule}: expected {self.wanted * 1e6:.2f} us, got {self.found * 1e6:.2f} us, at {self.time:.6f} s"


class OptoInputs:
    """Levels and last edges of the three inputs."""

    def __init__(self, wanted: Wanted) -> None:
        self._wanted = wanted
        self._levels = dict.fromkeys(PulseLine, False)
        self._rise = self._step = self._turn = self._switch = -math.inf  # last STEP rise, any STEP edge, ... [s]
        self.violations: list[Violation] = []

    @property
    def enable(self) -> bool:
        """Level of ENABLE."""
        return self._levels[PulseLine.ENABLE]

    def on_edges(self, edges: Edges, on: bool) -> tuple[Real, NDArray[np.bool_]]:
        """Take in edges [s on the Clock] between two ENABLE edges; ``on`` tells whether the module is on meanwhile.

        Returns
        -------
        tuple
            Rising edges that count [s] and the level of DIRECTION at each, both (n_steps,).
        """
        turns, _ = self._changes(edges, PulseLine.DIRECTION)
        direction = self._levels[PulseLine.DIRECTION]
        pulses, levels = self._changes(edges, PulseLine.STEP)
        rises = pulses[levels]
        widths = np.diff(np.concatenate([[self._step], pulses]))
        self._check("STEP high", widths[~levels], self._wanted.high, pulses[~levels])
        self._check("STEP low", widths[levels], self._wanted.low, pulses[levels])
        before = np.concatenate([[self._turn], turns])[np.searchsorted(turns, rises, side="right")]
        self._check("DIRECTION set-up", rises - before, self._wanted.setup, rises)
        stepped = np.concatenate([[self._rise], rises])[np.searchsorted(rises, turns, side="left")]
        self._check("DIRECTION hold", turns - stepped, self._wanted.hold, turns)
        first = np.concatenate([rises[:1], turns[:1]])
        self._check("ENABLE lead", first - self._switch, self._wanted.lead, first)
        flips = np.searchsorted(turns, rises, side="right") % 2 == 1
        self._remember(pulses, levels, turns)
        if not on:
            self._check("STEP while off", np.zeros(len(rises)), self._wanted.lead, rises)
            return np.empty(0), np.empty(0, dtype=bool)
        return rises, flips ^ direction

    def switch(self, level: bool, time: float) -> None:
        """Take in an ENABLE edge [s]."""
        if level != self.enable:
            self._levels[PulseLine.ENABLE], self._switch = level, time

    def late(self, by: float, time: float) -> None:
        """Note edges that were handed over after their time [s]."""
        self.violations.append(Violation("handed over late", by, 0.0, time))

    def _changes(self, edges: Edges, line: PulseLine) -> tuple[Real, NDArray[np.bool_]]:
        mine = edges[edges["line"] == line]
        before = np.concatenate([[self._levels[line]], mine["level"][:-1]]) if len(mine) else mine["level"]
        mine = mine[mine["level"] != before]
        return mine["time"], mine["level"]

    def _check(self, rule: str, found: Real, wanted: float, times: NDArray[Any]) -> None:
        for index in np.flatnonzero(found < wanted - ROUNDING):
            self.violations.append(Violation(rule, float(found[index]), wanted, float(times[index])))

    def _remember(self, pulses: Real, levels: NDArray[np.bool_], turns: Real) -> None:
        if len(pulses):
            self._step, self._levels[PulseLine.STEP] = float(pulses[-1]), bool(levels[-1])
        if levels.any():
            self._rise = float(pulses[levels][-1])
        if len(turns):
            self._turn = float(turns[-1])
            self._levels[PulseLine.DIRECTION] ^= len(turns) % 2 == 1
