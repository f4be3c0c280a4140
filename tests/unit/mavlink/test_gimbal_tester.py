"""What `gimbal_device_tester`, an example program of MAVSDK, expects of a device, point by point.

It is an autopilot of system 33 that streams set-points to everybody 20 times a second; its margin is 5 deg. It asks for
pitch, too: what a gimbal without a pitch axis cannot do is not here.
"""

import math
from contextlib import ExitStack

import pytest

from gimbal_bench import AUTOPILOT, NAN, GimbalBench, Station, deg, set_attitude
from hand_bench import Base
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.gimbal_messages import EARTH_FRAME, VEHICLE_FRAME
from ross_protocols.mavlink.vehicle import euler

MARGIN = 5.0  # [deg]


class Examiner:
    """The stream of MAVSDK's tester: set-points to everybody, with its flags."""

    def __init__(self, bench):
        self._say = Station(bench, AUTOPILOT, 33, 1).say
        self.steps = [self._say(0.5, common.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3))]
        self._end = 3.0
        self._hold(2.0, self._end, 0.0)

    def _hold(self, begin, end, yaw=NAN, rate=NAN, flags=12):
        message = set_attitude(deg(yaw), deg(rate), flags, target=(0, 0))
        self.steps += [self._say(begin + 0.05 * step, message) for step in range(round((end - begin) / 0.05))]

    def then(self, seconds, **what):
        """Stream something for so long [s]; return when it ends."""
        begin, self._end = self._end, self._end + seconds
        self._hold(begin, self._end, **what)
        return self._end - 0.01


@pytest.fixture
def tested():
    """A payload that takes its system id from the tester, and the tester."""
    quick = {"max_acceleration_deg_s2": 400.0, "lower_deg": -120, "upper_deg": 120}
    swift = {"kind": "ideal", "options": {"max_acceleration_deg_s2": 400.0}}

    with ExitStack() as stack:

        def make(base=None):
            one = GimbalBench(stack, "device", base, guard=quick, actuator=swift)
            one.links.system_id = 0
            return one, Examiner(one)

        yield make


def yaw_of(one, time):
    return math.degrees(euler(one.attitude(time, AUTOPILOT).q)[0])


def test_its_ids_and_types_are_those_of_a_gimbal_of_this_vehicle(tested):
    one, tester = tested()
    one.live(4.0, *tester.steps)
    said = [packet for _, packet in one.wires[AUTOPILOT].heard if packet.name == "GIMBAL_DEVICE_ATTITUDE_STATUS"]
    assert {packet.sender for packet in said} == {(33, 154)}
    assert {(packet.message.target_system, packet.message.target_component) for packet in said} == {(0, 0)}
    assert {beat.type for beat in one.told("HEARTBEAT", AUTOPILOT) if beat.sender == 154} == {26}


def test_it_tells_its_information_within_two_seconds(tested):
    one, tester = tested()
    request = common.MAVLink_command_long_message(33, 154, 512, 0, 283, 0, 0, 0, 0, 0, 0)
    one.live(5.0, *tester.steps, Station(one, AUTOPILOT, 33, 1).say(3.0, request))
    (said,) = one.told("GIMBAL_DEVICE_INFORMATION", AUTOPILOT, 3.0, 5.0)
    assert (math.degrees(said.yaw_min), math.degrees(said.yaw_max)) == pytest.approx((-120, 120))
    assert (said.roll_min, said.roll_max, said.pitch_min, said.pitch_max) == (0, 0, 0, 0)
    assert [ack.result for ack in one.told("COMMAND_ACK", AUTOPILOT)] == [0]


def test_its_attitude_comes_ten_times_a_second(tested):
    one, tester = tested()
    one.live(8.0, *tester.steps)
    said = one.told("GIMBAL_DEVICE_ATTITUDE_STATUS", AUTOPILOT, 3.0, 8.0)
    assert len(said) == pytest.approx(50, abs=2)
    assert {frame.flags & (VEHICLE_FRAME | EARTH_FRAME) for frame in said} <= {VEHICLE_FRAME, EARTH_FRAME}


def test_it_looks_forward_at_first(tested):
    one, tester = tested()
    one.live(4.0, *tester.steps)
    assert abs(yaw_of(one, 3.9)) < 1.0


@pytest.mark.soak
def test_it_pans_to_its_limits_in_two_seconds_each(tested):
    one, tester = tested()
    ends = [(yaw, tester.then(2.0, yaw=yaw)) for yaw in (0.0, 120.0, 0.0, -120.0, 0.0)]
    one.live(14.0, *tester.steps)
    assert [yaw_of(one, end) for _, end in ends] == pytest.approx([yaw for yaw, _ in ends], abs=MARGIN)


@pytest.mark.soak
def test_locked_it_points_from_north_while_the_vehicle_yaws(tested):
    one, tester = tested(Base(yaw=0.0))
    tester.then(2.0, yaw=0.0, flags=28)
    turned = tester.then(2.0, yaw=0.0, flags=28)
    ends = [(yaw, tester.then(2.0, yaw=yaw, flags=28)) for yaw in (60.0, -60.0, 0.0)]

    def yaw_left():
        one.base.yaw = deg(30)

    one.live(14.0, *tester.steps, (5.0, yaw_left))
    assert one.heading(turned) == pytest.approx(0.0, abs=MARGIN)
    assert [yaw_of(one, end) for _, end in ends] == pytest.approx([yaw for yaw, _ in ends], abs=MARGIN)


def test_it_pans_at_a_rate_and_stops(tested):
    one, tester = tested()
    tester.then(2.0, yaw=0.0)
    right = tester.then(5.0, rate=5.0)
    still = tester.then(0.5, rate=0.0)
    left = tester.then(5.0, rate=-10.0)
    one.live(16.5, *tester.steps)
    assert yaw_of(one, right) == pytest.approx(25, abs=MARGIN)
    assert yaw_of(one, left) == pytest.approx(yaw_of(one, still) - 50, abs=MARGIN)


@pytest.mark.soak
def test_an_angle_with_a_rate_is_reached_at_this_rate(tested):
    one, tester = tested()
    begin = tester.then(2.0, yaw=0.0)
    end = tester.then(4.0, yaw=20.0, rate=5.0)
    one.live(10.0, *tester.steps)
    assert yaw_of(one, (begin + end) / 2) == pytest.approx(10, abs=MARGIN)
    assert yaw_of(one, end) == pytest.approx(20, abs=MARGIN)
