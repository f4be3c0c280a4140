"""The turntable as a gimbal that manages itself: what it says, whom it obeys, and who is in control."""

import math
from contextlib import ExitStack
from itertools import pairwise

import pytest

from gimbal_bench import AUTOPILOT, GROUND, GimbalBench
from hand_bench import Base
from ross_payload.config import Config
from ross_payload.errors import ConfigError
from ross_payload.events import Answer, State
from ross_payload.gimbal import Gimbal
from ross_payload.links import Links
from ross_payload.orders import Cancel, Explore, Rearm, Stop
from ross_protocols import gimbal
from ross_protocols.dialect import common
from ross_protocols.vehicle import euler
from ross_sim.far_end import Fault

REQUEST, INTERVAL, POINT, CONFIGURE = 512, 511, 1000, 1001
ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED = 0, 1, 2, 3
NAN = math.nan
TAKE, GIVE = (-2, -2, -1, -1), (-3, -3, -1, -1)
READY = 3.0  # [s]: by then it speaks
FOLLOW, LOCK = 32, 16 | 64


def deg(angle):
    return math.radians(angle)


def pitchyaw(yaw=NAN, rate=NAN, flags=FOLLOW, device=1):
    return common.MAVLink_gimbal_manager_set_pitchyaw_message(1, 154, flags, device, 0.0, yaw, NAN, rate)


@pytest.fixture
def bench():
    with ExitStack() as stack:
        yield lambda mode="standalone", base=None, **more: GimbalBench(stack, mode, base, **more)


# ---------------------------------------------------------------------------------------------------- what it says


def test_its_first_heartbeat_is_that_of_a_gimbal_and_then_comes_one_a_second(bench):
    one = bench()
    one.live(8.0)
    beats = [beat for beat in one.told("HEARTBEAT") if beat.sender == 154]
    assert {(beat.type, beat.autopilot, beat.system_status) for beat in beats} == {(26, 8, 4)}
    assert all(later.at - beat.at == pytest.approx(1.0, abs=0.03) for beat, later in pairwise(beats))
    spoken = [packet.name for _, packet in one.wires[GROUND].heard if packet.component_id == 154]
    assert spoken[0] == "HEARTBEAT"


@pytest.mark.parametrize(("others", "own"), [((154,), 171), ((154, 171, 172), 173), ((100,), 154)])
def test_a_component_id_that_somebody_has_is_left_to_him(bench, others, own):
    one = bench()
    beat = common.MAVLink_heartbeat_message(26, 8, 0, 0, 4, 3)
    there = [type(one.ground)(one, GROUND, 1, number).say(0.5, beat) for number in others]
    one.live(4.0, *there)
    assert {beat.sender for beat in one.told("HEARTBEAT")} == {own}


def test_the_gimbal_of_another_vehicle_takes_no_id_from_ours(bench):
    one = bench()
    stranger = type(one.ground)(one, GROUND, 7, 154)
    one.live(4.0, stranger.say(0.5, common.MAVLink_heartbeat_message(26, 8, 0, 0, 4, 3)))
    assert {beat.sender for beat in one.told("HEARTBEAT")} == {154}


def test_a_component_id_may_be_configured(bench):
    one = bench(gimbal={"component_id": 174})
    one.live(4.0)
    assert {beat.sender for beat in one.told("HEARTBEAT")} == {174}


def test_it_tells_its_attitude_ten_times_and_its_status_five_times_a_second_on_every_link(bench):
    one = bench()
    one.live(13.0)
    for url in (GROUND, AUTOPILOT):
        assert len(one.told("GIMBAL_DEVICE_ATTITUDE_STATUS", url, 3.0, 13.0)) == pytest.approx(100, abs=2)
        assert len(one.told("GIMBAL_MANAGER_STATUS", url, 3.0, 13.0)) == pytest.approx(50, abs=2)


def test_a_link_may_ask_for_another_rate_and_for_the_usual_one_again(bench):
    one = bench()
    one.live(
        13.0,
        one.ground.command(3.0, INTERVAL, 285, 50_000),
        one.ground.command(8.0, INTERVAL, 285, 0),
        one.ground.command(8.0, INTERVAL, 281, -1),
    )
    name = "GIMBAL_DEVICE_ATTITUDE_STATUS"
    assert len(one.told(name, GROUND, 3.1, 7.9)) == pytest.approx(96, abs=3)
    assert len(one.told(name, GROUND, 8.1, 12.9)) == pytest.approx(48, abs=3)
    assert len(one.told(name, AUTOPILOT, 3.1, 7.9)) == pytest.approx(48, abs=3)
    assert not one.told("GIMBAL_MANAGER_STATUS", GROUND, 8.2)
    assert one.results(INTERVAL) == [ACCEPTED] * 3


def test_its_attitude_is_where_the_array_points_clockwise_from_the_nose(bench):
    one = bench(array={"offset_deg": 10})
    one.live(8.0, one.ground.command(READY, POINT, 0, -30, NAN, NAN, FOLLOW, 0, 1))
    said = one.attitude(7.5)
    assert math.degrees(euler(said.q)[0]) == pytest.approx(-30, abs=0.05)
    assert one.angle(7.5) == pytest.approx(20, abs=0.05)
    assert (said.flags, said.failure_flags, said.gimbal_device_id) == (FOLLOW, 0, 1)
    assert (said.target_system, said.target_component) == (0, 0)
    assert math.isnan(said.delta_yaw)


def test_while_it_turns_it_tells_where_it_is_and_how_fast(bench):
    one = bench()
    one.live(8.0, one.ground.command(READY, POINT, 0, 120, NAN, 20, FOLLOW, 0, 1))
    said = one.attitude(6.0)
    assert math.degrees(said.angular_velocity_z) == pytest.approx(20, abs=0.2)
    assert math.degrees(euler(said.q)[0]) == pytest.approx(-one.angle(said.at), abs=1.0)


def test_where_the_base_points_is_told_too(bench):
    one = bench(base=Base(yaw=deg(40), rate=deg(-5)))
    one.live(6.0)
    said = one.attitude(5.0)
    assert math.degrees(said.delta_yaw) == pytest.approx(-40 + 5 * said.at, abs=0.2)
    assert math.degrees(said.delta_yaw_velocity) == pytest.approx(5, abs=0.01)


def test_a_device_that_holds_a_heading_tells_it_from_north(bench):
    one = bench(base=Base(yaw=deg(20), rate=deg(4)), mount={"yaw_deg": 0})
    one.live(10.0, one.ground.command(READY, POINT, 0, -70, NAN, NAN, LOCK, 0, 1))
    assert [one.heading(time) for time in (7.0, 9.0)] == pytest.approx([70, 70], abs=0.7)
    said = one.attitude(9.0)
    assert said.flags == LOCK
    assert math.degrees(euler(said.q)[0]) == pytest.approx(-70, abs=0.7)


def test_on_request_it_says_what_it_is(bench):
    one = bench(guard={"lower_deg": -100, "upper_deg": 60}, array={"offset_deg": 5})
    one.live(5.0, one.ground.command(3.0, REQUEST, 283), one.ground.command(3.5, REQUEST, 280))
    (device,) = one.told("GIMBAL_DEVICE_INFORMATION")
    (manager,) = one.told("GIMBAL_MANAGER_INFORMATION")
    for said in (device, manager):
        assert (math.degrees(said.yaw_min), math.degrees(said.yaw_max)) == pytest.approx((-65, 95))
        assert (said.pitch_min, said.pitch_max, said.roll_min, said.roll_max) == (0, 0, 0, 0)
        assert (said.gimbal_device_id, said.cap_flags) == (1, 1 | 2 | 256 | 512)
    assert (device.vendor_name, device.model_name) == ("RoSS", "ideal")
    assert one.results(REQUEST) == [ACCEPTED, ACCEPTED]


def test_a_request_to_all_components_is_answered(bench):
    one = bench()
    one.live(4.0, one.ground.command(3.0, REQUEST, 280, component=0))
    assert len(one.told("GIMBAL_MANAGER_INFORMATION")) == 1


@pytest.mark.parametrize(("yaw", "flags"), [(None, 0), (0.0, 1024 | 4096)])
def test_that_it_can_hold_a_heading_is_said_where_the_mount_can_be_known(bench, yaw, flags):
    one = bench(mount={} if yaw is None else {"yaw_deg": yaw})
    one.live(4.0, one.ground.command(3.0, REQUEST, 283))
    (said,) = one.told("GIMBAL_DEVICE_INFORMATION")
    assert said.cap_flags & (1024 | 4096) == flags


def test_a_fault_of_the_actuator_shows_in_the_attitude_and_the_heartbeat(bench):
    one = bench()
    one.live(8.0, (4.0, lambda: one.far_end.afflict(Fault.SILENT)))
    assert one.attitude(3.9).failure_flags == 0
    assert gimbal.failures(one.attitude(7.0).failure_flags) == "communication inside the gimbal"
    assert one.told("HEARTBEAT")[-1].system_status == 5


# ---------------------------------------------------------------------------------------------------- who is obeyed


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


# ---------------------------------------------------------------------------------------------------- configuration


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"actuator": {"kind": "mavlink_gimbal"}, "gimbal": {"mode": "device"}}, "wanted 'off'"),
        ({"telemetry": {"component_id": 171}, "gimbal": {"mode": "device", "component_id": 171}}, "another one"),
    ],
)
def test_what_cannot_be_together_is_one_clear_line(tables, words):
    with pytest.raises(ValueError, match=words):
        Config.model_validate(tables)


def test_a_device_needs_a_link_to_its_manager(bench):
    one = bench()
    with Links(one.clock) as links, pytest.raises(ConfigError, match="wanted a link of role"):
        config = Config.model_validate({"actuator": {"kind": "ideal"}, "gimbal": {"mode": "device"}})
        Gimbal(config, one.clock, links, one.actuator, one.base, give=one.runner.order)
