"""The MAVLink gimbal driver against a simulated ArduPilot and gimbal, or a bare device: faults, frames, control."""

import math
from itertools import pairwise

import pytest

from gimbal_rig import SERVO, Bench
from ross_payload.actuators.mavlink_gimbal.component_port import ComponentPort, opener
from ross_payload.actuators.registry import open_actuator
from ross_payload.config import Config, Link
from ross_payload.errors import ActuatorFault, ConfigError
from ross_payload.interfaces import Services
from ross_payload.mavlink import Router
from ross_protocols.mavlink import gimbal_messages
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_sim.clock import SimClock
from ross_sim.devices.far_end import wire
from ross_sim.devices.gimbal_device import Servo
from ross_sim.devices.gimbal_far_end import GimbalFarEnd

ROLES = ("client", "manager")


def bench(role, **how):
    return Bench(role, autopilot=role != "manager", **how)


def test_nothing_moves_when_it_is_opened_wherever_the_gimbal_stands():
    rig = Bench(opened=False)
    rig.device.angle = rig.device._goal = rig.device._from = rig.far_end.autopilot._aim = 0.7
    rig.actuator.__enter__()
    rig.clock.sleep(1.0)
    assert rig.far_end.angle() == pytest.approx(0.7, abs=SERVO.resolution)
    assert rig.state.angle == pytest.approx(0.7, abs=SERVO.resolution)


def test_it_takes_control_as_component_191_for_a_goal_and_gives_it_back_in_the_end():
    rig = Bench()
    assert rig.far_end.autopilot.primary == (0, 0)
    rig.actuator.command(0.3)
    rig.settle()
    assert rig.far_end.autopilot.primary == (1, 191)
    rig.actuator.__exit__(None, None, None)
    rig.clock.sleep(0.1)
    assert rig.far_end.autopilot.primary == (0, 0)


def test_another_controller_is_a_fault_with_its_ids_until_home_takes_control_back():
    rig = Bench()
    rig.actuator.command(1.5)
    rig.clock.sleep(0.5)
    rig.far_end.autopilot.take_control((255, 190))
    assert rig.detect(within=0.3) <= 0.3
    assert "component 190 of system 255 has taken control" in rig.state.fault
    with pytest.raises(ActuatorFault):
        rig.actuator.command(0.0)
    rig.clock.sleep(2.0)
    assert rig.far_end.autopilot.primary == (255, 190)
    rig.actuator.home()
    rig.clock.sleep(1.0)
    rig.actuator.rearm()
    rig.actuator.command(0.2)
    rig.settle()
    assert rig.far_end.angle() == pytest.approx(0.2, abs=math.radians(0.1))


def test_whoever_points_another_gimbal_manages_not_ours():
    rig = Bench("manager", autopilot=False)
    rig.actuator.command(0.3)
    for gimbal in (171, 154):
        for _ in range(50):
            say(rig, gimbal_messages.point_device((1, gimbal), 1.0))
            rig.clock.sleep(0.02)
        assert ("manages the gimbal too" in rig.state.fault) is (gimbal == 154)


def say(rig, message):
    """Let component 190 of system 1 say something, which the payload hears."""
    rig.far_end.port.arrived.append(Encoder(1, 190).encode(message))


def test_whoever_lost_control_sends_no_set_points():
    rig = Bench()
    rig.far_end.autopilot.take_control((255, 190))
    rig.clock.sleep(0.5)
    before = rig.far_end.autopilot._aim = 0.3
    rig.clock.sleep(1.0)
    assert rig.far_end.autopilot._aim == before


@pytest.mark.parametrize("role", ROLES)
def test_a_stuck_gimbal_is_a_fault_though_every_command_is_acknowledged(role):
    rig = bench(role)
    rig.device.stuck = True
    rig.actuator.command(1.0)
    assert rig.detect(within=2.0) < 2.0
    assert "does not follow: it is at 0.0 deg" in rig.state.fault
    rig.device.stuck = False
    rig.clock.sleep(2.0)
    assert abs(rig.far_end.angle()) < math.radians(1)  # it does not jump after the goal when it is free again


@pytest.mark.parametrize("role", ROLES)
def test_a_small_move_that_never_comes_is_a_fault_too(role):
    rig = bench(role)
    rig.device.stuck = True
    rig.actuator.command(math.radians(5))
    assert rig.detect(within=4.5) > 3.0


@pytest.mark.parametrize("role", ROLES)
def test_a_mute_gimbal_is_a_fault_and_never_settled(role):
    rig = bench(role)
    rig.actuator.command(2.0)
    rig.clock.sleep(0.5)
    rig.device.mute = True
    assert rig.detect(within=2.0) < 2.0
    rig.clock.sleep(3.0)
    assert not rig.state.settled
    assert "no attitude received" in rig.state.fault


@pytest.mark.parametrize("role", ROLES)
def test_a_restart_in_a_move_is_a_fault_and_at_rest_it_is_none(role):
    rig = bench(role)
    rig.clock.sleep(3.0)
    rig.device.restart()
    rig.clock.sleep(2.0)
    assert rig.state.healthy
    rig.actuator.command(2.0)
    rig.clock.sleep(1.2)
    rig.device.restart()
    rig.detect(within=0.3)
    assert "restarted in the middle of a move" in rig.state.fault


@pytest.mark.parametrize(
    ("flags", "words"), [(8, "encoder"), (16, "power"), (32 | 64, "motor, software"), (128, "communication"), (1, None)]
)
def test_failure_flags_are_told_in_words_and_limit_flags_are_no_failures(flags, words):
    rig = Bench()
    rig.device.failures = flags
    rig.clock.sleep(0.5)
    assert rig.state.healthy == (words is None)
    assert (words or "") in rig.state.fault


def test_a_gimbal_that_turns_less_far_than_asked_is_a_fault_and_is_not_moved():
    rig = Bench(servo=Servo(math.radians(-120), math.radians(90), max_speed=2.0, max_acceleration=4.0))
    assert "expected at least -200 to 200 deg" in rig.state.fault
    assert "got -120 to 90" in rig.state.fault
    with pytest.raises(ActuatorFault):
        rig.actuator.command(0.1)


def test_without_an_autopilot_it_becomes_the_manager_after_three_seconds():
    rig = Bench(autopilot=False)
    assert not rig.state.healthy
    rig.clock.sleep(4.0)
    rig.actuator.command(0.5)
    rig.settle()
    assert rig.far_end.angle() == pytest.approx(0.5, abs=math.radians(0.1))


@pytest.mark.parametrize("role", ROLES)
def test_a_gimbal_is_called_what_it_calls_itself(role):
    rig = bench(role)
    rig.clock.sleep(1.0)
    assert rig.actuator.identity == "ROSS simulated, firmware 1.0.0"


@pytest.mark.parametrize("role", ROLES)
def test_set_points_come_at_50_hz_in_a_move_and_at_10_hz_at_rest_and_a_new_goal_at_once(role):
    rig = bench(role)
    rig.settle()
    times = set_points(rig, 1.0)
    assert [round(after - before, 6) for before, after in pairwise(times)] == [0.1] * (len(times) - 1)
    rig.actuator.command(1.0)
    begin = rig.clock.now()
    times = set_points(rig, 0.5)
    assert times[0] <= begin + 0.02
    assert {round(after - before, 6) for before, after in pairwise(times)} == {0.02}


def set_points(rig, seconds):
    """When the driver points the gimbal [s]."""
    wire, times = rig.far_end.port, []
    send = wire.send

    def noted(message):
        if message.get_type() in ("GIMBAL_MANAGER_SET_PITCHYAW", "GIMBAL_DEVICE_SET_ATTITUDE"):
            times.append(rig.clock.now())
        send(message)

    wire.send = noted
    rig.clock.sleep(seconds)
    wire.send = send
    return times


@pytest.mark.parametrize("role", ROLES)
def test_a_dead_program_means_a_still_gimbal(role):
    rig = bench(role)
    rig.actuator.command(3.0)
    rig.clock.sleep(1.0)
    rig.cancel()
    here = rig.far_end.angle()
    rig.clock.sleep(1.0)
    stands = rig.far_end.angle()
    rig.clock.sleep(10.0)
    assert rig.far_end.angle() == pytest.approx(stands, abs=SERVO.resolution)
    assert stands - here < math.radians(15)


def test_a_yaw_told_from_north_is_turned_into_the_joint_angle_on_a_yawing_vehicle():
    rig = Bench("client", earth=True, vehicle=lambda now: 2.8 + 0.3 * now)
    rig.actuator.command(-1.0)
    rig.settle()
    for _ in range(300):
        rig.clock.sleep(0.01)
        assert rig.state.angle == pytest.approx(-1.0, abs=math.radians(1.0))
    assert rig.far_end.angle() == pytest.approx(-1.0, abs=math.radians(0.1))


def test_a_second_manager_is_a_fault_and_not_fought():
    rig = Bench("manager", autopilot=True)
    assert "component 1 of system 1 manages the gimbal too" in rig.state.fault
    with pytest.raises(ActuatorFault):
        rig.actuator.command(-1.0)


def test_a_yaw_told_from_north_without_an_autopilot_is_a_fault():
    rig = Bench("manager", autopilot=False, earth=True)
    assert "from north" in rig.state.fault


def test_set_points_have_one_frame_flag_and_no_rates():
    for message in (gimbal_messages.point_manager((1, 1), 1, 0.5), gimbal_messages.point_device((1, 154), 0.5)):
        packet = Decoder().feed(Encoder(1, 191).encode(message))[0].message
        assert packet.flags == 32
    manager = gimbal_messages.point_manager((1, 1), 1, 0.5)
    assert (manager.pitch, manager.yaw) == (0.0, -0.5)
    assert math.isnan(manager.pitch_rate) and math.isnan(manager.yaw_rate)


def test_yaw_on_the_wire_is_clockwise_and_the_quaternion_starts_with_w():
    w, x, y, z = gimbal_messages.point_device((1, 154), math.pi / 2).q  # a quarter to the left
    assert (w, x, y, z) == pytest.approx((math.sqrt(0.5), 0.0, 0.0, -math.sqrt(0.5)))


class Vehicle:
    """A far end behind a real hub of links: frames go over a wire that takes 5 ms."""

    def __init__(self, clock):
        self.far_end = GimbalFarEnd(SERVO, autopilot=True)
        self.links = Router(clock, system_id=1)
        payload, self.end = wire(clock, 0.005, 0.0, seed=1)
        self.links.attach(Link(url="udpin:vehicle:1", role="autopilot"), payload)

    def advance(self, now):
        self.far_end.port.sent += self.end.receive()
        self.far_end.advance(now)
        for frame in self.far_end.port.arrived:
            self.end.send(frame)
        self.far_end.port.arrived.clear()


def test_it_shares_the_links_of_the_payload():
    clock = SimClock()
    with Router(clock) as alone, pytest.raises(ConfigError, match="links"):
        ComponentPort(alone, 191)
    vehicle = Vehicle(clock)
    clock.before_calls(vehicle.advance)
    config = Config.model_validate({"actuator": {"kind": "mavlink_gimbal"}})
    with vehicle.links as links, open_actuator(config, Services(clock, opener(links, 191, clock))) as actuator:
        clock.every(0.01, links.poll)
        clock.every(0.01, lambda: actuator.poll(clock.now()))
        clock.sleep(0.5)
        actuator.command(0.4)
        clock.sleep(2.0)
        assert actuator.state().settled
        assert vehicle.far_end.angle() == pytest.approx(0.4, abs=math.radians(0.1))
        assert vehicle.far_end.complaints() == []
