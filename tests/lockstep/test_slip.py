"""A turntable that slips on its shaft in the middle of a mission."""

import json

import pytest

from ross_sim.devices.far_end import Fault
from ross_sim.scenario import load
from short_mission import THREE

pytestmark = pytest.mark.lockstep

QUIET = """
title = "Nothing slips"
[payload.explore]
max_rotations = 6
[payload.exploit]
runs = 3
[noise]
snr_db = 25
"""


def flown(run, out, *arguments):
    code, _, err = run("sitl", "--json", "--out", out, *arguments)
    assert "Traceback" not in err
    return code, json.loads((out / "report.json").read_text())


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.soak)])
def test_the_mission_notices_a_slip_and_the_directions_are_right_again(run, tmp_path, seed):
    code, report = flown(run, tmp_path / "out", "--scenario", "slip", "-a", "ideal", "--seed", seed)
    assert code == 0
    assert report["slips_deg"] == [pytest.approx(-10, abs=0.5)]
    assert [abs(source["azimuth_error_deg"]) <= 0.5 for source in report["sources"]] == [True] * 3
    target = next(group for group in report["groups"] if group["target"])
    assert target["si_sdri_db"] > 20


def test_a_mission_without_a_slip_looks_for_none(run, tmp_path):
    scenario = tmp_path / "well.toml"
    scenario.write_text(QUIET + THREE)
    code, report = flown(run, tmp_path / "out", "--scenario", scenario, "-a", "ideal")
    assert (code, report["slips_deg"]) == (0, [])
    assert report["mission_s"] < 100


def test_a_trouble_that_makes_no_sense_for_an_actuator_is_one_clear_line(run, tmp_path):
    scenario = tmp_path / "odd.toml"
    scenario.write_text('title = "x"\n[[talkers]]\nazimuth_deg = 1\n[[troubles]]\nfault = "saturated"\nat_s = 1\n')
    code, _, err = run("sitl", "--scenario", scenario, "-a", "ideal")
    assert code == 2
    assert (
        err.strip()
        .splitlines()[-1]
        .endswith("troubles: expected a fault of ideal (silent, slip, stuck), got 'saturated'")
    )


def test_the_scenario_says_what_it_is_about():
    (trouble,) = load("slip").troubles
    assert (trouble.fault, trouble.at_s) == (Fault.SLIP, 34.0)
