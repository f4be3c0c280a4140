"""The far end of the pulse wire: a TB6600 module with its microstep counter, and the motor behind it."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ross_payload.actuators.pulses import EDGE, Edges, Line, RecordingPulses
from ross_payload.actuators.tb6600 import Options
from ross_payload.interfaces import Real
from ross_sim.far_end import Fault, checked
from ross_sim.opto import OptoInputs, Violation, Wanted
from ross_sim.stepper import Motor, Rotor


class Tb6600FarEnd:
    """Plays segments at their time and lets the motor follow as well as it can.

    Parameters
    ----------
    options : Options
        How the module is set and wired: microsteps, gear, polarities.
    motor : Motor
        The motor and its load.
    wanted : Wanted
        The module's timing.
    """

    faults: frozenset[Fault] = frozenset()

    def __init__(self, options: Options, motor: Motor, wanted: Wanted) -> None:
        self.port = RecordingPulses()
        self.rotor = Rotor(motor)
        self._options = options
        self._inputs = OptoInputs(wanted)
        self._seen = 0  # segments of the port
        self._edges: Edges = np.empty(0, dtype=EDGE)  # not yet played, times on the Clock [s]
        self._count = 0
        self._on = self._means_on(False)
        self._now = 0.0
        self._periods = 0  # between rotor and windings when the torque came on
        self._lost_since: float | None = None

    def advance(self, now: float) -> None:
        """Play the edges that are due and let the motor live until ``now`` [s]."""
        self._collect()
        if not len(self._edges) and self.rotor.still:
            self._now = now
            self.port.play(now)
            return
        due, self._edges = _split(self._edges, now)
        for switch in due[due["line"] == Line.ENABLE]:
            time = float(switch["time"])
            before, due = _split(due, time)
            self._play(before, time)
            self._switch(bool(switch["level"]), time)
        self._play(due, now)
        self.port.play(now)

    def angle(self) -> float:
        """Return the true joint angle [rad]."""
        sign = -1 if self._options.invert_direction else 1
        return sign * self.rotor.angle / self._options.gear_ratio

    @property
    def count(self) -> int:
        """The microstep counter of the module."""
        return self._count

    @property
    def full_steps_lost(self) -> int:
        """Full steps by which the shaft is off its counter since the torque came on; negative: behind."""
        return 4 * (self.rotor.periods_lost - self._periods) if self._on else 0

    @property
    def violations(self) -> tuple[Violation, ...]:
        """Every edge that broke a rule of the module."""
        return tuple(self._inputs.violations)

    def afflict(self, fault: Fault, on: bool = True) -> None:
        """Refuse: nobody sees what happens behind an open loop."""
        checked(fault, self.faults)

    def complaints(self) -> list[str]:
        """Return one line per rule broken, with the first case, and one about steps lost."""
        counts = Counter(violation.rule for violation in self.violations)
        first = {violation.rule: violation for violation in reversed(self.violations)}
        lines = [f"{first[rule]} ({n} times)" for rule, n in counts.items()]
        if self._lost_since is not None:
            off = f"the shaft is {self.full_steps_lost:+d} full steps off its counter"
            lines.append(f"steps lost since {self._lost_since:.2f} s: {off}")
        return lines

    def _collect(self) -> None:
        """Take in the segments sent since the last advance; edges whose time has passed are played at once."""
        new = self.port.n_sent - self._seen
        for segment in self.port.sent[-new:] if new else ():
            edges = segment.edges.copy()
            edges["time"] += segment.start
            if len(edges) and edges["time"][0] < self._now - 1e-9:
                self._inputs.late(self._now - float(edges["time"][0]), float(edges["time"][0]))
                edges["time"] = np.maximum(edges["time"], self._now)
            self._edges = np.concatenate([self._edges, edges])
        self._seen = self.port.n_sent

    def _play(self, edges: Edges, until: float) -> None:
        """Count steps and let the rotor follow; no ENABLE edge within."""
        times, levels = self._inputs.take(edges, self._on) if len(edges) else (np.empty(0), np.empty(0, dtype=bool))
        self.rotor.live(until - self._now, times - self._now, self._electrical(levels), self._on)
        self._count += int(np.where(levels, 1, -1).sum())
        self._now = until
        if self._lost_since is None and self.full_steps_lost:
            self._lost_since = until

    def _electrical(self, levels: NDArray[np.bool_]) -> Real:
        """Electrical angles [rad] before the first step and after each, (n_steps + 1,)."""
        counts = self._count + np.concatenate([[0], np.cumsum(np.where(levels, 1, -1))])
        return np.asarray(counts * (2 * math.pi / (self._options.full_steps * self._options.microsteps)))

    def _switch(self, level: bool, time: float) -> None:
        was_on, self._on = self._on, self._means_on(level)
        self._inputs.switch(level, time)
        if self._on and not was_on:
            self._periods = self.rotor.periods_at(float(self._electrical(np.empty(0, dtype=bool))[0]))

    def _means_on(self, level: bool) -> bool:
        return level != self._options.enable_means_off


def _split(edges: Edges, time: float) -> tuple[Edges, Edges]:
    """Edges up to and including ``time`` [s], and the rest."""
    n = int(np.searchsorted(edges["time"], time, side="right"))
    return edges[:n], edges[n:]


class Tb6600FarEndPlugin:
    """The module and motor behind ``tb6600``."""

    def make(self, config: Options, motor: Motor | None = None, wanted: Wanted | None = None) -> Tb6600FarEnd:
        """Make a module wired as the driver's options say, at joint angle 0; a motor of its own may be heavier."""
        motor = motor or replace(Motor(), teeth=config.full_steps // 4)
        return Tb6600FarEnd(config, motor, wanted or Wanted())


far_end = Tb6600FarEndPlugin()
