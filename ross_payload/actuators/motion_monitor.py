"""What the guard expects of an actuator since its last request, and what it says when that does not come true."""

from __future__ import annotations

import math
from dataclasses import replace

from ross_payload import config
from ross_payload.actuators.guard_checks import STILL_RAD_S, beyond, doubt
from ross_payload.interfaces import ActuatorState, Capabilities

PARKING, HOMING = "parking", "homing"
TOLD_AGAIN_S = 1.0  # [s] after which a device that does not come to rest is told to once more
UNASKED_S = 0.3  # [s] it may turn after a stop without a fault: a report may be wrong, somebody may bump into it
RUNAWAY_RAD = math.radians(2)  # farther beyond a limit than it was when the goal was given is a runaway, at least [rad]


class MotionMonitor:
    """The last request, by when it must be done, and which reports can be its answer."""

    def __init__(self, rules: config.Guard) -> None:
        self._rules = rules
        self.goal: float | None = None
        self.doing = ""  # what goes on in spite of a fault
        self.since = -math.inf  # reports made before this time know nothing of the last request [s]
        self.opened = math.inf  # [s]; a device that has just been opened gets watchdog_s for its first report
        self._deadline = math.inf  # of the move [s]
        self._rest_by = math.inf  # of the deceleration [s]
        self._room = 0.0  # so far beyond a limit may it be on the way to the goal [rad]
        self.shared = False  # others may turn it: what they do is not ours to watch
        self._well = True  # a report without a fault has come since homing began
        self.stopped = False  # a stop is latched
        self._rested = False  # it has been at rest since the last request
        self._turning_since = math.inf  # in spite of a stop, after it was at rest [s]
        self._settled = False  # it was at rest at its goal by the last report
        self._reported_at = -math.inf  # that [s]
        self._resumed = -math.inf  # when a pause of this program ended that began at rest [s]

    def forget(self) -> None:
        """Expect nothing."""
        self.goal, self.doing = None, ""
        self._rested, self._turning_since = False, math.inf
        self._deadline = self._rest_by = math.inf

    def expect_others(self) -> None:
        """Others may turn it from now on: expect nothing but the end of a deceleration."""
        rest_by = self._rest_by
        self.forget()
        self.shared, self._rest_by = True, rest_by

    def on_pause(self, now: float) -> None:
        """Give what rested at its goal before a pause of this program, over at ``now`` [s], time to report anew."""
        if self._settled and self.goal is not None and self._reported_at > self._resumed:
            self._resumed = now

    def believed(self, state: ActuatorState) -> ActuatorState:
        """Return a report, dated by the end of the pause of this program that it is older than, if any."""
        return replace(state, time=self._resumed) if state.time < self._resumed else state

    def expect_request(self) -> None:
        """Until `request_sent` or `request_refused`, no report can be the answer."""
        self.since = math.inf

    def request_sent(self, now: float) -> None:
        """From ``now`` [s] on, reports can be the answer; it has max_move_s."""
        self.since, self._deadline = now, now + self._rules.max_move_s
        self._settled, self._resumed = False, -math.inf

    def request_refused(self, now: float) -> None:
        """Go on with the last request; what is not begun is not waited for."""
        self.since = now
        if self.doing == HOMING:
            self.doing = ""

    def expect_goal(self, goal: float, here: float, able: Capabilities) -> None:
        """Expect it at ``goal``, and not much farther beyond a limit than ``here``, all [rad]."""
        self._rested, self._turning_since = False, math.inf
        self.goal, self._room = goal, beyond(here, able) + max(RUNAWAY_RAD, able.disturbance)
        self.shared = False
        self.doing, self._rest_by = "", math.inf

    def expect_homing(self) -> None:
        """Expect it homed; a fault that was there before may last a while."""
        self.forget()
        self.shared, self.doing, self._well = False, HOMING, False

    def watch_no_stop(self) -> None:
        """No stop is latched any more: whatever turns has been allowed to."""
        self.stopped, self._turning_since = False, math.inf

    def expect_rest(self, now: float, able: Capabilities) -> None:
        """Expect rest, and a report of it, within twice the time that braking takes and a second."""
        rest_by = min(self._rest_by, now + 2 * able.max_speed / able.max_acceleration + 1.0)
        self.forget()
        self._rest_by = rest_by
        self.since = max(self.since, now)

    def turns_on(self, now: float) -> bool:
        """Whether it was not at rest in time; asked once in `TOLD_AGAIN_S`."""
        late = now > self._rest_by
        if late:
            self._rest_by = now + TOLD_AGAIN_S
        return late

    def busy(self, state: ActuatorState) -> bool:
        """Whether something moves, should move, or holds a goal."""
        moves = bool(state.rate) and not self.shared
        return self.goal is not None or moves or min(self._deadline, self._rest_by) < math.inf

    def on_report(self, state: ActuatorState) -> None:
        """See which expectations a report fulfils."""
        if not state.time > self.since:
            return
        self._settled, self._reported_at = state.settled, state.time
        self._well = self._well or state.healthy
        if abs(state.rate) <= STILL_RAD_S:
            self._rest_by, self._rested, self._turning_since = math.inf, True, math.inf
        elif self.stopped and self._rested and not self.shared:
            self._turning_since = min(self._turning_since, state.time)
        if state.settled and (state.homed or self.doing != HOMING):
            self._deadline, self.doing = math.inf, ""

    def trouble(self, state: ActuatorState, able: Capabilities, now: float) -> str:
        """Say what is wrong at ``now`` [s]; empty when all is well."""
        if (state.fault or not state.healthy) and (self._well or self.doing != HOMING):
            return state.fault or "the actuator reports a fault"
        return self._silence(state, now) or self._lateness(state, now) or self._straying(state, able)

    def _silence(self, state: ActuatorState, now: float) -> str:
        known = max(self.opened, min(self.since, now)) if self.doing == HOMING else self.opened
        state = self.believed(state)
        believed = replace(state, time=known) if state.time < known else state
        return doubt(believed, now, self._rules.watchdog_s)

    def _lateness(self, state: ActuatorState, now: float) -> str:
        if now > self._deadline:
            wanted = "homed" if self.doing == HOMING else "at rest at the goal"
            return f"at {math.degrees(state.angle):.2f} deg, not {wanted} after {self._rules.max_move_s:g} s"
        if now > self._rest_by:
            return f"still turning after a stop, at {math.degrees(state.rate):.1f} deg/s"
        if self.stopped and state.time - self._turning_since > UNASKED_S:
            return f"turning again after a stop, at {math.degrees(state.rate):.1f} deg/s"
        return ""

    def _straying(self, state: ActuatorState, able: Capabilities) -> str:
        if self.goal is None:
            return ""
        if beyond(self.goal, able):
            return f"the goal {math.degrees(self.goal):.2f} deg is outside the travel that the device reports"
        if beyond(state.angle, able) > self._room:
            return f"at {math.degrees(state.angle):.2f} deg, beyond its limits"
        return ""
