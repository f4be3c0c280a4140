"""Where to turn: claims about isolation, aliasing and the plan."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from examples import examples
from ross_payload.alignment.plan import ENOUGH, Plan, Turn, isolation, plan
from ross_payload.alignment.predicted_gain import predicted_gain
from ross_payload.dsp.steering import ALIAS
from ross_payload.events import SourceEstimate

SPACING, SPEED = 0.05, 343.0
UNIT = SPACING / SPEED

angles = st.floats(-np.pi, np.pi)
elevations = st.floats(-1.0, 1.0)
layouts = st.lists(angles, min_size=1, max_size=5)
joints = st.floats(-3.0, 3.0)


def sources(azimuths: list[float]) -> list[SourceEstimate]:
    return [SourceEstimate(azimuth, 0.01, 1.0, True) for azimuth in azimuths]


def planned(
    azimuths: list[float], heading: float = 0.0, joint: float = 0.0, reach: tuple[float, float] = (-4, 4)
) -> Plan:
    return plan(sources(azimuths), Turn(heading - joint, joint, *reach), UNIT)


def tau(azimuth: float, heading: float, elevation: float = 0.0) -> float:
    return UNIT * float(np.cos(elevation) * np.cos(azimuth - heading))


@given(layouts, angles)
def test_half_a_turn_changes_no_isolation(azimuths: list[float], heading: float) -> None:
    here, across = isolation(azimuths, [heading, heading + np.pi], SPACING, SPEED).T
    np.testing.assert_allclose(here, across, atol=1e-15)


@given(layouts, angles, angles)
def test_turning_talkers_and_array_together_changes_no_isolation(
    azimuths: list[float], heading: float, by: float
) -> None:
    before = isolation(azimuths, [heading], SPACING, SPEED)
    after = isolation(np.array(azimuths) + by, [heading + by], SPACING, SPEED)
    np.testing.assert_allclose(before, after, atol=1e-15)


@given(st.lists(angles, min_size=2, max_size=5), angles)
def test_isolation_is_the_smallest_difference_of_tdoas(azimuths: list[float], heading: float) -> None:
    taus = [tau(a, heading) for a in azimuths]
    wanted = [min(abs(t - other) for k, other in enumerate(taus) if k != i) for i, t in enumerate(taus)]
    np.testing.assert_allclose(isolation(azimuths, [heading], SPACING, SPEED)[:, 0], wanted, atol=1e-15)


@given(layouts, angles, joints, st.floats(-4, 0), st.floats(0, 4))
def test_goals_stay_inside_the_limits(
    azimuths: list[float], heading: float, joint: float, lower: float, upper: float
) -> None:
    for candidate in planned(azimuths, heading, joint, (lower, upper)).candidates:
        assert lower <= candidate.joint <= upper


@given(layouts, angles, joints)
def test_goal_and_heading_differ_by_the_base(azimuths: list[float], heading: float, joint: float) -> None:
    for candidate in planned(azimuths, heading, joint).candidates:
        assert candidate.heading - candidate.joint == pytest.approx(heading - joint, abs=1e-9)
        predicted = isolation(azimuths, [candidate.heading], SPACING, SPEED)[candidate.source, 0]
        assert candidate.isolation == pytest.approx(predicted, abs=1e-15)


@given(layouts, angles, joints)
def test_candidates_come_in_order_of_travel(azimuths: list[float], heading: float, joint: float) -> None:
    travel = [abs(c.joint - joint) for c in planned(azimuths, heading, joint).candidates]
    assert travel == sorted(travel)


@given(layouts, angles, joints)
def test_with_half_a_turn_each_way_no_goal_is_further_than_a_quarter_turn(
    azimuths: list[float], heading: float, joint: float
) -> None:
    for candidate in planned(azimuths, heading, joint, (joint - np.pi, joint + np.pi)).candidates:
        assert abs(candidate.joint - joint) <= np.pi / 2 + 1e-9


def test_limits_that_leave_nothing_leave_no_candidate() -> None:
    assert planned([0.0, 1.0, 2.0], reach=(1.0, -1.0)).candidates == ()


def test_one_talker_lets_the_array_stay_and_none_asks_for_nothing() -> None:
    (only,) = planned([1.0], joint=0.5).candidates
    assert (only.rule, only.joint, only.isolation) == ("stay", 0.5, 2 * UNIT)
    assert planned([]).candidates == ()
    assert planned([]).isolation.shape == (0, 180)


@given(layouts, angles, joints)
def test_no_heading_promises_much_more_than_the_chosen_one(azimuths: list[float], heading: float, joint: float) -> None:
    """Other than those at which the target poses with somebody."""
    result = planned(azimuths, heading, joint)
    alone = result.isolation >= ALIAS * UNIT
    for candidate in result.candidates:
        if alone[candidate.source].any():
            best = result.gain_db[candidate.source][alone[candidate.source]].max()
            assert candidate.gain_db >= best - (ENOUGH if candidate.rule == "stay" else 0.05)


@given(layouts, angles, joints)
def test_a_candidate_is_promised_the_gain_of_its_heading(azimuths: list[float], heading: float, joint: float) -> None:
    for candidate in planned(azimuths, heading, joint).candidates:
        assert candidate.gain_db == pytest.approx(predicted_gain(azimuths, [candidate.heading])[candidate.source, 0])


@given(layouts, angles)
def test_after_its_turn_the_array_stays(azimuths: list[float], heading: float) -> None:
    for candidate in planned(azimuths, heading).candidates:
        there = planned(azimuths, candidate.heading, candidate.joint).candidates
        assert next(c.rule for c in there if c.source == candidate.source) == "stay"


@settings(max_examples=examples(50))
@given(st.lists(angles, min_size=2, max_size=5, unique=True), st.floats(0.05, 1.0))
def test_narrow_limits_give_the_best_reachable_heading(azimuths: list[float], reach: float) -> None:
    headings = np.linspace(-reach, reach, 201)
    alone = isolation(azimuths, headings, SPACING, SPEED) >= ALIAS * UNIT
    reachable = np.where(alone, predicted_gain(azimuths, headings), -np.inf).max(axis=1)
    for candidate in planned(azimuths, reach=(-reach, reach)).candidates:
        if candidate.rule == "limited":
            assert candidate.gain_db >= reachable[candidate.source] - 0.1


def test_limits_that_exclude_every_good_heading_are_said_to_limit() -> None:
    """Two talkers at +-30 deg are told apart across the axis, which points between them and hardly turns."""
    candidates = planned(list(np.deg2rad([30, -30])), reach=(-0.1, 0.1)).candidates
    assert [(c.rule, abs(c.joint)) for c in candidates] == [("limited", 0.1)] * 2


def test_two_talkers_that_pose_as_one_make_the_array_turn() -> None:
    candidates = planned(list(np.deg2rad([30, -30]))).candidates
    assert [c.rule for c in candidates] == ["gain", "gain"]
    assert all(abs(abs(c.joint) - np.pi / 2) < 1e-9 for c in candidates)


def test_two_talkers_far_apart_in_itd_let_the_array_stay() -> None:
    candidates = planned(list(np.deg2rad([10, 170])), heading=0.2, joint=0.7).candidates
    assert [(c.rule, c.joint) for c in candidates] == [("stay", 0.7)] * 2


def test_talkers_close_around_the_target_are_not_aligned() -> None:
    """Interferers at +-35 deg: aligned (1 - cos 35) = 0.18 d/v_p, across sin 35 = 0.57 d/v_p."""
    middle = next(c for c in planned(list(np.deg2rad([0, 35, -35]))).candidates if c.source == 0)
    assert middle.aliased == ()
    assert middle.isolation == pytest.approx(UNIT * np.sin(np.deg2rad(35)))


def test_talkers_opposite_the_target_are_aligned() -> None:
    """Interferers at 180 +- 35 deg: along their bisector both are 1.82 d/v_p away, and no heading does better."""
    chosen = next(c for c in planned(list(np.deg2rad([0, 145, -145]))).candidates if c.source == 0)
    assert chosen.joint == pytest.approx(0)
    assert chosen.aliased == (1, 2)


def test_elevation_moves_the_alignment() -> None:
    """An interferer right below has TDOA 0 at every heading: best is the target on the axis, not across it."""
    below = SourceEstimate(np.pi / 2, 0.01, 1.0, True, elevation=-np.pi / 2)
    talkers = [SourceEstimate(np.deg2rad(40), 0.01, 1.0, True), below]
    result = plan(talkers, Turn(2.0, 0.0, -4, 4), UNIT)
    chosen = next(c for c in result.candidates if c.source == 0)
    assert np.sin(chosen.heading - np.deg2rad(40)) == pytest.approx(0, abs=1e-9)
    assert chosen.isolation == pytest.approx(UNIT)


def test_every_candidate_is_checked_since_the_target_may_not_be_there() -> None:
    result = planned([0.0, 1.0, 2.5, -2.0])
    assert len(result.candidates) == 4
