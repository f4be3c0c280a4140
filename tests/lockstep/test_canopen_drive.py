"""The default mission with a CANopen drive, and what the drive does when its driver is killed."""

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest

from device_bench import device
from reports import gains
from short_mission import as_long

DRIVER = """
import json, sys, time
sys.path.insert(0, sys.argv[2])
from device_bench import driver
with driver(json.loads(sys.argv[1])) as one:
    one.ready()
    one.actuator.command(3.4, 0.3)
    time.sleep(600)
"""


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(5))
def test_it_finds_the_talkers_and_separates_as_well_as_the_ideal_actuator(fly, tmp_path, seed):
    scenario = as_long(tmp_path)
    drive, ideal = (
        fly("--scenario", scenario, "--actuator", kind, "--seed", seed) for kind in ("canopen_drive", "ideal")
    )
    assert all(abs(source["azimuth_error_deg"]) < 0.5 for source in drive["sources"])
    assert all(ours > theirs - 0.3 for ours, theirs in zip(gains(drive), gains(ideal), strict=True))


@pytest.mark.soak
def test_a_rerun_is_the_same(fly):
    first, second = (fly("--actuator", "canopen_drive", "--seed", 1) for _ in range(2))
    del first["timing"], second["timing"]
    assert first == second


def test_a_drive_whose_driver_is_killed_stops_by_itself(tmp_path):
    with device(tmp_path, "drive") as process:
        support = Path(__file__).parents[1] / "support"
        command = [sys.executable, "-c", DRIVER, json.dumps(process.told), str(support)]
        with subprocess.Popen(command) as driver:
            end = time.monotonic() + 60
            while process.ask("status")["angle_deg"] < 10:
                assert time.monotonic() < end
                time.sleep(0.02)
            driver.kill()
        time.sleep(2.0)
        stands = process.ask("status")["angle_deg"]
        time.sleep(1.0)
        assert process.ask("status")["angle_deg"] == pytest.approx(stands, abs=0.01)
        assert 10 < stands < 100  # at 17 deg/s; its goal is at 195
