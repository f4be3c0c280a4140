"""What a drive is told, given what it says: states, set-points and their handshake, halts, homing. No bus."""

from __future__ import annotations

from dataclasses import dataclass

from ross_payload.actuators.canopen_drive.link import Report
from ross_protocols import cia402
from ross_protocols.cia402 import Mode, State


@dataclass(frozen=True, slots=True)
class SetPoint:
    """Where to go, and how fast at most."""

    target: int  # [counts]
    speed: int  # [counts/s]
    order: int = 0  # of all that were asked for


@dataclass(slots=True)
class Axis:
    """What is wanted of a drive, and how far the handshake about it is.

    A set-point is offered by a rising bit, and taken when the drive acknowledges it; only then may the bit fall, and
    only when the acknowledgement has fallen too may the next one be offered.

    >>> axis, enabled = Axis(), State.OPERATION_ENABLED.bits
    >>> axis.go(100, 50)
    >>> hex(axis.word(Report(State.SWITCH_ON_DISABLED.bits))), hex(axis.word(Report(enabled, mode=1)))
    ('0x6', '0x3f')
    >>> hex(axis.word(Report(enabled | cia402.ACKNOWLEDGED, mode=1))), axis.taken
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

    def word(self, report: Report) -> int:
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
        self._shake_hands(bool(report.status & cia402.ACKNOWLEDGED))
        return word | (cia402.NEW_SET_POINT | cia402.AT_ONCE if self.offered else 0)

    def _enable(self, mode: Mode) -> None:
        self.wanted, self.mode, self.halted, self.resetting = State.OPERATION_ENABLED, mode, False, False

    def _shake_hands(self, acknowledged: bool) -> None:
        if self.offered and acknowledged:
            self.taken = self.goal == self.offered
            self.offered = None
        elif self.goal and not (self.offered or acknowledged or self.taken):
            self.offered, self.target = self.goal, self.goal.target
