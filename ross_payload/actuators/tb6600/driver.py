"""A stepper motor behind a TB6600 module: open loop, every edge computed before it is due.

A goal becomes a trapezoid, the trapezoid a list of edges, and the edges are handed over in segments, 40 ms ahead of
time. A stop or a new goal plans again from the end of the last segment handed over, with continuous velocity.
Feedback is a model: the angle is the steps handed over whose time has come. Nobody measures, so the position is
unknown after power-up (unless declared), after `release` and after a fault, until `home` declares it or finds a switch.

Only the pump (`poll`) plans; the other methods leave a request in a queue.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from types import TracebackType
from typing import Any, Self

from ross_payload.actuators.motion import Trapezoid
from ross_payload.actuators.requests import Ask, Motion, Move, Requests
from ross_payload.actuators.tb6600.feed import Feed
from ross_payload.actuators.tb6600.homing import Seeker
from ross_payload.actuators.tb6600.options import Options
from ross_payload.actuators.tb6600.pulses import Level, Line
from ross_payload.errors import ActuatorFault, LimitError, NotHomed
from ross_payload.interfaces import Actuator, ActuatorState, Capabilities, Feedback, Services


class Tb6600:
    """The driver: sans I/O over a pulse port."""

    def __init__(self, options: Options, services: Services) -> None:
        self._options = options
        self._services = services
        self._step = options.resolution
        self._feed = Feed(options.interface, self._step, options.ahead_ms * 1e-3)
        self._requests = Requests()
        self._motions = deque([Motion(Trapezoid(0.0, 0.0, 1.0, 1.0), -math.inf)])  # by begin, the last is the plan
        self._enabled: bool | None = None
        self._homed = options.zero == "declared"
        self._declare = False  # the zero, or begin to look for it, once all is still and reported
        self._seeker = Seeker(options.search, options.home_level == "high")
        self._fault = ""
        self._state = ActuatorState(0.0, 0.0, False, self._homed, healthy=True, time=-math.inf)
        self.capabilities = Capabilities(
            lower=-math.inf,
            upper=math.inf,
            max_speed=math.radians(options.max_speed_deg_s),
            max_acceleration=math.radians(options.max_acceleration_deg_s2),
            resolution=self._step,
            continuous=True,
            feedback=Feedback.MODEL,
            finds_zero=options.zero == "switch",
        )

    def command(self, angle: float, rate: float | None = None) -> None:
        """Go to the microstep nearest to a joint angle [rad], at most at ``rate`` [rad/s]; replaces the goal."""
        if not math.isfinite(angle):
            raise LimitError(f"goal {angle} rad is not finite")
        if self._fault:
            raise ActuatorFault(self._fault)
        if not self._homed:
            raise NotHomed("the zero is not known: home first")
        speed = min(rate or math.inf, self.capabilities.max_speed)
        self._requests.put(Move(round(angle / self._step) * self._step, speed))

    def state(self) -> ActuatorState:
        """Return the state at the last poll; not settled while a request waits."""
        return self._state if self._requests.empty else replace(self._state, settled=False)

    def stop(self) -> None:
        """Decelerate from the end of the last segment handed over."""
        self._requests.put(Ask.HALT)

    def home(self) -> None:
        """Decelerate, energise, and declare that here is the zero, or look for the switch that tells where it is."""
        self._homed = False
        self._requests.put(Ask.HOME)

    def release(self) -> None:
        """Switch the module off after the last segment handed over; the position is unknown afterwards."""
        self._requests.put(Ask.RELEASE)

    def poll(self, now: float) -> None:
        """Take in reports, obey requests, hand over segments, publish the state at ``now`` [s]."""
        if self._feed.is_open:
            self._take_in(now)
            self._look_for_starvation(now)
            for request in self._requests.taken():
                self._obey(request, now)
            self._seek(now)
            self._feed.top_up(now)
            self._declare_when_still(now)
        self._publish(now)

    def __enter__(self) -> Self:
        """Open the wire; a declared zero is held at once, an unknown one stays without torque, any other as it was."""
        self._feed.open(self._services.open_port(self._options.port))
        self._switch(self._homed if self._enabled is None else self._enabled, self._services.clock.now())
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Hand over the whole deceleration at once and close; the torque stays, so that nothing falls."""
        self._seeker.end()
        if self._feed.is_open:
            self._halt(self._services.clock.now())
            self._feed.close()

    # ------------------------------------------------------------------------------------------ requests

    def _obey(self, request: Move | Ask, now: float) -> None:
        if isinstance(request, Move):
            if self._homed and not self._fault:
                self._go(request, now)
            return
        self._end_search()
        if request is Ask.RELEASE:
            self._rest(self._from(now))
            self._feed.flush()
            self._switch(False, now)
            self._homed = self._declare = False
        else:
            self._halt(now)
            if request is Ask.HOME:
                self._declare, self._enabled = True, None  # the report of one more ENABLE edge proves the wire

    def _from(self, now: float) -> float:
        """From when on the future is still open [s]."""
        return max(now, self._feed.committed)

    def _go(self, move: Move, now: float) -> None:
        begin = self._from(now)
        position, velocity = self._motions[-1].at(begin)
        self._plan(Trapezoid(position, move.goal, move.rate, self.capabilities.max_acceleration, velocity), begin)

    def _halt(self, now: float) -> None:
        begin = self._from(now)
        position, velocity = self._motions[-1].at(begin)
        if velocity:
            self._plan(Trapezoid.to_rest(position, velocity, self.capabilities.max_acceleration), begin)
        elif self._feed.pending:
            self._rest(begin)

    def _rest(self, begin: float) -> None:
        """Plan to stay where the counter is."""
        here = self._feed.position
        self._plan(Trapezoid(here, here, 1.0, 1.0), begin)

    def _plan(self, plan: Trapezoid, begin: float) -> None:
        self._motions.append(Motion(plan, begin))
        self._feed.load(plan, begin)

    def _switch(self, on: bool, now: float) -> None:
        """Send the ENABLE edge, followed by its lead time when the torque comes on."""
        lead = self._options.enable_lead_ms * 1e-3 if on else self._options.interface.hold
        self._feed.switch(Line.ENABLE, on != self._options.enable_means_off, self._from(now), lead)
        self._enabled = on

    # ------------------------------------------------------------------------------------------ the zero

    def _declare_when_still(self, now: float) -> None:
        if not self._declare or not self._still(now):
            return
        if not self._enabled:
            self._switch(True, now)
        if not self._feed.all_reported:
            return
        self._declare, self._fault = False, ""
        if self._options.zero == "switch":
            self._seeker.begin(now)
        else:
            self._call_it(0.0, self._feed.position, now)

    def _seek(self, now: float) -> None:
        """Go on looking for the switch."""
        if not self._seeker.active:
            return
        try:
            step = self._seeker.step(self._feed.angle, now, self._still(now))
        except ActuatorFault as fault:
            self._lose(str(fault))
            self._halt(now)
            return
        if isinstance(step, Move):
            self._go(Move(step.goal, min(step.rate, self.capabilities.max_speed)), now)
        elif step is Ask.HALT:
            self._halt(now)
        elif self._seeker.found is not None and not self._seeker.active:
            self._call_it(math.radians(self._options.home_offset_deg), self._seeker.found, now)

    def _end_search(self) -> None:
        """Look for the switch no more, nor begin to."""
        self._seeker.end()
        self._declare = self._declare and self._options.zero != "switch"

    def _call_it(self, angle: float, place: float, now: float) -> None:
        """Let a place of the counter [rad] be a joint angle [rad]: the position is known; at rest only."""
        self._feed.shift(round((angle - place) / self._step))
        here = self._feed.position
        self._motions = deque([Motion(Trapezoid(here, here, 1.0, 1.0), now)])
        self._homed = True

    def _still(self, now: float) -> bool:
        return not self._feed.pending and now >= self._feed.committed

    # ------------------------------------------------------------------------------------------ the model

    def _take_in(self, now: float) -> None:
        for report in self._feed.take_in():
            if not isinstance(report, Level):
                self._lose("pulse underrun: edges arrived too late to be played; the position is lost")
                self._rest(self._from(now))
            elif report.line is Line.HOME:
                self._seeker.take(report)

    def _look_for_starvation(self, now: float) -> None:
        """Fault when the edges ran out in the middle of a move: the rotor was stopped dead, who knows where."""
        if not self._feed.pending or now <= self._feed.committed:
            return
        rate = self._motions[-1].at(self._feed.committed)[1]
        if rate:
            late = (now - self._feed.committed) * 1e3
            self._lose(f"pulse underrun for {late:.0f} ms at {math.degrees(rate):.1f} deg/s: the position is lost")
            self._rest(now)

    def _lose(self, why: str) -> None:
        """Begin a fault: nobody knows where the array is."""
        self._fault = self._fault or why
        self._homed = self._declare = False
        self._seeker.end()

    def _publish(self, now: float) -> None:
        while len(self._motions) > 1 and self._motions[1].begin <= now:
            self._motions.popleft()
        still = not self._feed.pending and now >= self._feed.committed + self._options.settle_ms * 1e-3 - 1e-9
        self._state = ActuatorState(
            angle=self._feed.angle(now),
            rate=self._motions[0].at(now)[1],
            settled=still and not (self._declare or self._seeker.active or self._fault),
            homed=self._homed,
            healthy=not self._fault,
            time=self._feed.known(now),
            fault=self._fault,
        )


class Tb6600Backend:
    """Stepper motor behind a TB6600 module: step, direction and enable pulses, open loop."""

    Config: type[Any] = Options

    def open(self, config: Options, services: Services) -> Actuator:
        """Make the driver."""
        return Tb6600(config, services)


backend = Tb6600Backend()
