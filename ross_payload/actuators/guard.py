"""Safety's one room: nothing that turns can be opened without this around it.

The guard holds the limits, the caps, the finite check, the maximum move time, the feedback watchdog, the fault action
and the stop latch. Threads: `command`, `home` and `release` belong to the mission's thread, `poll` to the pump;
`stop` and `state` may be called from any thread and from a signal handler, so the latch is a plain attribute (one
atomic assignment, no lock to hold), and who has made a request looks at it again afterwards.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import replace
from types import TracebackType
from typing import Self

from ross_payload import config
from ross_payload.actuators.driver_shell import HELD_UP_S
from ross_payload.actuators.guard_checks import (
    STILL_RAD_S,
    checked_angle,
    checked_rate,
    doubt,
    driver_broke,
    driver_faults,
    guarded,
    judged_at,
    reported,
)
from ross_payload.actuators.motion_monitor import PARKING, MotionMonitor
from ross_payload.errors import (
    PLUGIN_RAISES,
    ActuatorError,
    ActuatorFault,
    ConfigError,
    NotHomed,
    RossError,
    TimeStandsStill,
)
from ross_payload.interfaces import Actuator, ActuatorState, Capabilities, Clock, SharedControl
from ross_payload.plugin_calls import called

TURNS_ON, UNKNOWN = "and it still turns after the stop", "and nobody knows whether it stands"
log = logging.getLogger(__name__)


class Guard:
    """An actuator that obeys limits and stops when in doubt.

    Parameters
    ----------
    actuator : Actuator
        The back end, not yet entered.
    rules : config.Guard
        Limits, caps and the fault action.
    clock : Clock
        Tells how old a report is.
    who : str
        The actuator in words, where a call of its driver does not return.

    Raises
    ------
    ConfigError
        When the hardware's numbers are absurd, the configured limits and the hardware's do not meet, or the hardware
        accelerates beyond the cap.
    """

    def __init__(self, actuator: Actuator, rules: config.Guard, clock: Clock, who: str = "actuator") -> None:
        self._actuator = actuator
        self._who = who
        self._rules = rules
        self._clock = clock
        self._hardware: Capabilities | None = actuator.capabilities
        self.capabilities: Capabilities = guarded(actuator.capabilities, rules)
        self._unfit = ""  # why what the device tells of itself since cannot be used
        self._stopped = False
        self._fault = self._later = ""  # the first fault, and the last of what came on top of it
        self._failed = False  # the fault action is still to be done
        self._polled_at = -math.inf  # [s]
        self._monitor = MotionMonitor(rules)
        self._shared = actuator if isinstance(actuator, SharedControl) else None
        self._held = True  # for a task, as far as the driver knows; False: others may turn it
        self._unbraked = False  # what others turn could not be told of a stop
        self._zero_doubted = False  # the zero that the driver was told is not believed before it is homed

    @property
    def stopped(self) -> bool:
        """Whether a stop is latched."""
        return self._stopped

    @property
    def identity(self) -> str:
        """What the device says of itself; empty when it says nothing, or its driver does not ask."""
        return str(getattr(self._actuator, "identity", ""))

    def command(self, angle: float, rate: float | None = None) -> None:
        """Go to a joint angle [rad], at most at ``rate`` [rad/s]; replaces the goal in flight."""
        self._refuse_when_latched()
        self._update_limits()
        goal, rate = checked_angle(angle, self.capabilities), checked_rate(rate, self.capabilities)
        state = self.state()
        if not state.healthy:
            raise ActuatorFault(f"not moving on bad feedback: {state.fault}")
        if not state.homed:
            raise NotHomed("the zero is not known: home first")
        self._go(goal, rate, state.angle)
        if self._stopped or self._fault:  # another thread stopped between the check and the request
            self._halt()
            self._refuse_when_latched()

    def state(self) -> ActuatorState:
        """Return the last known state; never settled on a report that is stale, unhealthy or older than a request."""
        state = self._read()
        if self._zero_doubted and state.homed:
            state = replace(state, homed=False)
        latched = "; ".join(part for part in (self._fault, self._later) if part)
        fault = latched or state.fault or self._doubt(state)
        if not (fault or state.healthy):
            fault = "the actuator reports a fault"
        settled = state.settled and not fault and state.time > self._monitor.since
        if not fault and settled == state.settled:
            return state
        return replace(state, settled=settled, healthy=not fault, fault=fault)

    def stop(self) -> None:
        """Decelerate to rest, forget the goal and refuse new ones until `rearm`; from any thread; idempotent.

        What others turn is brought to rest, too; they may turn it again.
        """
        self._stopped = True
        self._halt(others=True)
        self._monitor.stopped = True  # by now it is told to come to rest

    def halt(self) -> None:
        """Decelerate to rest and forget the goal; new ones are welcome; from any thread."""
        self._halt()

    def take_control(self) -> None:
        """Hold the actuator for a task where others may turn it otherwise; not while a stop or a fault is latched."""
        if self._shared is None or self._stopped or self._fault:
            return
        self._held = True
        self._monitor.shared = False
        self._of_control(self._shared.take_control)

    def release_control(self) -> None:
        """No task needs the actuator: others may turn it, where there are others; idempotent."""
        if self._shared is None or not self._held or self._monitor.doing:
            return
        if self._of_control(self._shared.release_control):
            self._held = False
            self._monitor.expect_others()

    def doubt_zero(self) -> None:
        """Call the zero unknown until `home`, though the driver was told where it is; the torque stays as it is."""
        self._zero_doubted = True

    def rearm(self) -> None:
        """Accept commands again after a stop or a fault.

        Raises
        ------
        ActuatorFault
            When the actuator itself is still not well; `home` clears a lost position.
        """
        self._fault = self._later = ""
        self._stopped = self._failed = self._unbraked = False
        self._monitor.watch_no_stop()
        state = self.state()
        if not state.healthy:
            self._fault = state.fault
            raise ActuatorFault(f"still at fault: {state.fault}")

    def home(self) -> None:
        """Begin to find (or declare) the zero; also what clears a lost position after a fault.

        The limits are joint angles: with a zero that is declared they move along to wherever the array stands, so
        whoever declares it answers for what is in the way.

        Raises
        ------
        ActuatorFault
            When a stop is latched.
        """
        self._refuse_when_stopped()
        self._monitor.expect_homing()
        self._held = True
        self._request("home", self._actuator.home)
        self._zero_doubted = False
        if self._stopped:
            self._halt()
            self._refuse_when_stopped()

    def release(self) -> None:
        """Remove the torque."""
        self._request("release", self._actuator.release)
        self._monitor.forget()

    def poll(self, now: float) -> None:
        """Poll the actuator and run the watchdog at ``now`` [s]; whatever a driver raises here is a fault."""
        if now - self._polled_at > HELD_UP_S:
            self._monitor.on_pause(now)
        trouble, at_fault = self._polled(now), bool(self._fault)
        turns_on = self._monitor.turns_on(now)
        self._polled_at = now
        if trouble:
            self._latch(trouble)
        elif self._failed:
            self._act(may_park=False)
        if at_fault and turns_on:
            state = self._read()
            turns = abs(state.rate) > STILL_RAD_S and not self._doubt(state)
            self._later = self._later or (TURNS_ON if turns else UNKNOWN)
            self._act(may_park=False)

    def __enter__(self) -> Self:
        """Open the actuator; nothing moves.

        Raises
        ------
        ActuatorFault
            When its driver raises what no driver should.
        """
        with driver_faults():
            called(self._who, "__enter__", self._actuator.__enter__)
        self._monitor.opened = self._clock.now()
        self._update_limits()
        if self._unfit:
            unfit = ConfigError(self._unfit)
            self.__exit__(ConfigError, unfit, None)
            raise unfit
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop and close; idempotent; errors as of `__enter__`, in the log alone where another one is on its way."""
        self._monitor.forget()
        try:
            with driver_faults(TimeStandsStill):
                called(self._who, "__exit__", lambda: self._actuator.__exit__(kind, error, trace))
        except RossError as fault:
            if error is None:
                raise
            log.warning("while closing the actuator: %s", fault)

    # ------------------------------------------------------------------------------------------ requests

    def _refuse_when_latched(self) -> None:
        if self._fault:
            raise ActuatorFault(f"{self._fault}; re-arm first")
        self._refuse_when_stopped()

    def _refuse_when_stopped(self) -> None:
        if self._stopped:
            raise ActuatorFault("stopped: re-arm first")

    def _go(self, goal: float, rate: float, here: float) -> None:
        self._held = True
        self._request("command", lambda: self._actuator.command(goal, rate))
        self._monitor.expect_goal(goal, here, self.capabilities)

    def _request(self, method: str, request: Callable[[], None]) -> None:
        """Send a request so that no report made before it is taken for its answer."""
        self._monitor.expect_request()
        try:
            called(self._who, method, request)
        except ActuatorError:
            self._monitor.request_refused(self._clock.now())
            raise
        except PLUGIN_RAISES as error:
            fault = str(error) if isinstance(error, RossError) else driver_broke(error)
            self._monitor.request_refused(self._clock.now())
            self._latch(fault)
            raise ActuatorFault(fault) from error
        self._monitor.request_sent(self._clock.now())

    def _of_control(self, request: Callable[[], bool | None]) -> bool | None:
        """Take or give control; what a driver raises is a fault."""
        try:
            return request()
        except PLUGIN_RAISES as error:
            self._latch(str(error) if isinstance(error, RossError) else driver_broke(error))
            return None

    def _halt(self, *, others: bool = False) -> None:
        """Decelerate, also what ``others`` turn; never raises: a stop that fails is a fault; `poll` tries it again."""
        try:
            called(self._who, "stop", self._actuator.stop)  # before anything else is asked of it: it may never answer
        except PLUGIN_RAISES as error:
            self._fail("stop", error)
        if self._shared is not None and (others or self._unbraked):
            try:
                self._shared.brake()
                self._unbraked = False
            except PLUGIN_RAISES as error:
                self._unbraked = True
                self._fail("stop", error)
        if self._monitor.busy(self._read()):
            self._monitor.expect_rest(self._clock.now(), self.capabilities)

    # ------------------------------------------------------------------------------------------ reports

    def _read(self) -> ActuatorState:
        try:
            return reported(called(self._who, "state", self._actuator.state))
        except PLUGIN_RAISES as error:
            return ActuatorState(0.0, 0.0, False, homed=False, healthy=False, time=-math.inf, fault=driver_broke(error))

    def _doubt(self, state: ActuatorState) -> str:
        state = self._monitor.believed(state)
        when = judged_at(state, self._polled_at, self._clock.now())
        return self._unfit or doubt(state, when, self._rules.watchdog_s)

    def _update_limits(self) -> None:
        """Take in what a device tells of itself after it was opened."""
        try:
            hardware = self._actuator.capabilities
            if hardware == self._hardware:
                return
            self._hardware = hardware
            self.capabilities, self._unfit = guarded(hardware, self._rules), ""
        except ConfigError as error:
            self._unfit = str(error)
        except PLUGIN_RAISES as error:
            self._hardware, self._unfit = None, driver_broke(error)

    def _polled(self, now: float) -> str:
        """Poll the actuator; say what is wrong while something moves or holds a goal; empty when all is well."""
        try:
            called(self._who, "poll", lambda: self._actuator.poll(now))
            self._update_limits()
            state = reported(called(self._who, "state", self._actuator.state))
        except RossError as error:
            return str(error)
        except PLUGIN_RAISES as error:  # a bug in a driver must not end its polling: it may still be able to decelerate
            return driver_broke(error)
        self._monitor.on_report(state)
        if not self._monitor.busy(state):
            return ""
        return self._monitor.trouble(state, self.capabilities, now) or self._unfit

    # ------------------------------------------------------------------------------------------ the fault action

    def _latch(self, fault: str) -> None:
        """Latch the first fault and act on it; trouble while parking or homing, or an action that failed: act again."""
        first = not self._fault
        if first:
            self._fault = fault
        elif self._monitor.doing:
            self._later = f"while {self._monitor.doing}: {fault}"
        elif not self._failed:
            return
        self._act(may_park=first)

    def _act(self, may_park: bool) -> None:
        """Do what ``on_fault`` says; when that fails hold, and try again at the next poll."""
        self._failed = False
        try:
            if self._rules.on_fault == "release":
                self._monitor.forget()
                self._actuator.release()
            elif self._rules.on_fault == "park" and may_park and self._may_park():
                self._park()
            else:
                self._halt()
        except PLUGIN_RAISES as error:
            self._halt()
            self._fail("fault action", error)

    def _may_park(self) -> bool:
        state = self._read()
        known = state.homed and not self._zero_doubted
        return state.healthy and known and not self._doubt(state) and not self._stopped

    def _park(self) -> None:
        park, able = math.radians(self._rules.park_deg), self.capabilities
        self._go(checked_angle(min(max(park, able.lower), able.upper), able), able.max_speed, self._read().angle)
        self._monitor.doing = PARKING
        if self._stopped:
            self._halt()

    def _fail(self, what: str, error: BaseException) -> None:
        failure = f"the {what} failed: {error if isinstance(error, RossError) else driver_broke(error)}"
        self._failed = True
        self._later = f"and {failure}" if self._fault else ""
        self._fault = self._fault or failure
