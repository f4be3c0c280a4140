"""The default mission with a servo on a CAN bus: real driver, real frames, a servo with lag and friction."""

import json

import pytest

OTHERS = ("ideal", "tb6600")


@pytest.fixture
def mission(run):
    def fly(kind, seed=1):
        code, out, err = run("sitl", "--actuator", kind, "--seed", seed, "--json")
        assert code == 0, err
        return json.loads(out)

    return fly


def best(report):
    return [group["si_sdri_db"] for group in report["groups"]]


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(5))
def test_it_finds_the_talkers_and_separates_as_well_as_others(mission, seed):
    servo = mission("dronecan_servo", seed)
    assert all(abs(source["azimuth_error_deg"]) < 0.5 for source in servo["sources"])
    for kind in OTHERS:
        other = mission(kind, seed)
        found = zip(servo["sources"], other["sources"], strict=True)
        assert all(abs(ours["azimuth_deg"] - theirs["azimuth_deg"]) < 0.5 for ours, theirs in found)
        assert all(ours > theirs - 0.3 for ours, theirs in zip(best(servo), best(other), strict=True))


@pytest.mark.soak
def test_a_rerun_is_the_same(mission):
    first, second = mission("dronecan_servo"), mission("dronecan_servo")
    del first["timing"], second["timing"]
    assert first == second
