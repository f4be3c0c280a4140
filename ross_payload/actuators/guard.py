"""Safety's one room: nothing that turns can be opened without this around it.

The guard holds the limits, the caps, the finite check, the maximum move time, the feedback watchdog, the fault action
and the stop latch. Threads: `command`, `home` and `release` belong to the mission's thread, `poll` to the pump;
`stop` and `state` may be called from any thread and from a signal handler, so the latch is a plain attribute (one
atomic assignment, no lock to hold).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from types import TracebackType
from typing import Self

from ross_payload import config
from ross_payload.errors import ActuatorFault, ConfigError, LimitError, NotHomed, RossError
from ross_payload.interfaces import Actuator, ActuatorState, Capabilities, Clock

SLACK = 1e-9  # [rad], so that a limit itself is inside the limits


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

    Raises
    ------
    ConfigError
        When the configured limits and the hardware's do not meet, or the hardware accelerates beyond the cap.
    """

    def __init__(self, actuator: Actuator, rules: config.Guard, clock: Clock) -> None:
        self._actuator = actuator
        self._rules = rules
        self._clock = clock
        self.capabilities: Capabilities = guarded(actuator.capabilities, rules)
        self._stopped = False
        self._fault = ""
        self._goal: float | None = None
        self._parking = False
        self._since = -math.inf  # reports made before this time know nothing of the last request [s]
        self._deadline = math.inf  # [s]
        self._opened = math.inf  # [s]; a device that has just been opened gets watchdog_s for its first report

    @property
    def stopped(self) -> bool:
        """Whether a stop is latched."""
        return self._stopped

    def command(self, angle: float, rate: float | None = None) -> None:
        """Go to a joint angle [rad], at most at ``rate`` [rad/s]; replaces the goal in flight."""
        self._refuse_when_latched()
        goal, rate = self._checked_angle(angle), self._checked_rate(rate)
        state = self.state()
        if not state.healthy:
            raise ActuatorFault(f"not moving on bad feedback: {state.fault}")
        if not state.homed:
            raise NotHomed("the zero is not known: home first")
        self._request(lambda: self._actuator.command(goal, rate))
        self._goal = goal
        if self._stopped:  # another thread stopped between the check and the request
            self._halt()
            self._refuse_when_latched()

    def state(self) -> ActuatorState:
        """Return the last known state; never settled on a report that is stale, unhealthy or older than the goal."""
        state = self._actuator.state()
        fault = self._fault or state.fault or self._doubt(state, self._clock.now())
        if not (fault or state.healthy):
            fault = "the actuator reports a fault"
        settled = state.settled and not fault and state.time > self._since
        if not fault and settled == state.settled:
            return state
        return replace(state, settled=settled, healthy=not fault, fault=fault)

    def stop(self) -> None:
        """Decelerate to rest, forget the goal and refuse new ones until `rearm`; from any thread; idempotent."""
        self._stopped = True
        self._halt()

    def halt(self) -> None:
        """Decelerate to rest and forget the goal; new ones are welcome."""
        self._halt()

    def rearm(self) -> None:
        """Accept commands again after a stop or a fault.

        Raises
        ------
        ActuatorFault
            When the actuator itself is still not well; `home` clears a lost position.
        """
        self._stopped, self._fault, self._parking = False, "", False
        state = self.state()
        if not state.healthy:
            self._fault = state.fault
            raise ActuatorFault(f"still not well: {state.fault}")

    def home(self) -> None:
        """Begin to find (or declare) the zero; also what clears a lost position after a fault.

        The limits are joint angles: with a zero that is declared they move along to wherever the array stands, so
        whoever declares it answers for what is in the way.

        Raises
        ------
        ActuatorFault
            When a stop is latched.
        """
        if self._stopped:
            raise ActuatorFault("stopped: re-arm first")
        self._goal = None
        self._request(self._actuator.home)

    def release(self) -> None:
        """Remove the torque."""
        self._goal, self._deadline = None, math.inf
        self._actuator.release()

    def poll(self, now: float) -> None:
        """Poll the actuator and run the watchdog at ``now`` [s]; whatever a driver raises here is a fault."""
        try:
            self._actuator.poll(now)
        except RossError as error:
            self._latch(str(error))
            return
        except Exception as error:  # a bug in a driver must not end its polling: it may still be able to decelerate
            self._latch(f"the driver broke: {error!r}")
            return
        state = self._actuator.state()
        if self._arrived(state):
            self._deadline = math.inf
        trouble = self._trouble(state, now)
        if trouble:
            self._latch(trouble)

    def __enter__(self) -> Self:
        """Open the actuator; nothing moves."""
        self._actuator.__enter__()
        self._opened = self._clock.now()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop and close; idempotent."""
        self._goal, self._deadline = None, math.inf
        self._actuator.__exit__(kind, error, trace)

    # ------------------------------------------------------------------------------------------ requests

    def _refuse_when_latched(self) -> None:
        if self._fault:
            raise ActuatorFault(f"{self._fault}; re-arm first")
        if self._stopped:
            raise ActuatorFault("stopped: re-arm first")

    def _checked_angle(self, angle: float) -> float:
        lower, upper = self.capabilities.lower, self.capabilities.upper
        if not lower - SLACK <= angle <= upper + SLACK or math.isinf(angle):
            found, low, high = (f"{math.degrees(value):.2f}" for value in (angle, lower, upper))
            raise LimitError(f"goal {found} deg is not within {low} to {high} deg")
        half = self.capabilities.resolution / 2  # so that rounding to a step does not pass a limit
        return min(max(angle, lower + half), upper - half)

    def _checked_rate(self, rate: float | None) -> float:
        if rate is None:
            return self.capabilities.max_speed
        if not (math.isfinite(rate) and rate > 0):
            raise LimitError(f"rate {rate} rad/s is not above 0 and finite")
        return min(rate, self.capabilities.max_speed)

    def _request(self, request: Callable[[], None]) -> None:
        """Send a request so that no report made before it is taken for its answer."""
        self._since = math.inf
        try:
            request()
        finally:
            self._since = self._clock.now()
        self._deadline = self._since + self._rules.max_move_s

    def _halt(self) -> None:
        self._goal, self._deadline, self._parking = None, math.inf, False
        self._actuator.stop()

    # ------------------------------------------------------------------------------------------ doubts

    def _arrived(self, state: ActuatorState) -> bool:
        return state.settled and state.time > self._since

    def _doubt(self, state: ActuatorState, now: float) -> str:
        age = now - state.time
        if math.isinf(age):
            return "no report yet"
        return f"no report for {age:.2f} s" if age > self._rules.watchdog_s else ""

    def _trouble(self, state: ActuatorState, now: float) -> str:
        """Say what is wrong while something moves or holds a goal; empty when all is well."""
        if self._goal is None and not state.rate and self._deadline == math.inf:
            return ""
        if state.fault or not state.healthy:
            return state.fault or "the actuator reports a fault"
        if now > self._deadline:
            return f"at {math.degrees(state.angle):.2f} deg, not at rest at the goal after {self._rules.max_move_s:g} s"
        return self._doubt(replace(state, time=max(state.time, self._opened)), now)

    def _latch(self, fault: str) -> None:
        """Latch the first fault and act on it; trouble while parking ends the parking."""
        if self._fault and not self._parking:
            return
        first, was_parking = not self._fault, self._parking
        self._fault = fault if first else f"{self._fault}; while parking: {fault}"
        state = self._actuator.state()
        sure = state.healthy and state.homed and not self._doubt(state, self._clock.now())
        try:
            if self._rules.on_fault == "release":
                self._goal, self._deadline = None, math.inf
                self._actuator.release()
            elif self._rules.on_fault == "park" and sure and not was_parking and not self._stopped:
                self._park()
            else:
                self._halt()
        except RossError as error:
            self._goal, self._deadline, self._parking = None, math.inf, False
            self._fault += f"; and the fault action failed: {error}"

    def _park(self) -> None:
        park = math.radians(self._rules.park_deg)
        goal = self._checked_angle(min(max(park, self.capabilities.lower), self.capabilities.upper))
        self._request(lambda: self._actuator.command(goal, self.capabilities.max_speed))
        self._goal, self._parking = goal, True
        if self._stopped:
            self._halt()


def guarded(hardware: Capabilities, rules: config.Guard) -> Capabilities:
    """Intersect what the hardware can do with what the configuration allows.

    Raises
    ------
    ConfigError
        When the travels do not meet or the hardware cannot be kept below the acceleration.
    """
    lower = max(hardware.lower, math.radians(rules.lower_deg))
    upper = min(hardware.upper, math.radians(rules.upper_deg))
    if lower >= upper:
        found = f"{rules.lower_deg:g} to {rules.upper_deg:g} deg"
        has = f"{math.degrees(hardware.lower):g} to {math.degrees(hardware.upper):g} deg"
        raise ConfigError(f"guard: the limits {found} exclude all of the actuator's travel {has}")
    cap = math.radians(rules.max_acceleration_deg_s2)
    if hardware.max_acceleration > cap * (1 + 1e-9):
        found = f"{math.degrees(hardware.max_acceleration):g}"
        raise ConfigError(
            f"guard: the actuator accelerates at {found} deg/s^2, above the cap of {rules.max_acceleration_deg_s2:g}"
        )
    return replace(
        hardware,
        lower=lower,
        upper=upper,
        max_speed=min(hardware.max_speed, math.radians(rules.max_speed_deg_s)),
        continuous=hardware.continuous and math.isinf(lower) and math.isinf(upper),
    )
