"""What is asked of us as a gimbal, and what we say: signs, frames, flags, and numbers that cannot be meant."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_protocols.mavlink import gimbal_messages
from ross_protocols.mavlink.commands import Command
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.gimbal_device import (
    Aim,
    Axis,
    Pose,
    Rest,
    aim_of,
    attitude_status,
    commanded,
    device_information,
    firmware,
    flags_of,
    manager_information,
    set_point_of,
)
from ross_protocols.mavlink.vehicle import quaternion

NAN = math.nan
numbers = st.floats(width=32)
AXIS = Axis(-1.0, 2.0, earth=True, model="tb6600", version="1.2.3")


def pose(**changes):
    values = {"yaw": 0.4, "rate": 0.1, "vehicle": 0.3, "turning": 0.05, "locked": False, "rest": None, "failures": 0}
    return Pose(**values | changes)


@pytest.mark.parametrize(
    ("flags", "earth"),
    [(0, False), (28, True), (32, False), (16, True), (64 | 16, True), (12, False), (32 | 16, False)],
)
def test_the_frame_is_told_by_its_flag_and_else_by_the_lock(flags, earth):
    assert aim_of(flags, 0.5, NAN) == Aim(-0.5, earth)


def test_all_three_messages_ask_for_the_same():
    q = quaternion(0.5, 0.1, 0.0)
    messages = (
        common.MAVLink_gimbal_manager_set_attitude_message(1, 154, 32, 1, q, NAN, NAN, -0.2),
        common.MAVLink_gimbal_device_set_attitude_message(1, 154, 32, q, NAN, NAN, -0.2),
        common.MAVLink_gimbal_manager_set_pitchyaw_message(1, 154, 32, 1, 0.1, 0.5, NAN, -0.2),
    )
    for message in messages:
        asked = set_point_of(message)
        assert asked.target == (1, 154)
        assert (asked.aim.yaw, asked.aim.rate) == pytest.approx((-0.5, 0.2), abs=1e-6)


def test_a_command_speaks_in_degrees():
    aim = commanded(Command(1000, (0.0, 90.0, NAN, NAN, 32.0, 0.0, 1.0), ComponentId(1, 154), long=True))
    assert aim.yaw == pytest.approx(-math.pi / 2)


def test_a_rate_alone_has_a_sign_and_with_an_angle_it_is_the_most():
    assert aim_of(32, NAN, 0.25) == Aim(rate=-0.25)
    assert aim_of(32, 0.5, 0.25) == Aim(-0.5, rate=0.25)
    assert aim_of(32, 0.5, 0.0) == Aim(-0.5)


@given(st.integers(0, 2**32 - 1), numbers, numbers)
def test_whatever_is_asked_is_finite_or_nothing(flags, yaw, rate):
    aim = aim_of(flags, yaw, rate)
    if aim is not None:
        assert all(number is None or math.isfinite(number) for number in (aim.yaw, aim.rate))
        assert (aim.yaw, aim.rate, aim.rest) != (None, None, None)


@given(st.tuples(*[numbers] * 7))
def test_no_command_breaks_it(values):
    aim = commanded(Command(1000, values, ComponentId(1, 154), long=True))
    assert aim is None or isinstance(aim, Aim)


@given(st.lists(numbers, min_size=4, max_size=4), numbers)
def test_no_quaternion_breaks_it(q, rate):
    asked = set_point_of(common.MAVLink_gimbal_device_set_attitude_message(1, 154, 0, q, NAN, NAN, rate))
    assert asked.aim is None or asked.aim.yaw is None or math.isfinite(asked.aim.yaw)


@pytest.mark.parametrize("locked", [False, True])
@pytest.mark.parametrize("vehicle", [None, 0.3])
@pytest.mark.parametrize("rest", [None, Rest.NEUTRAL, Rest.RETRACTED])
def test_exactly_one_frame_is_said(locked, vehicle, rest):
    flags = flags_of(pose(locked=locked, vehicle=vehicle, rest=rest))
    assert flags & (gimbal_messages.VEHICLE_FRAME | gimbal_messages.EARTH_FRAME) in (
        gimbal_messages.VEHICLE_FRAME,
        gimbal_messages.EARTH_FRAME,
    )
    assert bool(flags & gimbal_messages.YAW_LOCK) == bool(flags & gimbal_messages.EARTH_FRAME)


def test_what_we_say_is_what_our_own_driver_reads():
    nose, north = (gimbal_messages.read(attitude_status(0, 1, pose(locked=locked))) for locked in (False, True))
    assert (nose.yaw, nose.rate, nose.earth) == pytest.approx((0.4, 0.1, False))
    assert (north.yaw, north.rate, north.earth) == pytest.approx((0.7, 0.15, True))


def test_the_other_frame_follows_by_what_is_said_beside():
    said = attitude_status(0, 1, pose())
    assert (said.delta_yaw, said.delta_yaw_velocity) == pytest.approx((-0.3, -0.05))


def test_the_limits_turn_around_with_the_yaw():
    for said in (device_information(0, 1, AXIS), manager_information(0, 1, AXIS)):
        assert (said.yaw_min, said.yaw_max) == (-2.0, 1.0)
        assert gimbal_messages.read(said) == gimbal_messages.GimbalTravel(1, -1.0, 2.0)


def test_without_an_end_it_says_so():
    said = device_information(0, 1, Axis(-math.inf, math.inf, earth=False, model="x" * 50, version="1"))
    assert said.cap_flags & gimbal_messages.INFINITE_YAW
    assert gimbal_messages.read(said).upper == math.inf


@pytest.mark.parametrize(("version", "number"), [("0.1.0", 0x000100), ("2.3", 0x000302), ("", 0)])
def test_a_version_has_its_major_number_lowest(version, number):
    assert firmware(version) == number
