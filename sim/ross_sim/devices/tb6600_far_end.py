"""The far end of the pulse wire: a TB6600 module with its microstep counter, the motor behind it, and a home switch."""

from __future__ import annotations

import math
from collections import Counter, deque
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ross_payload.actuators.tb6600 import pulse_segments
from ross_payload.actuators.tb6600.options import Options
from ross_payload.interfaces import Real
from ross_sim.devices.far_end import SLIP, Fault, checked
from ross_sim.devices.step_input import OptoInputs, Violation, Wanted
from ross_sim.devices.stepper import Motor, Rotor

CROWDED = 0.080  # by which a wire that others fill is late [s]


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
    home : HomeSwitch, optional
        At the array.
    """

    faults = frozenset({Fault.STALL, Fault.STUCK, Fault.SLIP, Fault.SILENT, Fault.SATURATED})

    def __init__(self, options: Options, motor: Motor, wanted: Wanted, home: HomeSwitch | None = None) -> None:
        self.port = pulse_segments.RecordingPulses()
        self.rotor = Rotor(motor)
        self._options = options
        self._inputs = OptoInputs(wanted)
        self._seen = 0  # segments of the port
        self._underway: deque[tuple[float, pulse_segments.Segment]] = deque()  # arrival [s], segment
        self._edges: pulse_segments.Edges = np.empty(0, pulse_segments.EDGE)  # not yet played, times on the Clock [s]
        self._count = 0
        self._on = self._means_on(False)
        self._now = 0.0
        self._periods = 0  # between rotor and windings when the torque came on
        self._lost_since: float | None = None
        self._home = home
        self._suffers: set[Fault] = set()
        self._slipped = 0.0  # [rad]

    def advance(self, now: float) -> None:
        """Play the edges that are due and let the motor live until ``now`` [s]."""
        self._collect(now)
        if len(self._edges) or not self.rotor.still:
            self._live(now)
        self._now = now
        self.port.play(now)
        if self._home is not None and not self.port.mute:
            self.port.report(self._home.look(self.angle(), now))

    def angle(self) -> float:
        """Return the true joint angle [rad]."""
        sign = -1 if self._options.invert_direction else 1
        return sign * self.rotor.angle / self._options.gear_ratio + self._slipped

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
        """Suffer where no wire tells of it, fall silent, or get segments late."""
        if checked(fault, self.faults) is Fault.SLIP:
            self._slipped += SLIP if on else 0.0
            return
        (self._suffers.add if on else self._suffers.discard)(fault)
        self.port.mute = Fault.SILENT in self._suffers
        self.rotor.suffer(blocked=Fault.STUCK in self._suffers, current=Fault.STALL not in self._suffers)

    def complaints(self) -> list[str]:
        """Return one line per rule broken, with the first case, and one about steps lost."""
        counts = Counter(violation.rule for violation in self.violations)
        first = {violation.rule: violation for violation in reversed(self.violations)}
        lines = [f"{first[rule]} ({n} times)" for rule, n in counts.items()]
        if self._lost_since is not None:
            off = f"the shaft is {self.full_steps_lost:+d} full steps off its counter"
            lines.append(f"steps lost since {self._lost_since:.2f} s: {off}")
        return lines

    def _collect(self, now: float) -> None:
        """Take in the segments that have come over the wire by ``now`` [s]."""
        delay = CROWDED if Fault.SATURATED in self._suffers else 0.0
        new = self.port.n_sent - self._seen
        self._underway.extend((self._now + delay, segment) for segment in (self.port.sent[-new:] if new else ()))
        self._seen = self.port.n_sent
        while self._underway and self._underway[0][0] <= now:
            self._arrived(*self._underway.popleft())

    def _arrived(self, arrival: float, segment: pulse_segments.Segment) -> None:
        """Line up the edges; steps that come after their time are not taken, and that is reported."""
        late = arrival - segment.start - float(segment.edges["time"][0]) if len(segment.edges) else 0.0
        if late > 1e-9 and pulse_segments.takes_steps(segment):
            self._inputs.late(late, arrival)
            self.port.report(pulse_segments.RanOut(segment.end))
            segment = pulse_segments.without_steps(segment)
        edges = segment.edges.copy()
        edges["time"] = np.maximum(edges["time"] + segment.start, arrival if late > 1e-9 else -math.inf)
        self._edges = np.concatenate([self._edges, edges])

    def _live(self, now: float) -> None:
        """Play the edges that are due by ``now`` [s], and let the rotor follow."""
        due, self._edges = _split(self._edges, now)
        for switch in due[due["line"] == pulse_segments.PulseLine.ENABLE]:
            time = float(switch["time"])
            before, due = _split(due, time)
            self._play(before, time)
            self._switch(bool(switch["level"]), time)
        self._play(due, now)

    def _play(self, edges: pulse_segments.Edges, until: float) -> None:
        """Count steps and let the rotor follow; no ENABLE edge within."""
        times, levels = self._inputs.on_edges(edges, self._on) if len(edges) else (np.empty(0), np.empty(0, dtype=bool))
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

    @classmethod
    def make(
        cls, config: Options, motor: Motor | None = None, wanted: Wanted | None = None, home: HomeSwitch | None = None
    ) -> Tb6600FarEnd:
        """Make a module wired as the driver's options say, at joint angle 0; a motor of its own may be heavier."""
        motor = motor or replace(Motor(), teeth=config.full_steps // 4)
        if config.zero == "switch":
            home = home or switch_of(config)
        return cls(config, motor, wanted or Wanted(), home)


def _split(edges: pulse_segments.Edges, time: float) -> tuple[pulse_segments.Edges, pulse_segments.Edges]:
    """Edges up to and including ``time`` [s], and the rest."""
    n = int(np.searchsorted(edges["time"], time, side="right"))
    return edges[:n], edges[n:]


def switch_of(config: Options) -> HomeSwitch:
    """Make a switch that closes at the step nearest to the angle that the options name, or a little before it."""
    sign = config.search.sign
    closes = (round(math.radians(config.home_offset_deg) / config.resolution) - 0.3 * sign) * config.resolution
    return HomeSwitch(closes, sign, high=config.home_level == "high")


class HomeSwitch:
    """Closed while the array is within the cam, with hysteresis; chatters when it changes.

    Parameters
    ----------
    closes : float
        Joint angle at which it closes, turning towards it [rad].
    sign : int
        Of the direction in which it is approached: +1 counter-clockwise.
    high : bool
        Level of the line while it is closed.
    bounce : float
        How long it chatters [s].
    width : float
        Of the cam [rad]: half a disc and a little tells on which side the array stands.
    """

    HYSTERESIS = math.radians(0.3)

    def __init__(
        self, closes: float, sign: int, *, high: bool = False, bounce: float = 0.0, width: float = math.radians(190)
    ) -> None:
        self._closes, self._sign, self._high, self._bounce, self._width = closes, sign, high, bounce, width
        self._closed = False
        self._changed = -math.inf
        self._shown = False

    def look(self, angle: float, now: float) -> pulse_segments.Level:
        """Return the level of its line with the array at ``angle`` [rad]; a chatter alternates from look to look."""
        within = self._sign * (angle - self._closes)
        slack = self.HYSTERESIS if self._closed else 0.0
        closed = -slack <= within <= self._width + slack
        if closed != self._closed:
            self._closed, self._changed = closed, now
        self._shown = not self._shown if now - self._changed < self._bounce else closed
        return pulse_segments.Level(pulse_segments.PulseLine.HOME, self._shown == self._high, now)


far_end = Tb6600FarEnd
