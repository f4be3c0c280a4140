"""A small payload for the tests of live worlds, in a process of its own: real driver, runner and mission, real time.

``python live_payload.py SCENARIO FOLDER QUIET WORLD [alone]`` flies one mission in a `ross world` that lives already,
ends it, flies the mission again in lock-step unless told otherwise, and prints the reports as JSON. WORLD is what the
world has told of itself, with its ``pid``; FOLDER is the world's, which is silent for QUIET seconds at first. The sound
comes over TCP, or where the world has told no address, by the sound card ``pulse``.
What was heard is compared with what the world made stretch by stretch: those between what the payload calls missing.
"""

import json
import os
import select
import signal
import sys
from contextlib import ExitStack
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.signal import correlate
from threadpoolctl import threadpool_limits

from ross_payload.actuators.registry import open_actuator
from ross_payload.actuators.wires import open_wire
from ross_payload.audio.audio_health import HealthMonitor
from ross_payload.audio.open_source import open_source
from ross_payload.clock import SystemClock
from ross_payload.interfaces import AudioFlag, Services
from ross_payload.mission.mission_sequence import mission
from ross_payload.mount import FixedMount
from ross_payload.service.assemble import settings_of, tools_of
from ross_payload.service.runner import Runner
from ross_sim.live_world.world_session import later
from ross_sim.scenario import load
from ross_sim.sitl.mission_session import perform
from ross_sim.sitl.mission_view import MissionView
from ross_sim.sitl.report import EventLog, report
from ross_sim.sitl.talker_selection import talkers_of
from world_truth import read_truth

RATE = 16000
KEY = 64  # samples by which a stretch is found
FAR = RATE // 2  # samples that a stretch may be out of place, to be found


class Memory:
    """Keeps what was heard and said."""

    def __init__(self):
        self.heard_by_hop, self.missing_by_hop = [], []
        self.log = EventLog()

    def on_input(self, heard):
        self.heard_by_hop.append(heard.block.samples[0])
        self.missing_by_hop.append(bool(heard.block.flags & AudioFlag.MISSING))

    def on_event(self, event, heard):
        self.log.events.append(event)


def wired(config, source, wire):
    """The configuration with these two addresses."""
    actuator = config.actuator.model_copy(update={"options": config.actuator.options | {"port": wire}})
    audio = config.audio.model_copy(update={"source": source})
    return config.model_copy(update={"actuator": actuator, "audio": audio})


def fly(scenario, config):
    """One mission in real time; what was kept of it, its result, and how its microphones were, as telemetry says."""
    clock, memory = SystemClock(), Memory()
    voiceprint = talkers_of(scenario, None, None).voiceprint
    sys.setswitchinterval(0.001)
    with ExitStack() as stack, threadpool_limits(limits=1):
        actuator = stack.enter_context(open_actuator(config, Services(clock, lambda url: open_wire(url, clock))))
        audio = stack.enter_context(open_source(config, clock))
        travel = actuator.capabilities
        brain = mission(settings_of(config, travel.lower, travel.upper), tools_of(config, voiceprint), None, None)
        runner = Runner(brain, audio, actuator, FixedMount(), config=config, clock=clock)
        health = HealthMonitor(config, audio)
        runner.observers = [memory, health]
        runner.poll()
        stack.callback(clock.every(0.010, runner.poll))
        result = runner.run()
        return memory, result, health.health()


def stretches(hops, missing):
    """Where what is not missing begins, and what was heard there."""
    changes = [0, *(np.flatnonzero(np.diff(missing)) + 1), len(missing)]
    starts = np.cumsum([0, *map(len, hops)])
    return [
        (int(starts[begin]), np.concatenate(hops[begin:end]))
        for begin, end in pairwise(changes)
        if end > begin and not missing[begin]
    ]


def compared(place, piece, made):
    """How many samples a stretch is out of its place, None if far, and by how much it differs from what was made."""
    first = max(place - FAR, 0)
    windows = sliding_window_view(made[first : place + FAR + KEY], KEY)
    found = first + np.flatnonzero((windows == piece[:KEY]).all(axis=1))
    if not found.size:
        return None, None
    at = int(found[np.argmin(np.abs(found - place))])
    size = min(len(piece), made.size - at)
    return at - place, float(np.abs(piece[:size] - made[at : at + size]).max())


def judge(scenario, world, memory, result, quiet):
    """The simulator's report, with the truth moved to where the payload began to hear."""
    truth = read_truth(world)
    heard = stretches(memory.heard_by_hop, memory.missing_by_hop)
    begin, first = heard[0]
    lag = int(np.argmax(np.abs(correlate(truth.mixture, first[: 10 * RATE], mode="valid")))) - begin
    places = [compared(lag + begin, piece, truth.mixture) for begin, piece in heard]
    truth = replace(truth, images=truth.images[:, lag:], mixture=truth.mixture[lag:])
    values = report(memory.log, truth, result, {"payload": scenario.payload.model_dump(mode="json")})
    began = lag / scenario.payload.audio.rate_hz - quiet  # in the time of the scenario [s]
    zeros = sum(
        int(np.sum(hop == 0)) for hop, gone in zip(memory.heard_by_hop, memory.missing_by_hop, strict=True) if gone
    )
    return values | {"began_s": began, "stretches": places, "zeros": zeros}


def end(pid):
    """End a process of somebody else, and wait until it has ended."""
    process = os.pidfd_open(pid)
    signal.pidfd_send_signal(process, signal.SIGTERM)
    assert select.select([process], [], [], 60.0)[0]
    os.close(process)


def flown(path, out, quiet, world):
    """Fly, end the world; the report and what the world says of itself."""
    scenario = load(path)
    config = wired(scenario.payload, world["pcm"] or "device:pulse", world["wire"])
    memory, result, health = fly(scenario, config)
    end(world["pid"])
    truth = json.loads((out / "truth.json").read_text())
    told = {
        "lost": health.lost,
        "late_s": truth["late_s"],
        "complaints": truth["complaints"],
    }
    told["unread"] = round(health.waiting * RATE)  # samples, or zeros in their place
    return judge(scenario, out, memory, result, quiet) | told


def main(path, folder, quiet, world, *alone):
    live = flown(path, Path(folder), float(quiet), json.loads(world))
    scene = later(load(path), -live["began_s"])  # as seen from where the payload began to listen
    lock_step = None if alone else perform(scene, talkers_of(scene, None, None), MissionView(), None, None).report
    print(json.dumps({"live": live, "lock_step": lock_step}))  # noqa: T201


if __name__ == "__main__":
    main(*sys.argv[1:])
