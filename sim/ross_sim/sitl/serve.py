"""``ross sitl --serve``: the living payload in a simulated room, on real sockets, until it is told to go.

Its threads are those of `ross run`: the pump moves simulated time on, with far ends, drivers, links and telemetry; what
reads the audio renders the room; live listening, the mission and the recorder have threads of their own. As fast as
the computer can (`--speed max`) there is no real time: then it is one thread, in lock-step.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack, nullcontext
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Self

import numpy as np

from ross_payload.actuators.registry import checked_options
from ross_payload.actuators.wires import open_wire
from ross_payload.clock import SystemClock
from ross_payload.computing import computing
from ross_payload.config import Config, Link
from ross_payload.config.parameter_store import Parameters
from ross_payload.dronecan.shared_bus import SharedBuses
from ross_payload.end_signals import PASSED_ON_S
from ross_payload.interfaces import Clock, Input, Port
from ross_payload.listening.observers import Listening
from ross_payload.mavlink import Router
from ross_payload.notify import MISSION, beside, hearing_signals, on_signal
from ross_payload.orders import Shutdown
from ross_payload.service.check import check_settable
from ross_payload.service.live import SWITCH_INTERVAL_S
from ross_payload.service.payload import Parts, assembled
from ross_payload.service.runner import Observer, Runner
from ross_payload.sessions.recorder import in_background
from ross_payload.sessions.session_store import SessionStore
from ross_payload.telemetry.computer import ComputerReader
from ross_payload.voiceprint import VoiceStore
from ross_sim.clock import QUANTUM, SimClock
from ross_sim.devices.far_end import FarEnd
from ross_sim.live_world.world_loop import STRETCH
from ross_sim.paced_clock import RealTimeClock
from ross_sim.scenario import Scenario
from ross_sim.sitl.ground_truth import TruthWriter, facts
from ross_sim.sitl.mission_session import aboard, stopping
from ross_sim.sitl.mission_view import MissionView
from ross_sim.sitl.pace import ListenedSpeed, Pace
from ross_sim.sitl.recording import drained
from ross_sim.sitl.results_folder import ResultsFolder
from ross_sim.sitl.talker_selection import TalkerSelection
from ross_sim.sitl.world import World

GROUND_STATION = "udpout:127.0.0.1:14550"  # where ground stations listen, `ross ground` and `ross monitor` among them


def serve(
    scenario: Scenario,
    company: TalkerSelection,
    view: MissionView,
    *,
    out: ResultsFolder | None,
    speed: float | None,
    recordings: Path,
    always: bool,
) -> None:
    """Live until SIGINT or SIGTERM; nothing turns before somebody orders it.

    Parameters
    ----------
    out
        Folder for the truth.
    speed
        Times real time; None: as fast as the computer can.
    recordings
        Folder that keeps what is recorded.
    always
        Record from start to end, not only on request.
    """
    scenario = _adapted(scenario, company, always=always)
    with ExitStack() as signals, ExitStack() as stack, computing(threads=1):  # the mission has a thread of its own
        cast, asked = scenario.cast(company.voices), ListenedSpeed(speed)
        far_end, simulated = scenario.far_end(), SimClock()
        clock = RealTimeClock(simulated, asked, scenario.payload.audio.buffer_s / 2) if speed else simulated
        waiting = (lambda: clock.sleep(QUANTUM)) if speed else None
        world = World(scenario, cast.talkers, far_end, simulated, scenario.payload.seed, wait=waiting)
        parts = _parts(scenario, company, world, clock, far_end=far_end, recordings=recordings, stack=stack)
        truth = stack.enter_context(TruthWriter(out, world.rate, len(cast.talkers)))
        observers: list[Observer] = [view, GroundTruthObserver(world, truth)]
        hearing: AbstractContextManager[object] = nullcontext()
        if isinstance(clock, RealTimeClock):
            observers.append(hearing := MissionProgress(clock))
            stack.callback(sys.setswitchinterval, sys.getswitchinterval())
            sys.setswitchinterval(SWITCH_INTERVAL_S)
            stack.enter_context(clock)
        else:
            observers.append(Pace(asked))
        with assembled(parts, tuple(observers)) as runner, hearing:
            asked.streams = next(one.streams for one in runner.observers if isinstance(one, Listening))
            _run(runner, signals)
        truth.write(world.drain())
        truth.finish(facts(scenario, cast) | {"complaints": far_end.complaints()}, scenario)


def _run(runner: Runner, signals: ExitStack) -> None:
    """Run the mission on a thread of its own, so that this one hears signals at once.

    What is passed on of a signal interrupts nothing, nor what is written until the end of ``signals``.

    Raises
    ------
    KeyboardInterrupt
        When a signal comes later, before the payload has shut down; its thread ends with the process then.
    """
    signals.enter_context(on_signal(stopping(runner, SystemClock(), Shutdown(), PASSED_ON_S)))
    hearing_signals(beside(runner.run, MISSION))


class MissionProgress(MissionView):
    """Tells a clock in real time how far the mission has heard: it waits rather than lose what is heard.

    As a context manager it lets time go on in the end, when nobody hears: what is left to say needs some to be sent.
    """

    def __init__(self, clock: RealTimeClock) -> None:
        self._clock = clock

    def on_input(self, hop: Input) -> None:
        """Tell it."""
        self._clock.on_progress(hop.block.time)

    def __enter__(self) -> Self:
        """Hear."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Hear no more."""
        self._clock.on_progress(math.inf)


def linked(scenario: Scenario) -> Scenario:
    """Return the scenario with a link: to `GROUND_STATION` unless it has one, since nobody could command it."""
    if scenario.payload.links:
        return scenario
    payload = scenario.payload.model_copy(update={"links": (Link(url=GROUND_STATION),)})
    return scenario.model_copy(update={"payload": payload})


def _adapted(scenario: Scenario, company: TalkerSelection, *, always: bool) -> Scenario:
    """The scenario with a payload that seeks the target, and records from start to end when ``always``."""
    config = scenario.payload
    service = config.service.model_copy(update={"target": company.target})
    recording = config.recording.model_copy(update={"always": always})
    return scenario.model_copy(
        update={"payload": config.model_copy(update={"service": service, "recording": recording})}
    )


def _parts(
    scenario: Scenario,
    company: TalkerSelection,
    world: World,
    clock: Clock,
    *,
    far_end: FarEnd,
    recordings: Path,
    stack: ExitStack,
) -> Parts:
    config, live = scenario.payload, clock is not world.clock
    state = Path(stack.enter_context(TemporaryDirectory(prefix="ross-sitl-")))
    links = stack.enter_context(Router.open(config.links, clock, system_id=config.telemetry.system_id, state=state))
    mount, timebase = aboard(scenario, world.clock, links, world.rotor_speeds)
    store = SessionStore(recordings)
    return Parts(
        clock=clock,
        source=world.source,
        open_port=SharedBuses(_opener(config, far_end, clock), clock).open,
        links=links,
        mount=mount,
        timebase=timebase,
        parameters=stack.enter_context(Parameters(config, state / "params.toml", check_settable)),
        store=store,
        drained=in_background if live else drained(clock),
        voiceprint=company.voiceprint,
        synthetic=company.synthetic,
        voices=VoiceStore(state / "voices"),  # of nobody: they end with the simulation
        state=state,
        rng=np.random.default_rng(config.seed),
        computer=ComputerReader(store.folder) if live else None,  # else it is the same on every computer
        live=live,
    )


def _opener(config: Config, far_end: FarEnd, clock: Clock) -> Callable[[str], Port]:
    """Return what opens wires: our node's bus is a real one, unless it is the one of the simulated actuator."""
    simulated = getattr(checked_options(config), "port", "")

    def open_port(url: str) -> Port:
        return open_wire(url, clock) if url == config.dronecan.port != simulated else far_end.port

    return open_port


class GroundTruthObserver(MissionView):
    """Writes what is true while the payload lives, so that nothing grows."""

    def __init__(self, world: World, truth: TruthWriter) -> None:
        self._world = world
        self._truth = truth
        self._hops = 0

    def on_input(self, hop: Input) -> None:
        """Take a stretch of the world now and then."""
        self._hops += 1
        if self._hops % STRETCH == 0:
            self._truth.write(self._world.drain())
