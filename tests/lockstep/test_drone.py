"""A drone that yaws under its payload: the real links, mount and driver, on simulated wires."""

import json

import numpy as np
import pytest
import soundfile

from command_line import called_once
from reports import gain, worst_azimuth
from short_mission import SCENARIOS

pytestmark = [pytest.mark.lockstep, pytest.mark.usefixtures("undrawn")]

SCENARIO = (SCENARIOS / "drone-yaw.toml").read_text(encoding="utf-8")
REST = SCENARIO.replace("amplitude_deg = 15", "amplitude_deg = 0")

SOONER = """
[payload.explore]
unit_s = 1.0
min_rotations = 2
max_rotations = 2
[payload.exploit]
separator = "gaussian"
run_s = 2.0
check_s = 1.0
"""
SHORT = """
[payload.explore]
unit_s = 1.0
min_rotations = 2
max_rotations = 2
[payload.exploit]
run_s = 1.0
check_s = 1.0
"""
NORTH = {10.0, 125.0, -110.0}  # where the talkers are: 30 deg clockwise of the file's
ONCE = "max_restarts = 0\n"
QUICK = 'separator = "duet"\ntrack = false\n'  # where nobody listens to what is separated


@pytest.fixture
def fly(run, tmp_path):
    def flown(text, seed, *, out=None):
        """Fly; the report. The results go into the folder ``out``."""
        path = tmp_path / "scenario.toml"
        path.write_text(text)
        kept = ("--out", tmp_path / out) if out else ()
        _, said, _ = run("sitl", "--scenario", path, "--seed", seed, *kept, "--json")
        return json.loads(said)

    return flown


@pytest.fixture(scope="module")
def yawing(tmp_path_factory):
    """The results of a short mission while the drone yaws."""
    folder = tmp_path_factory.mktemp("yawing")
    (folder / "scenario.toml").write_text(SCENARIO + SOONER)
    called_once("sitl", "-s", folder / "scenario.toml", "--seed", 1, "--out", folder / "out", "--json")
    return folder / "out"


def azimuths(report):
    return {source["azimuth_true_deg"]: source["azimuth_deg"] for source in report["sources"]}


def compare(fly, seed):
    """Differences of the azimuths between yawing and rest [deg], and both gains [dB]."""
    rest, yaw = fly(REST, seed), fly(SCENARIO, seed)
    assert rest["outcome"] == yaw["outcome"] == "target_found"
    assert azimuths(rest).keys() == azimuths(yaw).keys() == NORTH
    apart = [(azimuths(yaw)[true] - found + 180) % 360 - 180 for true, found in azimuths(rest).items()]
    return np.abs(apart), gain(rest), gain(yaw)


def test_a_yawing_drone_hears_everyone_where_they_are_from_north(yawing):
    report = json.loads((yawing / "report.json").read_text())
    assert report["outcome"] == "target_found"
    assert azimuths(report).keys() == NORTH
    assert worst_azimuth(report) < 2.0
    assert gain(report) > 16.2  # at rest 20.2; the motor of the joint is heard now


@pytest.mark.soak
def test_a_drone_that_nobody_follows_hears_talkers_who_are_not_there(fly):
    """What following is for: the azimuths swing with the vehicle when nobody says that it yaws."""
    report = fly(SCENARIO.replace('source = "autopilot"', 'source = "fixed"\nyaw_deg = 30') + SHORT + QUICK + ONCE, 1)
    errors = [abs(source["azimuth_error_deg"] or 0.0) for source in report["sources"]]
    assert report["k"] != report["k_true"] or max(errors) > 2.0


@pytest.mark.soak  # of another mission: test_sitl
def test_a_rerun_in_the_air_gives_the_same_bytes(fly, yawing, tmp_path):
    fly(SCENARIO + SOONER, 1, out="again")
    for name in ("events.jsonl", "report.json", "mixture.wav"):
        assert (yawing / name).read_bytes() == (tmp_path / "again" / name).read_bytes(), name


@pytest.mark.soak  # without a room: test_following; who notices: test_mount
def test_an_autopilot_that_falls_silent_makes_the_mission_begin_again_in_the_other_frame(fly, tmp_path):
    text = (
        (SCENARIO + SHORT + QUICK)
        .replace("[vehicle]", "[vehicle]\nsilent = [[4.0, 1000.0]]")
        .replace("amplitude_deg = 15", "amplitude_deg = 0")
    )
    report = fly(text, 3, out="out")
    events = [json.loads(line) for line in (tmp_path / "out" / "events.jsonl").read_text().splitlines()]
    doubted = next(event for event in events if event["event"] == "Doubted")
    assert "attitude" in doubted["reason"]
    assert 4.0 < doubted["time"] < 5.0
    after = [event for event in events if event["event"] == "OrientationHeard" and event["time"] > doubted["time"]]
    assert after[0]["index"] == 0
    mount_frame = {-80.0, 40.0, 155.0}  # as in the file: nobody knows where north is
    found = {source["azimuth_deg"] for source in report["sources"]}
    assert all(min(abs(one - true) for true in mount_frame) < 8 for one in found)
    assert soundfile.info(tmp_path / "out" / "mixture.wav").frames > 0


@pytest.mark.soak  # one short flight against the truth: the first test
@pytest.mark.timeout(3600)
def test_ten_flights_are_within_two_degrees_of_ten_at_rest(fly):
    found = [compare(fly, seed) for seed in range(1, 11)]
    assert max(apart.max() for apart, _, _ in found) < 2.0
    assert np.mean([yaw - rest for _, rest, yaw in found]) > -4.0
