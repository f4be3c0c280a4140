"""The plan that what is led by set-points follows."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from ross_payload.actuators.driver_shell import Move
from ross_payload.actuators.mavlink_gimbal.feedback import GimbalFeedback
from ross_payload.actuators.mavlink_gimbal.set_points import YawSetPoints
from ross_payload.interfaces import Capabilities, Feedback
from ross_protocols.mavlink.gimbal_messages import GimbalAttitude

ABLE = Capabilities(-2.0, 2.0, 1.0, 1.0, 0.01, False, Feedback.MEASURED)


def seen_at(angle: float, now: float) -> GimbalFeedback:
    seen = GimbalFeedback(ABLE.lower, ABLE.upper, ABLE.max_speed)
    seen.on_report(GimbalAttitude(round(now * 1e3), angle, 0.0, False, 0, 0), now, own=True)
    return seen


def test_what_was_told_to_brake_and_rests_far_behind_its_plan_stays_there():
    plan = YawSetPoints(ABLE)
    plan.turn(Move(1.5, 1.0), 0.0, 0.0, 0.0)
    plan.halt(1.0)
    plan.brake_where_it_is(seen_at(0.1, 1.1), 1.1)
    assert plan.motion.plan.goal == pytest.approx(0.1)


def test_what_only_lags_brakes_as_planned():
    plan = YawSetPoints(ABLE)
    plan.turn(Move(1.5, 1.0), 0.0, 0.0, 0.0)
    plan.halt(1.0)
    plan.brake_where_it_is(seen_at(0.5 - math.radians(4), 1.0), 1.0)
    assert plan.motion.plan.goal == pytest.approx(1.0)


def test_a_turn_is_not_ended_by_what_is_behind():
    plan = YawSetPoints(ABLE)
    plan.turn(Move(1.5, 1.0), 0.0, 0.0, 0.0)
    plan.brake_where_it_is(seen_at(0.1, 1.1), 1.1)
    assert plan.motion.plan.goal == 1.5


def test_what_has_rested_where_it_was_told_to_be_is_held_there_against_a_hand():
    plan = YawSetPoints(ABLE)
    plan.hold(0.5, 0.0)
    for time in range(50):
        plan.rest(seen_at(0.5, time / 100), ABLE.resolution, time / 100)
    plan.brake_where_it_is(seen_at(0.6, 0.5), 0.5)
    assert plan.motion.plan.goal == 0.5


def test_what_is_where_it_was_told_to_be_shortly_before_brakes_as_planned():
    """Its reports are late, and it has only begun to turn."""
    plan = YawSetPoints(replace(ABLE, max_acceleration=2.0))
    plan.hold(0.0, 0.0)
    plan.turn(Move(1.5, 1.0), 0.0, 0.0, 1.0)
    plan.halt(1.3)
    goal = plan.motion.plan.goal
    plan.brake_where_it_is(seen_at(0.0, 1.3), 1.3)
    assert plan.motion.plan.goal == goal
    plan.brake_where_it_is(seen_at(0.0, 1.4), 1.4)
    assert plan.motion.plan.goal == 0.0
