"""A drive on a CAN bus that speaks CANopen and CiA 402: it makes the trapezoid, we say where to and how fast.

A goal is one set-point; the drive's own reports, 50 a second, say where it is and whether it is there. The first goal
or homing enables it, nothing else. When our heartbeat ends it stops by itself and switches off. Whatever is in doubt
makes us send the same quick stop; only `home` resets a fault, and the drive stays off then.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from ross_payload.actuators.canopen_drive.cia402_controller import (
    ENABLE_TIMEOUT_S,
    TORQUE_OFF,
    Cia402Controller,
    DriveDiagnostics,
)
from ross_payload.actuators.canopen_drive.drive_client import DriveClient, DriveReport
from ross_payload.actuators.canopen_drive.drive_setup import DriveSetup
from ross_payload.actuators.canopen_drive.options import Options
from ross_payload.actuators.canopen_drive.position_filter import PositionFilter
from ross_payload.actuators.driver_shell import TIME_TOLERANCE_S, Driver, DriverBackend, Move, Request, wait
from ross_payload.errors import ActuatorFault, LinkError
from ross_payload.interfaces import ActuatorState, Clock, Port
from ross_protocols.canopen import cia402
from ross_protocols.canopen.cia402 import Homing, Mode, State

LAST_ANSWER_TIMEOUT_S = 0.05  # [s] in which the last answer comes
ORDER_PERIOD_S = 0.1  # [s] between two equal orders


class CanopenDrive(Driver):
    """The driver: sans I/O over a port of CAN frames."""

    def __init__(self, options: Options) -> None:
        self._options = options
        self._client: DriveClient
        self._leaving = False
        self._setup = DriveSetup(options)
        self._controller = Cia402Controller()
        self.capabilities = able = options.capabilities
        self._positions = PositionFilter(options.settle_ms * 1e-3, 1.5 * able.max_speed, able.max_acceleration)
        self._known = False  # where the drive counts 0
        self._homing = False  # asked for, and not over
        self._next: Move | None = None  # what was asked for meanwhile
        self._diagnostics = DriveDiagnostics()
        self._sent: tuple[int, int, int] | None = None
        self._due = -math.inf  # the next repetition [s]
        self._fault = ""
        self._published = -math.inf  # time of the last state [s]

    @property
    def identity(self) -> str:
        """The numbers by which the drive's maker knows it."""
        return self._setup.identity

    def open(self, port: Port, now: float) -> None:
        """Join the bus; asking the drive who it is and telling it how to move begins with the first poll."""
        self._client = DriveClient(self._options, port, now)
        self._controller, self._diagnostics = Cia402Controller(), DriveDiagnostics()
        self._fault, self._homing, self._leaving, self._published = "", False, False, -math.inf
        self._known = self._options.absolute  # whoever was switched off meanwhile counts from elsewhere
        self._begin()

    def read(self, now: float) -> None:
        """Read the bus; look at what the drive says; go on setting it up."""
        self._client.read(now)
        self._on_reports(now)
        self._set_up(now)

    def obey(self, request: Move | Request, now: float) -> None:
        """Begin what is asked for; a goal waits until homing is over."""
        if isinstance(request, Move):
            if self._homing:
                self._next = request
            elif not self._fault and self._known:
                self._go(request)
        elif request is Request.HALT:
            self._homing = False
            self._controller.halt()
        elif request is Request.RELEASE:
            self._homing = False
            self._controller.end(State.QUICK_STOP_ACTIVE if self._fault else State.SWITCH_ON_DISABLED)
        elif not self._homing:
            self._homing, self._known, self._next = True, self._options.absolute, None
            self._fault, self._client.event, self._client.emergency = "", "", None
            self._diagnostics = DriveDiagnostics()
            self._positions.clear()
            if self._controller.mode is Mode.HOMING:  # one that was broken off
                self._controller.end(State.QUICK_STOP_ACTIVE)
            if self._client.restarted or not self._client.running or self._client.is_silent(now):
                self._begin()  # one that is silent may have restarted unheard

    def write(self, now: float) -> None:
        """Send our heartbeat and what the drive is to do."""
        self._client.send_heartbeat(now)
        self._send_order(now)

    def link_lost(self, error: LinkError) -> bool:
        """Latch that the bus is down."""
        self._latch(str(error))
        return False

    def snapshot(self, now: float) -> ActuatorState:
        """Return the state."""
        client = self._client
        homed = client.fresh and self._known
        settled = homed and not (self._fault or self._homing) and self._arrived(client.report.status)
        self._published = client.report.time if client.fresh else client.heard_at
        return ActuatorState(
            angle=self._positions.joint,
            rate=0.0 if settled or not client.fresh else client.velocity / self._options.scale,
            settled=settled,
            homed=homed,
            healthy=not self._fault,
            time=self._published,
            fault=self._fault,
        )

    def leave(self, clock: Clock) -> Iterator[None]:
        """Let the drive decelerate, which takes its time, switch off and expect no more of us."""
        self._leaving, client = True, self._client
        braking = self.capabilities.max_speed / self.capabilities.max_acceleration
        until = clock.now() + braking + ENABLE_TIMEOUT_S if client.running else -math.inf
        self._homing = False
        self._controller.end(State.QUICK_STOP_ACTIVE)
        yield
        while clock.now() < until and cia402.state_of(client.report.status) not in TORQUE_OFF:
            yield
        client.stop_heartbeat_watch()
        until = clock.now() + LAST_ANSWER_TIMEOUT_S
        while client.awaits_answer and clock.now() < until:  # an answer that comes later would puzzle whoever asks next
            wait(clock, 0.005)
            client.read(clock.now())

    def close(self) -> None:
        """Leave the bus."""
        self._client.close()

    # ------------------------------------------------------------------------------------------ set-up

    def _begin(self) -> None:
        """Ask and tell everything from the beginning; what is not running obeys nothing."""
        self._setup, self._sent = DriveSetup(self._options), None
        self._positions.clear()
        self._client.enter_pre_operational()

    def _set_up(self, now: float) -> None:
        answers, self._client.answers = self._client.answers, []
        if self._fault or self._setup.done or self._leaving:
            return
        try:
            asked = self._setup.advance(answers, now)
        except ActuatorFault as fault:
            self._latch(str(fault))
            return
        if asked:
            self._client.send_sdo(asked)
        elif self._setup.done:
            self._client.start(now)

    # ------------------------------------------------------------------------------------------ what is heard

    def _on_reports(self, now: float) -> None:
        """Remember the newest place; latch what is wrong with the drive or on the bus."""
        client = self._client
        if client.restarted:
            self._known = self._options.absolute
            if not (self._fault or self._setup.done):
                self._begin()  # it has just been switched on
        if client.running and client.report.time > self._published:
            joint, rate = self._options.joint(client.report.position), client.velocity / self._options.scale
            self._on_position(joint, rate, client.report)
        self._latch(client.event)
        client.event = ""
        if client.fresh:
            if self._homing:
                self._go_home(now)
            trouble = self._diagnostics.trouble(self._controller, client.report, client.emergency, now)
            self._latch(trouble if not self._fault else "")

    def _on_position(self, joint: float, rate: float, report: DriveReport) -> None:
        """Take a new place; one that cannot be true is a fault, and no place."""
        if self._controller.mode is Mode.HOMING:
            self._positions.clear()  # the drive will count from elsewhere
        jump = self._positions.update(joint, rate, report.time, report.since)
        self._latch(f"implausible position from the drive: it {jump}" if jump else "")

    def _latch(self, fault: str) -> None:
        """Keep the first fault and let the drive stop and switch off."""
        if fault:
            self._fault, self._homing = self._fault or fault, False
            self._controller.end(State.QUICK_STOP_ACTIVE)

    def _go_home(self, now: float) -> None:
        """Reset a fault, then find home where the encoder does not know it."""
        state = cia402.state_of(self._client.report.status)
        if state in (State.FAULT, State.FAULT_REACTION):
            if not self._controller.resetting:
                self._controller.reset()
        elif state is State.QUICK_STOP_ACTIVE:
            return  # it brakes
        elif self._options.absolute:
            self._controller.rest()
            self._end_homing(Homing.DONE)
        elif self._controller.mode is not Mode.HOMING:
            self._controller.home()
        else:
            self._end_homing(self._diagnostics.homing(self._controller, self._client.report, now))

    def _end_homing(self, homing: Homing) -> None:
        if homing is Homing.FAILED:
            self._latch("homing failed: the drive reports a homing error")
        elif homing is Homing.DONE:
            self._homing, self._known, self._sent = False, True, None
            self._controller.mode = Mode.PROFILE_POSITION
            self._positions.clear()
            if self._next:
                self._go(self._next)

    def _go(self, move: Move) -> None:
        self._controller.go(self._options.counts(move.goal), self._options.span(math.degrees(move.rate)))

    # ------------------------------------------------------------------------------------------ out

    def _send_order(self, now: float) -> None:
        """Send an order that is new, or old enough to be repeated."""
        if not self._client.fresh:
            return
        controller = self._controller
        word = controller.word(self._client.report)
        if self._sent is None and not controller.offered:
            controller.target = self._client.report.position
        order = (word, controller.target, controller.mode)
        if order != self._sent or now >= self._due - TIME_TOLERANCE_S:
            self._sent, self._due = order, now + ORDER_PERIOD_S
            if controller.offered:
                self._client.send_speed_limit(controller.offered.speed)
            self._client.send_order(*order)

    def _arrived(self, status: int) -> bool:
        """Whether the drive is still, and where it was last sent to as it says itself and as we see."""
        goal, near = self._controller.goal, self.capabilities.resolution
        if goal is None:
            return self._positions.still(near)
        there = abs(self._positions.joint - self._options.joint(goal.target)) <= near
        return there and self._positions.still(near) and self._controller.taken and bool(status & cia402.REACHED)


backend = DriverBackend(
    "Drive on a CAN bus that speaks CANopen (CiA 402): profile position, homing, position from its encoder.",
    Options,
    CanopenDrive,
)
