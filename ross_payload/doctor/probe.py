"""What a person does first with something new that turns: open it, look at it, and only if asked move it.

Everything goes through the guard. Nothing moves unless homing or a move is asked for, nor what a command has stopped.
Whatever ends the probe, a stop comes first.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

from ross_payload.actuators.guard import Guard
from ross_payload.actuators.mavlink_gimbal.component_port import SCHEME, opener
from ross_payload.actuators.registry import checked_options, open_actuator
from ross_payload.actuators.tb6600.pulse_segments import RECORDING
from ross_payload.clock import SystemClock
from ross_payload.config import Config
from ross_payload.doctor.findings import Finding, fail, ok, warn
from ross_payload.doctor.probe_moves import Figures, Leg, figures, judge, make
from ross_payload.errors import ActuatorError, RossError
from ross_payload.interfaces import ActuatorState, Feedback, Services
from ross_payload.mavlink import Router
from ross_payload.service.runner import POLL_PERIOD_S
from ross_payload.service.state_folder import owned, state_folder, state_path
from ross_payload.service.stop_latch import STOPPED, StopLatch
from ross_payload.service.zero_mark import zero_mark_of
from ross_protocols.angle_text import rotation

FIRST_REPORT_TIMEOUT_S = 5.0  # that an actuator may take to report for the first time [s]
HOMED_TIMEOUT_S = 2.0  # that one that reports may take to know its place: some are told a lot first [s]
IDENTITY_TIMEOUT_S = 0.5  # and to tell after that who it is, if it does at all [s]
REST_S = 2.0  # of looking at it at rest [s]
BRAKING_TIMEOUT_S = 5.0  # that it may take to stand still at the end [s]
MAX_NOISE_RAD = math.radians(0.3)  # at rest: more is worth a word [rad]


@dataclass(frozen=True, slots=True)
class Wishes:
    """What may move."""

    home: bool = False
    move: Callable[[], bool] | None = None  # asked when all is ready to move


@dataclass(slots=True)
class Results:
    """The numbers behind the findings, as far as it came."""

    kind: str = ""
    identity: str = ""
    feedback: str = ""
    report_rate_hz: float = math.nan
    oldest_report_s: float = math.nan
    noise_deg: float = math.nan  # from lowest to highest at rest
    move: Figures | None = None

    def as_values(self) -> dict[str, Any]:
        """Return all of it for JSON; what is not known is None."""
        return dict(_without_nan(asdict(self)))


@contextmanager
def open_services(config: Config) -> Iterator[Services]:
    """Give real time and real wires; the links are opened when the actuator is behind them.

    Raises
    ------
    RossError
        When a payload runs on the state folder, or a link cannot be opened.
    """
    clock = SystemClock()
    used = config.links if getattr(checked_options(config), "port", "") == SCHEME else ()
    with ExitStack() as stack:
        state = state_folder(config) if used else state_path(config)
        stack.enter_context(owned(state))
        links = stack.enter_context(Router.open(used, clock, system_id=config.telemetry.system_id, state=state))
        if used:
            stack.callback(clock.every(POLL_PERIOD_S, links.poll))
        yield Services(clock, opener(links, config.telemetry.component_id, clock))


def probe(config: Config, services: Services, wishes: Wishes, results: Results) -> Generator[Finding]:
    """Open the actuator of a configuration, look at it, move it if that is wished; yield what is found."""
    results.kind = config.actuator.kind
    if (wishes.home or wishes.move is not None) and StopLatch.of(state_path(config)).closed:
        yield fail("stop", STOPPED, "start the payload and re-arm it; without --move and --home it can be looked at")
        return
    try:
        guard = open_actuator(config, services)
    except RossError as error:
        yield fail("open", str(error), "see `ross actuators` and the page of this actuator")
        return
    try:
        with _polled(guard, config, services):
            yield from _examined(guard, config, services, wishes, results)
    except RossError as error:
        yield fail("open", str(error), "wire, power, permission? See the page of this actuator")


def _examined(guard: Guard, config: Config, services: Services, wishes: Wishes, results: Results) -> Iterator[Finding]:
    state = _first_report(guard, services)
    if not state.healthy and not (wishes.home and state.time > -math.inf):
        yield fail("report", state.fault, "wire, power, ids? See 'what happens when' on the page of this actuator")
        return
    _wait_for(lambda: bool(guard.identity), services, IDENTITY_TIMEOUT_S)
    yield from _identified(guard, config, results)
    if wishes.home:
        yield _homed(guard, config, services)
    elif not state.homed:
        yield warn("zero", "its position is unknown", "`--home`, when nothing is in the way; it may turn")
    yield from _at_rest(guard, config, services, results)
    state = guard.state()
    if state.healthy and state.homed and wishes.move is not None and wishes.move():
        yield from _moved(guard, services, results)


@contextmanager
def _polled(guard: Guard, config: Config, services: Services) -> Iterator[None]:
    """Keep a guarded actuator open and polled; at the end it stops and stands still before it is closed.

    Whether it is away from a declared zero is kept for whoever opens it next, and believed of whoever had it before.
    """
    clock = services.clock
    with guard:
        mark = zero_mark_of(config, state_path(config), guard)

        def poll() -> None:
            guard.poll(clock.now())
            if mark is not None:
                mark.look()

        cancel = clock.every(POLL_PERIOD_S, poll)
        try:
            yield
        finally:
            guard.stop()
            end = clock.now() + BRAKING_TIMEOUT_S
            clock.sleep(2 * POLL_PERIOD_S)
            while guard.state().rate and clock.now() < end:
                clock.sleep(POLL_PERIOD_S)
            cancel()
            if mark is not None:
                mark.close()


def _first_report(guard: Guard, services: Services) -> ActuatorState:
    _wait_for(lambda: guard.state().healthy, services, FIRST_REPORT_TIMEOUT_S)
    _wait_for(lambda: guard.state().homed or not guard.state().healthy, services, HOMED_TIMEOUT_S)
    return guard.state()


def _wait_for(true: Callable[[], bool], services: Services, seconds: float) -> None:
    end = services.clock.now() + seconds
    while not true() and services.clock.now() < end:
        services.clock.sleep(POLL_PERIOD_S)


def _identified(guard: Guard, config: Config, results: Results) -> Iterator[Finding]:
    able = guard.capabilities
    results.identity, results.feedback = guard.identity, str(able.feedback)
    yield ok("device", f"{results.kind}: {results.identity or 'it does not identify itself'}")
    if getattr(checked_options(config), "port", "") == RECORDING:
        yield warn("wire", "pulses stay in memory: nothing will turn", "name a wire: options.port")
    lower, upper, speed, acceleration, step = (
        math.degrees(value)
        for value in (able.lower, able.upper, able.max_speed, able.max_acceleration, able.resolution)
    )
    travel = f"{lower:.1f} to {upper:.1f} deg counter-clockwise"  # as guard.lower_deg and upper_deg
    yield ok("limits", f"{travel}, {speed:.4g} deg/s, {acceleration:.4g} deg/s^2")
    yield ok("feedback", f"{able.feedback}, in steps of {step:.3g} deg")


def _homed(guard: Guard, config: Config, services: Services) -> Finding:
    try:
        guard.home()
    except ActuatorError as error:
        return fail("zero", str(error), "see the page of this actuator")
    end = services.clock.now() + config.guard.max_move_s
    while services.clock.now() < end:
        services.clock.sleep(POLL_PERIOD_S)
        state = guard.state()
        if state.homed and state.settled:
            return ok("zero", f"found; the joint is at {rotation(state.angle, 2)}")
    return fail("zero", guard.state().fault or "not found in time", "see the page of this actuator")


def _at_rest(guard: Guard, config: Config, services: Services, results: Results) -> Iterator[Finding]:
    """Look at the reports of something that stands still."""
    clock, reports, ages = services.clock, [guard.state()], [0.0]
    begin = clock.now()
    while clock.now() < begin + REST_S:
        clock.sleep(POLL_PERIOD_S)
        state = guard.state()
        ages.append(clock.now() - state.time)
        if state.time > reports[-1].time:
            reports.append(state)
    state = reports[-1]
    if not guard.state().healthy or len(reports) < 2:
        yield fail("report", guard.state().fault or "no second report", "wire, power?")
        return
    results.oldest_report_s = max(ages)
    results.report_rate_hz = 1 / (sum(b.time - a.time for a, b in pairwise(reports)) / (len(reports) - 1))
    angles = [math.degrees(report.angle) for report in reports]
    results.noise_deg = max(angles) - min(angles)
    rate = f"{results.report_rate_hz:.0f} reports/s, none older than {results.oldest_report_s:.3f} s"
    if results.oldest_report_s > config.guard.watchdog_s / 2:
        yield warn("report", rate, f"raise guard.watchdog_s = {config.guard.watchdog_s:g}, or fix the link")
    else:
        yield ok("report", rate)
    yield _noise(state.angle, results, math.degrees(guard.capabilities.resolution))


def _noise(angle: float, results: Results, step: float) -> Finding:
    if results.feedback == Feedback.MODEL:
        return ok("at rest", f"assumed at {rotation(angle, 2)}; not measured")
    found = f"at {rotation(angle, 2)}, varying by {results.noise_deg:.3g} deg"
    if results.noise_deg > max(math.degrees(MAX_NOISE_RAD), 3 * step):
        return warn("at rest", found, "it hunts, its sensor is noisy, or something turns it")
    return ok("at rest", found)


def _moved(guard: Guard, services: Services, results: Results) -> Iterator[Finding]:
    legs: list[Leg] = []
    trouble = make(guard, services.clock, legs)
    if trouble is not None:
        yield trouble
        return
    results.move = figures(legs)
    yield from judge(results.move, guard.capabilities)


def _without_nan(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_nan(item) for key, item in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value
