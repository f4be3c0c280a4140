"""The simulated gimbal manager beside what an ArduPilot does; what the driver makes of one that refuses or pretends."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from examples import examples, in_soak
from rigs import rig_of
from ross_payload.actuators.registry import open_actuator
from ross_payload.config import Config
from ross_payload.errors import ActuatorFault
from ross_payload.interfaces import Services
from ross_protocols.mavlink import gimbal_messages
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.vehicle import quaternion
from ross_sim.clock import SimClock
from ross_sim.devices.gimbal_device import Device, Servo
from ross_sim.devices.gimbal_far_end import GimbalFarEnd

SERVO = Servo(math.radians(-202), math.radians(202), max_speed=2.0, max_acceleration=4.0)
ACCEPTED, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4
NAN = math.nan
QUARTER = math.pi / 2
ATTITUDE_NOW = common.MAVLink_command_long_message(1, 1, 512, 0, 30.0, *[0.0] * 6)


class Ground:
    """A ground station alone with an autopilot and its gimbal, in simulated time."""

    def __init__(self, **far_end):
        self.clock = SimClock()
        self.far_end = GimbalFarEnd(SERVO, autopilot=True, **far_end)
        self.clock.before_calls(self.far_end.advance)
        self.clock.sleep(1.5)
        self.encoder, self.decoder = Encoder(255, 190), Decoder()

    def say(self, message):
        """Send; return what is said within 50 ms."""
        self.far_end.port.arrived.clear()
        self.far_end.port.sent.append(self.encoder.encode(message))
        self.clock.sleep(0.05)
        return [packet.message for packet in self.decoder.feed(b"".join(self.far_end.port.arrived))]

    def said(self, seconds):
        """What is said in the time to come."""
        self.far_end.port.arrived.clear()
        self.clock.sleep(seconds)
        return [packet.message for packet in self.decoder.feed(b"".join(self.far_end.port.arrived))]

    def listen(self, seconds):
        """The names of what is said in the time to come."""
        return [message.get_type() for message in self.said(seconds)]

    def order(self, number, *values):
        numbers = [*values, *[0.0] * (7 - len(values))]
        said = self.say(common.MAVLink_command_long_message(1, 1, number, 0, *numbers))
        return next(message.result for message in said if message.get_type() == "COMMAND_ACK")

    def turned(self):
        """Where the gimbal points two seconds later [deg], clockwise."""
        self.clock.sleep(2.0)
        return -math.degrees(self.far_end.angle())


@pytest.fixture
def ground():
    return Ground()


def test_command_1000_points_in_degrees_clockwise(ground):
    assert ground.order(1000, 0.0, 30.0, NAN, NAN, 12.0, 0.0, 1.0) == ACCEPTED
    assert ground.turned() == pytest.approx(30.0, abs=0.05)


def test_command_1000_as_an_integer_turns_at_a_rate_until_it_is_stopped(ground):
    def rate(degrees):
        numbers = (NAN, NAN, 0.0, degrees, 12, 0, 0.0)
        return common.MAVLink_command_int_message(1, 1, 0, 1000, 0, 0, *numbers)

    ground.say(rate(10.0))
    assert ground.turned() == pytest.approx(20.0, abs=2.0)
    ground.say(rate(0.0))
    stands = ground.turned()
    assert ground.turned() == pytest.approx(stands, abs=0.05)


def test_message_282_points_by_a_quaternion(ground):
    q = quaternion(math.radians(-25), 0.0, 0.0)
    ground.say(common.MAVLink_gimbal_manager_set_attitude_message(1, 1, 12, 1, q, NAN, NAN, NAN))
    assert ground.turned() == pytest.approx(-25.0, abs=0.05)


def test_message_287_with_angles_and_rates_is_ignored(ground):
    ground.say(common.MAVLink_gimbal_manager_set_pitchyaw_message(1, 1, 32, 0, 0.0, 0.5, 0.0, 0.1))
    assert ground.turned() == pytest.approx(0.0, abs=0.05)


@pytest.mark.parametrize(
    ("number", "values", "result"),
    [
        (1000, (NAN, NAN, NAN, NAN), FAILED),
        (1000, (0.0, 30.0, NAN, NAN, 0.0, 0.0, 5.0), FAILED),
        (1001, (-2.0, -2.0, -1.0, -1.0, 0.0, 0.0, 5.0), FAILED),
        (1001, (300.0, 1.0), FAILED),
        (1001, (-2.0, -2.0, -1.0, -1.0), ACCEPTED),
        (512, (99999.0,), FAILED),
        (512, (NAN,), ACCEPTED),
        (512, (283.0,), FAILED),
        (512, (281.0,), ACCEPTED),
        (511, (281.0, 200_000.0), ACCEPTED),
        (400, (1.0,), UNSUPPORTED),
    ],
)
def test_what_a_command_is_answered_with(ground, number, values, result):
    assert ground.order(number, *values) == result


def test_control_is_recorded_for_whom_it_is_asked_and_given_back_by_them_alone(ground):
    ground.order(1001, 7.0, 8.0)
    assert ground.far_end.autopilot.primary == (7, 8)
    ground.order(1001, -3.0, -3.0)
    assert ground.far_end.autopilot.primary == (7, 8)
    ground.order(1001, -2.0, -2.0)
    assert ground.far_end.autopilot.primary == (255, 190)
    ground.order(1001, -3.0, -3.0)
    assert ground.far_end.autopilot.primary == (0, 0)


def test_who_is_in_control_is_said_on_change_and_on_request_and_not_in_a_stream(ground):
    ground.order(511, 281.0, 200_000.0)
    said = ground.listen(10.0)
    assert said.count("GIMBAL_MANAGER_STATUS") == 0
    ground.order(1001, -2.0, -2.0)
    ground.order(1001, -2.0, -2.0)
    assert ground.listen(0.2).count("GIMBAL_MANAGER_STATUS") == 0
    ground.order(1001, -3.0, -3.0)
    assert 0 < ground.listen(60.0).count("GIMBAL_MANAGER_STATUS") <= 2


def test_a_restart_forgets_who_is_in_control_and_begins_its_clock_again(ground):
    ground.order(1001, -2.0, -2.0)
    ground.far_end.autopilot.restart(ground.clock.now())
    ground.clock.sleep(1.5)
    assert ground.order(512, 281.0) == ACCEPTED
    assert ground.far_end.autopilot.primary == (0, 0)
    (said,) = [one for one in ground.say(ATTITUDE_NOW) if one.get_type() == "ATTITUDE"][:1]
    assert said.time_boot_ms < 2000


def test_reports_are_a_few_milliseconds_older_than_their_arrival(ground):
    ages = set()
    for _ in range(200):
        for message in ground.said(0.01):
            if message.get_type() == "GIMBAL_DEVICE_ATTITUDE_STATUS":
                ages.add(round(ground.clock.now() * 1e3) - message.time_boot_ms)
    assert len(ages) > 1
    assert min(ages) > 0


numbers = st.one_of(
    st.floats(width=32), st.sampled_from([-3.0, -2.0, -1.0, 0.0, 1.0, 280.0, 281.0, 283.0, 284.0, 285.0, NAN])
)
quaternions = st.lists(numbers, min_size=4, max_size=4)
whom = st.sampled_from([(1, 1), (1, 154), (0, 0), (1, 0)])
flags, ids = st.integers(0, 255), st.integers(0, 255)
orders = st.builds(
    lambda to, number, values: common.MAVLink_command_long_message(*to, number, 0, *values),
    whom,
    st.sampled_from([511, 512, 1000, 1001, 400]),
    st.lists(numbers, min_size=7, max_size=7),
)
points = st.builds(
    lambda to, flags, device, values: common.MAVLink_gimbal_manager_set_pitchyaw_message(*to, flags, device, *values),
    whom,
    flags,
    ids,
    quaternions,
)
attitudes = st.builds(
    lambda to, flags, q, rates: common.MAVLink_gimbal_device_set_attitude_message(*to, flags, q, *rates),
    whom,
    flags,
    quaternions,
    st.lists(numbers, min_size=3, max_size=3),
)


@settings(max_examples=examples(60))
@given(said=st.lists(st.one_of(orders, points, attitudes, st.binary(max_size=40)), max_size=20))
def test_whatever_is_said_to_it_the_gimbal_lives_within_its_travel(said):
    ground = Ground()
    for message in said:
        if isinstance(message, bytes):
            ground.far_end.port.sent.append(message)
        else:
            ground.far_end.port.sent.append(ground.encoder.encode(message))
        ground.clock.sleep(0.05)
        assert SERVO.lower <= ground.far_end.angle() <= SERVO.upper
    ground.clock.sleep(1.0)
    ground.far_end.port.arrived.clear()
    ground.clock.sleep(1.1)
    names = {packet.name for packet in Decoder().feed(b"".join(ground.far_end.port.arrived))}
    assert "HEARTBEAT" in names


class Bench:
    """The guarded driver as the client of the simulated autopilot."""

    def __init__(self, far_end, **options):
        config = Config.model_validate({"actuator": {"kind": "mavlink_gimbal", "options": options}})
        self.clock, self.far_end = SimClock(), far_end
        self.clock.before_calls(far_end.advance)
        self.actuator = open_actuator(config, Services(self.clock, lambda url: far_end.port))
        self.clock.every(0.01, lambda: self.actuator.poll(self.clock.now()))
        self.actuator.__enter__()
        self.clock.sleep(1.5)

    @property
    def fault(self):
        return self.actuator.state().fault


def test_a_manager_that_refuses_control_is_named_and_nothing_moves():
    far_end = GimbalFarEnd(SERVO, autopilot=True)
    obeyed = far_end.autopilot.on_packet

    def refusing(packet, now):
        if packet.name == "COMMAND_LONG" and packet.message.command == gimbal_messages.CONFIGURE:
            whom = {"target_system": packet.system_id, "target_component": packet.component_id}
            return [common.MAVLink_command_ack_message(gimbal_messages.CONFIGURE, DENIED, **whom)]
        return obeyed(packet, now)

    far_end.autopilot.on_packet = refusing
    rig = Bench(far_end)
    assert rig.fault == ""
    rig.actuator.command(0.5)
    rig.clock.sleep(1.0)
    assert "component 1 of system 1, denies control" in rig.fault
    with pytest.raises(ActuatorFault):
        rig.actuator.command(0.5)
    assert far_end.angle() == 0.0


def test_a_manager_that_never_names_us_in_control_is_a_fault_after_two_seconds_and_nothing_moves():
    far_end = GimbalFarEnd(SERVO, autopilot=True)
    far_end.autopilot._configure = lambda order, sender: True
    rig = Bench(far_end)
    rig.actuator.command(0.5)
    rig.clock.sleep(1.9)
    assert rig.fault == ""
    assert not rig.actuator.state().settled
    rig.clock.sleep(0.2)
    assert "component 1 of system 1, does not grant control" in rig.fault
    rig.clock.sleep(1.0)
    assert far_end.angle() == 0.0


def test_a_manager_that_nobody_has_read_for_4_s_is_not_one_that_has_restarted():
    """What it has said meanwhile waits to be read."""
    rig = rig_of("mavlink_gimbal").open()
    rig.actuator.command(2.0)
    rig.clock.sleep(0.8)
    rig.pause(4.0)
    rig.settle(within=4.0)
    assert rig.far_end.angle() == pytest.approx(2.0, abs=rig.tolerance)


def test_without_a_gimbal_every_acknowledgement_is_worth_nothing():
    far_end = GimbalFarEnd(SERVO, autopilot=True)
    far_end.device.mute = True
    rig = Bench(far_end)
    assert "the gimbal has not reported its attitude yet" in rig.fault
    with pytest.raises(ActuatorFault):
        rig.actuator.command(0.5)
    assert not rig.actuator.state().settled


@pytest.mark.parametrize(
    ("lower", "upper", "words"),
    [
        (NAN, QUARTER, "expected lower < upper, got nan to 90 deg"),
        (1.0, -1.0, "expected lower < upper, got 57 to -57 deg"),
        (math.inf, -math.inf, "expected lower < upper, got inf to -inf deg"),
        (0.0, 0.0, "expected lower < upper, got 0 to 0 deg"),
        (-math.inf, 0.1, "got -inf to 6"),
    ],
)
@pytest.mark.parametrize("role", ["client", *in_soak("manager")])
def test_absurd_limits_of_a_gimbal_are_one_clear_line_and_no_motion(role, lower, upper, words):
    class Absurd(Device):
        def _information(self, now):
            told = super()._information(now)
            told.yaw_min, told.yaw_max = -upper, -lower
            return told

    far_end = GimbalFarEnd(SERVO, autopilot=role == "client")
    far_end.device.__class__ = Absurd
    if far_end.autopilot is not None:
        far_end.autopilot._servo = Servo(lower, upper, 1.0, 1.0)
    rig = Bench(far_end, role=role)
    assert words in rig.fault
    with pytest.raises(ActuatorFault):
        rig.actuator.command(0.1)
    rig.clock.sleep(1.0)
    assert far_end.angle() == 0.0


def test_a_gimbal_that_does_not_know_its_limits_is_believed_to_have_those_of_the_options():
    far_end = GimbalFarEnd(SERVO, autopilot=True)
    far_end.autopilot._servo = Servo(NAN, NAN, 1.0, 1.0)
    assert Bench(far_end).fault == ""


@pytest.mark.parametrize("role", ["client", *in_soak("manager")])
def test_a_slip_on_the_platform_is_seen_by_nobody(role):
    from ross_sim.devices.far_end import Fault

    far_end = GimbalFarEnd(SERVO, autopilot=role == "client")
    rig = Bench(far_end, role=role)
    far_end.afflict(Fault.SLIP)
    rig.actuator.command(0.3)
    rig.clock.sleep(3.0)
    assert rig.actuator.state().settled
    assert far_end.angle() - rig.actuator.state().angle == pytest.approx(math.radians(10), abs=0.002)


def test_a_dead_device_that_its_manager_repeats_is_not_believed():
    """An autopilot passes the last attitude on for a second; a set-point back to it would make the gimbal swing."""
    far_end = GimbalFarEnd(SERVO, autopilot=True)
    rig = Bench(far_end)
    rig.actuator.command(3.0)
    rig.clock.sleep(1.0)
    far_end.device.mute = True
    before = far_end.angle()
    for _ in range(400):
        rig.clock.sleep(0.01)
        assert far_end.angle() >= before - SERVO.resolution
        before = far_end.angle()
