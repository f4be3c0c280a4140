"""Pointing by hand: set-points follow each other without a halt, rates end, headings are held, a stop wins."""

import math
from contextlib import ExitStack
from dataclasses import asdict

import pytest

from examples import in_soak
from hand_bench import Base, HandBench
from ross_payload.angles import wrap
from ross_payload.events import Answer, Finished, State
from ross_payload.orders import Cancel, Explore, Home, Point, Rearm, Stop, TurnTo
from ross_payload.sessions.input_log import order_of
from ross_sim.devices.far_end import Fault


def deg(angle):
    return math.radians(angle)


@pytest.fixture
def bench():
    with ExitStack() as stack:
        yield lambda base=None, **config: HandBench(stack, base, **config)


def test_the_array_goes_to_a_joint_angle_and_the_payload_idles_again(bench):
    one = bench()
    one.live(6.0, one.order(0.5, Point(joint=deg(40), number=-1)))
    assert one.angle(4.0) == pytest.approx(40, abs=0.01)
    assert one.answers(-1) == [Answer.ACCEPTED, Answer.DONE]
    assert (State.TURN, "by hand") in one.states()


def test_a_move_by_hand_is_no_mission(bench):
    one = bench()
    one.live(5.0, one.order(0.5, Point(joint=deg(10))))
    assert not [event for event in one.events if isinstance(event, Finished)]


def test_a_new_set_point_takes_the_place_of_the_old_one_without_a_halt(bench):
    one = bench()
    one.live(8.0, one.order(0.5, Point(joint=deg(150), number=-1)), one.order(1.8, Point(joint=deg(160), number=-2)))
    assert all(one.speed(time) > 60 for time in (1.7, 1.8, 1.9, 2.0))
    assert one.angle(7.0) == pytest.approx(160, abs=0.01)
    assert one.answers(-1) == [Answer.ACCEPTED, Answer.DONE]
    assert one.answers(-2) == []


def test_of_two_set_points_at_once_the_later_one_is_meant(bench):
    one = bench()
    one.live(5.0, one.order(0.5, Point(joint=deg(40), number=-1), Point(joint=deg(20), number=-2)))
    assert one.angle(4.9) == pytest.approx(20, abs=0.01)
    assert (one.answers(-1), one.answers(-2)) == ([], [Answer.ACCEPTED, Answer.DONE])


def test_of_a_set_point_and_a_task_at_once_the_task_is_meant(bench):
    one = bench()
    one.live(2.0, one.order(0.5, Point(joint=deg(40), number=-1), Explore(number=1)))
    assert one.answers(1)[0] is Answer.ACCEPTED
    assert one.angle(1.9) == 0.0


def test_a_stream_of_set_points_is_followed(bench):
    one = bench()
    steps = [one.order(0.5 + 0.02 * step, Point(joint=deg(0.4 * step))) for step in range(200)]  # 20 deg/s
    one.live(7.0, *steps)
    assert all(abs(one.angle(time) - 20 * (time - 0.5)) < 4 for time in (1.5, 2.5, 3.5, 4.4))
    assert one.angle(6.0) == pytest.approx(79.6, abs=0.01)


def test_the_way_is_the_shorter_one_within_the_limits(bench):
    one = bench()
    one.live(12.0, one.order(0.5, Point(joint=deg(170))), one.order(6.0, Point(joint=deg(-170))))
    assert one.angle(5.0) == pytest.approx(170, abs=0.01)
    assert one.angle(11.0) == pytest.approx(190, abs=0.01)


def test_a_move_at_a_rate_ends_at_the_angle_wherever_it_begins(bench):
    """From 105.4 deg the way and back is another number than the goal, by rounding."""
    one = bench()
    first, second = Point(joint=deg(105.4), number=-1), Point(joint=deg(-14), rate=deg(60), number=-2)
    one.live(9.0, one.order(0.5, first), one.order(4.5, second))
    assert one.angle(8.9) == pytest.approx(-14, abs=0.01)
    assert one.answers(-2) == [Answer.ACCEPTED, Answer.DONE]


def test_a_homing_that_takes_too_long_is_a_fault_and_no_zero(bench):
    """The guard latches it, and nobody may take it back but an operator."""
    search = {
        "zero": "switch",
        "home_direction": "counter-clockwise",
        "home_offset_deg": 150.0,
        "home_speed_deg_s": 10.0,
    }
    one = bench(actuator={"kind": "tb6600", "options": search}, guard={"max_move_s": 2.0})
    one.live(9.0, one.order(0.5, Home(number=7)))
    assert one.answers(7) == [Answer.ACCEPTED, Answer.FAILED]
    assert "not homed after 2 s" in one.actuator.state().fault
    assert not one.actuator.state().homed


def test_beyond_a_limit_is_the_limit(bench):
    one = bench(guard={"lower_deg": -50, "upper_deg": 50})
    one.live(12.0, one.order(0.5, Point(joint=deg(80))), one.order(6.0, Point(joint=deg(-120))))
    assert one.angle(5.0) == pytest.approx(50, abs=0.01)
    assert one.angle(11.0) == pytest.approx(-50, abs=0.01)


def test_a_rate_turns_until_the_next_set_point(bench):
    one = bench()
    one.live(9.0, one.order(0.5, Point(rate=deg(-20))), one.order(5.5, Point(rate=0.0)))
    assert [one.speed(time) for time in (2.0, 4.0, 5.4)] == pytest.approx([-20] * 3, abs=0.1)
    assert one.speed(6.5) == 0.0
    assert one.angle(8.0) == pytest.approx(-20 * 5.0, abs=5)


def test_a_rate_ends_at_the_limit(bench):
    one = bench(guard={"lower_deg": -50, "upper_deg": 50})
    one.live(9.0, one.order(0.5, Point(rate=deg(30))))
    assert max(math.degrees(angle) for _, angle, _ in one.trace) <= 50 + 1e-3
    assert one.angle(8.0) == pytest.approx(50, abs=0.01)


def test_a_slow_move_is_no_fault_though_it_takes_longer_than_a_move_may(bench):
    one = bench(guard={"max_move_s": 8.0})
    one.live(26.0, one.order(0.5, Point(joint=deg(40), rate=deg(2))))
    assert one.speed(10.0) == pytest.approx(2.0, abs=0.1)
    assert one.angle(24.0) == pytest.approx(40, abs=0.01)
    assert State.FAULT not in [state for state, _ in one.states()]


def test_a_heading_is_held_while_the_base_turns(bench):
    one = bench(Base(yaw=deg(30), rate=deg(10)), array={"offset_deg": 15})
    one.live(12.0, one.order(0.5, Point(heading=deg(60))))
    assert [one.heading(time) for time in (4.0, 7.0, 11.0)] == pytest.approx([60] * 3, abs=1.0)


def test_a_rate_that_leads_further_beyond_a_limit_turns_nothing(bench):
    one = bench(guard={"lower_deg": -200, "upper_deg": -60, "park_deg": -60})
    one.live(12.0, one.order(0.5, Point(rate=deg(30), number=1)), one.order(5.0, Point(rate=deg(-30), number=2)))
    assert one.angle(4.9) == 0.0
    assert one.angle(11.0) < -150
    assert one.answers(1)[-1] is Answer.DONE


def test_a_slow_rate_from_far_beyond_a_limit_may_take_longer_than_a_move(bench):
    one = bench(guard={"lower_deg": 30, "upper_deg": 200, "park_deg": 30, "max_move_s": 5})
    one.live(25.0, one.order(0.5, Point(joint=deg(40), rate=deg(2), number=1)))
    assert one.answers(1)[-1] is Answer.DONE
    assert [one.angle(time) for time in (5.5, 10.5, 24.0)] == pytest.approx([10, 20, 40], abs=1.5)


@pytest.mark.parametrize(
    ("lower", "point"),
    [(lower, Point(joint=joint, rate=deg(2), number=1)) for lower, joint in ((30, 0.7), (-200, 3.0), (30, None))],
)
def test_a_motor_that_cannot_turn_at_a_slow_rate_is_a_fault(bench, lower, point):
    one = bench(guard={"lower_deg": lower, "upper_deg": 200, "park_deg": 30, "max_move_s": 5})
    one.live(20.0, one.order(0.5, point), (3.0, lambda: one.far_end.afflict(Fault.STUCK, on=True)))
    assert one.answers(1)[-1] is Answer.FAILED
    assert one.states()[-1] == (State.FAULT, "at 4.96 deg, not at rest at the goal after 5 s")


def test_a_slow_way_back_from_where_a_fast_move_has_braked_is_no_fault(bench):
    one = bench(guard={"lower_deg": -720, "upper_deg": 720, "max_move_s": 5})
    slow = Point(joint=deg(100), rate=deg(5), number=2)
    one.live(50.0, one.order(0.5, Point(rate=deg(200), number=1)), one.order(2.0, slow))
    assert max(angle for _, angle, _ in one.trace) > deg(200)
    assert one.answers(1)[-1] is Answer.DONE
    assert one.angle(49.0) == pytest.approx(100, abs=0.1)


@pytest.mark.parametrize("rate", [0.02, -0.05])
@pytest.mark.parametrize("wanted", [170, -120])
def test_a_heading_that_is_ordered_is_not_the_opposite_one_on_a_base_that_turns(bench, rate, wanted):
    bench = bench(Base(0.0, rate))
    bench.live(6.0, bench.order(1.0, TurnTo(deg(wanted), number=1)))
    assert bench.answers(1)[-1] is Answer.DONE
    reached = next(event.time for event in bench.events if isinstance(event, Finished))
    assert bench.heading(reached + 0.05) == pytest.approx(wanted, abs=3)


@pytest.mark.parametrize(
    ("rate", "why"), [(0.6, "outside the limits of the joint"), (0.9, "the vehicle turned away"), (0.1, "reached")]
)
def test_a_heading_that_a_limit_keeps_the_array_from_is_not_reached(bench, rate, why):
    one = bench(Base(0.0, rate), guard={"lower_deg": -100, "upper_deg": 60, "max_speed_deg_s": 30})
    one.live(15.0, one.order(0.5, TurnTo(deg(50), number=1)))
    over = next(event for event in one.events if isinstance(event, Finished))
    assert why in over.reason
    reached = abs(wrap(deg(one.heading(over.time + 0.05) - 50))) < deg(5)
    assert one.answers(1)[-1] is (Answer.DONE if reached else Answer.FAILED)


def test_a_heading_needs_to_know_where_the_base_points(bench):
    one = bench()
    one.live(2.0, one.order(0.5, Point(heading=deg(60), number=-1)))
    assert one.answers(-1) == [Answer.REFUSED]
    assert one.angle(1.9) == 0.0


def test_when_the_attitude_is_lost_nothing_is_followed_any_more(bench):
    one = bench(Base(yaw=0.0, rate=deg(10)))

    def lose():
        one.base.yaw = None

    one.live(9.0, one.order(0.5, Point(heading=deg(60), number=-1)), (4.0, lose))
    assert one.answers(-1) == [Answer.ACCEPTED, Answer.FAILED]
    assert one.angle(8.0) == one.angle(6.0)


def test_another_task_takes_over_from_the_hand(bench):
    one = bench()
    one.live(9.0, one.order(0.5, Point(rate=deg(10), number=-1)), one.order(2.0, Explore(number=1)))
    assert one.answers(-1) == [Answer.ACCEPTED, Answer.CANCELLED]
    assert one.answers(1)[0] is Answer.ACCEPTED


def test_the_hand_does_not_end_a_task(bench):
    one = bench()
    one.live(3.0, one.order(0.5, Explore(number=1)), one.order(1.0, Point(joint=1.0, number=-1)))
    assert one.answers(-1) == [Answer.REFUSED]
    assert one.angle(2.0) == 0.0


def test_a_set_point_behind_a_cancel_is_obeyed_when_the_task_is_over(bench):
    one = bench()
    one.live(6.0, one.order(0.5, Explore(number=1)), one.order(1.5, Cancel(number=-1), Point(joint=deg(20), number=-2)))
    assert one.answers(1)[-1] is Answer.CANCELLED
    assert one.answers(-2) == [Answer.ACCEPTED, Answer.DONE]
    assert one.angle(5.0) == pytest.approx(20, abs=0.01)


def test_a_stop_wins_and_stays(bench):
    one = bench()
    one.live(
        9.0,
        one.order(0.5, Point(rate=deg(40), number=-1)),
        one.order(2.0, Stop(number=1)),
        one.order(4.0, Point(joint=0.0, number=-2)),
        one.order(5.0, Rearm(number=2)),
        one.order(6.0, Point(joint=0.0, number=-3)),
    )
    assert one.answers(-1) == [Answer.ACCEPTED, Answer.CANCELLED]
    assert one.answers(-2) == [Answer.REFUSED]
    assert one.angle(5.9) == one.angle(3.5) != 0.0
    assert one.answers(-3)[0] is Answer.ACCEPTED
    assert one.angle(8.9) == pytest.approx(0.0, abs=0.01)


def test_a_rate_that_is_none_turns_nothing(bench):
    one = bench()
    one.live(5.0, one.order(0.5, Point(rate=1e-40)), one.order(1.5, Point(joint=deg(30), rate=1e-40)))
    assert max(abs(angle) for _, angle, _ in one.trace) < deg(0.1)
    assert State.FAULT not in [state for state, _ in one.states()]


@pytest.mark.soak
@pytest.mark.parametrize("kind", ["tb6600", *in_soak("dronecan_servo")])
def test_real_drivers_follow_a_stream_a_rate_and_a_turning_base(bench, kind):
    one = bench(Base(yaw=0.0, rate=deg(6)), actuator={"kind": kind})
    stream = [one.order(1.0 + 0.02 * step, Point(joint=deg(0.3 * step))) for step in range(100)]  # 15 deg/s
    one.live(14.0, *stream, one.order(5.0, Point(rate=deg(-20))), one.order(8.0, Point(heading=deg(40))))
    assert one.speed(2.8) == pytest.approx(15, abs=3)
    assert one.angle(4.9) == pytest.approx(29.7, abs=0.5)
    assert one.speed(7.5) == pytest.approx(-20, abs=1)
    assert [one.heading(time) for time in (12.0, 13.9)] == pytest.approx([40, 40], abs=1.5)
    assert State.FAULT not in [state for state, _ in one.states()]
    assert one.far_end.complaints() == []


def test_a_recording_knows_the_set_point_again():
    point = Point(heading=0.5, rate=0.1, number=-3)
    assert order_of({"order": "Point", **asdict(point)}) == point
