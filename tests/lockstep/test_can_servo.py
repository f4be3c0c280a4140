"""The default mission with a servo on a CAN bus: real driver, real frames, a servo with lag and friction."""

import pytest

from reports import gains
from short_mission import as_long

OTHERS = ("ideal", "tb6600")


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(5))
def test_it_finds_the_talkers_and_separates_as_well_as_others(fly, tmp_path, seed):
    scenario = as_long(tmp_path)
    servo = fly("--scenario", scenario, "--actuator", "dronecan_servo", "--seed", seed)
    assert all(abs(source["azimuth_error_deg"]) < 0.5 for source in servo["sources"])
    for kind in OTHERS:
        other = fly("--scenario", scenario, "--actuator", kind, "--seed", seed)
        found = zip(servo["sources"], other["sources"], strict=True)
        assert all(abs(ours["azimuth_deg"] - theirs["azimuth_deg"]) < 0.5 for ours, theirs in found)
        assert all(ours > theirs - 0.3 for ours, theirs in zip(gains(servo), gains(other), strict=True))


@pytest.mark.soak
def test_a_rerun_is_the_same(fly):
    first, second = (fly("--actuator", "dronecan_servo", "--seed", 1) for _ in range(2))
    del first["timing"], second["timing"]
    assert first == second
