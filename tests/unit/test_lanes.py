"""Every test has one lane: that of its folder, or the one that it names."""

from types import SimpleNamespace

import pytest

import lanes
from lanes import TESTS, imports_of, lane_of


@pytest.mark.parametrize(
    ("place", "markers", "imports", "lane"),
    [
        ("unit/dsp/test_stft.py", ["timeout"], ["numpy"], "pure"),
        ("unit/ground/test_page.py", [], ["socket"], "process"),
        ("unit/test_links.py", [], ["waiting"], "process"),
        ("unit/actuators/test_homing.py", ["lockstep"], ["threading"], "lockstep"),
        ("contract/test_port.py", [], [], "lockstep"),
        ("dist/test_wheel.py", [], ["subprocess"], "process"),
        ("process/test_run.py", [], [], "process"),
        ("interop/test_mavsdk.py", [], [], "realtime"),
        ("realtime/test_stop_latency.py", ["alone"], [], "alone"),
        ("interop/test_c_headers.py", ["process", "soak"], [], "process"),
        ("browser/test_map.py", [], [], "browser"),
    ],
)
def test_the_lane_is_that_of_the_folder_or_the_one_that_is_named(place, markers, imports, lane):
    assert lane_of(TESTS / place, markers, imports) == lane


def test_examples_in_docstrings_are_pure():
    assert lane_of(TESTS.parent / "ross_payload" / "angles.py", []) == "pure"


@pytest.mark.parametrize(
    ("place", "markers", "why"),
    [
        ("strange/test_it.py", [], "no lane"),
        ("unit/test_it.py", ["pure", "lockstep"], "two lanes"),
        ("unit/test_it.py", ["realtime"], "lies in interop, realtime"),
        ("browser/test_it.py", ["alone"], "lies in interop, realtime"),
        ("realtime/test_it.py", ["process"], "expected realtime or alone, as all of tests/realtime"),
        ("realtime/test_it.py", ["browser"], "lies in browser"),
        ("browser/test_it.py", ["process"], "expected browser, as all of tests/browser"),
    ],
)
def test_a_test_without_a_lane_or_with_two_or_in_the_wrong_place_is_refused(place, markers, why):
    with pytest.raises(ValueError, match=why):
        lane_of(TESTS / place, markers)


def test_what_a_module_has_imported_is_known_by_the_names_of_modules():
    assert imports_of(SimpleNamespace(pytest=pytest, lane_of=lane_of, number=3)) == {"pytest", "lanes"}
    assert imports_of(None) == set()


def test_what_takes_long_begins():
    known = {path.stem for path in TESTS.rglob("test_*.py")}
    assert set(lanes.FIRST) <= known
    places = [lanes.begins(TESTS / "interop" / f"{name}.py") for name in (*lanes.FIRST, "test_short")]
    assert places == sorted(set(places))


def test_every_lane_runs_in_one_stage():
    assert sorted(lane for stage in lanes.STAGES for lane in stage.lanes) == sorted(lanes.LANES)
    assert lanes.SPARE.lanes in {stage.lanes for stage in lanes.STAGES}
