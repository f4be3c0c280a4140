"""Missions in the paper's measured settings, with synthetic voices: everybody is found where they stand."""

import json

import pytest

from reports import gain
from short_mission import CHEAP, SOON, brief

pytestmark = [pytest.mark.lockstep, pytest.mark.soak, pytest.mark.usefixtures("undrawn")]


def worst(report):
    return max(abs(source["azimuth_error_deg"]) for source in report["sources"])


def test_in_the_field_everybody_is_found_and_the_target_is_separated(run, tmp_path):
    code, out, err = run(
        "sitl", "--scenario", brief("setting-4", tmp_path, explore=SOON, check_s=1.0, run_s=1.0, **CHEAP), "--json"
    )
    assert code == 0, err
    report = json.loads(out)
    assert report["k"] == 3
    assert worst(report) < 5
    assert gain(report) > 12


def test_in_the_conference_room_everybody_is_found_even_when_the_voice_is_not_recognised(run, tmp_path):
    soon = brief("setting-5", tmp_path, explore=SOON, check_s=1.0, run_s=1.0, **CHEAP)
    code, out, err = run("sitl", "--scenario", soon, "--json")
    assert code in (0, 3), err
    report = json.loads(out)
    assert report["k"] == 3
    assert worst(report) < 10
    assert not report["groups"] or gain(report) > 4
