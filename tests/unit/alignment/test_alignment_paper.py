"""The paper's rules for where to turn: its equations, its footnote, its count of checks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from examples import examples
from ross_payload.alignment.paper_rules import aliasing_headings, paper_plan
from ross_payload.alignment.plan import Plan, Turn, isolation
from ross_payload.angles import difference
from ross_payload.events import SourceEstimate

SPACING, SPEED = 343.0, 343.0  # d / v_p = 1 s

angles = st.floats(-np.pi, np.pi)
elevations = st.floats(-1.0, 1.0)


def planned(azimuths: list[float], heading: float = 0.0, reach: tuple[float, float] = (-4, 4)) -> Plan:
    talkers = [SourceEstimate(azimuth, 0.01, 1.0, True) for azimuth in azimuths]
    return paper_plan(talkers, Turn(heading, 0.0, *reach), SPACING / SPEED)


def tau(azimuth: float, heading: float, elevation: float = 0.0) -> float:
    return float(np.cos(elevation) * np.cos(azimuth - heading))


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


@given(st.lists(angles, min_size=1, max_size=2), angles)
def test_up_to_two_talkers_need_no_rotation(azimuths: list[float], heading: float) -> None:
    assert [(c.rule, c.joint) for c in planned(azimuths, heading).candidates] == [("stay", 0.0)] * len(azimuths)


@given(st.lists(angles, min_size=3, max_size=3), angles)
def test_three_talkers_turn_to_the_mean_azimuth_of_the_interferers(azimuths: list[float], heading: float) -> None:
    assume(np.abs(np.sin(np.subtract.outer(azimuths, azimuths) / 2))[np.triu_indices(3, 1)].min() > 1e-3)
    for candidate in planned(azimuths, heading).candidates:
        wanted = (sum(azimuths) - azimuths[candidate.source]) / 2
        assert np.sin(candidate.heading - wanted) == pytest.approx(0, abs=1e-9)
        assert candidate.rule == "bisector"
        assert set(candidate.aliased) == {0, 1, 2} - {candidate.source}


@given(st.lists(angles, min_size=4, max_size=5), angles)
def test_more_talkers_turn_to_the_argmax_of_the_isolation(azimuths: list[float], heading: float) -> None:
    result = planned(azimuths, heading)
    for candidate in result.candidates:
        assert candidate.rule == "argmax"
        assert candidate.isolation >= result.isolation[candidate.source].max() - 1e-9


@given(st.lists(angles, min_size=1, max_size=5))
def test_every_talker_is_a_candidate(azimuths: list[float]) -> None:
    assert len(planned(azimuths).candidates) == len(azimuths)


@given(st.lists(angles, min_size=1, max_size=5), angles)
def test_candidates_come_in_order_of_travel(azimuths: list[float], heading: float) -> None:
    travel = [abs(c.joint) for c in planned(azimuths, heading).candidates]
    assert travel == sorted(travel)


@settings(max_examples=examples(50))
@given(st.lists(angles, min_size=3, max_size=5, unique=True), st.floats(0.05, 1.0))
def test_narrow_limits_give_the_best_reachable_isolation(azimuths: list[float], reach: float) -> None:
    reachable = isolation(azimuths, np.linspace(-reach, reach, 201), SPACING, SPEED).max(axis=1)
    for candidate in planned(azimuths, reach=(-reach, reach)).candidates:
        assert -reach <= candidate.joint <= reach
        if candidate.rule == "limited":
            assert candidate.isolation >= reachable[candidate.source] * (1 - 1e-9)


def test_limits_that_exclude_every_alignment_are_said_to_limit() -> None:
    assert {c.rule for c in planned(list(np.deg2rad([80, -100, 0])), reach=(-0.001, 0.001)).candidates} == {"limited"}
    assert planned([0.0, 1.0, 2.0], reach=(1.0, -1.0)).candidates == ()


def test_the_target_at_70_degrees_hears_the_others_at_plus_and_minus_110() -> None:
    """Sec. IV: local AoAs [110, 10, -110] and [110, 10, -110, 180] at the alignment of the source that is at 10 deg."""
    for local in ([110, 10, -110], [110, 10, -110, 180]):
        azimuths = [float(azimuth) for azimuth in np.deg2rad(np.add(local, 60))]
        (chosen,) = [candidate for candidate in planned(azimuths).candidates if candidate.source == 1]
        assert np.sin(chosen.heading - np.deg2rad(60)) == pytest.approx(0, abs=1e-9)


def test_elevation_moves_the_alignment_off_the_bisector() -> None:
    high = SourceEstimate(np.pi / 2, 0.01, 1.0, True, elevation=np.pi / 3)
    talkers = [SourceEstimate(np.deg2rad(-120), 0.01, 1.0, True), SourceEstimate(0.0, 0.01, 1.0, True), high]
    result = paper_plan(talkers, Turn(0.0, 0.0, -4, 4), SPACING / SPEED)
    chosen = next(c for c in result.candidates if c.source == 0)
    assert np.tan(chosen.heading) == pytest.approx(2)  # cos(phi) = cos(60 deg) sin(phi)
