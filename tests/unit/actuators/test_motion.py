"""The motion law, against its closed forms and invariants."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_payload.actuators.motion import Trapezoid, braking_distance

position = st.floats(-10, 10)
speed = st.floats(0.05, 10)
acceleration = st.floats(0.1, 100)
velocity = st.floats(-10, 10)
plans = st.builds(Trapezoid, position, position, speed, acceleration, velocity)


def test_a_short_move_takes_two_roots_of_distance_over_acceleration() -> None:
    move = Trapezoid(0.0, math.radians(15), math.radians(225), math.radians(112.5))
    assert move.duration == pytest.approx(0.7303, abs=1e-4)
    assert move.at(move.duration / 2) == pytest.approx((math.radians(7.5), math.sqrt(math.radians(15) * 2 * 0.9817477)))


def test_a_long_move_takes_distance_over_speed_plus_speed_over_acceleration() -> None:
    assert Trapezoid(1.0, 11.0, 2.0, 4.0).duration == pytest.approx(10 / 2 + 2 / 4)


def test_a_move_to_where_it_is_takes_no_time() -> None:
    assert Trapezoid(1.0, 1.0, 2.0, 4.0).duration == 0.0


def test_a_move_back_is_the_mirror_image() -> None:
    there, back = Trapezoid(0.0, 3.0, 1.0, 2.0, 0.5), Trapezoid(0.0, -3.0, 1.0, 2.0, -0.5)
    for t in np.linspace(0, 5, 51):
        assert back.at(t) == pytest.approx(tuple(-value for value in there.at(t)))


def test_a_goal_behind_is_reached_through_a_reversal() -> None:
    move = Trapezoid(0.0, -1.0, speed=2.0, acceleration=2.0, velocity=2.0)
    assert move.at(1.0) == pytest.approx((1.0, 0.0))  # stops after v / a = 1 s, v^2 / (2 a) = 1 rad on
    assert move.duration == pytest.approx(1.0 + 2 * math.sqrt(2.0 / 2.0))


def test_a_goal_too_near_to_stop_at_is_overshot_by_what_braking_needs() -> None:
    move = Trapezoid(0.0, 0.5, speed=2.0, acceleration=2.0, velocity=2.0)
    assert max(move.at(t)[0] for t in np.linspace(0, 3, 3001)) == pytest.approx(1.0, abs=1e-6)


def test_more_speed_than_the_cap_is_shed_first() -> None:
    move = Trapezoid(0.0, 10.0, speed=1.0, acceleration=2.0, velocity=3.0)
    assert move.at(1.0) == pytest.approx((2.0, 1.0))  # (9 - 1) / (2 * 2) rad in (3 - 1) / 2 s
    assert move.at(3.0) == pytest.approx((4.0, 1.0))


@given(position, velocity, acceleration)
def test_braking_takes_speed_over_acceleration_and_the_braking_distance(x: float, v: float, a: float) -> None:
    move = Trapezoid.to_rest(x, v, a)
    assert move.duration == pytest.approx(abs(v) / a, abs=1e-6)
    assert abs(move.goal - x) == pytest.approx(braking_distance(v, a), abs=1e-12)
    assert (move.goal - x) * v >= 0


@given(plans)
def test_every_plan_ends_at_rest_at_the_goal_and_keeps_its_caps(move: Trapezoid) -> None:
    a, v0 = move.acceleration, move.velocity
    times = np.linspace(0, move.duration, 401)
    positions, velocities = np.array([move.at(t) for t in times]).T
    assert (positions[0], velocities[0]) == pytest.approx((move.start, v0), abs=1e-6)
    assert (positions[-1], velocities[-1]) == (move.goal, 0.0)
    assert np.abs(velocities).max() <= max(move.speed, abs(v0)) * (1 + 1e-9)
    dt = times[1] - times[0]
    assert np.abs(np.diff(velocities)).max() <= a * dt * (1 + 1e-6) + 1e-6
    assert np.diff(positions) == pytest.approx((velocities[1:] + velocities[:-1]) / 2 * dt, abs=a * dt**2 + 1e-6)


@given(plans, st.floats(0, 1))
def test_planning_again_in_flight_to_the_same_goal_changes_nothing(move: Trapezoid, when: float) -> None:
    t = when * move.duration
    again = Trapezoid(move.at(t)[0], move.goal, move.speed, move.acceleration, move.at(t)[1])
    assert t + again.duration == pytest.approx(move.duration, rel=1e-4, abs=1e-4)


@given(plans)
def test_crossing_times_are_where_the_position_is(move: Trapezoid) -> None:
    for phase in move.phases:
        levels = np.linspace(phase.position, phase.at(phase.begin + phase.duration)[0], 7)
        times = phase.crossings(levels)
        assert [phase.at(t)[0] for t in times] == pytest.approx(levels, abs=1e-7)
        assert np.all(np.diff(times) >= -1e-12)
