"""``ross run``: the payload on real wires, from a file to the shutdown."""

from __future__ import annotations

import logging
import math
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from datetime import datetime
from functools import partial

import numpy as np

from ross_payload import __version__
from ross_payload.actuators.mavlink_gimbal.component_port import opener
from ross_payload.audio.open_source import open_source
from ross_payload.bounded_files import set_aside
from ross_payload.clock import RetryingOpener, SystemClock, synchronised_time, system_time
from ross_payload.computing import computing
from ross_payload.config import Config
from ross_payload.config.parameter_store import Parameters
from ross_payload.dronecan.shared_bus import SharedBuses
from ross_payload.end_signals import PASSED_ON_S
from ross_payload.errors import AudioEnded
from ross_payload.events import Event
from ross_payload.interfaces import Input, VoicePrint
from ross_payload.logs import LogObserver, logging_to
from ross_payload.mavlink import Router
from ross_payload.mount import mount_of
from ross_payload.notify import MISSION, Manager, Watchdog, beside, hearing_signals, on_signal
from ross_payload.orders import Shutdown, Stop
from ross_payload.plugin_calls import LateCalls, telling_late_calls
from ross_payload.program_end import end_within
from ross_payload.service.check import check_settable
from ross_payload.service.payload import Parts, assembled
from ross_payload.service.runner import POLL_PERIOD_S, Runner
from ross_payload.service.state_folder import owned, recording_path, state_folder
from ross_payload.service.stop_latch import StopLatch
from ross_payload.sessions.recorder import in_background
from ross_payload.sessions.session_store import STAMP, SessionStore
from ross_payload.telemetry.computer import ComputerReader
from ross_payload.timebase import Timebase
from ross_payload.voiceprint import VoiceStore
from ross_payload.voiceprint.features import at_rate
from ross_payload.voiceprint.model_folder import ModelFolder
from ross_payload.voiceprint.store import Damaged

END_S = 60.0  # after a signal to end; systemd gives less (TimeoutStopSec)
COMPUTE_LIMIT = 2.0  # of the audio that can wait: so long the mission may compute without hearing a hop
SERVER_START_TIMEOUT_S = 10.0  # a simulated world or a CAN server may be started after the payload
AGAIN = 75  # exit code: start me again; EX_TEMPFAIL of sysexits.h
SWITCH_INTERVAL_S = 0.001  # [s] after which a thread that computes lets the pump have its turn

log = logging.getLogger(__name__)


def live(config: Config) -> int:
    """Run the payload until SIGINT, SIGTERM, a restart or the end of its audio; return the exit code.

    Raises
    ------
    RossError
        When a part cannot be opened.
    """
    with ExitStack() as signals, ExitStack() as stack:
        stack.enter_context(logging_to(sys.stderr, config.service.log_level, config.service.log_format))
        calls = stack.enter_context(telling_late_calls())
        stack.enter_context(owned(state_folder(config)))
        stack.enter_context(computing(threads=1))  # the mission has a thread of its own
        sys.setswitchinterval(SWITCH_INTERVAL_S)
        clock, manager = SystemClock(), Manager.of()
        watchdog = Watchdog(manager, clock, {MISSION: COMPUTE_LIMIT * config.audio.buffer_s})
        latch = StopLatch.of(state_folder(config))
        stack.callback(latch.close)
        again = threading.Event()  # somebody has asked for a restart; asked on the pump, read when all is over
        parts = stack.enter_context(_parts(config, clock, latch, partial(_late, watchdog, calls), again))
        pumping = Pumping(clock)
        runner = stack.enter_context(assembled(parts, (LogObserver(), watchdog, pumping)))
        stack.callback(clock.every(POLL_PERIOD_S, lambda: pumping.poll(runner)))
        cancel = watchdog.start()
        if cancel is not None:
            stack.callback(cancel)
        log.info("ross %s: %s on %s", __version__, config.actuator.kind, config.audio.source)
        manager.ready("idle")
        _run(runner, clock, manager, watchdog, calls, signals=signals)
    return AGAIN if again.is_set() else 0


class Pumping:
    """An observer that ends the mission when a call of the pump has died; before that the motor decelerates."""

    def __init__(self, clock: SystemClock) -> None:
        self._clock = clock
        self._stopped = False

    def poll(self, runner: Runner) -> None:
        """Stop the motor, on the pump: the mission's thread may be computing for seconds."""
        if not self._stopped and self._clock.failed:
            self._stopped = True
            runner.order(Stop())

    def on_input(self, hop: Input) -> None:
        """Look at the pump."""
        self._clock.check()

    def on_event(self, event: Event, hop: Input) -> None:
        """Events say nothing about the pump."""


@contextmanager
def _parts(
    config: Config, clock: SystemClock, latch: StopLatch, late: Callable[[], tuple[str, ...]], again: threading.Event
) -> Iterator[Parts]:
    state = state_folder(config)
    with ExitStack() as stack:
        parameters = stack.enter_context(Parameters(config, state / "params.toml", check_settable))
        for note in parameters.notes:
            log.warning(note)
        links = Router.open(config.links, clock, system_id=config.telemetry.system_id, state=state, patient=True)
        stack.enter_context(links)
        timebase = Timebase(clock, synchronised_time, system_time, system_id=config.telemetry.system_id)
        timebase.attach(links.component(config.telemetry.component_id))
        source = open_source(config, clock, SERVER_START_TIMEOUT_S)
        wires = RetryingOpener(opener(links, config.telemetry.component_id, clock), clock, SERVER_START_TIMEOUT_S)
        store = SessionStore(recording_path(config))
        for note in store.set_damaged_aside():
            log.warning(note)
        yield Parts(
            clock=clock,
            source=source,
            watched=source,
            open_port=SharedBuses(wires, clock).open,
            links=links,
            mount=mount_of(config, clock, links, timebase),
            timebase=timebase,
            parameters=parameters,
            store=store,
            drained=in_background,
            voiceprint=_enrolled(config),
            voices=VoiceStore.default(),
            latch=latch,
            state=state,
            computer=ComputerReader(store.folder),
            live=True,
            late=late,
            restart=again.set,
            ended=lambda: not again.is_set(),
            stamp=lambda: _stamp(timebase.utc()),
            today=lambda: _stamp(timebase.sure_utc()),
        )


def _late(watchdog: Watchdog, calls: LateCalls) -> tuple[str, ...]:
    """Return who makes no progress, and what it may be waiting for."""
    late = watchdog.late()
    return late + calls.in_words() if late else ()


def _waits_for(calls: LateCalls) -> tuple[str, ...]:
    """Return what an end that does not come waits for: calls of plug-ins, or what else the mission does; or neither."""
    running = any(thread.name == MISSION for thread in threading.enumerate())
    return calls.in_words() or (("the mission",) if running else ())


def _stamp(now: datetime | None) -> str:
    return "" if now is None else f"{now:{STAMP}}"


def _enrolled(config: Config) -> VoicePrint | None:
    if not config.service.target:
        return None
    store = VoiceStore.default()
    try:
        voice = store.load(config.service.target, ModelFolder.default().in_use(config.voice_print.model))
    except Damaged as error:  # whoever flies it can still turn, listen and stop
        where = set_aside(store.path(config.service.target), "unreadable")
        log.error("%s; %s; there is no target until the voice is enrolled again", error, where)
        return None
    at_rate(np.zeros(1), config.audio.rate_hz)  # what resampling needs is loaded now, not while something turns
    return voice


def _run(
    runner: Runner, clock: SystemClock, manager: Manager, watchdog: Watchdog, calls: LateCalls, *, signals: ExitStack
) -> None:
    """Run the mission on a thread of its own, so that this one hears signals at once, whatever is computed.

    Ctrl-C and SIGTERM are an orderly shutdown: the motor decelerates before anything else. What then does not end, as
    a disk that hangs, is given up after `END_S`. What is passed on of a signal interrupts nothing, nor what is closed
    until the end of ``signals``.

    Raises
    ------
    KeyboardInterrupt
        When a signal comes again, `PASSED_ON_S` after the first, and the mission has heard nothing for as long: it may
        never hear of the first, for a plug-in computes for ever, and its thread ends with the process.
    """
    asked, over = math.inf, False  # when a signal came [s]; whether the mission has ended
    limit = end_within(END_S, 1, partial(_waits_for, calls))

    def shut_down(name: str) -> None:
        nonlocal asked
        now = clock.now()
        if asked == math.inf:
            asked = now
            limit()  # before a driver is asked, which may never answer
        elif min(now - asked, watchdog.silent(MISSION)) > PASSED_ON_S:
            asked = now
            raise KeyboardInterrupt
        if not over:
            runner.order(Shutdown())
        manager.stopping(name)

    signals.enter_context(on_signal(shut_down))
    try:
        result = hearing_signals(beside(runner.run, MISSION))
    except AudioEnded as ended:
        log.info("%s", ended)
    except OSError as error:  # nobody's input any more
        raise RuntimeError(f"a fault in flight: {error}") from error
    else:
        log.info("%s", result.reason)
    finally:
        over = True
