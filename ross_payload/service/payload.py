"""The payload that lives: everything that hears, turns, speaks and writes, from start to shutdown.

`ross run` gives it real parts, `ross sitl --serve` simulated ones. Live there are several threads: the audio callback,
what reads the audio, live listening, the pump (drivers, links, telemetry), and the mission, on which `run` is called.
In lock-step there is one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from ross_payload.actuators.guard import Guard
from ross_payload.actuators.registry import open_actuator
from ross_payload.audio.audio_health import HealthMonitor
from ross_payload.audio.live_source import Watched
from ross_payload.audio.shared_source import SharedSource
from ross_payload.config import Config
from ross_payload.config.parameter_store import Parameters
from ross_payload.interfaces import AudioSource, Clock, Mount, Port, Services, VoicePrint
from ross_payload.listening.observers import Listening
from ross_payload.logs import Changes
from ross_payload.mavlink import Router
from ross_payload.mavlink.gimbal import Gimbal
from ross_payload.mavlink.recording_files import Recordings
from ross_payload.mission.live_session import Kit, LiveSession, Make
from ross_payload.mission.tasks import Memory
from ross_payload.orders import Explore, Order, Seek, Set, Task
from ross_payload.service.assemble import settings_of, tools_of
from ross_payload.service.condition import Condition
from ross_payload.service.dronecan_node import Aboard, node_on_bus
from ross_payload.service.health_socket import POLL_S, HealthSocket
from ross_payload.service.live_listening import attached, described, listening_of, source_of
from ross_payload.service.runner import POLL_PERIOD_S, Observer, Runner
from ross_payload.service.stop_latch import StopLatch
from ross_payload.service.voice_keeper import VoiceKeeper
from ross_payload.service.zero_mark import zero_mark_of
from ross_payload.sessions.manifest import Beginning
from ross_payload.sessions.recorder import Recorder
from ross_payload.sessions.session_store import SessionStore
from ross_payload.telemetry.component import Telemetry
from ross_payload.timebase import Timebase
from ross_payload.voiceprint import EmbeddingPrint, VoiceStore
from ross_protocols.mavlink.computer import Computer
from ross_protocols.mavlink.values import Severity

FIRST_REPORT_TIMEOUT_S = 5.0  # [s] that an actuator may take to report for the first time; later it is a fault
LOG_PERIOD_S = 1.0  # [s] between two looks for what the log should tell
FIRST: dict[str, type[Task] | None] = {"nothing": None, "explore": Explore, "seek": Seek}


@dataclass(frozen=True, slots=True)
class Parts:
    """What a payload is made of: the links are open, the source and the actuator are not."""

    clock: Clock
    source: AudioSource
    open_port: Callable[[str], Port]  # the wire of the actuator
    links: Router
    mount: Mount
    timebase: Timebase
    parameters: Parameters
    store: SessionStore  # of the recordings
    drained: Callable[[Recorder], AbstractContextManager[None]]  # has what the recorder queues written
    watched: Watched | None = None  # the source, where it tells how it is
    voiceprint: VoicePrint | None = None
    synthetic: EmbeddingPrint | None = None  # the same, of a target that no person is: recordings keep it
    voices: VoiceStore | None = None  # where voices go that are enrolled on the way; None: they are not kept
    stamp: Callable[[], str] = lambda: ""  # of a new recording
    today: Callable[[], str] | None = None  # by which recordings are too old, '' while that is not sure; None: `stamp`
    live: bool = False  # time is real: the audio is read, and listened to, on threads of their own
    latch: StopLatch | None = None  # what remembers an order to stop over a restart
    state: Path | None = None  # folder of what outlives a restart
    rng: np.random.Generator = field(default_factory=np.random.default_rng)
    computer: Callable[[], Computer] | None = None  # how it is; None: what is said must not depend on the machine
    late: Callable[[], tuple[str, ...]] | None = None  # who makes no progress, for whoever asks; None: nobody can
    restart: Callable[[], None] | None = None  # has this program started again when it ends; None: nobody would
    ended: Callable[[], bool] = lambda: True  # whether it ends for good, and is not started again by itself


@contextmanager
def assembled(parts: Parts, observers: tuple[Observer, ...] = ()) -> Iterator[Runner]:
    """Open everything; the runner that is given runs the session. What watches it beside the payload's own is told.

    Raises
    ------
    RossError
        When a part cannot be opened; those before it are closed again.
    """
    config, clock = parts.parameters.config, parts.clock
    stopped = parts.latch is not None and parts.latch.closed
    with ExitStack() as stack:
        aboard = stack.enter_context(node_on_bus(config, clock, parts.open_port, parts.state, parts.rng))
        actuator = stack.enter_context(open_actuator(config, Services(clock, parts.open_port)))
        source = stack.enter_context(source_of(config, parts.source, parts.watched, live=parts.live))
        recorder, runner = _mission(parts, source, actuator, stopped=stopped)
        monitor = HealthMonitor(config, source if isinstance(source, SharedSource) else parts.watched)
        keeper = stack.enter_context(VoiceKeeper(parts.voices, parts.timebase.utc))
        listening = listening_of(config, clock, runner, recorder, live=parts.live)
        telemetry = stack.enter_context(
            _telemetry(
                parts, actuator, lambda order: runner.order(keeper.named(order)), recorder, monitor, listening=listening
            )
        )
        stack.enter_context(recorder)
        stack.enter_context(parts.drained(recorder))
        component = parts.links.component(config.telemetry.component_id)
        component.tap(lambda frame: recorder.on_frame(parts.timebase.usec(), frame))
        stack.enter_context(attached(listening, source))
        stack.enter_context(described(listening, config))
        runner.observers = [monitor, telemetry, recorder, listening, keeper, *observers]
        stack.callback(clock.every(LOG_PERIOD_S, partial(keeper.poll, partial(telemetry.send_text, Severity.ERROR))))
        if parts.latch is not None:
            runner.observers.append(parts.latch)
        speakers = _speakers(parts, actuator, runner, recorder, telemetry=telemetry, aboard=aboard)
        runner.observers += map(stack.enter_context, speakers)
        stack.callback(clock.every(POLL_PERIOD_S, parts.links.poll))
        stack.callback(clock.every(LOG_PERIOD_S, Changes(parts.links.status, monitor.health, recorder.status).poll))
        runner.observers += stack.enter_context(_asked(parts, monitor, recorder))
        runner.observers += stack.enter_context(_marked(parts, actuator))
        runner.poll()  # before the pump does: an actuator that has not reported yet is a fault at the first hop
        stack.callback(clock.every(POLL_PERIOD_S, runner.poll))
        _wait_for_report(actuator, clock)
        if stopped:
            actuator.stop()
        yield runner


def _mission(parts: Parts, source: AudioSource, actuator: Guard, *, stopped: bool) -> tuple[Recorder, Runner]:
    """Make what records the session and what runs it; the one writes down what the other begins with."""
    config, clock = parts.parameters.config, parts.clock
    recorder = Recorder(
        parts.store, config.recording, lambda: beginning(session, actuator, parts.synthetic), parts.stamp, parts.today
    )
    voiceprint = None if parts.voiceprint is None else recorder.noting(parts.voiceprint)
    memory = Memory(stopped=stopped, starting=True)
    session = LiveSession(config, maker(actuator, voiceprint), memory, recorder.noting)
    first = FIRST[config.service.autostart]
    mission = session.mission(first() if first is not None else None)
    return recorder, Runner(mission, source, actuator, parts.mount, config=config, clock=clock, latch=parts.latch)


@contextmanager
def _asked(parts: Parts, monitor: HealthMonitor, recorder: Recorder) -> Iterator[list[Observer]]:
    """Have the pump answer whoever asks on this computer how the payload is; who watches for that is given."""
    if parts.late is None or parts.state is None:
        yield []
        return
    condition = Condition(parts.late, monitor.health, recorder.status, parts.links.status)
    with HealthSocket(parts.state, condition.values) as wire, ExitStack() as stack:
        stack.callback(parts.clock.every(POLL_S, wire.poll))
        yield [condition]


@contextmanager
def _marked(parts: Parts, actuator: Guard) -> Iterator[list[Observer]]:
    """Remember over a crash that the array is away from a zero that is declared; who watches for that is given."""
    kept = parts.state if parts.live else None
    mark = zero_mark_of(parts.parameters.config, kept, actuator) if kept is not None else None
    if mark is None:
        yield []
        return
    yield [mark]
    if parts.ended():
        mark.forget()


def _wait_for_report(actuator: Guard, clock: Clock) -> None:
    """Give the actuator time to be found and to say where it is, so that a start is no fault."""
    end = clock.now() + FIRST_REPORT_TIMEOUT_S
    while not actuator.state().healthy and clock.now() < end:
        clock.sleep(POLL_PERIOD_S)


def maker(actuator: Guard, voiceprint: VoicePrint | None) -> Make:
    """Return what makes the settings and tools of a task; the travel is the guarded one, told late by some devices."""

    def make(config: Config) -> Kit:
        travel = actuator.capabilities
        return Kit(settings_of(config, travel.lower, travel.upper), tools_of(config, voiceprint))

    return make


def beginning(session: LiveSession, actuator: Guard, synthetic: EmbeddingPrint | None = None) -> Beginning | None:
    """Return what a replay from here must know; None while a task runs.

    ``synthetic`` is the print of the configured target, where no person is it.
    """
    if session.busy:
        return None
    travel, target = actuator.capabilities, session.target
    kept = synthetic if target == session.config.service.target else None  # else somebody was enrolled on the way
    return Beginning(
        "session", session.config, travel.lower, travel.upper, target, memory=session.memory, synthetic=kept
    )


def _speakers(
    parts: Parts, actuator: Guard, runner: Runner, recorder: Recorder, *, telemetry: Telemetry, aboard: Aboard | None
) -> Iterator[AbstractContextManager[Observer]]:
    """Who else speaks for the payload: a gimbal on the links, and our node on a DroneCAN bus."""
    if parts.parameters.config.gimbal.mode != "off":
        yield Gimbal(
            parts.parameters.config,
            parts.clock,
            parts.links,
            actuator,
            parts.mount,
            give=runner.order,
            tap=lambda frame: recorder.on_frame(parts.timebase.usec(), frame),
        )
    if aboard is not None:
        yield aboard.speaking(
            parts.parameters,
            actuator,
            parts.timebase,
            give=runner.order,
            send_text=telemetry.send_text,
            restart=parts.restart,
            sought=parts.voiceprint is not None,
        )


def _telemetry(
    parts: Parts,
    actuator: Guard,
    give: Callable[[Order], None],
    recorder: Recorder,
    monitor: HealthMonitor,
    *,
    listening: Listening,
) -> Telemetry:
    asked = parts.parameters.config.recording
    return Telemetry(
        parts.parameters.config,
        parts.clock,
        parts.links,
        actuator=actuator,
        give=give,
        parameters=parts.parameters,
        changed=lambda name, value: give(Set(name, value)),
        recorder=recorder,
        health=monitor.health,
        computer=parts.computer,
        listening=listening,
        descriptions=listening.descriptions,
        timebase=parts.timebase,
        recordings=Recordings(parts.store.folder, asked.ftp_bytes_s) if asked.offer_ftp else None,
        latch=parts.latch,
        sought=parts.voiceprint is not None,
    )
