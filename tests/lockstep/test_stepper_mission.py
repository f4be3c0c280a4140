"""Missions with a stepper: as good as with an ideal actuator, also with a switch for its zero and after a slip."""

import pytest

from reports import gain, worst_azimuth
from short_mission import THREE, changed

SWITCH = """
[payload.actuator]
kind = "tb6600"
[payload.actuator.options]
zero = "switch"
home_offset_deg = -15.0
"""
SLIP = """
title = "The array slips, and finds its zero by its switch"
payload.explore.max_rotations = 6
payload.exploit.runs = 3
noise.snr_db = 25
"""
SLIP += (
    THREE
    + """
[[troubles]]
fault = "slip"
at_s = 34
"""
)


SIX = {"[payload.audio]": "[payload.explore]\nmax_rotations = 6\n[payload.audio]"}  # so that both hear nearly the same


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(5))
def test_the_default_mission_is_as_good_as_with_an_ideal_actuator(fly, tmp_path, seed):
    demo = changed("demo", tmp_path, SIX)
    kinds = ("tb6600", "ideal")
    stepper, ideal = (fly("--scenario", demo, "--actuator", kind, "--seed", seed) for kind in kinds)
    assert worst_azimuth(stepper) <= 0.5
    assert gain(stepper) == pytest.approx(gain(ideal), abs=0.3)
    assert "complaints" not in stepper


@pytest.mark.soak
def test_a_slip_is_put_right_by_the_switch(fly, tmp_path):
    scenario = tmp_path / "slip.toml"
    scenario.write_text(SLIP + SWITCH)
    report = fly("--scenario", scenario)
    assert report["slips_deg"] == [pytest.approx(-10, abs=0.5)]
    assert worst_azimuth(report) <= 0.5
    assert gain(report) > 20
