"""One live world from a scenario to its truth."""

from __future__ import annotations

import json
import os
import threading
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import click
from threadpoolctl import threadpool_limits

from ross_payload.audio.audio_files import write_wav
from ross_payload.clock import SystemClock, hurry
from ross_payload.errors import ConfigError, refused_as
from ross_payload.notify import on_signal
from ross_payload.transport.link_url import tcp_endpoint
from ross_sim.clock import RealTimeDriver, SimClock
from ross_sim.devices.connections import advice, connected
from ross_sim.devices.far_end import far_end_of
from ross_sim.live_world.audio_output import AudioOutput, Fifo, PcmServer
from ross_sim.live_world.world_loop import LiveWorld
from ross_sim.scenario import Cast, Scenario, Talker, WayPoint
from ross_sim.sitl.ground_truth import TruthWriter, facts
from ross_sim.sitl.mission_view import waiting
from ross_sim.sitl.results_folder import ResultsFolder
from ross_sim.sitl.talker_selection import talkers_of
from ross_sim.sitl.world import World
from ross_sim.talkers.speech import TalkerVoice

URGENCY = 1  # real-time priority of a world: a microphone is never late, but a payload's pump comes first


@dataclass(frozen=True, slots=True)
class Sockets:
    """Where the world meets the payload."""

    pcm: str | None  # tcp:HOST:PORT
    pipe: Path | None
    form: str  # of the samples
    wire: str | None  # URL of the actuator's wire or link; None: the usual one


@dataclass(frozen=True, slots=True)
class Wishes:
    """How the world is to live."""

    at_once: bool  # do not wait for a listener
    quiet: float  # noise alone before the scenario [s]
    speech: Path | None
    enrolment: Path | None  # where to write clean speech of the target
    as_json: bool


def run(scenario: Scenario, sockets: Sockets, wishes: Wishes, out: ResultsFolder | None) -> None:
    """Live until SIGINT or SIGTERM, then write what was true.

    Raises
    ------
    ConfigError
        When an address or the scenario is wrong.
    LinkError
        When a port is taken.
    """
    cast = _cast(scenario, wishes)
    ended = threading.Event()
    with on_signal(lambda _: ended.set()), ExitStack() as stack, threadpool_limits(limits=1):
        config = scenario.payload
        clock, wall, far_end = SimClock(), SystemClock(), far_end_of(config)
        world = World(later(scenario, wishes.quiet), cast.talkers, far_end, clock, config.seed)
        truth = stack.enter_context(TruthWriter(out, world.rate, len(cast.talkers)))
        outlets = _outlets(sockets, world.rate, stack)
        real_time = RealTimeDriver(clock, wall, lambda line: click.echo(f"ross: {line}", err=True))
        actuator = connected(config, sockets.wire, far_end, epoch=real_time.epoch, stack=stack)
        _print_ready(sockets, outlets, actuator.address, scenario, wishes.as_json)
        live = LiveWorld(world, actuator.lead, outlets, truth, real_time)
        servers = [outlet for outlet in outlets if isinstance(outlet, PcmServer)]

        def wanted() -> bool:
            used = any(server.used for server in servers) if servers else actuator.used()
            return wishes.at_once or used

        hurry(URGENCY)
        live.live(wanted, ended.is_set)
        how = {"quiet_s": wishes.quiet, "late_s": round(real_time.worst, 3), "complaints": far_end.complaints()}
        truth.finish(facts(scenario, cast) | live.account() | how, later(scenario, wishes.quiet))


def _cast(scenario: Scenario, wishes: Wishes) -> Cast:
    if scenario.vehicle is not None:
        raise ConfigError(
            "[vehicle]: expected a scenario without one, got one: ross world has no autopilot, ross sitl --serve has"
        )
    with waiting(wishes.as_json, f"{scenario.title}: preparing the voices"):
        cast = scenario.cast(talkers_of(scenario, wishes.speech, None).voices)
    if wishes.enrolment is not None:
        _keep_enrolment(wishes.enrolment, cast.target)
    return cast


def _keep_enrolment(path: Path, voice: TalkerVoice) -> None:
    """Write clean speech of the target; a file that is there stays as it is, and must be the same."""
    with refused_as(ConfigError, f"--enrolment {path}: cannot be written"), TemporaryDirectory(dir=path.parent) as made:
        part = Path(made) / path.name
        write_wav(part, voice.enrolment, voice.rate)
        if not os.path.lexists(path):
            part.rename(path)
        elif not path.is_file() or path.read_bytes() != part.read_bytes():
            raise ConfigError(f"--enrolment: {path} is there already: delete it, or give another name")


def later(scenario: Scenario, seconds: float) -> Scenario:
    """Return the scenario with everybody talking ``seconds`` later."""
    talkers = tuple(
        talker.model_copy(
            update={
                "start_s": scenario.start(talker) + seconds,
                "end_s": None if talker.end_s is None else talker.end_s + seconds,
                "pauses": tuple((begin + seconds, end + seconds) for begin, end in talker.pauses),
                "path": delayed(talker, seconds),
            }
        )
        for talker in scenario.talkers
    )
    return scenario.model_copy(update={"talkers": talkers})


def delayed(talker: Talker, seconds: float) -> tuple[WayPoint, ...]:
    """Return the path of a talker who sets out ``seconds`` later, and stays where it is until then."""
    if not talker.path or not seconds:
        return talker.path
    start = WayPoint(at_s=seconds, azimuth_deg=talker.azimuth_deg)
    return start, *(point.model_copy(update={"at_s": point.at_s + seconds}) for point in talker.path)


def _outlets(sockets: Sockets, rate: int, stack: ExitStack) -> list[AudioOutput]:
    outlets: list[AudioOutput] = []
    if sockets.pcm is not None:
        outlets.append(
            stack.enter_context(closing(PcmServer(*tcp_endpoint(sockets.pcm, "--pcm", min_port=0), rate, sockets.form)))
        )
    if sockets.pipe is not None:
        outlets.append(stack.enter_context(closing(Fifo(sockets.pipe, rate, sockets.form))))
    return outlets


def _print_ready(sockets: Sockets, outlets: list[AudioOutput], wire: str, scenario: Scenario, as_json: bool) -> None:
    """Say that the world is ready, and what a payload's configuration needs."""
    pcm = next((outlet.port for outlet in outlets if isinstance(outlet, PcmServer)), None)
    host = (sockets.pcm or "").rpartition(":")[0]
    source = None if pcm is None else f"{host}:{pcm}"
    config = scenario.payload
    if as_json:
        pipe = None if sockets.pipe is None else str(sockets.pipe)
        click.echo(json.dumps({"pcm": source, "pipe": pipe, "wire": wire, "rate_hz": config.audio.rate_hz}))
        return
    click.echo(f"{scenario.title}: ready. The payload's configuration:\n\n[audio]")
    click.echo(f'source = "{source or "device:NAME"}"\nrate_hz = {config.audio.rate_hz}\n')
    click.echo(advice(config, wire))
