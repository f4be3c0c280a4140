"""What the guard asks of capabilities, goals and reports; pure functions."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from numbers import Real
from typing import Any, TypeGuard

import numpy as np

from ross_payload import config
from ross_payload.errors import PLUGIN_RAISES, ActuatorFault, ConfigError, LimitError, RossError
from ross_payload.interfaces import ActuatorState, Capabilities

LIMIT_TOLERANCE_RAD = 1e-9  # [rad], so that a limit itself is inside the limits
MAX_AHEAD_S = 0.05  # a report may be so far ahead of the clock [s]
PATIENCE_S = 2.0  # without a poll: so long no report grows stale
STILL_RAD_S = math.radians(2)  # slower is at rest [rad/s]
SLOWEST_RAD_S = 1e-6  # least speed that is one: a radian in 12 days [rad/s]


def guarded(hardware: Capabilities, rules: config.Guard) -> Capabilities:
    """Intersect what the hardware can do with what the configuration allows.

    Raises
    ------
    ConfigError
        When the hardware's numbers are absurd, the travels do not meet, nothing would move, or it cannot be kept below
        the acceleration.
    """
    _check_sanity(hardware)
    lower = max(hardware.lower, math.radians(rules.lower_deg))
    upper = min(hardware.upper, math.radians(rules.upper_deg))
    if lower >= upper:
        found = f"{rules.lower_deg:g} to {rules.upper_deg:g} deg"
        has = f"{math.degrees(hardware.lower):g} to {math.degrees(hardware.upper):g} deg"
        raise ConfigError(f"guard: expected limits that meet the actuator's travel {has}, got {found}")
    if hardware.resolution >= upper - lower:
        found = f"{math.degrees(hardware.resolution):g} deg"
        raise ConfigError(f"guard: expected limits farther apart than one step of the actuator, got a step of {found}")
    cap = math.radians(rules.max_acceleration_deg_s2)
    if hardware.max_acceleration > cap * (1 + 1e-9):
        found = f"{math.degrees(hardware.max_acceleration):g}"
        raise ConfigError(
            f"guard.max_acceleration_deg_s2: expected an actuator with at most {rules.max_acceleration_deg_s2:g}, "
            f"got one with {found} deg/s^2"
        )
    speed = min(hardware.max_speed, math.radians(rules.max_speed_deg_s))
    if speed < SLOWEST_RAD_S:
        raise ConfigError(f"guard: expected a speed of at least {SLOWEST_RAD_S:g} rad/s, got {speed:g}")
    return replace(
        hardware,
        lower=lower,
        upper=upper,
        max_speed=speed,
        continuous=hardware.continuous and math.isinf(lower) and math.isinf(upper),
    )


def _check_sanity(hardware: Capabilities) -> None:
    named = {"speed": hardware.max_speed, "acceleration": hardware.max_acceleration, "resolution": hardware.resolution}
    for name, value in named.items():
        if not (math.isfinite(value) and value > 0):
            raise ConfigError(f"guard: expected the actuator's {name} to be finite and above 0, got {value:g}")
    if not 0 <= hardware.disturbance < math.inf:
        found = f"{hardware.disturbance:g}"
        raise ConfigError(f"guard: expected the actuator's disturbance to be finite and not negative, got {found}")
    if not hardware.lower < hardware.upper:  # NaN is not either
        has = f"{math.degrees(hardware.lower):g} to {math.degrees(hardware.upper):g} deg"
        raise ConfigError(f"guard: expected the lower limit of the actuator's travel first, got {has}")


def checked_angle(angle: float, able: Capabilities) -> float:
    """Return a goal [rad], half a step inside the limits so that rounding to a step does not pass them.

    Raises
    ------
    LimitError
        When it lies outside the limits or is not finite.
    """
    if not able.lower - LIMIT_TOLERANCE_RAD <= angle <= able.upper + LIMIT_TOLERANCE_RAD or math.isinf(angle):
        found, low, high = (f"{math.degrees(value):.2f}" for value in (angle, able.lower, able.upper))
        raise LimitError(f"goal: expected {low} to {high} deg, got {found} deg")
    half = able.resolution / 2
    return min(max(angle, able.lower + half), able.upper - half)


def checked_rate(rate: float | None, able: Capabilities) -> float:
    """Return a rate [rad/s], at most what is allowed; None: as fast as allowed.

    Raises
    ------
    LimitError
        When it is too slow to be one, or not finite.
    """
    if rate is None:
        return able.max_speed
    if not SLOWEST_RAD_S <= rate < math.inf:
        raise LimitError(f"rate: expected at least {SLOWEST_RAD_S:g} rad/s and finite, got {rate:g}")
    return min(rate, able.max_speed)


def beyond(angle: float, able: Capabilities) -> float:
    """How far an angle lies outside the limits [rad]; 0 inside.

    >>> from ross_payload.interfaces import Feedback
    >>> beyond(3.0, Capabilities(-2.0, 2.0, 1.0, 1.0, 0.1, False, Feedback.MEASURED))
    1.0
    """
    return max(able.lower - angle, angle - able.upper, 0.0)


def doubt(state: ActuatorState, now: float, watchdog: float) -> str:
    """Say why a report cannot be believed at ``now`` [s]; empty when it can."""
    if not math.isfinite(state.angle):
        return f"the actuator reports an angle of {state.angle}"
    if not math.isfinite(state.rate):
        return f"the actuator reports a rate of {state.rate}"
    age = now - state.time
    if age == math.inf:
        return "no report yet"
    if not age >= -MAX_AHEAD_S:  # NaN is not either
        return f"the time of the last report is {-age:.2f} s ahead of the clock"
    return f"no report for {age:.2f} s" if age > watchdog else ""


def judged_at(state: ActuatorState, polled: float, now: float) -> float:
    """Return when the age of a report is to be judged [s]: what was fresh when polled for is until the next poll.

    After a pause of the whole computer somebody may ask before the pump has looked what arrived meanwhile.

    >>> judged_at(ActuatorState(0.0, 0.0, True, True, True, time=7.0), polled=7.0, now=8.5)
    7.0
    """
    return now if state.time > polled else max(polled, now - PATIENCE_S)


def driver_broke(error: BaseException) -> str:
    """Say that a driver has raised what no driver should.

    >>> driver_broke(ZeroDivisionError("by zero"))
    "the driver broke: ZeroDivisionError('by zero')"
    """
    return f"the driver broke: {error!r}"


def reported(state: Any) -> ActuatorState:
    """Return what a driver reports, in Python's own numbers.

    Raises
    ------
    TypeError
        When it is no `ActuatorState`, or one of its values has another type; says which.

    Examples
    --------
    >>> reported(ActuatorState(1, 0.0, True, True, True, time=7.0)).angle
    1.0
    """
    if _is_plain(state):
        return state
    if not isinstance(state, ActuatorState):
        raise TypeError(f"expected a state of type ActuatorState, got {type(state).__name__}")
    numbers = {"angle": state.angle, "rate": state.rate, "time": state.time}
    truths = {"settled": state.settled, "homed": state.homed, "healthy": state.healthy}
    for kind, wanted, named in (((bool, np.bool_), "true or false", truths), (Real, "a number", numbers)):
        for name, value in named.items():
            if not isinstance(value, kind):
                raise TypeError(f"expected {wanted} as {name}, got {value!r}")
    if not isinstance(state.fault, str):
        raise TypeError(f"expected a text as fault, got {state.fault!r}")
    values: dict[str, Any] = {name: float(n) for name, n in numbers.items()}
    values |= {name: bool(t) for name, t in truths.items()}
    return replace(state, **values)


def _is_plain(state: Any) -> TypeGuard[ActuatorState]:
    """Whether a report has Python's own values already, as nearly always."""
    return (
        type(state) is ActuatorState
        and type(state.angle) is type(state.rate) is type(state.time) is float
        and type(state.settled) is type(state.homed) is type(state.healthy) is bool
        and type(state.fault) is str
    )


@contextmanager
def driver_faults(*others: type[Exception]) -> Iterator[None]:
    """Make an ActuatorFault of whatever a driver raises that no driver should; ``others`` are left alone.

    Raises
    ------
    ActuatorFault
        With what was raised.
    """
    try:
        yield
    except PLUGIN_RAISES as error:
        if isinstance(error, (RossError, *others)):
            raise
        raise ActuatorFault(driver_broke(error)) from error
