"""A vehicle that its autopilot yaws: what turns it, what must not, and whose it is."""

from __future__ import annotations

import math

import numpy as np
import pytest

from examples import in_soak
from ross_payload.actuators.vehicle_yaw.options import Options
from ross_payload.errors import ActuatorFault, ConfigError
from ross_protocols.mavlink import vehicle_control
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.vehicle import VehicleAttitude, quaternion
from ross_protocols.mavlink.vehicle_control import (
    GLOBAL_POSITION,
    GUIDED,
    HEARTBEAT,
    LOITER,
    OFFBOARD,
    POSITION,
    RC_CHANNELS,
)
from ross_sim.autopilot.flight_modes import Copter
from ross_sim.autopilot.flying_autopilot import FlyingAutopilot
from ross_sim.autopilot.yaw_dynamics import Wind, YawDynamics
from ross_sim.clock import QUANTUM
from ross_sim.devices.far_end import Fault
from ross_sim.devices.vehicle_far_end import VehicleFarEnd
from vehicle_rig import AIRFRAME, KINDS, LATENCY, Bench, in_a_turn

pytestmark = pytest.mark.lockstep

US, VEHICLE = ComponentId(1, 191), ComponentId(1, 1)
PHASES = np.arange(10) * 0.013  # between what the pilot does and the messages that tell of it [s]


def on_the_wire(message):
    """A message as the other side reads it."""
    (packet,) = Decoder().feed(Encoder(*US).encode(message))
    return packet.message


# ---------------------------------------------------------------------------------------------------- it turns


@pytest.mark.parametrize("kind", ["ardupilot", "offboard", *in_soak("hold")])
def test_it_goes_to_headings_counted_counter_clockwise_from_north(kind):
    bench = Bench(kind)
    for goal in (60.0, -30.0):
        bench.turn(goal)
        bench.clock.sleep(1.0)
        assert bench.yaw_deg == pytest.approx(goal, abs=1.0)
        assert math.degrees(bench.state.angle) == pytest.approx(bench.yaw_deg, abs=0.2)
    assert bench.far_end.complaints() == []


def test_turned_gently_a_simulated_vehicle_follows():
    """One that could do no more than the payload asks of it would be far behind, and taken for one that does not."""
    asked = Options(turn_vehicle=True, max_acceleration_deg_s2=5.0)
    bench = Bench(airframe=VehicleFarEnd.make(asked).modes.body.airframe, max_acceleration_deg_s2=5.0)
    bench.turn(150.0, within=20.0)


@pytest.mark.parametrize("kind", ["ardupilot", *in_soak("hold", "offboard")])
def test_in_gusts_it_arrives_and_stays(kind):
    bench = Bench(kind)
    bench.far_end.blow(Wind(math.radians(80), 0.5), np.random.default_rng(4))
    bench.turn(100.0)
    off = []
    for _ in range(600):
        bench.clock.sleep(QUANTUM)
        assert bench.state.healthy
        off.append(bench.yaw_deg - 100.0)
    assert np.sqrt(np.mean(np.square(off))) < 2.5


def test_a_gust_that_takes_it_beyond_a_limit_for_a_moment_is_no_fault():
    """Where a fault is what stays away from its goal for three seconds, at a limit as elsewhere."""
    bench, beyond = Bench(), 0.0
    bench.far_end.blow(Wind(math.radians(120), 0.5), np.random.default_rng(2))
    bench.actuator.command(bench.actuator.capabilities.upper)
    for _ in range(2000):
        bench.clock.sleep(QUANTUM)
        assert bench.state.healthy, bench.state
        beyond = max(beyond, bench.yaw_deg - 200.0)
    assert beyond > 2.0


def test_at_rest_the_autopilot_is_left_alone():
    bench = Bench()
    bench.turn(30.0)
    arrived = bench.clock.now()
    bench.clock.sleep(10.0)
    assert bench.orders(arrived + 0.3) == []


def test_a_turn_after_flying_by_hand_begins_where_the_vehicle_points():
    bench = Bench()
    bench.modes.enter(LOITER, bench.clock.now())
    bench.far_end.push(-400.0)
    bench.clock.sleep(2.0)
    bench.far_end.push(0.0)
    bench.clock.sleep(1.5)
    bench.modes.enter(GUIDED, bench.clock.now())
    start = bench.yaw_deg
    assert abs(start) > 90
    lowest = highest = start
    bench.actuator.command(bench.state.angle + math.radians(20))
    for _ in range(400):
        bench.clock.sleep(QUANTUM)
        lowest, highest = min(lowest, bench.yaw_deg), max(highest, bench.yaw_deg)
    assert bench.state.settled
    assert start - 2 < lowest and highest < start + 25


def test_a_vehicle_that_was_turned_round_twice_by_hand_has_a_joint_angle_inside_the_travel():
    bench = Bench()
    bench.modes.enter(LOITER, bench.clock.now())
    bench.far_end.push(-400.0)
    bench.clock.sleep(8.5)
    bench.far_end.push(0.0)
    bench.clock.sleep(1.5)
    assert bench.yaw_deg > 700
    turns = (bench.yaw_deg - math.degrees(bench.state.angle)) / 360
    assert turns == pytest.approx(round(turns), abs=0.01)
    assert abs(bench.state.angle) < math.radians(203)


def test_px4_keeps_its_altitude_in_a_turn():
    bench, heights, chance = Bench("hold"), [], np.random.default_rng(1)
    bench.actuator.command(1.5)
    while not bench.state.settled:
        bench.far_end.autopilot.altimeter_error = chance.normal()  # what DO_REPOSITION without an altitude would take
        bench.clock.sleep(QUANTUM)
        heights.append(bench.far_end.modes.altitude)
    assert {round(height, 2) for height in heights[20:]} == {round(heights[-1], 2)}
    assert len(bench.orders()) > 5


# ------------------------------------------------------------------------------------- it is allowed, or is not


def test_a_vehicle_that_nobody_has_said_may_be_turned_is_refused_in_one_line():
    with pytest.raises(ConfigError, match=r"^actuator\.options\.turn_vehicle: expected true, .*, got false$"):
        Bench(turn_vehicle=False)


@pytest.mark.parametrize("kind", KINDS)
def test_a_vehicle_that_is_not_armed_is_not_turned(kind):
    bench = Bench(kind)
    bench.far_end.autopilot.armed = False
    bench.clock.sleep(1.5)
    assert bench.state.healthy  # nobody wants to turn it
    begin, there = bench.clock.now(), bench.yaw_deg
    bench.actuator.command(1.0)
    bench.fault(within=0.1)
    bench.clock.sleep(2.0)
    assert "the vehicle is not armed" in bench.state.fault
    assert bench.orders(begin) == []
    assert bench.yaw_deg == there


@pytest.mark.parametrize(
    ("kind", "words"), [("ardupilot", "LOITER.*only in GUIDED"), ("hold", "Position.*only in Hold")]
)
def test_it_is_turned_in_no_other_mode(kind, words):
    bench = Bench(kind)
    bench.far_end.autopilot.fly_by_hand(bench.clock.now())
    bench.clock.sleep(0.2)
    begin = bench.clock.now()
    bench.actuator.command(1.0)
    bench.fault(within=0.1)
    with pytest.raises(ActuatorFault, match=words):
        bench.actuator.command(1.0)
    assert bench.orders(begin) == []


def test_an_autopilot_that_tells_its_mode_once_a_second_only_is_refused():
    bench = Bench(wait=0.0)
    bench.far_end.autopilot._adjustable.discard(HEARTBEAT)
    bench.clock.sleep(2.0)
    bench.actuator.command(1.0)
    bench.fault(within=2.5)
    assert "does not send HEARTBEAT every 0.3 s" in bench.state.fault
    assert bench.orders() == []


def test_without_a_radio_control_it_is_turned_only_if_that_was_said():
    def without(**options):
        bench = Bench(wait=0.0, **options)
        bench.far_end.autopilot._adjustable.discard(RC_CHANNELS)
        bench.clock.sleep(2.0)
        return bench

    bench = without()
    bench.actuator.command(1.0)
    bench.fault(within=2.5)
    assert "yaw_channel = 0 if nobody holds one" in bench.state.fault
    without(yaw_channel=0).turn(20.0)


def test_an_autopilot_that_refuses_to_turn_is_told_of():
    bench = Bench()
    answers = bench.far_end.autopilot._command
    bench.far_end.autopilot._command = lambda message, now: (
        common.MAV_RESULT_DENIED if message.command == vehicle_control.CONDITION_YAW else answers(message, now)
    )
    bench.actuator.command(1.0)
    bench.fault(within=0.2)
    assert "answers CONDITION_YAW with DENIED" in bench.state.fault


@pytest.mark.parametrize("kind", ["FIXED_WING", "GROUND_ROVER", "SURFACE_BOAT", "SUBMARINE", "VTOL_TILTROTOR"])
def test_what_is_no_multicopter_is_not_turned(kind):
    bench = Bench()
    bench.far_end.autopilot._heartbeat = lambda: common.MAVLink_heartbeat_message(
        getattr(common, f"MAV_TYPE_{kind}"), common.MAV_AUTOPILOT_ARDUPILOTMEGA, 209, GUIDED, 4, 3
    )
    bench.clock.sleep(0.5)
    assert "does not fly a multicopter" in bench.state.fault
    begin = bench.clock.now()
    with pytest.raises(ActuatorFault, match="does not fly a multicopter"):
        bench.actuator.command(1.0)
    bench.clock.sleep(0.5)
    assert bench.orders(begin) == []


# ----------------------------------------------------------------------------------------- it is the pilot's


# ------------------------------------------------------------------------------------------------ it stops


def test_a_stop_is_the_autopilot_s_own_and_is_sent_until_the_vehicle_stands():
    bench = in_a_turn("ardupilot", 0.0)
    begin, here = bench.clock.now(), bench.yaw_deg
    bench.actuator.stop()
    bench.clock.sleep(3.0)
    assert set(bench.orders(begin + LATENCY + 2 * QUANTUM)) == {"stop"}
    stops = len(bench.orders(begin))
    bench.clock.sleep(5.0)
    assert len(bench.orders(begin)) == stops < 20
    assert 0 < bench.yaw_deg - here < 25
    assert bench.state.healthy


@pytest.mark.parametrize("kind", ["ardupilot", "hold"])
def test_when_the_payload_dies_the_vehicle_goes_to_the_last_set_point_and_is_held_there(kind):
    bench = in_a_turn(kind, 0.0)
    here, fastest = bench.yaw_deg, math.degrees(bench.state.rate)
    bench.cancel()
    bench.clock.sleep(3.0)
    gone = bench.yaw_deg - here
    assert 0 < gone < 0.5 * fastest  # the set-point is one period ahead, the vehicle behind it
    there = bench.yaw_deg
    bench.clock.sleep(3.0)
    assert bench.yaw_deg == pytest.approx(there, abs=0.1)


def test_when_the_payload_dies_a_px4_leaves_offboard_after_a_second_and_stands():
    bench = in_a_turn("offboard", 0.0)
    here, fastest = bench.yaw_deg, math.degrees(bench.state.rate)
    bench.cancel()
    bench.clock.sleep(0.9)
    assert bench.modes.mode == OFFBOARD
    bench.clock.sleep(0.3)
    assert bench.modes.mode == POSITION
    bench.clock.sleep(3.0)
    assert 0 < bench.yaw_deg - here < 0.5 * fastest


def test_a_turn_in_hold_keeps_the_height_with_which_it_began():
    bench = in_a_turn("hold", 0.0)
    bench.far_end.autopilot.withhold(GLOBAL_POSITION)
    bench.clock.sleep(3.0)
    assert bench.state.healthy


def test_a_turn_that_ends_because_nothing_is_told_any_more_is_a_fault_and_nowhere_settled():
    """At its beginning, when what was asked for may still be on its way."""
    bench = Bench("ardupilot", settle_ms=100)
    bench.far_end.afflict(Fault.STALL)
    bench.clock.sleep(3.0)
    bench.actuator.command(math.radians(-200))
    bench.clock.sleep(0.6)
    bench.far_end.afflict(Fault.SILENT)
    for _ in range(150):
        bench.clock.sleep(QUANTUM)
        assert not bench.state.settled
    assert not bench.state.healthy


def test_attitudes_that_stop_end_a_turn():
    bench = in_a_turn("ardupilot", 0.0)
    bench.far_end.afflict(Fault.SILENT)
    assert bench.fault(within=0.7) > 0.2
    last = bench.clock.now()
    bench.clock.sleep(2.0)
    assert set(bench.orders(last + 2 * LATENCY)) <= {"stop"}


# ------------------------------------------------------------------------------------------- what is on the wire


def test_condition_yaw_is_clockwise_from_north_in_degrees_and_takes_the_shorter_way():
    message = on_the_wire(vehicle_control.turn_to(VEHICLE, math.radians(-30), math.radians(12)))
    assert message.command == common.MAV_CMD_CONDITION_YAW
    assert (message.param1, message.param3, message.param4) == (pytest.approx(30.0), 0.0, 0.0)
    assert message.param2 == pytest.approx(12.0)
    held = on_the_wire(vehicle_control.hold_yaw(VEHICLE))
    assert (held.param1, held.param4) == (0.0, 1.0)


def test_do_reposition_changes_the_yaw_alone_in_radians():
    message = on_the_wire(vehicle_control.reposition(VEHICLE, math.radians(-30), 123.5))
    assert message.command == common.MAV_CMD_DO_REPOSITION
    assert message.param2 == 0.0  # MAV_DO_REPOSITION_FLAGS_CHANGE_MODE is not set
    assert (message.param4, message.z) == (pytest.approx(math.radians(30)), 123.5)
    assert (message.x, message.y) == (2**31 - 1, 2**31 - 1)


def test_a_set_point_of_the_stream_ignores_all_but_position_and_yaw():
    message = on_the_wire(vehicle_control.position_target(VEHICLE, 1.0, (1.0, 2.0, -3.0), math.radians(-30)))
    used = [name for name in ("X", "Y", "Z", "VX", "VY", "VZ", "AX", "AY", "AZ", "YAW", "YAW_RATE")
            if not message.type_mask & getattr(common, f"POSITION_TARGET_TYPEMASK_{name}_IGNORE")]  # fmt: skip
    assert used == ["X", "Y", "Z", "YAW"]
    assert message.yaw == pytest.approx(math.radians(30))


def test_attitude_quaternion_tells_what_attitude_tells():
    q = quaternion(math.radians(-50), 0.1, -0.2)
    message = common.MAVLink_attitude_quaternion_message(2500, *q, 0.0, 0.0, -0.4)
    told = vehicle_control.attitude_quaternion(on_the_wire(message))
    assert isinstance(told, VehicleAttitude)
    assert (told.boot, told.yaw) == (2.5, pytest.approx(math.radians(50)))
    assert told.yaw_rate == pytest.approx(0.4 * math.cos(-0.2) / math.cos(0.1))


def test_condition_yaw_is_accepted_in_loiter_and_not_obeyed_there_as_by_ardupilot():
    autopilot = FlyingAutopilot(VEHICLE, Copter(YawDynamics(AIRFRAME), mode=LOITER))
    order = common.MAVLink_command_long_message(1, 1, common.MAV_CMD_CONDITION_YAW, 0, 90.0, 30.0, 0, 0, 0, 0, 0)
    (packet,) = Decoder().feed(Encoder(*US).encode(order))
    (answer,) = autopilot.on_packet(packet, 0.0)
    assert answer.result == common.MAV_RESULT_ACCEPTED
    autopilot.move(5.0)
    assert autopilot.yaw == 0.0
