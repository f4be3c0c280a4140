"""A vehicle that is armed and does not fly: nothing turns it, and nothing makes it take off."""

from __future__ import annotations

import math

import pytest

from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.vehicle_control import EXTENDED_SYS_STATE, HOLD, OFFBOARD
from ross_sim.devices.far_end import Fault
from vehicle_rig import KINDS, Bench

pytestmark = pytest.mark.lockstep

STATES = {
    common.MAV_LANDED_STATE_ON_GROUND: "the vehicle is on the ground: it is turned only in the air",
    common.MAV_LANDED_STATE_TAKEOFF: "the vehicle is taking off: it is turned only when it has",
    common.MAV_LANDED_STATE_LANDING: "the vehicle is landing: it is turned only in the air",
}


def places_streamed(bench, seconds):
    """Set-points for Offboard in the time to come."""
    sent, send = [], bench.far_end.port.send

    def noted(message):
        if message.get_type() == "SET_POSITION_TARGET_LOCAL_NED":
            sent.append(message.z)
        send(message)

    bench.far_end.port.send = noted
    bench.clock.sleep(seconds)
    bench.far_end.port.send = send
    return sent


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("landed", STATES)
def test_a_vehicle_that_does_not_fly_is_not_turned_and_says_why(kind, landed):
    bench = Bench(kind)
    bench.far_end.autopilot.landed = landed
    bench.clock.sleep(1.0)
    assert bench.state.healthy  # nobody wants to turn it
    begin = bench.clock.now()
    bench.actuator.command(1.0)
    bench.fault(within=0.1)
    assert bench.state.fault == STATES[landed]
    bench.clock.sleep(1.0)
    assert bench.orders(begin) == []
    bench.far_end.autopilot.landed = common.MAV_LANDED_STATE_IN_AIR
    bench.clock.sleep(1.0)
    bench.actuator.rearm()
    bench.turn(30.0)


@pytest.mark.parametrize("kind", KINDS)
def test_a_vehicle_that_comes_to_the_ground_in_a_turn_is_ordered_nothing_more(kind):
    """A stop of a PX4 in Hold names the altitude at which the turn began: it would take off again."""
    bench = Bench(kind)
    bench.actuator.command(math.radians(150))
    bench.clock.sleep(1.5)
    bench.far_end.afflict(Fault.LANDED)
    bench.fault(within=0.25)
    assert "on the ground" in bench.state.fault
    begin = bench.clock.now()
    bench.clock.sleep(2.0)
    assert bench.orders(begin + 0.05) == []


@pytest.mark.parametrize("kind", ["ardupilot", "hold"])
def test_a_turn_that_ends_because_nobody_tells_any_longer_that_it_flies_ends_with_a_stop(kind):
    """It flew when that was told last."""
    bench = Bench(kind)
    bench.actuator.command(math.radians(150))
    bench.clock.sleep(1.5)
    bench.far_end.autopilot.withhold(EXTENDED_SYS_STATE)
    bench.fault(within=1.6)
    assert "whether the vehicle flies" in bench.state.fault
    ended = bench.clock.now()
    bench.clock.sleep(2.0)
    assert bench.orders(ended) == ["stop" if kind == "ardupilot" else "turn"]


def test_on_the_ground_a_px4_gets_no_stream_and_grants_no_offboard():
    """A place is above the vehicle as soon as its height has wandered down, and an armed PX4 in Offboard takes off."""
    bench = Bench("hold", wait=0.0, px4_mode="offboard")
    bench.far_end.autopilot.landed = common.MAV_LANDED_STATE_ON_GROUND
    assert places_streamed(bench, 3.0) == []
    bench.modes.enter(OFFBOARD, bench.clock.now())
    assert bench.modes.mode == HOLD
    bench.far_end.autopilot.landed = common.MAV_LANDED_STATE_IN_AIR
    bench.clock.sleep(0.5)
    assert len(places_streamed(bench, 1.5)) == pytest.approx(30, abs=2)


def test_offboard_in_which_another_program_takes_off_is_left_alone():
    """Its place was known before, on the ground: nobody is sent back there."""
    bench = Bench("hold", wait=0.0, px4_mode="offboard")
    bench.far_end.autopilot.landed = common.MAV_LANDED_STATE_ON_GROUND
    bench.clock.sleep(2.0)
    order = common.MAVLink_set_position_target_local_ned_message(0, 1, 1, 1, 0, *(0.0,) * 11)
    bench.clock.every(0.05, lambda: bench.modes.on_set_point(order, bench.clock.now()))
    bench.clock.sleep(1.5)
    assert bench.modes.enter(OFFBOARD, bench.clock.now())
    bench.clock.sleep(1.0)
    bench.far_end.autopilot.landed = common.MAV_LANDED_STATE_IN_AIR
    assert places_streamed(bench, 2.0) == []


@pytest.mark.parametrize("kind", KINDS)
def test_a_vehicle_of_which_nobody_tells_whether_it_flies_is_not_turned(kind):
    bench = Bench("hold" if kind == "offboard" else kind, wait=0.0)
    bench.far_end.autopilot.withhold(EXTENDED_SYS_STATE)
    bench.clock.sleep(2.0)
    bench.actuator.command(1.0)
    bench.fault(within=2.5)
    assert bench.state.fault == "the autopilot does not tell whether the vehicle flies (EXTENDED_SYS_STATE)"
    assert bench.orders() == []


@pytest.mark.parametrize(("fault", "words"), [(Fault.PILOT, "moves the yaw stick"), (Fault.MODE, "flight mode is")])
def test_on_the_ground_stick_and_mode_can_be_tried(fault, words):
    """A trial without propellers shows that they are heard."""
    bench = Bench()
    bench.far_end.afflict(Fault.LANDED)
    bench.clock.sleep(1.0)
    bench.far_end.afflict(fault)
    bench.clock.sleep(0.1)
    bench.actuator.command(1.0)
    bench.fault(within=0.1)
    assert words in bench.state.fault
