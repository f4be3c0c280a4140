"""A stepper motor behind a TB6600 module: open loop, every edge computed before it is due.

A goal becomes a trapezoid, the trapezoid a list of edges, and the edges are handed over in segments, 40 ms ahead of
time. A stop or a new goal plans again from the end of the last segment handed over, with continuous velocity.
Feedback is a model: the angle is the steps handed over whose time has come. Nobody measures, so the position is
unknown after power-up (unless declared), after `release` and after a fault, until `home` declares it or finds a switch.
"""

from __future__ import annotations

import math
from collections import deque

from ross_payload.actuators.driver_shell import Driver, DriverBackend, Move, Request, capabilities_of
from ross_payload.actuators.motion import Motion, Trapezoid
from ross_payload.actuators.tb6600.homing import SwitchSearch
from ross_payload.actuators.tb6600.options import Options
from ross_payload.actuators.tb6600.pulse_segments import Level, PulseLine
from ross_payload.actuators.tb6600.segment_queue import SegmentQueue
from ross_payload.errors import ActuatorFault, LinkError
from ross_payload.interfaces import ActuatorState, Clock, Feedback, Port


class Tb6600(Driver):
    """The driver: sans I/O over a pulse port."""

    forgets_zero = plays_on = True

    def __init__(self, options: Options) -> None:
        self._options = options
        self._step = options.resolution
        self._queue = SegmentQueue(options.timing, self._step, options.ahead_ms * 1e-3)
        self._motions = deque([Motion(Trapezoid.still(0.0), -math.inf)])  # by begin, the last is the plan
        self._enabled: bool | None = None
        self._homed = options.zero == "declared"
        self._declare = False  # the zero, or begin to look for it, once all is still and reported
        self._search = SwitchSearch(options.search, options.home_level == "high")
        self._fault = ""
        self._heard_at = math.inf  # when the port was read last, while it is open [s]
        self.capabilities = capabilities_of(
            options, self._step, Feedback.MODEL, endless=True, finds_zero=options.zero == "switch"
        )

    def goal(self, angle: float) -> float:
        """Return the microstep nearest to a joint angle [rad]."""
        return round(angle / self._step) * self._step

    def open(self, port: Port, now: float) -> None:
        """Hold a declared zero at once; an unknown one stays without torque, any other as it was."""
        self._queue.open(port)
        self._switch(self._homed if self._enabled is None else self._enabled, now)

    def read(self, now: float) -> None:
        """Take in reports, and whether the edges ran out."""
        for report in self._queue.receive():
            if not isinstance(report, Level):
                self._lose("pulse underrun: edges arrived too late to be played; the position is lost")
                self._rest(self._from(now))
            elif report.line is PulseLine.HOME:
                self._search.update(report)
        self._look_for_starvation(now)
        self._heard_at = now

    def obey(self, request: Move | Request, now: float) -> None:
        """Plan again from the end of the last segment handed over; a release switches the module off there."""
        if isinstance(request, Move):
            if self._homed and not self._fault:
                self._go(request, now)
            return
        self._end_search()
        if request is Request.RELEASE:
            self._rest(self._from(now))
            self._queue.flush()
            self._switch(False, now)
            self._homed = self._declare = False
        else:
            self._halt(now)
            if request is Request.HOME:
                self._homed, self._declare = False, True
                self._enabled = None  # the report of one more ENABLE edge proves the wire

    def write(self, now: float) -> None:
        """Go on looking for the switch, hand over segments, declare the zero."""
        self._seek(now)
        self._queue.top_up(now)
        self._declare_when_still(now)

    def snapshot(self, now: float) -> ActuatorState:
        """Return the state at ``now`` [s]: the steps handed over whose time has come."""
        while len(self._motions) > 1 and self._motions[1].begin <= now:
            self._motions.popleft()
        still = not self._queue.pending and now >= self._queue.committed + self._options.settle_ms * 1e-3 - 1e-9
        return ActuatorState(
            angle=self._queue.angle(now),
            rate=self._motions[0].at(now)[1],
            settled=still and not (self._declare or self._search.active or self._fault),
            homed=self._homed,
            healthy=not self._fault,
            time=min(self._queue.known(now), self._heard_at),
            fault=self._fault,
        )

    def link_lost(self, error: LinkError) -> bool:
        """Latch it: nobody knows which of the edges handed over are played."""
        self._lose(f"{error}: the position is lost")
        return False

    def leave(self, clock: Clock) -> tuple[()]:
        """Plan the deceleration; the torque stays, so that nothing falls."""
        try:
            self.read(clock.now())
        finally:  # also when the wire fails: what is handed over would be played to its end
            self._search.end()
            self._halt(clock.now())
        return ()

    def close(self) -> None:
        """Hand over the whole deceleration at once and give the wire back."""
        self._heard_at = math.inf
        self._queue.close()

    # ------------------------------------------------------------------------------------------ plans

    def _from(self, now: float) -> float:
        """From when on the future is still open [s]."""
        return max(now, self._queue.committed)

    def _go(self, move: Move, now: float) -> None:
        begin = self._from(now)
        position, velocity = self._motions[-1].at(begin)
        self._plan(Trapezoid(position, move.goal, move.rate, self.capabilities.max_acceleration, velocity), begin)

    def _halt(self, now: float) -> None:
        begin = self._from(now)
        position, velocity = self._motions[-1].at(begin)
        if velocity:
            self._plan(Trapezoid.to_rest(position, velocity, self.capabilities.max_acceleration), begin)
        elif self._queue.pending:
            self._rest(begin)

    def _rest(self, begin: float) -> None:
        """Plan to stay where the counter is."""
        self._plan(Trapezoid.still(self._queue.position), begin)

    def _plan(self, plan: Trapezoid, begin: float) -> None:
        self._motions.append(Motion(plan, begin))
        self._queue.load(plan, begin)

    def _switch(self, on: bool, now: float) -> None:
        """Send the ENABLE edge, followed by its lead time when the torque comes on."""
        lead = self._options.enable_lead_ms * 1e-3 if on else self._options.timing.hold
        self._queue.switch(PulseLine.ENABLE, on != self._options.enable_means_off, self._from(now), lead)
        self._enabled = on

    # ------------------------------------------------------------------------------------------ the zero

    def _declare_when_still(self, now: float) -> None:
        if not self._declare or not self._still(now):
            return
        if not self._enabled:
            self._switch(True, now)
        if not self._queue.all_reported:
            return
        self._declare, self._fault = False, ""
        if self._options.zero == "switch":
            self._search.begin(now)
        else:
            self._set_position(0.0, self._queue.position, now)

    def _seek(self, now: float) -> None:
        """Go on looking for the switch."""
        if not self._search.active:
            return
        try:
            step = self._search.step(self._queue.angle, now, self._still(now))
        except ActuatorFault as fault:
            self._lose(str(fault))
            self._halt(now)
            return
        if isinstance(step, Move):
            self._go(Move(step.goal, min(step.rate, self.capabilities.max_speed)), now)
        elif step is Request.HALT:
            self._halt(now)
        elif self._search.found is not None and not self._search.active:
            self._set_position(math.radians(self._options.home_offset_deg), self._search.found, now)

    def _end_search(self) -> None:
        """Look for the switch no more, nor begin to."""
        self._search.end()
        self._declare = self._declare and self._options.zero != "switch"

    def _set_position(self, angle: float, place: float, now: float) -> None:
        """Let a place of the counter [rad] be a joint angle [rad]: the position is known; at rest only."""
        self._queue.shift(round((angle - place) / self._step))
        self._motions = deque([Motion(Trapezoid.still(self._queue.position), now)])
        self._homed = True

    def _still(self, now: float) -> bool:
        return not self._queue.pending and now >= self._queue.committed

    # ------------------------------------------------------------------------------------------ the model

    def _look_for_starvation(self, now: float) -> None:
        """Fault when the edges ran out in the middle of a move: the rotor was stopped dead, who knows where."""
        if not self._queue.pending or now <= self._queue.committed:
            return
        rate = self._motions[-1].at(self._queue.committed)[1]
        if rate:
            late = (now - self._queue.committed) * 1e3
            self._lose(f"pulse underrun for {late:.0f} ms at {math.degrees(rate):.1f} deg/s: the position is lost")
            self._rest(now)

    def _lose(self, why: str) -> None:
        """Begin a fault: nobody knows where the array is."""
        self._fault = self._fault or why
        self._homed = self._declare = False
        self._search.end()


backend = DriverBackend(
    "Stepper motor behind a TB6600 module: step, direction and enable pulses, open loop.", Options, Tb6600
)
