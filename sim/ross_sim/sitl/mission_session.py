"""One simulated mission from a scenario to its results: every part is real but the far ends of the wires."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ross_payload.actuators.guard import Guard
from ross_payload.actuators.registry import open_actuator
from ross_payload.angles import wrap
from ross_payload.audio.audio_files import WavWriter, write_wav
from ross_payload.clock import SystemClock
from ross_payload.computing import computing
from ross_payload.config import VEHICLE_YAW, Config, Link
from ross_payload.config import Guard as Rules
from ross_payload.errors import ActuatorError, OutputError
from ross_payload.events import Separated
from ross_payload.interfaces import ActuatorState, Attitude, Clock, Mount, Result, Services
from ross_payload.listening.observers import Listening
from ross_payload.mavlink import Router
from ross_payload.mission.mission_sequence import mission
from ross_payload.mission.source_tracking import SourceTracker
from ross_payload.mount import fixed_mount, mount_of
from ross_payload.notify import on_signal
from ross_payload.orders import Order, Stop
from ross_payload.service.assemble import informed_of, settings_of, tools_of
from ross_payload.service.live_listening import listening_of
from ross_payload.service.runner import Observer, Runner
from ross_payload.sessions import event_json
from ross_payload.sessions.manifest import Beginning
from ross_payload.sessions.recorder import Recorder
from ross_payload.sessions.replay_results import softer_by, voices_of
from ross_payload.telemetry.component import Telemetry
from ross_payload.timebase import Timebase
from ross_sim.autopilot import simulated_autopilot as simulated
from ross_sim.autopilot.simulated_autopilot import Rotors
from ross_sim.clock import SimClock
from ross_sim.devices.far_end import FarEnd, wire
from ross_sim.scenario import Cast, Scenario
from ross_sim.sitl.ground_truth import write_azimuths
from ross_sim.sitl.mission_cost import Cost
from ross_sim.sitl.mission_view import MissionView
from ross_sim.sitl.moving_report import moving_report
from ross_sim.sitl.pace import ListenedSpeed, Pace
from ross_sim.sitl.page_observer import PageObserver
from ross_sim.sitl.page_voices import PageVoices
from ross_sim.sitl.recording import Collector, recorded
from ross_sim.sitl.report import EventLog, Truth, report
from ross_sim.sitl.results_folder import ResultsFolder
from ross_sim.sitl.talker_selection import TalkerSelection
from ross_sim.sitl.world import World
from ross_sim.vehicle_table import Vehicle

POLL = 0.010  # [s] between two polls of drivers and links
SAME_SIGNAL_S = 0.1  # within this, signals to end mean one: of the terminal, and of a script that passes it on
Looking = AbstractContextManager[list[Observer]]


@dataclass(frozen=True, slots=True)
class Finished:
    """What is left of a mission."""

    result: Result
    report: dict[str, Any]
    timing: dict[str, float]
    cost: Cost  # of the payload's hearing and deciding
    complaints: tuple[str, ...]  # of the simulated hardware
    closing: ActuatorError | None  # what went wrong when the actuator was closed, the mission being over


def perform(
    scenario: Scenario,
    company: TalkerSelection,
    view: MissionView,
    out: ResultsFolder | None,
    speed: float | None,
    *,
    record: Path | None = None,
    page: PageObserver | None = None,
    tracker: type[SourceTracker] = SourceTracker,
    cache: Path | None = None,
) -> Finished:
    """Run one mission in lock-step, write its results, record it in the folder ``record``, and let ``page`` look on.

    Impulse responses of true rooms are kept in the folder ``cache``; None: see ``cache_folder``.

    Raises
    ------
    ActuatorError
        When the actuator cannot be opened; when it cannot be closed, see `Finished`.
    KeyboardInterrupt
        When a second signal to end comes before the results are written; there are none then.
    OutputError
        When results, the recording or a stream could not be written.
    """
    with ExitStack() as signals:  # what is passed on of one interrupts nothing, until the results are written
        wall = SystemClock()
        started = wall.now()
        draw = _picture(scenario) if out is not None else None
        with _Closing() as closing, ExitStack() as stack, computing():
            staged = _staged(
                stack, scenario, company, view, out, speed=speed, record=record, page=page, tracker=tracker, cache=cache
            )
            ready = wall.now()
            signals.enter_context(on_signal(stopping(staged.runner, wall, Stop())))
            result = staged.runner.run()
            staged.listening.close()
            _expect_whole(staged.listening)
            done, closing.over = wall.now(), True
        log, simulated = staged.collector.log, staged.world.clock.now()
        truth = _truth(scenario, staged.world, staged.cast, company.target)
        values = report(log, truth, result, _configuration(scenario)) | moving_report(log, truth)
        complaints = staged.far_end.complaints()
        if complaints:
            values["complaints"] = complaints
        if softer := softer_by(log.last(Separated)):
            values["softer_db"] = round(softer, 2)
        timing = {"set_up_s": ready - started, "mission_s": done - ready, "simulated_s": simulated}
        timing["times_real_time"] = simulated / max(done - ready, 1e-9)
        timing["payload_cpu_s"] = staged.cost.seconds
        if out is not None and draw is not None:
            _write(out, log, truth, values, scenario)
            with out.writing("mission.png") as path:
                draw(path, log, truth)
            timing["results_s"] = wall.now() - done
            out.write_json("timing.json", {name: round(value, 3) for name, value in timing.items()})
        return Finished(result, values, timing, staged.cost, tuple(complaints), closing.error)


@dataclass(slots=True)
class _Closing:
    """Keeps an error of the actuator that comes when the mission is over: its outcome is to be told first."""

    over: bool = False
    error: ActuatorError | None = None

    def __enter__(self) -> _Closing:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> bool:
        if self.over and isinstance(error, ActuatorError):
            self.error = error
        return self.error is not None


def stopping(runner: Runner, wall: Clock, order: Order, within: float = SAME_SIGNAL_S) -> Callable[[str], None]:
    """Return what a signal to end does: the first gives an order at the next hop, a later one ends all at once.

    A plug-in may compute for ever. What comes ``within`` [s] of the first is the same signal.
    """
    asked = math.inf

    def stop(name: str) -> None:
        nonlocal asked
        if wall.now() - asked > within:
            raise KeyboardInterrupt
        asked = min(asked, wall.now())
        runner.order(order)

    return stop


@dataclass(frozen=True, slots=True)
class _Staged:
    """A mission that is ready to run."""

    runner: Runner
    listening: Listening
    collector: Collector
    world: World
    cast: Cast
    far_end: FarEnd
    cost: Cost


def _staged(
    stack: ExitStack,
    scenario: Scenario,
    company: TalkerSelection,
    view: MissionView,
    out: ResultsFolder | None,
    *,
    speed: float | None,
    record: Path | None,
    page: PageObserver | None,
    tracker: type[SourceTracker],
    cache: Path | None,
) -> _Staged:
    """Open everything that a mission needs; ``stack`` closes it."""
    config, clock = scenario.payload, SimClock()
    links = stack.enter_context(Router.open(config.links, clock, system_id=config.telemetry.system_id))
    far_end = scenario.far_end()
    cast = scenario.cast(company.voices)
    world = World(scenario, cast.talkers, far_end, clock, config.seed, cache=cache)
    collector = Collector(_wav(stack, out, config))
    actuator = stack.enter_context(open_actuator(config, Services(clock, lambda url: far_end.port)))
    _find(actuator, far_end, clock, config.guard)
    stack.enter_context(world.source)
    mount, _ = aboard(scenario, clock, links, world.rotor_speeds)
    clock.every(POLL, links.poll)
    recorder = stack.enter_context(recorded(record, _beginning(scenario, company, actuator), clock, links))
    cost = Cost()
    runner = _runner(scenario, company, world, actuator, mount, recorder=recorder, tracker=tracker, cost=cost)
    asked = ListenedSpeed(speed)
    pace = Pace(asked)
    voices = None if page is None else PageVoices(config, asked, pace.pacer)
    aside: Looking = nullcontext([])
    if page is not None and voices is not None:
        aside = page.aboard(config, clock, actuator, runner.order, voices)
    looking = stack.enter_context(aside)  # before the telemetry, which then waits for nobody at its end
    tlog = out.staging / "mission.tlog" if out is not None else None
    telemetry = stack.enter_context(Telemetry(config, clock, links, tlog, actuator))
    runner.observers = [collector, telemetry, *looking, view, *([pace] if speed or page is not None else [])]
    listening = stack.enter_context(listening_of(config, clock, runner, recorder))
    runner.observers += [listening] if recorder is None else [recorder, listening]
    return _Staged(runner, listening, collector, world, cast, far_end, cost)


def _expect_whole(listening: Listening) -> None:
    """Raise OutputError when a stream did not get into its file."""
    for stream in listening.streams():
        if stream.keeps and stream.fault:
            raise OutputError(f"stream {stream.number} is not whole: {stream.fault}")


def expected(scenario: Scenario) -> float:
    """About how long the mission will take [s], if the explorer is certain half-way and the second candidate is it."""
    explore, exploit = scenario.payload.explore, scenario.payload.exploit
    rotations = 0.0 if scenario.payload.informed else (explore.min_rotations + explore.max_rotations) / 2
    return explore.lead_in_s + rotations * (explore.unit_s + 1.0) + 2 * (exploit.check_s + 2.0) + exploit.run_s


def room_yaw(scenario: Scenario) -> float:
    """Where the room's first axis points [rad], from which azimuths of talkers count, in the frame of the mount."""
    if scenario.vehicle is None or scenario.payload.mount.source == "fixed":
        return fixed_mount(scenario.payload).attitude(0.0).yaw
    return scenario.vehicle.motion().mean


def aboard(scenario: Scenario, clock: SimClock, links: Router, rotors: Rotors | None = None) -> tuple[Mount, Timebase]:
    """Make the mount, the time, and the autopilot that tells them and how fast ``rotors`` turn, if there is one."""
    config, timebase = scenario.payload, Timebase(clock)
    if scenario.vehicle is not None and config.actuator.kind != VEHICLE_YAW:  # which is an autopilot
        _attach_autopilot(scenario, scenario.vehicle, clock, links, rotors)
    timebase.attach(links.component(config.telemetry.component_id))
    return mount_of(config, clock, links, timebase), timebase


def _attach_autopilot(
    scenario: Scenario, vehicle: Vehicle, clock: SimClock, links: Router, rotors: Rotors | None
) -> None:
    """Attach an autopilot to the payload's links, over a wire that takes its time."""
    height = sum(scenario.centre()[2:])  # above the floor, where it has taken off
    autopilot = simulated.Autopilot(
        vehicle.motion(),
        attitude=1 / vehicle.attitude_hz,
        silent=vehicle.silent,
        height=height,
        rotors=rotors,
        rotor_messages=vehicle.rotor_messages,
    )
    payload_end, own_end = wire(clock, vehicle.latency_ms / 1e3, vehicle.jitter_ms / 1e3, scenario.payload.seed)
    links.attach(Link(url=simulated.URL, role="autopilot"), payload_end)
    autopilot.plug("payload", own_end)
    clock.every(simulated.POLL, lambda: autopilot.advance(clock.now()))


def _find(actuator: Guard, far_end: FarEnd, clock: SimClock, rules: Rules) -> None:
    """Give an actuator that has to be looked for, or has to look for its zero, time before the sound begins."""
    far_end.advance(clock.now())
    actuator.poll(clock.now())
    _wait(actuator, clock, lambda state: state.healthy, rules.watchdog_s)
    if not actuator.state().homed:
        actuator.home()
        _wait(actuator, clock, lambda state: state.homed, rules.max_move_s)


def _wait(actuator: Guard, clock: SimClock, done: Callable[[ActuatorState], bool], timeout: float) -> None:
    end = clock.now() + timeout
    while not done(actuator.state()) and clock.now() < end:
        clock.sleep(POLL)
        actuator.poll(clock.now())


def _beginning(scenario: Scenario, company: TalkerSelection, actuator: Guard) -> Beginning:
    """What a replay must know."""
    travel, yaw = actuator.capabilities, room_yaw(scenario)
    config, print_ = scenario.payload, company.synthetic
    return Beginning("mission", config, travel.lower, travel.upper, company.target, yaw=yaw, synthetic=print_)


def _runner(
    scenario: Scenario,
    company: TalkerSelection,
    world: World,
    actuator: Guard,
    mount: Mount,
    *,
    recorder: Recorder | None,
    tracker: type[SourceTracker],
    cost: Cost,
) -> Runner:
    config, travel = scenario.payload, actuator.capabilities
    voiceprint = company.voiceprint if recorder is None else recorder.noting(company.voiceprint)
    settings, tools = settings_of(config, travel.lower, travel.upper), tools_of(config, voiceprint)
    tools = replace(tools, tracker=tracker)
    informed = informed_of(config, Attitude(room_yaw(scenario)))
    brain = mission(settings, tools, informed, config.informed.target if config.informed else None)
    runner = Runner(cost.of(brain), world.source, actuator, mount, config=config, clock=world.clock)
    world.clock.every(POLL, runner.poll)
    return runner


def _wav(stack: ExitStack, out: ResultsFolder | None, config: Config) -> WavWriter | None:
    if out is None:
        return None
    return stack.enter_context(WavWriter(out.staging / "mixture.wav", config.audio.rate_hz, channels=2))


def _truth(scenario: Scenario, world: World, cast: Cast, target: str) -> Truth:
    yaw, walks = room_yaw(scenario), scenario.walks()
    return Truth(
        names=tuple(voice.name for voice in cast.talkers),
        azimuths=np.array([wrap(azimuth + yaw) for azimuth in world.azimuths]),
        elevations=np.array(world.elevations),
        images=world.images(),
        mixture=world.mixture()[0],
        target=target,
        walks=walks if any(walk.moves for walk in walks) else (),
        yaw=yaw,
    )


def _configuration(scenario: Scenario) -> dict[str, Any]:
    values: dict[str, Any] = scenario.model_dump(mode="json", exclude={"payload": {"links", "listening"}})
    return values | {"seed": scenario.payload.seed}


def _picture(scenario: Scenario) -> Callable[[Path, EventLog, Truth], None]:
    """Return what draws a mission; no mission is flown where matplotlib is missing and a picture is wanted."""
    from ross_sim.sitl.mission_figure import draw  # noqa: PLC0415

    config = scenario.payload
    unit = config.array.spacing_m / config.array.speed_of_sound_m_s
    return partial(draw, rate=config.audio.rate_hz, unit=unit, title=scenario.title)


def _write(out: ResultsFolder, log: EventLog, truth: Truth, values: dict[str, Any], scenario: Scenario) -> None:
    rate = scenario.payload.audio.rate_hz
    out.write_json("report.json", values)
    out.write_text("events.jsonl", "".join(map(event_json.line, log.events)))
    write_azimuths(out, scenario, truth.mixture.size)
    for name, voice in voices_of(log.last(Separated)).items():
        write_wav(out.staging / name, voice, rate)
