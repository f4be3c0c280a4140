"""Whole missions with the MAVLink gimbal beside the ideal actuator."""

import json
import subprocess

import pytest

from processes import ROSS
from reports import gain
from short_mission import as_long

pytestmark = [pytest.mark.soak, pytest.mark.timeout(1200)]


def flown(folder, actuator, seed):
    """The report of the default scenario."""
    out = folder / f"{actuator}-{seed}"
    command = [*ROSS, "sitl", "--scenario", str(as_long(folder))]
    subprocess.run(
        [*command, "--actuator", actuator, "--seed", str(seed), "--out", str(out)], check=True, capture_output=True
    )
    return json.loads((out / "report.json").read_text())


@pytest.mark.parametrize("seed", range(5))
def test_a_gimbal_s_mission_is_as_good_as_an_ideal_one(tmp_path, seed):
    ideal, gimbal = (flown(tmp_path, actuator, seed) for actuator in ("ideal", "mavlink_gimbal"))
    assert [abs(source["azimuth_error_deg"]) <= 0.5 for source in gimbal["sources"]] == [True] * 3
    assert gain(gimbal) == pytest.approx(gain(ideal), abs=0.3)
    assert "complaints" not in gimbal
