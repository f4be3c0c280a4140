"""The turntable as a gimbal that an autopilot manages: the simulated ArduPilot streams to it all the time."""

import math
from contextlib import ExitStack

import pytest

from gimbal_bench import AUTOPILOT, GimbalBench, Station
from hand_bench import Base
from ross_payload.events import Answer
from ross_payload.interfaces import Attitude
from ross_payload.mount import AutopilotMount
from ross_payload.orders import Cancel, Explore, Rearm, Stop
from ross_payload.timebase import Timebase
from ross_protocols import gimbal
from ross_protocols.codec import Decoder, Encoder
from ross_protocols.dialect import common
from ross_protocols.gimbal import EARTH_FRAME, VEHICLE_FRAME, YAW_LOCK
from ross_protocols.vehicle import VehicleAttitude, euler, gimbal_state, quaternion
from ross_sim.gimbal_device import Servo
from ross_sim.gimbal_manager import ArduPilot

NAN = math.nan
SERVO = Servo(lower=math.radians(-200), upper=math.radians(200), max_speed=4.0, max_acceleration=2.0)
LOCKED, FOLLOWING = YAW_LOCK | EARTH_FRAME, VEHICLE_FRAME


def deg(angle):
    return math.radians(angle)


def set_attitude(yaw=NAN, rate=NAN, flags=0, target=(1, 154)):
    """GIMBAL_DEVICE_SET_ATTITUDE; clockwise."""
    q = quaternion(yaw, 0.0, 0.0) if math.isfinite(yaw) else (NAN,) * 4
    return common.MAVLink_gimbal_device_set_attitude_message(*target, flags, q, NAN, NAN, rate)


class Vehicle:
    """The simulated autopilot at the far end of its link, and a pilot who points through it."""

    def __init__(self, bench):
        self._bench, self._wire = bench, bench.wires[AUTOPILOT]
        self.manager = ArduPilot((1, 1), (1, 154), SERVO, lambda now: bench.base.attitude(now).yaw)
        self._voice, self._read = Encoder(1, 1), 0
        self.silent = False
        bench.clock.before_calls(self._live)

    def _live(self, now):
        if self.silent:
            return
        new, self._read = self._wire.heard[self._read :], len(self._wire.heard)
        said = [answer for _, packet in new for answer in self.manager.hear(packet, now)]
        self._wire.coming += [self._voice.encode(message) for message in (*said, *self.manager.live(now))]

    def pilot(self, time, yaw, flags=FOLLOWING):
        """A step of a script: the pilot points, clockwise [rad]."""
        message = common.MAVLink_gimbal_manager_set_pitchyaw_message(1, 1, flags, 0, 0.0, yaw, NAN, NAN)
        (packet,) = Decoder().feed(Encoder(255, 190).encode(message))
        return time, lambda: self.manager.hear(packet, time)

    def hush(self):
        self.silent = True

    def speak(self):
        self.silent = False


@pytest.fixture
def bench():
    with ExitStack() as stack:
        yield lambda base=None, **more: GimbalBench(stack, "device", base, **more)


def test_the_autopilot_finds_it_and_manages_it(bench):
    one = bench()
    Vehicle(one)
    one.live(5.0)
    (said,) = one.told("GIMBAL_DEVICE_INFORMATION", AUTOPILOT)
    assert said.gimbal_device_id == 0
    assert one.attitude(4.9).gimbal_device_id == 0
    assert one.attitude(4.9).failure_flags == 0


def test_without_a_manager_it_says_so(bench):
    one = bench()
    vehicle = Vehicle(one)
    one.live(8.0, (5.0, vehicle.hush))
    before, after = one.attitude(1.7), one.attitude(7.0)
    assert (gimbal.failures(before.failure_flags), gimbal.failures(after.failure_flags)) == ("it hears no manager",) * 2
    assert one.attitude(4.9).failure_flags == 0
    assert one.told("HEARTBEAT")[-1].system_status == 4


def test_what_the_autopilot_begins_with_is_no_order(bench):
    one = bench()
    vehicle = Vehicle(one)
    one.live(6.0, vehicle.pilot(0.5, deg(40)))
    assert one.angle(5.9) == 0.0


def test_an_autopilot_that_comes_back_moves_nothing(bench):
    one = bench()
    vehicle = Vehicle(one)
    one.live(
        12.0,
        vehicle.pilot(3.5, deg(30)),
        (6.0, vehicle.hush),
        vehicle.pilot(7.0, deg(-50)),
        (8.0, vehicle.speak),
        vehicle.pilot(10.0, deg(20)),
    )
    assert one.angle(9.9) == pytest.approx(-30, abs=0.05)
    assert one.angle(11.9) == pytest.approx(-20, abs=0.05)


def test_the_pilot_points_it(bench):
    one = bench(array={"offset_deg": 10})
    vehicle = Vehicle(one)
    one.live(8.0, vehicle.pilot(4.0, deg(50)))
    assert one.angle(7.9) == pytest.approx(-60, abs=0.05)
    assert math.degrees(euler(one.attitude(7.9).q)[0]) == pytest.approx(50, abs=0.05)
    assert one.attitude(7.9).flags == FOLLOWING


def test_the_pilot_locks_it_to_north(bench):
    one = bench(Base(yaw=deg(10), rate=deg(8)))
    vehicle = Vehicle(one)
    one.live(12.0, vehicle.pilot(4.0, deg(-60), LOCKED))
    assert [one.heading(time) for time in (8.0, 10.0, 11.9)] == pytest.approx([60] * 3, abs=0.8)
    assert one.attitude(11.0).flags == LOCKED


class Told(Base):
    """A base of which the payload knows what the autopilot says."""

    mount = None

    def attitude(self, time):
        return self.mount.attitude(time) if self.mount else Attitude(0.0, known=False)


def test_a_lock_is_held_by_what_the_autopilot_tells_gimbals(bench):
    one = bench(Told(yaw=deg(10), rate=deg(8)))
    one.base.mount = AutopilotMount(one.links.component(191), one.clock, Timebase(one.clock), fresh=0.5, system_id=1)
    steps = [
        one.autopilot.say(
            0.02 * step, gimbal_state(VehicleAttitude(0.02 * step, deg(10 + 0.16 * step), 0.0, 0.0, deg(8)))
        )
        for step in range(600)
    ]
    first, second = set_attitude(deg(20), flags=28), set_attitude(deg(-60), flags=28)
    one.live(12.0, *steps, *one.autopilot.stream(2.0, 4.0, first), *one.autopilot.stream(4.0, 12.0, second))
    true = [one.angle(time) + 10 + 8 * time for time in (8.0, 10.0, 11.9)]
    assert true == pytest.approx([60] * 3, abs=1.0)
    assert one.attitude(11.0).flags == LOCKED


def test_a_lock_goes_on_when_the_attitude_comes_back(bench):
    one = bench(Base(yaw=0.0, rate=deg(5)))
    vehicle = Vehicle(one)

    def lose():
        one.base.yaw = None

    def find():
        one.base.yaw = 0.0

    one.live(12.0, vehicle.pilot(3.5, deg(-40), LOCKED), (6.0, lose), (8.0, find))
    assert one.angle(7.9) == one.angle(7.0)
    assert one.heading(11.9) == pytest.approx(40, abs=0.8)


def test_its_stream_does_not_fight_the_mission_and_is_obeyed_after_it_when_it_changes(bench):
    one = bench()
    vehicle = Vehicle(one)
    one.live(
        14.0,
        vehicle.pilot(3.5, deg(30)),
        one.order(6.0, Explore(number=1)),
        vehicle.pilot(7.0, deg(90)),
        one.order(9.0, Cancel(number=2)),
        vehicle.pilot(11.0, deg(80)),
    )
    assert one.angle(5.9) == pytest.approx(-30, abs=0.05)
    assert one.answers(1) == [Answer.ACCEPTED, Answer.CANCELLED]
    assert one.attitude(8.0).flags == FOLLOWING
    assert one.attitude(8.0).failure_flags == 0
    assert one.angle(10.9) == one.angle(10.0) > -60
    assert one.angle(13.9) == pytest.approx(-80, abs=0.05)


def test_an_operator_who_cancels_is_not_overruled_by_the_stream(bench):
    one = bench()
    vehicle = Vehicle(one)
    one.live(12.0, vehicle.pilot(3.5, deg(150)), one.order(4.5, Cancel(number=1)), vehicle.pilot(9.0, deg(20)))
    assert 0 > one.angle(8.9) == one.angle(7.0) > -150
    assert one.angle(11.9) == pytest.approx(-20, abs=0.05)


def test_after_a_stop_the_stream_moves_nothing_until_it_changes(bench):
    one = bench()
    vehicle = Vehicle(one)
    one.live(
        13.0,
        vehicle.pilot(3.5, deg(150)),
        one.order(4.5, Stop(number=1)),
        one.order(7.0, Rearm(number=2)),
        vehicle.pilot(10.0, deg(20)),
    )
    assert one.angle(9.9) == one.angle(6.9)
    assert one.angle(12.9) == pytest.approx(-20, abs=0.05)


@pytest.mark.parametrize("who", ["ground", "other", "stranger", "neighbour"])
def test_nobody_else_may_point_it(bench, who):
    one = bench()
    Vehicle(one)
    senders = {
        "ground": one.ground,
        "other": Station(one, AUTOPILOT, 255, 190),
        "stranger": Station(one, AUTOPILOT, 2, 1),
        "neighbour": Station(one, AUTOPILOT, 1, 195),
    }
    one.live(6.0, senders[who].say(4.0, set_attitude(deg(50))), senders[who].say(4.5, set_attitude(deg(60))))
    assert one.angle(5.9) == 0.0


def test_it_is_no_manager(bench):
    one = bench()
    Vehicle(one)
    numbers = (1000, 1001)
    one.live(6.0, *[one.ground.command(4.0, number, -2, -2, -1, -1) for number in numbers])
    assert [one.results(number) for number in numbers] == [[3], [3]]
    assert not one.told("GIMBAL_MANAGER_STATUS", AUTOPILOT)


def test_a_rate_whose_sender_dies_ends(bench):
    one = bench()
    steps = [
        *one.autopilot.stream(2.5, 4.0, set_attitude(0.0)),
        *one.autopilot.stream(4.0, 6.0, set_attitude(rate=deg(20))),
    ]
    one.live(10.0, *steps)
    assert one.speed(5.9) == pytest.approx(-20, abs=0.3)
    assert one.speed(7.2) == 0.0
    assert one.angle(9.9) == pytest.approx(-20 * 2.5, abs=4)


# What `gimbal_device_tester`, an example program of MAVSDK, expects of a device, point by point. It is an autopilot of
# system 33 that streams set-points to everybody 20 times a second; its margin is 5 deg. It asks for pitch, too: what a
# gimbal without a pitch axis cannot do is not here.

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
def tested(bench):
    """A payload that takes its system id from the tester, and the tester."""
    quick = {"max_acceleration_deg_s2": 400.0, "lower_deg": -120, "upper_deg": 120}
    swift = {"kind": "ideal", "options": {"max_acceleration_deg_s2": 400.0}}

    def make(base=None):
        one = bench(base, guard=quick, actuator=swift)
        one.links.system_id = 0
        return one, Examiner(one)

    return make


def yaw_of(one, time):
    return math.degrees(euler(one.attitude(time, AUTOPILOT).q)[0])


def test_mavsdk_its_ids_and_types_are_those_of_a_gimbal_of_this_vehicle(tested):
    one, tester = tested()
    one.live(4.0, *tester.steps)
    said = [packet for _, packet in one.wires[AUTOPILOT].heard if packet.name == "GIMBAL_DEVICE_ATTITUDE_STATUS"]
    assert {(packet.system_id, packet.component_id) for packet in said} == {(33, 154)}
    assert {(packet.message.target_system, packet.message.target_component) for packet in said} == {(0, 0)}
    assert {beat.type for beat in one.told("HEARTBEAT", AUTOPILOT) if beat.sender == 154} == {26}


def test_mavsdk_it_tells_its_information_within_two_seconds(tested):
    one, tester = tested()
    request = common.MAVLink_command_long_message(33, 154, 512, 0, 283, 0, 0, 0, 0, 0, 0)
    one.live(5.0, *tester.steps, Station(one, AUTOPILOT, 33, 1).say(3.0, request))
    (said,) = one.told("GIMBAL_DEVICE_INFORMATION", AUTOPILOT, 3.0, 5.0)
    assert (math.degrees(said.yaw_min), math.degrees(said.yaw_max)) == pytest.approx((-120, 120))
    assert (said.roll_min, said.roll_max, said.pitch_min, said.pitch_max) == (0, 0, 0, 0)
    assert [ack.result for ack in one.told("COMMAND_ACK", AUTOPILOT)] == [0]


def test_mavsdk_its_attitude_comes_ten_times_a_second(tested):
    one, tester = tested()
    one.live(8.0, *tester.steps)
    said = one.told("GIMBAL_DEVICE_ATTITUDE_STATUS", AUTOPILOT, 3.0, 8.0)
    assert len(said) == pytest.approx(50, abs=2)
    assert {frame.flags & (VEHICLE_FRAME | EARTH_FRAME) for frame in said} <= {VEHICLE_FRAME, EARTH_FRAME}


def test_mavsdk_it_looks_forward_at_first(tested):
    one, tester = tested()
    one.live(4.0, *tester.steps)
    assert abs(yaw_of(one, 3.9)) < 1.0


def test_mavsdk_it_pans_to_its_limits_in_two_seconds_each(tested):
    one, tester = tested()
    ends = [(yaw, tester.then(2.0, yaw=yaw)) for yaw in (0.0, 120.0, 0.0, -120.0, 0.0)]
    one.live(14.0, *tester.steps)
    assert [yaw_of(one, end) for _, end in ends] == pytest.approx([yaw for yaw, _ in ends], abs=MARGIN)


def test_mavsdk_locked_it_points_from_north_while_the_vehicle_yaws(tested):
    one, tester = tested(Base(yaw=0.0))
    tester.then(2.0, yaw=0.0, flags=28)
    turned = tester.then(2.0, yaw=0.0, flags=28)
    ends = [(yaw, tester.then(2.0, yaw=yaw, flags=28)) for yaw in (60.0, -60.0, 0.0)]

    def yaw_left():
        one.base.yaw = deg(30)

    one.live(14.0, *tester.steps, (5.0, yaw_left))
    assert one.heading(turned) == pytest.approx(0.0, abs=MARGIN)
    assert [yaw_of(one, end) for _, end in ends] == pytest.approx([yaw for yaw, _ in ends], abs=MARGIN)


def test_mavsdk_it_pans_at_a_rate_and_stops(tested):
    one, tester = tested()
    tester.then(2.0, yaw=0.0)
    right = tester.then(5.0, rate=5.0)
    still = tester.then(0.5, rate=0.0)
    left = tester.then(5.0, rate=-10.0)
    one.live(16.5, *tester.steps)
    assert yaw_of(one, right) == pytest.approx(25, abs=MARGIN)
    assert yaw_of(one, left) == pytest.approx(yaw_of(one, still) - 50, abs=MARGIN)


def test_mavsdk_an_angle_with_a_rate_is_reached_at_this_rate(tested):
    one, tester = tested()
    begin = tester.then(2.0, yaw=0.0)
    end = tester.then(4.0, yaw=20.0, rate=5.0)
    one.live(10.0, *tester.steps)
    assert yaw_of(one, (begin + end) / 2) == pytest.approx(10, abs=MARGIN)
    assert yaw_of(one, end) == pytest.approx(20, abs=MARGIN)
