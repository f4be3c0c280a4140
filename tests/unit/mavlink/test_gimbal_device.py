"""The turntable as a gimbal that an autopilot manages: the simulated ArduPilot streams to it all the time."""

import math
from contextlib import ExitStack

import numpy as np
import pytest

from gimbal_bench import AUTOPILOT, NAN, GimbalBench, Station, deg, set_attitude
from hand_bench import Base
from ross_payload.events import Answer
from ross_payload.interfaces import Attitude
from ross_payload.mount import AutopilotMount
from ross_payload.orders import Cancel, Explore, Rearm, Stop
from ross_payload.timebase import Timebase
from ross_protocols.mavlink import gimbal_messages
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.gimbal_messages import EARTH_FRAME, VEHICLE_FRAME, YAW_LOCK
from ross_protocols.mavlink.vehicle import VehicleAttitude, euler, gimbal_state
from ross_sim.devices.gimbal_device import Servo
from ross_sim.devices.gimbal_manager import ArduPilot

SERVO = Servo(lower=math.radians(-200), upper=math.radians(200), max_speed=4.0, max_acceleration=2.0)
LOCKED, FOLLOWING = YAW_LOCK | EARTH_FRAME, VEHICLE_FRAME


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
        said = [answer for _, packet in new for answer in self.manager.on_packet(packet, now)]
        self._wire.coming += [self._voice.encode(message) for message in (*said, *self.manager.live(now))]

    def pilot(self, time, yaw, flags=FOLLOWING):
        """A step of a script: the pilot points, clockwise [rad]."""
        message = common.MAVLink_gimbal_manager_set_pitchyaw_message(1, 1, flags, 0, 0.0, yaw, NAN, NAN)
        (packet,) = Decoder().feed(Encoder(255, 190).encode(message))
        return time, lambda: self.manager.on_packet(packet, time)

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
    words = gimbal_messages.failures(before.failure_flags), gimbal_messages.failures(after.failure_flags)
    assert words == ("no data from its manager",) * 2
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


@pytest.mark.soak
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


@pytest.mark.soak
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


def test_nobody_else_may_point_it(bench):
    """Neither a ground station, on either link, nor an autopilot of another vehicle, nor a component of this one."""
    one = bench()
    Vehicle(one)
    others = (one.ground, *(Station(one, AUTOPILOT, *who) for who in ((255, 190), (2, 1), (1, 195))))
    steps = [
        sender.say(4.0 + place + late, set_attitude(deg(angle)))
        for place, sender in enumerate(others)
        for late, angle in ((0.0, 50 + 20 * place), (0.5, 60 + 20 * place))
    ]
    one.live(9.0, *steps)
    assert {one.angle(time) for time in np.arange(4.0, 8.9, 0.1)} == {0.0}


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
