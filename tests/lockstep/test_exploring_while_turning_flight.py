"""Missions that explore without a pause, in the simulator: real driver, true headings, the motor's own noise."""

import json

import pytest

from command_line import called_once
from replay_bench import replayed
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


def test_everybody_is_found_in_the_time_of_a_quarter_of_the_orientations(flown):
    report, events, _ = flown
    assert report["k"] == 3
    assert max(abs(source["azimuth_error_deg"]) for source in report["sources"]) < 5
    (final,) = (event for event in events if event["event"] == "SourcesEstimated" and event["final"])
    assert final["time"] == pytest.approx(1.0 + 4.5, abs=0.1)  # 13 orientations take 45 s


def test_beliefs_are_told_on_the_way(flown):
    _, events, _ = flown
    told = [event for event in events if event["event"] == "SourcesEstimated"]
    assert [event["rotations"] for event in told] == [0, 1, 2]
    heard = [event["heading"] for event in events if event["event"] == "OrientationHeard"]
    assert heard == sorted(heard)
    assert heard[-1] - heard[0] == pytest.approx(2.1, abs=0.3)  # 1.5 s at 40 deg/s between two of them


def test_a_replay_says_the_same(flown, tmp_path, run):
    code, values = replayed(flown[2], tmp_path / "again", run)
    assert code == 0
    assert values["identical"]
