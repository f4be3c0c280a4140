"""The turntable as a gimbal that manages itself: whom it obeys, and who is in control."""

from contextlib import ExitStack

import pytest

from gimbal_bench import (
    ACCEPTED,
    CONFIGURE,
    DENIED,
    FOLLOW,
    GIVE,
    LOCK,
    NAN,
    POINT,
    READY,
    TAKE,
    TEMPORARILY_REJECTED,
    UNSUPPORTED,
    GimbalBench,
    deg,
    pitchyaw,
)
from ross_payload.events import Answer, State
from ross_payload.orders import Cancel, Explore, Rearm, Stop
from ross_protocols.mavlink.dialect import common


@pytest.fixture
def bench():
    with ExitStack() as stack:
        yield lambda mode="standalone", base=None, **more: GimbalBench(stack, mode, base, **more)


def test_when_nobody_is_in_control_anybody_may_point(bench):
    one = bench()
    one.live(8.0, one.ground.say(READY, pitchyaw(deg(50))))
    assert one.angle(7.5) == pytest.approx(-50, abs=0.05)
    assert one.primary(7.5) == (0, 0)


def test_control_is_taken_and_given_back(bench):
    one = bench()
    one.live(
        8.0, one.ground.command(3.0, CONFIGURE, *TAKE, 0, 0, 1), one.ground.command(5.0, CONFIGURE, *GIVE, 0, 0, 1)
    )
    assert (one.primary(2.9), one.primary(4.5), one.primary(7.0)) == ((0, 0), (255, 190), (0, 0))
    assert one.results(CONFIGURE) == [ACCEPTED, ACCEPTED]


def test_who_is_not_in_control_is_denied(bench):
    one = bench()
    one.live(
        8.0,
        one.ground.command(3.0, CONFIGURE, *TAKE, 0, 0, 1),
        one.other.command(4.0, POINT, 0, 50, NAN, NAN, FOLLOW, 0, 1),
        one.other.say(4.5, pitchyaw(deg(50))),
    )
    assert one.results(POINT) == [DENIED]
    assert one.angle(7.5) == 0.0


def test_who_has_secondary_control_may_point(bench):
    one = bench()
    one.live(
        8.0,
        one.ground.command(3.0, CONFIGURE, -2, -2, 254, 190, 0, 0, 1),
        one.other.command(4.0, POINT, 0, 50, NAN, NAN, FOLLOW, 0, 1),
    )
    assert one.results(POINT) == [ACCEPTED]
    assert one.angle(7.5) == pytest.approx(-50, abs=0.05)


def test_a_release_by_who_is_not_in_control_changes_nothing(bench):
    one = bench()
    one.live(8.0, one.ground.command(3.0, CONFIGURE, *TAKE, 0, 0, 1), one.other.command(4.0, CONFIGURE, *GIVE, 0, 0, 1))
    assert one.primary(7.0) == (255, 190)


def test_whoever_comes_into_control_finds_the_array_at_rest(bench):
    one = bench()
    one.live(
        9.0,
        one.ground.command(3.0, CONFIGURE, *TAKE, 0, 0, 1),
        one.ground.command(3.2, POINT, 0, 180, NAN, 20, FOLLOW, 0, 1),
        one.other.command(5.0, CONFIGURE, *TAKE, 0, 0, 1),
    )
    assert abs(one.speed(4.9)) > 15
    assert one.speed(6.5) == 0.0


@pytest.mark.parametrize(
    ("numbers", "result"),
    [
        ((0, NAN, NAN, NAN, 32, 0, 1), DENIED),
        ((0, 10, NAN, NAN, NAN, 0, 1), DENIED),
        ((0, 10, NAN, NAN, 32, 0, 3), DENIED),
    ],
)
def test_what_cannot_be_meant_is_denied(bench, numbers, result):
    one = bench()
    one.live(5.0, one.ground.command(3.0, POINT, *numbers), one.ground.command(3.5, CONFIGURE, 300, 1, 0, 0, 0, 0, 1))
    assert one.results(POINT) == [result]
    assert one.results(CONFIGURE) == [DENIED]
    assert one.angle(4.9) == 0.0


def test_flags_that_a_command_int_does_not_tell_are_no_order_to_retract(bench):
    one = bench()
    not_told = 2**31 - 1
    message = common.MAVLink_command_int_message(1, 154, 0, POINT, 0, 0, NAN, 50, NAN, NAN, not_told, 0, 1)
    one.live(8.0, one.ground.say(READY, message))
    assert one.results(POINT) == [DENIED]
    assert one.status(7.5).flags == FOLLOW


def test_what_it_does_not_know_is_unsupported_unless_all_are_asked(bench):
    one = bench()
    one.live(5.0, one.ground.command(3.0, 205), one.ground.command(3.5, 206, component=0))
    assert (one.results(205), one.results(206)) == ([UNSUPPORTED], [])


def test_who_may_not_order_anything_may_not_point(bench):
    one = bench(accept=(1,))
    one.live(
        6.0,
        one.ground.command(3.0, CONFIGURE, *TAKE, 0, 0, 1),
        one.ground.command(3.5, POINT, 0, 50, NAN, NAN, FOLLOW, 0, 1),
        one.ground.say(4.0, pitchyaw(deg(50))),
    )
    assert (one.results(CONFIGURE), one.results(POINT)) == ([DENIED], [DENIED])
    assert one.angle(5.9) == 0.0


def test_a_heading_needs_a_base_that_is_known(bench):
    one = bench()
    one.live(5.0, one.ground.command(3.0, POINT, 0, 50, NAN, NAN, LOCK, 0, 1))
    assert one.results(POINT) == [TEMPORARILY_REJECTED]


# ---------------------------------------------------------------------------------------------------- rates and rests


def test_a_rate_that_nobody_renews_ends(bench):
    one = bench()
    one.live(10.0, one.ground.say(3.0, pitchyaw(rate=deg(10))))
    assert one.speed(4.3) == pytest.approx(-10, abs=0.2)
    assert one.speed(5.0) == 0.0
    assert one.angle(9.9) == pytest.approx(-15, abs=2)


def test_a_rate_that_is_renewed_goes_on_until_it_is_ended(bench):
    one = bench()
    steps = one.ground.stream(3.0, 7.0, pitchyaw(rate=deg(10)), 0.5)
    one.live(10.0, *steps, one.ground.say(7.0, pitchyaw(rate=0.0)))
    assert [one.speed(time) for time in (4.0, 5.5, 6.9)] == pytest.approx([-10] * 3, abs=0.3)
    assert one.speed(7.5) == 0.0


@pytest.mark.parametrize(("flag", "angle"), [(1, 25), (2, -10)])
def test_retracted_is_parked_and_neutral_is_forward(bench, flag, angle):
    one = bench(guard={"park_deg": 25}, array={"offset_deg": 10})
    one.live(8.0, one.ground.command(3.0, POINT, 0, 0, NAN, NAN, flag, 0, 1))
    assert one.angle(7.5) == pytest.approx(angle, abs=0.05)
    assert one.attitude(7.5).flags == FOLLOW | flag


@pytest.mark.parametrize(
    ("guard", "options", "angle"),
    [
        ({"park_deg": -190}, {}, -190),
        ({"park_deg": 190}, {"lower_deg": -90, "upper_deg": 90}, 90),
    ],
    ids=["no other turn of it", "the end of the travel on its side"],
)
def test_retracted_is_where_the_order_to_park_leads(bench, guard, options, angle):
    """A cable that is wound the other way round is not parked."""
    one = bench(guard=guard, actuator={"kind": "ideal", "options": options})
    one.live(10.0, one.ground.command(3.0, POINT, 0, 0, NAN, NAN, 1, 0, 1))
    assert one.angle(9.5) == pytest.approx(angle, abs=0.05)


# ---------------------------------------------------------------------------------------------------- with the mission


def test_while_a_task_runs_the_mission_is_in_control_and_nobody_else_points(bench):
    one = bench()
    one.live(
        6.0,
        one.order(3.0, Explore(number=1)),
        one.ground.command(4.0, POINT, 0, 50, NAN, NAN, FOLLOW, 0, 1),
        one.ground.say(4.2, pitchyaw(deg(50))),
    )
    assert one.primary(5.0) == (1, 191)
    assert one.results(POINT) == [DENIED]
    assert Answer.CANCELLED not in one.answers(1)[:1]
    assert one.angle(4.5) == 0.0


def test_taking_control_ends_the_task_and_the_next_set_point_is_obeyed_at_once(bench):
    one = bench()
    one.live(
        9.0,
        one.order(3.0, Explore(number=1)),
        one.ground.command(5.0, CONFIGURE, 255, 190, 255, 190, NAN, NAN, 1),
        one.ground.command(5.02, POINT, 0, 50, NAN, NAN, FOLLOW, 0, 1),
    )
    assert one.answers(1)[-1] is Answer.CANCELLED
    assert one.results(CONFIGURE) + one.results(POINT) == [ACCEPTED, ACCEPTED]
    assert one.primary(5.5) == (255, 190)
    assert one.angle(8.9) == pytest.approx(-50, abs=0.05)


def test_when_control_is_given_back_the_mission_does_not_begin_by_itself(bench):
    one = bench()
    one.live(
        12.0,
        one.order(3.0, Explore(number=1)),
        one.ground.command(5.0, CONFIGURE, *TAKE, 0, 0, 1),
        one.ground.command(6.0, CONFIGURE, *GIVE, 0, 0, 1),
    )
    assert one.answers(1)[-1] is Answer.CANCELLED
    assert one.angle(11.9) == one.angle(7.5)
    assert one.primary(11.0) == (0, 0)


def test_whoever_orders_a_task_takes_control_back(bench):
    one = bench()
    one.live(
        7.0,
        one.ground.command(3.0, CONFIGURE, *TAKE, 0, 0, 1),
        one.ground.command(3.2, POINT, 0, 90, NAN, 10, FOLLOW, 0, 1),
        one.order(4.5, Explore(number=1)),
        one.order(5.5, Cancel(number=2)),
    )
    assert (one.primary(4.4), one.primary(5.2), one.primary(6.5)) == ((255, 190), (1, 191), (0, 0))


def test_a_stream_that_was_in_vain_during_a_task_is_not_obeyed_after_it_until_it_changes(bench):
    one = bench()
    one.live(
        10.0,
        one.order(2.5, Explore(number=1)),
        *one.ground.stream(3.0, 7.0, pitchyaw(deg(50)), 0.1),
        one.order(5.0, Cancel(number=2)),
        one.ground.say(7.5, pitchyaw(deg(40))),
    )
    assert one.angle(7.4) == one.angle(5.8)
    assert one.angle(9.9) == pytest.approx(-40, abs=0.05)


def test_a_stop_wins_until_the_payload_is_armed_again(bench):
    one = bench()
    one.live(
        11.0,
        one.ground.command(3.0, POINT, 0, 90, NAN, 10, FOLLOW, 0, 1),
        one.order(4.0, Stop(number=1)),
        one.ground.command(5.0, POINT, 0, 90, NAN, NAN, FOLLOW, 0, 1),
        one.ground.command(5.5, CONFIGURE, *TAKE, 0, 0, 1),
        one.ground.command(6.0, POINT, 0, 90, NAN, NAN, FOLLOW, 0, 1),
        one.order(7.0, Rearm(number=2)),
        one.ground.command(8.0, POINT, 0, 90, NAN, NAN, FOLLOW, 0, 1),
    )
    assert one.results(POINT) == [ACCEPTED, TEMPORARILY_REJECTED, TEMPORARILY_REJECTED, ACCEPTED]
    assert one.angle(7.9) == one.angle(4.8)
    assert one.attitude(7.0).failure_flags == 0
    assert one.angle(10.9) == pytest.approx(-90, abs=0.05)
    assert State.STOPPED in [state for state, _ in one.states()]


def test_a_command_is_an_order_though_it_says_what_the_last_one_said(bench):
    one = bench()
    same = (POINT, 0, 30, NAN, NAN, FOLLOW, 0, 1)
    one.live(9.0, one.ground.command(3.0, *same), one.ground.command(6.0, *same))
    assert (one.answers(-1), one.answers(-2)) == ([Answer.ACCEPTED, Answer.DONE],) * 2


def test_a_flood_of_set_points_is_a_few_orders_and_the_last_one_counts(bench):
    one = bench()
    steps = [one.ground.say(3.0 + 0.01 * (step // 10), pitchyaw(deg(step / 50))) for step in range(1000)]
    one.live(7.0, *steps)
    assert sum(len(heard.orders) for _, _, heard in one.trace) < 60
    assert one.angle(6.9) == pytest.approx(-999 / 50, abs=0.06)
