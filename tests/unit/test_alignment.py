"""Where to turn: claims about isolation, aliasing and the plan."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from ross_payload.angles import difference
from ross_payload.dsp.alignment import Plan, aliasing_headings, isolation, plan
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
    return plan(
        sources(azimuths),
        heading=heading,
        joint=joint,
        lower=reach[0],
        upper=reach[1],
        spacing=SPACING,
        speed_of_sound=SPEED,
    )


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


@given(angles, angles, elevations, elevations)
def test_at_the_aliasing_heading_both_tdoas_are_equal(a: float, b: float, up_a: float, up_b: float) -> None:
    assume(abs(np.cos(up_a) * np.exp(1j * a) - np.cos(up_b) * np.exp(1j * b)) > 1e-6)
    (heading,) = aliasing_headings(a, b, up_a, up_b)
    assert 0 <= heading < np.pi
    assert tau(a, heading, up_a) == pytest.approx(tau(b, heading, up_b), abs=1e-12)


@given(angles, angles, elevations)
def test_at_equal_elevation_the_aliasing_heading_is_the_bisector(a: float, b: float, up: float) -> None:
    assume(abs(float(difference(a, b))) > 1e-3)
    (heading,) = aliasing_headings(a, b, up, up)
    assert np.sin(heading - (a + b) / 2) == pytest.approx(0, abs=1e-9)


def test_sources_that_coincide_have_no_special_heading() -> None:
    assert aliasing_headings(0.3, 0.3) == ()


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


@given(st.lists(angles, min_size=2, max_size=5), angles)
def test_no_heading_beats_the_argmax(azimuths: list[float], heading: float) -> None:
    result = planned(azimuths, heading)
    for candidate in result.candidates:
        if candidate.rule == "argmax":
            assert candidate.isolation >= result.isolation[candidate.source].max() * (1 - 1e-9)


@given(st.lists(angles, min_size=3, max_size=3), angles)
def test_three_talkers_align_unless_that_costs_half_of_the_isolation(azimuths: list[float], heading: float) -> None:
    result = planned(azimuths, heading)
    for candidate in result.candidates:
        best = result.isolation[candidate.source].max()
        assert candidate.isolation >= 0.49 * best
        if candidate.rule == "bisector":
            assert set(candidate.aliased) == {0, 1, 2} - {candidate.source}


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


@settings(max_examples=50)
@given(st.lists(angles, min_size=2, max_size=5, unique=True), st.floats(0.05, 1.0))
def test_narrow_limits_give_the_best_reachable_heading(azimuths: list[float], reach: float) -> None:
    reachable = isolation(azimuths, np.linspace(-reach, reach, 201), SPACING, SPEED).max(axis=1)
    for candidate in planned(azimuths, reach=(-reach, reach)).candidates:
        if candidate.rule == "limited":
            assert candidate.isolation >= reachable[candidate.source] * (1 - 1e-9)


def test_limits_that_exclude_every_alignment_are_said_to_limit() -> None:
    rules = {c.rule for c in planned(list(np.deg2rad([80, -100, 0])), reach=(-0.001, 0.001)).candidates}
    assert rules == {"limited"}


def test_limits_that_leave_nothing_leave_no_candidate() -> None:
    assert planned([0.0, 1.0, 2.0], reach=(1.0, -1.0)).candidates == ()


def test_two_talkers_that_pose_as_one_make_the_array_turn() -> None:
    candidates = planned(list(np.deg2rad([30, -30]))).candidates
    assert [c.rule for c in candidates] == ["argmax", "argmax"]
    assert all(abs(abs(c.joint) - np.pi / 2) < 1e-9 for c in candidates)


def test_two_talkers_far_apart_in_itd_let_the_array_stay() -> None:
    candidates = planned(list(np.deg2rad([10, 170])), heading=0.2, joint=0.7).candidates
    assert [(c.rule, c.joint) for c in candidates] == [("stay", 0.7)] * 2


def test_one_talker_lets_the_array_stay_and_none_asks_for_nothing() -> None:
    (only,) = planned([1.0], joint=0.5).candidates
    assert (only.rule, only.joint, only.isolation) == ("stay", 0.5, 2 * UNIT)
    assert planned([]).candidates == ()
    assert planned([]).isolation.shape == (0, 180)


def test_the_paper_target_at_70_degrees_puts_the_others_at_plus_and_minus_110() -> None:
    """Sec. IV: local AoAs [110, 10, -110] at the alignment of the source that is heard at 10 deg."""
    target, heading = np.deg2rad(70), np.deg2rad(60)
    talkers = [float(heading + np.deg2rad(110)), float(target), float(heading - np.deg2rad(110))]
    chosen = next(c for c in planned(talkers).candidates if c.source == 1)
    assert np.sin(chosen.heading - heading) == pytest.approx(0, abs=1e-9)
    assert chosen.rule == "bisector"


def test_talkers_close_around_the_target_are_better_not_aligned() -> None:
    """Interferers at +-35 deg: aligned (1 - cos 35) = 0.18 d/v_p, across sin 35 = 0.57 d/v_p."""
    middle = next(c for c in planned(list(np.deg2rad([0, 35, -35]))).candidates if c.source == 0)
    assert middle.rule == "argmax"
    assert middle.isolation == pytest.approx(UNIT * np.sin(np.deg2rad(35)))


def test_elevation_moves_the_alignment_off_the_bisector() -> None:
    high = SourceEstimate(np.pi / 2, 0.01, 1.0, True, elevation=np.pi / 3)
    talkers = [SourceEstimate(np.deg2rad(-120), 0.01, 1.0, True), SourceEstimate(0.0, 0.01, 1.0, True), high]
    result = plan(talkers, heading=0.0, joint=0.0, lower=-4, upper=4, spacing=SPACING, speed_of_sound=SPEED)
    chosen = next(c for c in result.candidates if c.source == 0)
    assert np.tan(chosen.heading) == pytest.approx(2)  # cos(phi) = cos(60 deg) sin(phi)
