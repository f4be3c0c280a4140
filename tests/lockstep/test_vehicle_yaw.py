"""Missions with two fixed microphones on a drone in gusts of wind, which its autopilot turns."""

import json

import numpy as np
import pytest

from short_mission import SCENARIOS

pytestmark = [pytest.mark.lockstep, pytest.mark.usefixtures("undrawn")]

SCENARIO = (SCENARIOS / "vehicle-yaw.toml").read_text(encoding="utf-8")
SHORT = """
[payload.explore]
unit_s = 1.0
min_rotations = 2
max_rotations = 2
[payload.exploit]
separator = "duet"
track = false
run_s = 2.0
check_s = 1.0
"""
PUSHED = """
[[troubles]]
fault = "pilot"
at_s = 4.3
"""


@pytest.fixture
def fly(run, tmp_path):
    def flown(text, seed):
        """Fly; the report, what was said, and the telemetry log."""
        path, out = tmp_path / "scenario.toml", tmp_path / f"out-{seed}"
        path.write_text(text)
        _, said, _ = run("sitl", "--scenario", path, "--seed", seed, "--out", out, "--json")
        events = [json.loads(line) for line in (out / "events.jsonl").read_text().splitlines()]
        return json.loads(said), events, (out / "mission.tlog").read_bytes()

    return flown


def errors(report):
    assert report["k"] == report["k_true"] == 3
    return np.abs([source["azimuth_error_deg"] for source in report["sources"]])


@pytest.mark.soak
def test_azimuths_from_north_hold_while_the_vehicle_turns_in_gusts(fly):
    report, _, _ = fly(SCENARIO + SHORT, 1)
    assert report["outcome"] == "target_found"
    assert errors(report).max() < 1.5
    assert report["frame"] == "earth"
    assert "complaints" not in report


def test_a_push_of_the_pilot_s_stick_ends_the_mission_and_telemetry_says_why(fly):
    report, events, telemetry = fly(SCENARIO + SHORT + PUSHED, 1)
    assert report["outcome"] == "fault"
    assert "the pilot moves the yaw stick" in report["reason"]
    assert events[-1]["time"] - 4.3 < 1.0
    assert b"the pilot moves the yaw stick" in telemetry


@pytest.mark.soak
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("seed", range(1, 6))
def test_azimuths_of_whole_missions_in_wind_are_within_1_5_degrees(fly, seed):
    report, _, _ = fly(SCENARIO, seed)
    assert report["outcome"] == "target_found"
    assert errors(report).max() < 1.5
