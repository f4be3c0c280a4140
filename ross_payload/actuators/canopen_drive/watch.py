"""Whether a drive is in the state that is wanted of it; what is wrong in words."""

from __future__ import annotations

import math

from ross_payload.actuators.canopen_drive.axis import Axis
from ross_payload.actuators.canopen_drive.link import Report
from ross_protocols import cia402
from ross_protocols.canopen import Emergency
from ross_protocols.cia402 import Homing, Mode, State

EXPLAIN = 0.05  # so long a drive may take to say why it is in a fault [s]
BEHIND = 0.2  # so long it may be behind its plan without a fault of its own [s]
ENABLE = 1.0  # so long it may take to switch on, or to be reset [s]
START = 0.1  # so long it may take to forget that it was homed before [s]
OFF = (State.NOT_READY, State.SWITCH_ON_DISABLED, State.READY_TO_SWITCH_ON, State.SWITCHED_ON, State.FAULT)  # no torque


class Watch:
    """Remembers since when a drive is not as wanted."""

    def __init__(self) -> None:
        self._wanted = State.QUICK_STOP_ACTIVE
        self._since = self._faulty = self._late = self._seeking = math.inf  # [s]
        self._enabled = False  # it has been, since that was wanted

    def trouble(self, axis: Axis, report: Report, emergency: Emergency | None, now: float) -> str:
        """Say what is wrong at ``now`` [s]; empty when all is well or may become so."""
        if axis.wanted is not self._wanted:
            self._wanted, self._since, self._enabled = axis.wanted, now, False
        state = cia402.state_of(report.status)
        if state not in (State.FAULT, State.FAULT_REACTION):
            self._faulty = math.inf
            trouble = self._not_enabled(report, state, now) if axis.wanted is State.OPERATION_ENABLED else ""
            return f"{trouble}; it reports {emergency}" if trouble and emergency else trouble
        self._faulty = min(self._faulty, now)
        why = emergency or "no error code"
        if axis.resetting:
            return f"the drive's fault cannot be reset: {why}" if now >= self._since + ENABLE else ""
        return f"the drive is in fault: {why}" if emergency or now >= self._faulty + EXPLAIN else ""

    def homing(self, axis: Axis, report: Report, now: float) -> Homing:
        """Return how far homing is."""
        if axis.mode is not Mode.HOMING or report.mode != Mode.HOMING:
            self._seeking = math.inf
        elif cia402.state_of(report.status) is State.OPERATION_ENABLED:
            self._seeking = min(self._seeking, now)
            if now >= self._seeking + START:
                return cia402.homing_of(report.status)
        return Homing.RUNNING

    def _not_enabled(self, report: Report, state: State | None, now: float) -> str:
        if state is State.OPERATION_ENABLED:
            self._enabled = True
            late = report.mode == Mode.PROFILE_POSITION and report.status & cia402.FOLLOWING_ERROR
            self._late = min(self._late, now) if late else math.inf
            return "the drive does not follow: it reports a following error" if now >= self._late + BEHIND else ""
        if self._enabled:
            return f"the drive left 'operation enabled' unexpectedly: {words(report)}"
        return f"the drive does not switch on: {words(report)}" if now >= self._since + ENABLE else ""


def words(report: Report) -> str:
    """Say what a statusword says.

    >>> words(Report(status=0x0040))
    "it is in 'switch on disabled', without voltage at its motor, not under remote control"
    """
    state = cia402.state_of(report.status)
    found = f"it is in '{state.words}'" if state else f"its statusword 0x{report.status:04X} is not a valid one"
    voltage = "" if report.status & cia402.VOLTAGE else ", without voltage at its motor"
    return found + voltage + ("" if report.status & cia402.REMOTE else ", not under remote control")
