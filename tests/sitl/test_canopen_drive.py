"""The default mission with a CANopen drive: real driver, real frames, a drive with friction and an encoder."""

import json

import pytest


@pytest.fixture
def mission(run):
    def fly(kind, seed):
        code, out, err = run("sitl", "--actuator", kind, "--seed", seed, "--json")
        assert code == 0, err
        return json.loads(out)

    return fly


def best(report):
    return [group["si_sdri_db"] for group in report["groups"]]


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(5))
def test_it_finds_the_talkers_and_separates_as_well_as_the_ideal_actuator(mission, seed):
    drive, ideal = mission("canopen_drive", seed), mission("ideal", seed)
    assert all(abs(source["azimuth_error_deg"]) < 0.5 for source in drive["sources"])
    assert all(ours > theirs - 0.3 for ours, theirs in zip(best(drive), best(ideal), strict=True))


@pytest.mark.soak
def test_a_rerun_is_the_same(mission):
    first, second = mission("canopen_drive", 1), mission("canopen_drive", 1)
    del first["timing"], second["timing"]
    assert first == second
