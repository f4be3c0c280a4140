"""A turntable that slips on its shaft in the middle of a mission; one that does not: test_sitl."""

import json

import pytest

from ross_sim.devices.far_end import Fault
from ross_sim.scenario import load
from short_mission import changed

pytestmark = [pytest.mark.lockstep, pytest.mark.usefixtures("undrawn")]

SOONER = {  # what happens in the scenario `slip`, in less time
    "max_rotations = 6": "lead_in_s = 1.0\nunit_s = 1.5\nmin_rotations = 2\nmax_rotations = 2",
    "runs = 2": "runs = 1\ncheck_s = 1.0\nrun_s = 3.0\nseparator = 'gaussian'",
    "at_s = 34": "at_s = 8",
}


def flown(run, out, *arguments):
    code, _, err = run("sitl", "--json", "--out", out, *arguments)
    assert "Traceback" not in err
    return code, json.loads((out / "report.json").read_text())


@pytest.mark.soak  # without a room: test_slips
@pytest.mark.parametrize(("shorter", "seed"), [(True, 0), (False, 0), (False, 1)])
def test_the_mission_notices_a_slip_and_the_directions_are_right_again(run, tmp_path, shorter, seed):
    scenario = changed("slip", tmp_path, SOONER if shorter else {})
    code, report = flown(run, tmp_path / "out", "--scenario", scenario, "-a", "ideal", "--seed", seed)
    assert code == 0
    assert report["slips_deg"] == [pytest.approx(-10, abs=0.5)]
    assert [abs(source["azimuth_error_deg"]) <= 0.5 for source in report["sources"]] == [True] * 3
    target = next(group for group in report["groups"] if group["target"])
    assert target["si_sdri_db"] > 20


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
