"""The turntable as a gimbal that manages itself: what it is and says."""

import math
from contextlib import ExitStack
from itertools import pairwise

import pytest

from gimbal_bench import (
    ACCEPTED,
    AUTOPILOT,
    FOLLOW,
    GROUND,
    INTERVAL,
    LOCK,
    NAN,
    POINT,
    READY,
    REQUEST,
    GimbalBench,
    deg,
)
from hand_bench import Base
from ross_payload.config import Config
from ross_payload.errors import ConfigError
from ross_payload.mavlink import Router
from ross_payload.mavlink.gimbal import Gimbal
from ross_protocols.mavlink import gimbal_messages
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.vehicle import euler
from ross_sim.devices.far_end import Fault


@pytest.fixture
def bench():
    with ExitStack() as stack:
        yield lambda mode="standalone", base=None, **more: GimbalBench(stack, mode, base, **more)


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


def test_a_radio_keeps_two_thirds_of_its_budget_for_others(bench):
    one = bench(bytes_s=350)
    one.live(23.0)
    said = [packet for time, packet in one.wires[GROUND].heard if time > 3.0]
    assert 50 < sum(len(packet.frame) for packet in said) / 20 < 350 / 3 + 25
    assert len([packet for packet in said if packet.name == "HEARTBEAT"]) == 20
    assert len(one.told("GIMBAL_DEVICE_ATTITUDE_STATUS", AUTOPILOT, 3.0)) == pytest.approx(200, abs=2)


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
    assert gimbal_messages.failures(one.attitude(7.0).failure_flags) == "communication inside the gimbal"
    assert one.told("HEARTBEAT")[-1].system_status == 5


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"actuator": {"kind": "mavlink_gimbal"}, "gimbal": {"mode": "device"}}, "expected 'off'"),
        ({"telemetry": {"component_id": 171}, "gimbal": {"mode": "device", "component_id": 171}}, "another id"),
    ],
)
def test_what_cannot_be_together_is_one_clear_line(tables, words):
    with pytest.raises(ValueError, match=words):
        Config.model_validate(tables)


def test_a_device_needs_a_link_to_its_manager(bench):
    one = bench()
    with Router(one.clock) as links, pytest.raises(ConfigError, match="expected a link with role"):
        config = Config.model_validate({"actuator": {"kind": "ideal"}, "gimbal": {"mode": "device"}})
        Gimbal(config, one.clock, links, one.actuator, one.base, give=one.runner.order)
