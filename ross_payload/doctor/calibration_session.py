"""Turn the array through its guard and listen: the parts of a payload without a mission of its own."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass

from ross_payload.actuators.guard import Guard
from ross_payload.actuators.mavlink_gimbal.component_port import opener
from ross_payload.actuators.registry import open_actuator
from ross_payload.audio.open_source import open_source
from ross_payload.calibration.cross_spectrum import HeadingSpectrum
from ross_payload.clock import SystemClock, synchronised_time
from ross_payload.config import Config
from ross_payload.errors import ActuatorFault, ConfigError, NotHomed
from ross_payload.events import Outcome
from ross_payload.interfaces import AudioSource, Clock, Mount, Services
from ross_payload.mavlink import Router
from ross_payload.mission.calibration_turn import calibration_turn, stepped
from ross_payload.mount import mount_of
from ross_payload.notify import on_signal
from ross_payload.orders import Stop
from ross_payload.service.assemble import settings_of, tools_of
from ross_payload.service.runner import POLL_PERIOD_S, Observer, Runner
from ross_payload.service.state_folder import owned, state_folder
from ross_payload.service.stop_latch import STOPPED, StopLatch
from ross_payload.service.zero_mark import zero_mark_of
from ross_payload.timebase import Timebase

REPORT_TIMEOUT_S = 5.0  # that an actuator may take to report for the first time [s]
SERVER_START_TIMEOUT_S = 10.0  # a simulated world may be started after this
SWITCH_S = 0.001  # after which a thread that computes lets the pump have its turn [s]


@dataclass(frozen=True, slots=True)
class TurnPlan:
    """How far to turn, and how often and how long to listen."""

    angle: float = 2 * math.pi  # [rad]
    headings: int = 12
    seconds: float = 2.0  # at each of them [s]
    home: bool = False  # find or declare the zero first


@dataclass(frozen=True, slots=True)
class Rig:
    """What turns and what hears; both are open."""

    clock: Clock
    actuator: Guard
    source: AudioSource
    mount: Mount


class Stopped(Exception):
    """Somebody has stopped it."""


def turned(rig: Rig, config: Config, plan: TurnPlan, observers: tuple[Observer, ...] = ()) -> list[HeadingSpectrum]:
    """Turn and listen; return what was heard at every heading. The array is at rest again.

    Raises
    ------
    ActuatorError
        When the actuator is in a fault, its zero is not known, or the guard ends the turn.
    Stopped
        When a signal has stopped it.
    """
    _ready(rig, config, home=plan.home)
    able, heard = rig.actuator.capabilities, list[HeadingSpectrum]()
    settings = stepped(settings_of(config, able.lower, able.upper), plan.angle, plan.headings)
    mission = calibration_turn(settings, tools_of(config, None), plan.seconds, heard)
    runner = Runner(mission, rig.source, rig.actuator, rig.mount, config=config, clock=rig.clock)
    runner.observers = list(observers)
    cancel = rig.clock.every(POLL_PERIOD_S, runner.poll)
    try:
        with on_signal(lambda _: runner.order(Stop())):
            result = runner.run()
    finally:
        cancel()
    if result.outcome is Outcome.STOPPED:
        raise Stopped
    if result.outcome is Outcome.FAULT:
        raise ActuatorFault(result.reason)
    return heard


def live(config: Config, plan: TurnPlan, ask: Callable[[], bool]) -> tuple[list[HeadingSpectrum], bool]:
    """Open what a configuration names, turn and listen; return what was heard, and whether in the earth frame.

    ``ask`` is called when all is ready to move.

    Raises
    ------
    RossError
        When a part cannot be opened, or the turn fails.
    Stopped
        When it is not allowed, or stopped.
    """
    if config.audio.source.startswith("file:"):
        raise ConfigError("audio.source: expected microphones, got a file: a recording is read with --recording")
    clock, folder = SystemClock(), state_folder(config)
    sys.setswitchinterval(SWITCH_S)
    with ExitStack() as stack:
        stack.enter_context(owned(folder))
        if StopLatch.of(folder).closed:
            raise ActuatorFault(STOPPED)
        links = Router.open(config.links, clock, system_id=config.telemetry.system_id, state=folder)
        stack.enter_context(links)
        timebase = Timebase(clock, synchronised_time, system_id=config.telemetry.system_id)
        timebase.attach(links.component(config.telemetry.component_id))
        stack.callback(clock.every(POLL_PERIOD_S, links.poll))
        services = Services(clock, opener(links, config.telemetry.component_id, clock))
        actuator = stack.enter_context(open_actuator(config, services))
        mark = zero_mark_of(config, folder, actuator)
        if mark is not None:
            stack.callback(mark.close)
        mount = mount_of(config, clock, links, timebase)
        if not ask():
            raise Stopped
        source: AudioSource = open_source(config, clock, SERVER_START_TIMEOUT_S)
        stack.enter_context(source)
        rig = Rig(clock, actuator, source, mount)
        return turned(rig, config, plan, () if mark is None else (mark,)), rig.mount.attitude(clock.now()).known


def _ready(rig: Rig, config: Config, *, home: bool) -> None:
    """Wait until the actuator has reported, and knows its zero where that is wished."""
    _wait(rig, lambda: rig.actuator.state().healthy, REPORT_TIMEOUT_S)
    state = rig.actuator.state()
    if not state.healthy:
        raise ActuatorFault(state.fault or "the actuator does not report")
    if not state.homed and home:
        rig.actuator.home()
        _wait(rig, lambda: rig.actuator.state().homed and rig.actuator.state().settled, config.guard.max_move_s)
    if not rig.actuator.state().homed:
        raise NotHomed("the zero of the joint is not known: `--home`, when nothing is in the way; it may turn")


def _wait(rig: Rig, done: Callable[[], bool], timeout: float) -> None:
    end = rig.clock.now() + timeout
    rig.actuator.poll(rig.clock.now())
    while not done() and rig.clock.now() < end:
        rig.clock.sleep(POLL_PERIOD_S)
        rig.actuator.poll(rig.clock.now())
