"""The default mission with a controller that runs grbl: real driver, real bytes, a simulated firmware and motor."""

import pytest

from reports import gain
from short_mission import as_long

SWITCH = """
[payload.actuator]
kind = "grbl"
[payload.actuator.options]
zero = "switch"
home_deg = 10.0
"""


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(5))
def test_the_default_mission_is_as_good_as_with_an_ideal_actuator(fly, tmp_path, seed):
    scenario = as_long(tmp_path)
    ours, ideal = (fly("--scenario", scenario, "--actuator", kind, "--seed", seed) for kind in ("grbl", "ideal"))
    assert all(abs(source["azimuth_error_deg"]) <= 0.5 for source in ours["sources"])
    assert gain(ours) == pytest.approx(gain(ideal), abs=0.3)
    assert "complaints" not in ours


@pytest.mark.soak
def test_a_rerun_is_the_same(fly):
    first, second = (fly("--actuator", "grbl", "--seed", 1) for _ in range(2))
    del first["timing"], second["timing"]
    assert first == second


@pytest.mark.soak
def test_a_switch_is_found_before_the_mission(fly, tmp_path):
    scenario = tmp_path / "switch.toml"
    scenario.write_text('title = "grbl with a switch"\n[[talkers]]\nazimuth_deg = 40\n[[talkers]]\nazimuth_deg = 155\n'
                        "[[talkers]]\nazimuth_deg = -80\n" + SWITCH)  # fmt: skip
    report = fly("--scenario", scenario)
    step = 0.1125  # [deg], by which a switch may be off: all azimuths alike
    errors = [source["azimuth_error_deg"] for source in report["sources"]]
    assert abs(sum(errors) / len(errors)) <= 0.2 + step
    assert max(map(abs, errors)) <= 1.0
