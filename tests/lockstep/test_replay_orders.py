"""A live session of orders that was recorded runs again."""

import numpy as np
import pytest

from replay_bench import SHORT, replayed
from ross_payload.actuators.registry import open_actuator
from ross_payload.config import Config
from ross_payload.interfaces import Score, Services, VoicePrint
from ross_payload.mission.live_session import Kit, LiveSession
from ross_payload.mission.tasks import Memory
from ross_payload.mount import fixed_mount
from ross_payload.orders import Explore, Seek, Set, Shutdown, Stop
from ross_payload.service.assemble import settings_of, tools_of
from ross_payload.service.payload import FIRST
from ross_payload.service.runner import Runner
from ross_payload.sessions.manifest import Beginning
from ross_payload.sessions.recorder import Recorder
from ross_payload.sessions.session_reader import RecordedSession as Recorded
from ross_payload.sessions.session_store import SessionStore
from ross_sim.clock import SimClock
from ross_sim.devices.far_end import far_end_of
from ross_sim.scenario import load
from ross_sim.sitl.talker_selection import talkers_of
from ross_sim.sitl.world import World


class Answers(VoicePrint):
    """Scores that anybody can compute."""

    def score(self, voice, rate):
        return Score(float(np.mean(np.abs(voice))) * 1e3 - 1, accepted=True)


class Operator:
    """Gives orders at certain hops, and has the recorder begin at one of them."""

    def __init__(self, orders, start):
        self.orders, self.start, self.hops = orders, start, 0

    def on_input(self, heard):
        self.hops += 1
        if self.hops in self.orders:
            self.runner.order(self.orders[self.hops])
        if self.hops == self.start:
            assert self.recorder.record(True) == ""

    def on_event(self, event, heard):
        pass


def live(scenario, folder, orders, start, autostart="nothing"):
    """A session as `ross run` assembles it, in simulated time."""
    values = scenario.payload.model_dump(mode="json") | {"service": {"target": "ann", "autostart": autostart}}
    config = Config.model_validate(values | {"recording": {"always": start == 0, "min_free_gb": 0}})
    clock, far_end = SimClock(), far_end_of(config)
    cast = scenario.cast(talkers_of(scenario, None, None).voices)
    world = World(scenario, cast.talkers, far_end, clock, 1)
    with open_actuator(config, Services(clock, lambda url: far_end.port)) as actuator, world.source:
        travel = actuator.capabilities

        def begin():
            if session.busy:
                return None
            return Beginning("session", session.config, travel.lower, travel.upper, "ann", session.memory)

        with Recorder(SessionStore(folder), config.recording, begin) as recorder:
            clock.every(0.2, recorder.drain)
            voice = recorder.noting(Answers())
            make = lambda now: Kit(settings_of(now, travel.lower, travel.upper), tools_of(now, voice))  # noqa: E731
            session = LiveSession(config, make)
            first = FIRST[autostart]
            mission = session.mission(None if first is None else first())
            runner = Runner(mission, world.source, actuator, fixed_mount(config), config=config, clock=clock)
            clock.every(0.01, runner.poll)
            operator = Operator(orders, start)
            operator.runner, operator.recorder = runner, recorder
            runner.observers = [recorder, operator]
            runner.run()
    return folder / "0001"


@pytest.fixture
def scenario(tmp_path):
    (tmp_path / "short.toml").write_text(SHORT)
    return load(str(tmp_path / "short.toml"))


@pytest.mark.soak
def test_a_session_recorded_between_two_tasks_is_replayed_with_what_it_knew(scenario, tmp_path, run):
    orders = {
        5: Explore(number=1), 700: Set(name="RUN_S", value=1.0, number=2), 705: Seek(number=3),
        1400: Stop(number=4), 1410: Shutdown(number=5),
    }  # fmt: skip
    session = live(scenario, tmp_path / "all", orders, start=650)
    memory = Recorded.open(session).memory(Memory)
    assert memory.estimate is not None
    assert memory.samples == 650 * 160
    code, values = replayed(session, tmp_path / "out", run)
    assert code == 0
    assert values["identical"]
    assert values["events"] > 10
    assert (tmp_path / "out" / "events.jsonl").read_bytes() == (session / "events.jsonl").read_bytes()


def test_a_session_that_starts_with_a_task_is_replayed_from_its_first_hop(scenario, tmp_path, run):
    session = live(scenario, tmp_path / "all", {650: Shutdown(number=1)}, start=0, autostart="explore")
    code, values = replayed(session, tmp_path / "out", run)
    assert (code, values["identical"]) == (0, True)
    assert len(values["sources"]) > 0
