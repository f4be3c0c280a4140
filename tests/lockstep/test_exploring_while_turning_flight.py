"""Missions that explore without a pause, in the simulator: real driver, true headings, the motor's own noise."""

import json

import numpy as np
import pytest

from command_line import called_once
from replay_bench import replayed
from ross_payload.actuators.registry import open_actuator
from ross_payload.events import OrientationHeard, State, StateChanged
from ross_payload.interfaces import Services
from ross_payload.mission.live_session import Kit, LiveSession
from ross_payload.mission.tasks import Memory
from ross_payload.mount import fixed_mount
from ross_payload.orders import Explore, Shutdown, Stop
from ross_payload.service.assemble import settings_of, tools_of
from ross_payload.service.runner import Runner
from ross_sim.clock import SimClock
from ross_sim.devices.far_end import far_end_of
from ross_sim.scenario import load
from ross_sim.sitl.talker_selection import talkers_of
from ross_sim.sitl.world import World
from short_mission import THREE

pytestmark = [pytest.mark.lockstep, pytest.mark.usefixtures("undrawn")]

TURNING = f"""
title = "a short mission that explores without a pause"
[payload.audio]
rate_hz = 16000
[payload.explore]
lead_in_s = 1.0
unit_s = 1.5
continuous = true
rate_deg_s = 40.0
turn_deg = 180.0
[payload.exploit]
check_s = 1.0
run_s = 1.0
max_restarts = 0
separator = "gaussian"
track = false
[noise]
snr_db = 20
motor_db = -20
{THREE}"""


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """One mission with its recording: its report, its events, and the session."""
    base = tmp_path_factory.mktemp("turning")
    (base / "turning.toml").write_text(TURNING)
    code, _, err = called_once(
        "sitl", "--json", "-s", base / "turning.toml", "--seed", 1, "--out", base / "out", "--record", base / "all"
    )
    assert code in (0, 3), err
    events = [json.loads(line) for line in (base / "out" / "events.jsonl").read_text().splitlines()]
    return json.loads((base / "out" / "report.json").read_text()), events, base / "all" / "0001"


def test_everybody_is_found_in_the_time_of_three_orientations(flown):
    report, events, _ = flown
    assert report["k"] == 3
    assert max(abs(source["azimuth_error_deg"]) for source in report["sources"]) < 5
    (final,) = (event for event in events if event["event"] == "SourcesEstimated" and event["final"])
    assert final["time"] < 1.0 + 4.5 + 0.1  # 9 orientations take three times as long, and eight turns


def test_beliefs_are_told_on_the_way(flown):
    _, events, _ = flown
    told = [event for event in events if event["event"] == "SourcesEstimated"]
    assert [event["rotations"] for event in told] == list(range(len(told)))
    heard = [event["heading"] for event in events if event["event"] == "OrientationHeard"]
    assert len(heard) == len(told) >= 2
    assert np.diff(heard) == pytest.approx(1.05, abs=0.15)  # 1.5 s at 40 deg/s between two of them [rad]


@pytest.mark.soak
def test_a_replay_says_the_same(flown, tmp_path, run):
    code, values = replayed(flown[2], tmp_path / "again", run)
    assert code == 0
    assert values["identical"]


# ------------------------------------------------------------------------------------------ limits, and a stop

NARROW = """
title = "nobody talks, and the joint has little room"
talkers = []
[noise]
snr_db = 20
[payload.audio]
rate_hz = 16000
[payload.actuator]
kind = "tb6600"
[payload.guard]
lower_deg = -20.0
upper_deg = 70.0
[payload.explore]
lead_in_s = 0.5
unit_s = 1.0
continuous = true
rate_deg_s = 60.0
turn_deg = 240.0
"""


class Watcher:
    """Gives orders at certain hops, and writes down where the joint truly is after every one of them."""

    def __init__(self, orders, far_end):
        self.orders, self.far_end, self.angles, self.events = orders, far_end, [], []

    def on_input(self, heard):
        self.angles.append(np.rad2deg(self.far_end.angle()))
        if len(self.angles) in self.orders:
            self.runner.order(self.orders[len(self.angles)])

    def on_event(self, event, heard):
        self.events.append(event)


def watched(folder, orders):
    """A live session as `ross run` assembles it, in simulated time, and what was seen of it."""
    (folder / "narrow.toml").write_text(NARROW)
    scenario = load(str(folder / "narrow.toml"))
    config, clock = scenario.payload, SimClock()
    far_end = far_end_of(config)
    world = World(scenario, scenario.cast(talkers_of(scenario, None, None).voices).talkers, far_end, clock, 1)
    watcher = Watcher(orders, far_end)
    with open_actuator(config, Services(clock, lambda url: far_end.port)) as actuator, world.source:
        travel = actuator.capabilities
        session = LiveSession(
            config, lambda now: Kit(settings_of(now, travel.lower, travel.upper), tools_of(now, None)), Memory()
        )
        runner = Runner(session.mission(None), world.source, actuator, fixed_mount(config), config=config, clock=clock)
        clock.every(0.01, runner.poll)
        watcher.runner, runner.observers = runner, [watcher]
        runner.run()
    return watcher


def test_the_joint_stays_within_its_limits_however_far_it_is_to_turn(tmp_path):
    seen = watched(tmp_path, {10: Explore(number=1), 490: Shutdown()})
    assert len([event for event in seen.events if isinstance(event, OrientationHeard)]) == 4  # of 60 degrees each
    assert max(seen.angles) == pytest.approx(70.0, abs=0.5)
    assert min(seen.angles) == pytest.approx(-20.0, abs=0.5)
    assert np.abs(np.diff(seen.angles)).max() <= 60.0 * 0.01 * 1.1


def test_a_stop_halts_the_turn_and_nothing_turns_back(tmp_path):
    seen = watched(tmp_path, {10: Explore(number=1), 130: Stop(), 260: Shutdown()})
    turning, rest = seen.angles[120:130], seen.angles[190:]
    assert np.ptp(turning) > 4.0  # it turns when it is stopped
    assert np.ptp(rest) < 0.1  # at 112.5 deg/s^2 it stands after 0.53 s
    assert abs(rest[-1] - turning[-1]) <= 60.0**2 / (2 * 112.5) + 60.0 * 0.1
    states = [event.state for event in seen.events if isinstance(event, StateChanged)]
    assert states == [State.IDLE, State.LEAD_IN, State.EXPLORE_TURN, State.STOPPED]
