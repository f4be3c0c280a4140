"""CiA 402: what a drive is told, given what it says, and what is wrong when it is not as wanted. No bus."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ross_payload.actuators.canopen_drive.drive_client import DriveReport
from ross_protocols.canopen import cia402
from ross_protocols.canopen.cia402 import Homing, Mode, State
from ross_protocols.canopen.frames import Emergency

EMERGENCY_TIMEOUT_S = 0.05  # so long a drive may take to say why it is in a fault [s]
FOLLOWING_TIMEOUT_S = 0.2  # so long it may be behind its plan without a fault of its own [s]
ENABLE_TIMEOUT_S = 1.0  # so long it may take to switch on, or to be reset [s]
HOMING_START_S = 0.1  # so long it may take to forget that it was homed before [s]
TORQUE_OFF = (State.NOT_READY, State.SWITCH_ON_DISABLED, State.READY_TO_SWITCH_ON, State.SWITCHED_ON, State.FAULT)


@dataclass(frozen=True, slots=True)
class SetPoint:
    """Where to go, and how fast at most."""

    target: int  # [counts]
    speed: int  # [counts/s]
    order: int = 0  # of all that were asked for


@dataclass(slots=True)
class Cia402Controller:
    """What is wanted of a drive, and how far the handshake about it is.

    A set-point is offered by a rising bit, and taken when the drive acknowledges it; only then may the bit fall, and
    only when the acknowledgement has fallen too may the next one be offered.

    >>> controller, enabled = Cia402Controller(), State.OPERATION_ENABLED.bits
    >>> controller.go(100, 50)
    >>> off, on = DriveReport(State.SWITCH_ON_DISABLED.bits), DriveReport(enabled, mode=1)
    >>> hex(controller.word(off)), hex(controller.word(on))
    ('0x6', '0x3f')
    >>> hex(controller.word(DriveReport(enabled | cia402.ACKNOWLEDGED, mode=1))), controller.taken
    ('0xf', True)
    """

    wanted: State = State.QUICK_STOP_ACTIVE  # which enables nothing and resets nothing
    mode: Mode = Mode.PROFILE_POSITION
    halted: bool = False
    resetting: bool = False
    goal: SetPoint | None = None
    taken: bool = False  # the drive has the goal
    offered: SetPoint | None = None  # the bit is up for it
    target: int = 0  # of the set-point that was offered last [counts]

    def go(self, target: int, speed: int) -> None:
        """Go somewhere, in place of where it goes."""
        self._enable(Mode.PROFILE_POSITION)
        self.taken = False
        self.goal = SetPoint(target, speed, self.goal.order + 1 if self.goal else 0)

    def home(self) -> None:
        """Enable and find home."""
        self._enable(Mode.HOMING)
        self.goal, self.offered = None, None

    def halt(self) -> None:
        """Slow down and hold."""
        self.halted, self.goal, self.offered = True, None, None

    def end(self, wanted: State) -> None:
        """Want no motion any more, but to stop and switch off, or to switch off."""
        self.wanted, self.resetting = wanted, False
        self.goal, self.offered, self.mode = None, None, Mode.PROFILE_POSITION

    def rest(self) -> None:
        """Hold where it holds, and stay off where it is off."""
        if self.resetting:
            self.end(State.SWITCH_ON_DISABLED)
        self.halt()

    def reset(self) -> None:
        """Reset a fault; the drive stays off."""
        self.end(State.SWITCH_ON_DISABLED)
        self.resetting = True

    def word(self, report: DriveReport) -> int:
        """Return the controlword that answers a report."""
        state = cia402.state_of(report.status)
        if self.wanted is not State.OPERATION_ENABLED or state is not State.OPERATION_ENABLED:
            self.offered = None
            reset = self.resetting and state is State.FAULT
            return cia402.FAULT_RESET if reset else cia402.controlword(report.status, self.wanted)
        word = cia402.ENABLED | (cia402.HALT if self.halted else 0)
        if report.mode != self.mode:
            return word
        if self.mode is Mode.HOMING:
            return word | cia402.START_HOMING
        self._handshake(bool(report.status & cia402.ACKNOWLEDGED))
        return word | (cia402.NEW_SET_POINT | cia402.AT_ONCE if self.offered else 0)

    def _enable(self, mode: Mode) -> None:
        self.wanted, self.mode, self.halted, self.resetting = State.OPERATION_ENABLED, mode, False, False

    def _handshake(self, acknowledged: bool) -> None:
        if self.offered and acknowledged:
            self.taken = self.goal == self.offered
            self.offered = None
        elif self.goal and not (self.offered or acknowledged or self.taken):
            self.offered, self.target = self.goal, self.goal.target


class DriveDiagnostics:
    """Remembers since when a drive is not as wanted."""

    def __init__(self) -> None:
        self._wanted = State.QUICK_STOP_ACTIVE
        self._since = self._faulty = self._late = self._seeking = math.inf  # [s]
        self._enabled = False  # it has been, since that was wanted

    def trouble(
        self, controller: Cia402Controller, report: DriveReport, emergency: Emergency | None, now: float
    ) -> str:
        """Say what is wrong at ``now`` [s]; empty when all is well or may become so."""
        if controller.wanted is not self._wanted:
            self._wanted, self._since, self._enabled = controller.wanted, now, False
        state = cia402.state_of(report.status)
        if state not in (State.FAULT, State.FAULT_REACTION):
            self._faulty = math.inf
            trouble = self._not_enabled(report, state, now) if controller.wanted is State.OPERATION_ENABLED else ""
            return f"{trouble}; it reports {emergency}" if trouble and emergency else trouble
        self._faulty = min(self._faulty, now)
        why = emergency or "no error code"
        if controller.resetting:
            return f"the drive's fault cannot be reset: {why}" if now >= self._since + ENABLE_TIMEOUT_S else ""
        return f"the drive is in fault: {why}" if emergency or now >= self._faulty + EMERGENCY_TIMEOUT_S else ""

    def homing(self, controller: Cia402Controller, report: DriveReport, now: float) -> Homing:
        """Return how far homing is."""
        if controller.mode is not Mode.HOMING or report.mode != Mode.HOMING:
            self._seeking = math.inf
        elif cia402.state_of(report.status) is State.OPERATION_ENABLED:
            self._seeking = min(self._seeking, now)
            if now >= self._seeking + HOMING_START_S:
                return cia402.homing_of(report.status)
        return Homing.RUNNING

    def _not_enabled(self, report: DriveReport, state: State | None, now: float) -> str:
        if state is State.OPERATION_ENABLED:
            self._enabled = True
            late = report.mode == Mode.PROFILE_POSITION and report.status & cia402.FOLLOWING_ERROR
            self._late = min(self._late, now) if late else math.inf
            too_late = now >= self._late + FOLLOWING_TIMEOUT_S
            return "the drive does not follow: it reports a following error" if too_late else ""
        if self._enabled:
            return f"the drive left 'operation enabled' unexpectedly: {status_text(report)}"
        return f"the drive does not switch on: {status_text(report)}" if now >= self._since + ENABLE_TIMEOUT_S else ""


def status_text(report: DriveReport) -> str:
    """Say what a statusword says.

    >>> status_text(DriveReport(status=0x0040))
    "it is in 'switch on disabled', without voltage at its motor, not under remote control"
    """
    state = cia402.state_of(report.status)
    found = f"it is in '{state.words}'" if state else f"its statusword 0x{report.status:04X} is not a valid one"
    voltage = "" if report.status & cia402.VOLTAGE else ", without voltage at its motor"
    return found + voltage + ("" if report.status & cia402.REMOTE else ", not under remote control")
