"""Sources as the picture shows them: trails, estimates, plans, hundreds of them, and mirrors alone."""

import math
from itertools import pairwise

import pytest

from fleet_ear import source, status
from ross_payload.ground.model.state_reducer import MOST_SOURCES
from ross_protocols.mavlink import values as v

# ------------------------------------------------------------------------------------------- sources


def azimuths(ground):
    return [entry["azimuth"] for entry in ground.view["sources"]]


def test_a_trail_follows_its_source_though_indices_are_shuffled(ground):
    """Three sources walk by one degree per estimate; the explorer renumbers them each time."""
    walks = (0.0, 60.0, -90.0)
    for estimate in range(1, 10):
        ground.at = float(estimate * 3)
        for index in range(3):
            azimuth = walks[(index + estimate) % 3] + estimate
            ground.say(source(index, math.radians(azimuth), estimate, time=ground.at))
    for entry in ground.view["sources"]:
        shown = [azimuth for _, azimuth in entry["trail"]]
        assert len(shown) == 9
        steps = [(b - a + 180) % 360 - 180 for a, b in pairwise(shown)]
        assert steps == pytest.approx([-1.0] * 8, abs=1e-4), "a compass counts the other way round"


def test_a_source_that_appears_far_away_has_no_trail(ground):
    ground.say(source(0, 0.0, 1))
    ground.say(source(0, 2.0, 2, time=2.0))
    assert [len(entry["trail"]) for entry in ground.view["sources"]] == [1]


def test_angles_from_another_zero_begin_another_trail(ground):
    ground.say(source(0, 0.0, 1))
    ground.say(source(0, 0.01, 2, time=2.0, earth=False))
    assert [len(entry["trail"]) for entry in ground.view["sources"]] == [1]


def test_of_two_hundred_sources_thirty_two_are_kept_and_all_are_announced(ground):
    ground.say(*(source(index, index / 40, count=200) for index in range(200)))
    assert len(ground.view["sources"]) == MOST_SOURCES == 32
    assert {entry["announced"] for entry in ground.view["sources"]} == {200}


def test_a_new_estimate_takes_the_place_of_the_old_and_of_its_plan(ground):
    plan = v.Alignment(1_500_000, 1, 0, 1, 0, 0.5, 0.5, 1e-4, (1, 2), v.Rule.GAIN, v.CandidateState.PLANNED, earth=True)
    ground.say(*(source(index, index) for index in range(3)), plan)
    assert len(ground.view["plan"]["candidates"]) == 1
    ground.say(source(0, 0.3, 2, count=1, time=4.0))
    assert (len(ground.view["sources"]), ground.view["plan"]["candidates"]) == (1, [])


def test_a_plan_that_comes_before_its_sources_stays(ground):
    plan = v.Alignment(2_000_000, 1, 0, 1, 0, 0.5, 0.5, 1e-4, (1, 2), v.Rule.GAIN, v.CandidateState.PLANNED, earth=True)
    ground.say(plan, source(0, 0.1, time=1.0))
    assert len(ground.view["plan"]["candidates"]) == 1


def test_a_source_of_an_older_estimate_that_comes_late_changes_nothing(ground):
    ground.say(source(0, 0.3, 2, count=2, time=4.0), source(1, 0.9, 2, count=2, time=4.0))
    ground.say(source(0, 2.0, 1, time=1.0))
    assert {entry.estimate for entry in ground.known.sources} == {2}
    assert len(ground.view["sources"]) == 2


def test_a_repeated_source_of_an_old_estimate_that_was_overtaken_by_a_new_one_changes_nothing(ground):
    ground.say(status(100.0), *(source(index, index, 5, time=20.0) for index in range(3)))
    *new, repeated = ground.frames(source(0, 0.3, 6, count=1, time=99.0), source(1, 1.0, 5, time=20.0))
    ground.hear([*new, repeated])
    assert [(entry.estimate, entry.azimuth) for entry in ground.known.sources] == [(6, pytest.approx(0.3))]


def test_after_a_new_start_estimates_are_older_and_count(ground):
    ground.say(status(5000.0), source(0, 0.3, 6, count=1, time=4990.0))
    ground.say(status(70.0), source(0, 1.3, 1, count=1, time=65.0))
    assert [entry.azimuth for entry in ground.known.sources] == [pytest.approx(1.3)]


def test_when_nobody_is_heard_any_longer_no_source_is_shown(ground):
    ground.say(status(1.0, k=3), *(source(index, index) for index in range(3)))
    ground.say(status(2.0, k=0))
    assert ground.view["sources"] == []


# ------------------------------------------------------------------------------------------- mirrors alone


def test_mirrors_alone_show_sources_without_uncertainty(ground):
    ground.say(v.Named(0.0, "ross_k", 3.0), v.Named(0.0, "ross_head", 20.0), v.Named(0.0, "ross_state", 6.0))
    ground.say(v.Array(0, "ross_az", 1, (3.0, 10.5, 350.0)))
    shown = ground.view
    assert [(entry["azimuth"], entry["sigma"]) for entry in shown["sources"]] == [
        (10.5, None),
        (350.0, None),
        (0.0, None),
    ]
    assert (shown["standing"]["mirrors_only"], shown["standing"]["state"]) == (True, "run")
    assert (shown["pointing"]["heading"], shown["mission"]["k"]) == (20.0, 3)
