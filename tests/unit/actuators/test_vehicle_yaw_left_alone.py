"""A vehicle of which frames are lost, or whose payload is held up: what its pilot has done meanwhile is not undone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rigs import rig_of
from ross_protocols.mavlink import vehicle_control
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.vehicle_control import GUIDED, LOITER
from ross_sim.autopilot.yaw_dynamics import Wind
from ross_sim.clock import QUANTUM
from ross_sim.devices.far_end import Fault
from vehicle_rig import KINDS, Bench

US, VEHICLE = ComponentId(1, 191), ComponentId(1, 1)


@pytest.mark.parametrize("lost", [0, 1, 3, 6])
def test_no_turn_begins_before_the_autopilot_holds_its_yaw(lost):
    """Without it ArduCopter would begin at the heading of an earlier turn, and no stop would end it."""
    bench = yawed_by_hand()
    begin = bench.yaw_deg
    bench.far_end.lost = lost
    bench.actuator.command(bench.state.angle + math.radians(10))
    seen = []
    for _ in range(500):
        bench.clock.sleep(QUANTUM)
        seen.append(bench.yaw_deg)
    assert begin - 1.0 <= min(seen) and max(seen) <= begin + 11.0
    assert bench.state.settled
    assert bench.yaw_deg == pytest.approx(begin + 10.0, abs=1.0)


@pytest.mark.parametrize(("waited", "lost"), [(0.0, 3), (2.0, 1)])
def test_nor_does_the_second_turn_of_a_task(waited, lost):
    """What is acknowledged before it is not what reminds of the old goal."""
    bench = Bench()
    bench.turn(30.0)
    bench.clock.sleep(waited)
    bench.far_end.lost, began = lost, bench.clock.now()
    bench.turn(-30.0)
    assert bench.orders(began)[0] == "stop"  # what was asked for first, at last


@pytest.mark.parametrize("kind", ["ardupilot", "hold"])
@pytest.mark.parametrize("pushed", [0.3, 1.0])
def test_a_vehicle_at_rest_in_a_task_is_left_where_its_pilot_has_yawed_it_while_the_payload_was_held_up(kind, pushed):
    """Nor is a PX4 sent back to the height at which the turn before had begun."""
    bench = Bench(kind)
    bench.turn(30.0)
    bench.cancel()
    mode = bench.modes.mode
    bench.far_end.autopilot.fly_by_hand(bench.clock.now())
    bench.far_end.push(400)
    bench.clock.sleep(pushed)
    bench.far_end.push(0)
    bench.clock.sleep(1.0)
    if kind == "hold":
        bench.modes.altitude = 130.0
    bench.modes.enter(mode, bench.clock.now())
    bench.clock.sleep(0.5)
    here = bench.yaw_deg
    bench.clock.every(QUANTUM, lambda: bench.actuator.poll(bench.clock.now()))
    bench.clock.sleep(4.0)
    assert bench.yaw_deg == pytest.approx(here, abs=3.0)
    assert kind != "hold" or bench.modes.altitude == 130.0


@pytest.mark.parametrize("kind", ["ardupilot", "hold"])
@pytest.mark.parametrize("fault", [Fault.MODE, Fault.DISARMED])
def test_closing_orders_nothing_of_a_vehicle_that_is_its_pilots_by_then(kind, fault):
    bench = Bench(kind)
    bench.actuator.command(math.radians(150))
    bench.clock.sleep(1.0)
    bench.cancel()
    bench.far_end.afflict(fault)
    bench.clock.sleep(1.5)  # PX4 tells once a second whether it is armed
    sent = len(bench.far_end.orders)
    bench.actuator.__exit__(None, None, None)
    bench.clock.sleep(1.0)
    assert bench.far_end.orders[sent:] == []


def test_a_turn_that_a_pilot_has_ended_meanwhile_brings_no_px4_back_to_the_old_height():
    bench = Bench("hold")
    bench.actuator.command(math.radians(150))
    bench.clock.sleep(1.5)
    bench.cancel()
    mode = bench.modes.mode
    bench.far_end.autopilot.fly_by_hand(bench.clock.now())
    bench.clock.sleep(1.0)
    bench.modes.altitude = 130.0
    bench.modes.enter(mode, bench.clock.now())
    bench.clock.sleep(0.5)
    bench.clock.every(QUANTUM, lambda: bench.actuator.poll(bench.clock.now()))
    bench.clock.sleep(3.0)
    assert "the flight mode is Position" in bench.state.fault or bench.state.healthy
    assert bench.modes.altitude == 130.0


def test_an_autopilot_that_acknowledges_nothing_is_turned_nowhere():
    bench = yawed_by_hand()
    begin = bench.yaw_deg
    bench.far_end.lost = 1000
    bench.actuator.command(bench.state.angle + math.radians(10))
    assert bench.fault(within=2.5) > 1.9
    assert bench.state.fault == "the autopilot does not acknowledge CONDITION_YAW; home and rearm"
    bench.far_end.lost = 0
    bench.clock.sleep(3.0)
    assert bench.yaw_deg == pytest.approx(begin, abs=1.0)
    bench.actuator.home()
    bench.clock.sleep(0.5)
    bench.actuator.rearm()
    bench.turn(math.degrees(bench.state.angle) + 10.0)
    assert bench.yaw_deg == pytest.approx(begin + 10.0, abs=1.0)


def yawed_by_hand():
    """Return the bench of an ArduCopter that its pilot has turned far since it was turned last, and given back."""
    bench = Bench()
    bench.modes.enter(LOITER, bench.clock.now())
    bench.far_end.push(-400.0)
    bench.clock.sleep(1.8)
    bench.far_end.push(0.0)
    bench.clock.sleep(1.5)
    bench.modes.enter(GUIDED, bench.clock.now())
    bench.clock.sleep(0.5)
    assert abs(bench.yaw_deg) > 100.0
    return bench


def test_a_px4_in_hold_turns_and_answers_that_it_does_not_support_it():
    """Its commander has no mode to change; its navigator obeys."""
    bench = Bench("hold")
    order = vehicle_control.reposition(VEHICLE, math.radians(40), 100.0)
    (packet,) = Decoder().feed(Encoder(*US).encode(order))
    (answer,) = bench.far_end.autopilot.on_packet(packet, bench.clock.now())
    assert answer.result == common.MAV_RESULT_UNSUPPORTED
    bench.clock.sleep(4.0)
    assert bench.yaw_deg == pytest.approx(40.0, abs=1.0)
    bench.turn(-20.0)
    assert bench.state.healthy


@pytest.mark.parametrize("kind", ["vehicle_yaw", "vehicle_yaw:offboard"])
@pytest.mark.parametrize("fault", [Fault.PILOT, Fault.MODE, Fault.DISARMED])
def test_a_pilot_who_intervenes_while_the_payload_is_held_up_ends_the_turn(kind, fault):
    """Also when all is as before again when it goes on."""
    rig = rig_of(kind).open()
    rig.actuator.command(2.0)
    rig.clock.sleep(0.8)
    rig.held_up = True
    rig.far_end.afflict(fault)
    rig.clock.sleep(0.3)
    if fault is Fault.PILOT:
        rig.far_end.push(0.0)
    else:
        rig.far_end.afflict(fault, on=False)
    rig.clock.sleep(0.2)
    rig.held_up = False
    rig.clock.sleep(2 * QUANTUM)
    assert not rig.state.healthy
    rig.clock.sleep(0.7)
    here = rig.far_end.angle()
    rig.clock.sleep(3.0)
    assert rig.far_end.angle() == pytest.approx(here, abs=math.radians(3))


def test_a_gust_sends_no_px4_back_to_the_height_at_which_its_last_turn_began():
    """Who flies it may have chosen another one since, in the same mode."""
    bench = Bench("hold")
    bench.actuator.take_control()
    bench.turn(30.0)
    bench.clock.sleep(10.0)
    bench.modes.altitude = 130.0
    bench.far_end.blow(Wind(math.radians(160), 0.5), np.random.default_rng(4))
    bench.clock.sleep(10.0)
    bench.actuator.halt()
    bench.clock.sleep(2.0)
    assert bench.modes.altitude == 130.0


@pytest.mark.parametrize(("seconds", "limits_deg"), [(9.0, 200.0), (3.3, 100.0)], ids=["turned round", "outside"])
@pytest.mark.parametrize("kind", KINDS)
def test_wherever_a_pilot_has_left_it_a_vehicle_stays_and_can_be_turned(kind, seconds, limits_deg):
    """More than a turn away, or outside the limits: there the stream for Offboard holds it, and no fault comes."""
    bench = Bench(kind, lower_deg=-limits_deg, upper_deg=limits_deg)
    automatic = bench.modes.mode
    bench.far_end.afflict(Fault.MODE)
    bench.far_end.push(200.0)
    bench.clock.sleep(seconds)
    bench.far_end.push(0.0)
    bench.clock.sleep(1.0)
    left = bench.yaw_deg
    assert abs(left) > limits_deg
    bench.far_end.afflict(Fault.MODE, on=False)
    bench.modes.enter(automatic, bench.clock.now())
    bench.clock.sleep(3.0)
    assert bench.modes.mode == automatic
    assert bench.yaw_deg == pytest.approx(left, abs=0.1)
    assert bench.state.healthy, bench.state.fault
    bench.turn(30.0)
    assert math.remainder(bench.yaw_deg - 30.0, 360.0) == pytest.approx(0.0, abs=1.0)
