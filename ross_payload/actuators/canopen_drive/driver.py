"""A drive on a CAN bus that speaks CANopen and CiA 402: it makes the trapezoid, we say where to and how fast.

A goal is one set-point; the drive's own reports, 50 a second, say where it is and whether it is there. The first goal
or homing enables it, nothing else. When our heartbeat ends it stops by itself and switches off. Whatever is in doubt
makes us send the same quick stop; only `home` resets a fault, and the drive stays off then.

Only the pump (`poll`) acts; the other methods leave a request in a queue.
"""

from __future__ import annotations

import logging
import math
from dataclasses import replace
from types import TracebackType
from typing import Any, Self

from ross_payload.actuators.canopen_drive.axis import Axis
from ross_payload.actuators.canopen_drive.link import Link
from ross_payload.actuators.canopen_drive.options import Options
from ross_payload.actuators.canopen_drive.places import Places
from ross_payload.actuators.canopen_drive.setup import Setup
from ross_payload.actuators.canopen_drive.watch import ENABLE, OFF, Watch
from ross_payload.actuators.requests import Ask, Move, Requests
from ross_payload.errors import ActuatorFault, LimitError, LinkError, NotHomed
from ross_payload.interfaces import Actuator, ActuatorState, Services
from ross_protocols import cia402
from ross_protocols.cia402 import Homing, Mode, State

PARTING = 0.05  # [s] in which the last answer comes
REPEAT = 0.1  # [s] between two equal orders
EARLY = 1e-6  # so much before its time something is due [s]
log = logging.getLogger(__name__)


class CanopenDrive:
    """The driver: sans I/O over a port of CAN frames."""

    def __init__(self, options: Options, services: Services) -> None:
        self._options = options
        self._services = services
        self._requests = Requests()
        self._link: Link | None = None
        self._leaving = False
        self._setup = Setup(options)
        self._axis = Axis()
        self.capabilities = able = options.capabilities
        self._places = Places(options.settle_ms * 1e-3, 1.5 * able.max_speed, able.max_acceleration)
        self._known = False  # where the drive counts 0
        self._homing = False  # asked for, and not over
        self._next: Move | None = None  # what was asked for meanwhile
        self._watch = Watch()
        self._sent: tuple[int, int, int] | None = None
        self._due = -math.inf  # the next repetition [s]
        self._fault = ""
        self._state = ActuatorState(0.0, 0.0, settled=False, homed=False, healthy=True, time=-math.inf)

    @property
    def identity(self) -> str:
        """The numbers by which the drive's maker knows it."""
        return self._setup.identity

    def command(self, angle: float, rate: float | None = None) -> None:
        """Go to a joint angle [rad], at most at ``rate`` [rad/s]; replaces the goal."""
        if not self.capabilities.lower <= angle <= self.capabilities.upper:
            raise LimitError(f"goal {math.degrees(angle):.2f} deg is outside the travel of the drive")
        if self._fault:
            raise ActuatorFault(self._fault)
        if not self._state.homed:
            raise NotHomed("the drive's position is not known: home first")
        self._requests.put(Move(angle, min(rate or math.inf, self.capabilities.max_speed)))

    def state(self) -> ActuatorState:
        """Return the state at the last poll; not settled while a request waits."""
        return self._state if self._requests.empty else replace(self._state, settled=False)

    def stop(self) -> None:
        """Let the drive slow down along its ramp, and hold."""
        self._requests.put(Ask.HALT)

    def home(self) -> None:
        """Forget a fault, reset the drive's, and find home where its encoder does not know it."""
        self._requests.put(Ask.HOME)

    def release(self) -> None:
        """Switch the drive off; its encoder goes on counting."""
        self._requests.put(Ask.RELEASE)

    def poll(self, now: float) -> None:
        """Read the bus, obey requests, tell the drive what is due, publish the state at ``now`` [s]."""
        if self._link is None:
            return
        try:
            self._link.take_in(now)
            self._look(self._link, now)
            self._set_up(self._link, now)
            for request in self._requests.taken():
                self._obey(request, self._link)
            self._link.beat(now)
            self._steer(self._link, now)
        except LinkError as down:
            self._latch(str(down))
            raise
        finally:
            self._publish(self._link)

    def __enter__(self) -> Self:
        """Join the bus; asking the drive who it is and telling it how to move begins with the first poll."""
        port = self._services.open_port(self._options.port)
        self._state = replace(self._state, settled=False, homed=False, healthy=True, fault="", time=-math.inf)
        self._link = Link(self._options, port, self._services.clock.now())
        self._axis, self._watch, self._fault, self._homing = Axis(), Watch(), "", False
        self._leaving = False
        self._known = self._options.absolute  # whoever was switched off meanwhile counts from elsewhere
        self._begin(self._link)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Let the drive decelerate, which takes its time, switch off and expect no more of us; leave the bus."""
        if self._link is None:
            return
        try:
            self._leave(self._link)
        except LinkError as gone:
            log.warning("%s", gone)
        self._link.close()
        self._link = None

    # ------------------------------------------------------------------------------------------ set-up

    def _begin(self, link: Link) -> None:
        """Ask and tell everything from the beginning; what is not running obeys nothing."""
        self._setup, self._sent = Setup(self._options), None
        self._places.clear()
        link.hold()

    def _set_up(self, link: Link, now: float) -> None:
        answers, link.answers = link.answers, []
        if self._fault or self._setup.done or self._leaving:
            return
        try:
            asked = self._setup.go_on(answers, now)
        except ActuatorFault as fault:
            self._latch(str(fault))
            return
        if asked:
            link.ask(asked)
        elif self._setup.done:
            link.start(now)

    def _leave(self, link: Link) -> None:
        self._leaving = True
        clock, braking = self._services.clock, self.capabilities.max_speed / self.capabilities.max_acceleration
        until = clock.now() + braking + ENABLE if link.running else -math.inf
        self._axis.end(State.QUICK_STOP_ACTIVE)
        self.poll(clock.now())
        while clock.now() < until and cia402.state_of(link.report.status) not in OFF:
            clock.sleep(0.01)
            self.poll(clock.now())
        link.part()
        until = clock.now() + PARTING
        while link.awaits and clock.now() < until:  # an answer that comes later would puzzle whoever asks next
            clock.sleep(0.005)
            link.take_in(clock.now())

    # ------------------------------------------------------------------------------------------ what is heard

    def _look(self, link: Link, now: float) -> None:
        """Remember the newest place; latch what is wrong with the drive or on the bus."""
        if link.restarted:
            self._known = self._options.absolute
            if not (self._fault or self._setup.done):
                self._begin(link)  # it has just been switched on
        if link.running and link.report.time > self._state.time:
            self._see(self._options.joint(link.report.position), link.velocity / self._options.scale, link.report.time)
        self._latch(link.event)
        link.event = ""
        if link.fresh:
            if self._homing:
                self._go_home(link, now)
            self._latch(self._watch.trouble(self._axis, link.report, link.emergency, now) if not self._fault else "")

    def _see(self, joint: float, rate: float, time: float) -> None:
        """Take a new place; one that cannot be true is a fault, and no place."""
        if self._axis.mode is Mode.HOMING:
            self._places.clear()  # the drive will count from elsewhere
        jump = self._places.take(joint, rate, time)
        self._latch(f"implausible position from the drive: it {jump}" if jump else "")

    def _latch(self, fault: str) -> None:
        """Keep the first fault and let the drive stop and switch off."""
        if fault:
            self._fault, self._homing = self._fault or fault, False
            self._axis.end(State.QUICK_STOP_ACTIVE)

    def _go_home(self, link: Link, now: float) -> None:
        """Reset a fault, then find home where the encoder does not know it."""
        state = cia402.state_of(link.report.status)
        if state in (State.FAULT, State.FAULT_REACTION):
            if not self._axis.resetting:
                self._axis.reset()
        elif state is State.QUICK_STOP_ACTIVE:
            return  # it brakes
        elif self._options.absolute:
            self._axis.rest()
            self._end_homing(Homing.DONE)
        elif self._axis.mode is not Mode.HOMING:
            self._axis.home()
        else:
            self._end_homing(self._watch.homing(self._axis, link.report, now))

    def _end_homing(self, homing: Homing) -> None:
        if homing is Homing.FAILED:
            self._latch("homing failed: the drive reports a homing error")
        elif homing is Homing.DONE:
            self._homing, self._known, self._sent = False, True, None
            self._axis.mode = Mode.PROFILE_POSITION
            self._places.clear()
            if self._next:
                self._go(self._next)

    def _go(self, move: Move) -> None:
        self._axis.go(self._options.counts(move.goal), self._options.span(math.degrees(move.rate)))

    # ------------------------------------------------------------------------------------------ requests

    def _obey(self, request: Move | Ask, link: Link) -> None:
        if isinstance(request, Move):
            if self._homing:
                self._next = request
            elif not self._fault and self._known:
                self._go(request)
        elif request is Ask.HALT:
            self._homing = False
            self._axis.halt()
        elif request is Ask.RELEASE:
            self._homing = False
            self._axis.end(State.QUICK_STOP_ACTIVE if self._fault else State.SWITCH_ON_DISABLED)
        elif not self._homing:
            self._home(link)

    def _home(self, link: Link) -> None:
        self._homing, self._known, self._next = True, self._options.absolute, None
        self._fault, link.event, link.emergency = "", "", None
        self._watch = Watch()
        self._places.clear()
        if self._axis.mode is Mode.HOMING:  # one that was broken off
            self._axis.end(State.QUICK_STOP_ACTIVE)
        if link.restarted or not link.running:
            self._begin(link)

    # ------------------------------------------------------------------------------------------ out

    def _steer(self, link: Link, now: float) -> None:
        """Send an order that is new, or old enough to be repeated."""
        if not link.fresh:
            return
        axis = self._axis
        word = axis.word(link.report)
        if self._sent is None and not axis.offered:
            axis.target = link.report.position
        order = (word, axis.target, axis.mode)
        if order != self._sent or now >= self._due - EARLY:
            self._sent, self._due = order, now + REPEAT
            if axis.offered:
                link.limit(axis.offered.speed)
            link.steer(*order)

    def _publish(self, link: Link) -> None:
        homed = link.fresh and self._known
        settled = homed and not (self._fault or self._homing) and self._arrived(link.report.status)
        self._state = ActuatorState(
            angle=self._places.joint,
            rate=0.0 if settled or not link.fresh else link.velocity / self._options.scale,
            settled=settled,
            homed=homed,
            healthy=not self._fault,
            time=link.report.time if link.fresh else link.heard,
            fault=self._fault,
        )

    def _arrived(self, status: int) -> bool:
        """Whether the drive is still, and where it was last sent to as it says itself and as we see."""
        goal, near = self._axis.goal, self.capabilities.resolution
        if goal is None:
            return self._places.still(near)
        there = abs(self._places.joint - self._options.joint(goal.target)) <= near
        return there and self._places.still(near) and self._axis.taken and bool(status & cia402.REACHED)


class CanopenDriveBackend:
    """Drive on a CAN bus that speaks CANopen (CiA 402): profile position, homing, position from its encoder."""

    Config: type[Any] = Options

    def open(self, config: Options, services: Services) -> Actuator:
        """Make the driver."""
        return CanopenDrive(config, services)


backend = CanopenDriveBackend()
