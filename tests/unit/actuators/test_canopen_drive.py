"""The driver of a CANopen drive on a simulated one: set-up, states, set-points, faults, what others do on the bus."""

import math
import random
import struct

import pytest

from drive_bench import NODE, OWN, Bench
from examples import in_soak
from rigs import rig_of
from ross_payload.errors import ActuatorFault
from ross_protocols.canopen import cia402
from ross_protocols.canopen.cia402 import State
from ross_sim.clock import QUANTUM
from ross_sim.devices.far_end import Fault

RPDO_SPEED, RPDO_ORDER, SDO = 0x200 + NODE, 0x300 + NODE, 0x600 + NODE
ABSENT = {cia402.HALT_OPTION, cia402.FOLLOWING_TIME, cia402.POSITION_WINDOW, cia402.POSITION_TIME, cia402.PRODUCT}


def orders(bench, since=-math.inf):
    return [struct.unpack("<Hib", data) for data in bench.frames(RPDO_ORDER, since)]


def braking(degrees_per_second):
    return degrees_per_second / 112.5


# -------------------------------------------------------------------------------------------------- opening


def test_opening_moves_nothing_and_gives_no_torque():
    bench = Bench().open()
    bench.clock.sleep(2.0)
    assert bench.drive_state is State.SWITCH_ON_DISABLED
    assert bench.far_end.angle() == 0.0
    assert bench.state.settled
    assert all(word & cia402.ENABLED == 0 for word, *_ in orders(bench))


def test_the_first_goal_enables_the_drive():
    bench = Bench().open()
    bench.go(10, 0.1)
    assert bench.drive_state is State.OPERATION_ENABLED
    bench.settle()
    assert bench.true_deg == pytest.approx(10, abs=0.1)


def test_one_entry_is_asked_or_told_at_a_time():
    bench = Bench()
    waiting = []

    def passes(frame):
        if frame.id == SDO:
            assert not waiting, "a second request before the answer"
            waiting.append(frame)
        elif frame.id == 0x580 + NODE:
            waiting.pop()
        return True

    bench.wire.passes = passes
    bench.open()
    assert len(bench.frames(SDO)) > 40
    assert bench.state.homed


def test_a_move_is_made_of_process_data_only():
    bench = Bench().open()
    began = bench.clock.now()
    bench.go(60)
    bench.settle()
    kinds = {frame.id for time, frame in bench.wire.sent if time > began}
    assert kinds == {RPDO_ORDER, RPDO_SPEED, 0x700 + OWN}


def test_a_speed_is_that_of_its_own_set_point_where_the_lowest_identifier_is_sent_first():
    """As by a controller with several mailboxes."""
    rig = rig_of("canopen_drive").open()
    rig.clock.every(QUANTUM, lambda: rig.far_end.port.sent.sort(key=lambda frame: frame.id))
    rig.actuator.command(math.radians(20))
    rig.settle(within=5.0)
    for goal, rate in ((60, 10.0), (40, 40.0), (60, 20.0)):
        rig.actuator.command(math.radians(goal), math.radians(rate))
        fastest, last = 0.0, rig.far_end.angle()
        while not rig.state.settled:
            rig.clock.sleep(QUANTUM)
            here = rig.far_end.angle()
            fastest, last = max(fastest, abs(here - last) / QUANTUM), here
        assert math.degrees(fastest) == pytest.approx(rate, rel=0.1)


def test_a_drive_that_somebody_left_moving_is_stopped_first():
    bench = Bench().open()
    bench.go(180, 1.0)
    here, speed = bench.true_deg, math.degrees(bench.state.rate)
    bench.actuator.__enter__()  # as by a program that was restarted at once
    bench.clock.sleep(braking(speed) + 0.5)
    assert bench.drive_state is State.SWITCH_ON_DISABLED
    assert bench.true_deg - here < speed**2 / (2 * 112.5) + 0.1 * (speed + 6)
    assert bench.state.settled


def test_another_device_is_not_taken_for_a_drive():
    bench = Bench()
    bench.set(cia402.DEVICE_TYPE, 0x00020191)
    bench.open()
    assert bench.fault == "node 5 is not a CiA 402 drive: its device type is 0x00020191"
    with pytest.raises(ActuatorFault, match="not a CiA 402 drive"):
        bench.go(10)


def test_a_drive_that_is_not_there_is_named_within_a_second():
    bench = Bench()
    bench.wire.passes = lambda frame: frame.id != SDO
    bench.open()
    assert bench.fault == "node 5 does not answer: cannot read 0x1000"


def test_a_drive_that_is_switched_on_late_is_found_by_homing():
    bench = Bench()
    bench.wire.passes = lambda frame: False
    bench.open()
    bench.wire.passes = lambda frame: True
    bench.home()
    bench.actuator.rearm()
    bench.go(10)
    bench.settle()
    assert bench.true_deg == pytest.approx(10, abs=0.1)


@pytest.mark.parametrize(
    ("item", "value", "fault"),
    [
        (cia402.LOWEST, 5, "the drive's software limits are invalid: 5 to 5 counts"),
        (cia402.LOWEST, 9, "the drive's software limits are invalid: 9 to 5 counts"),
        (cia402.MAX_MOTOR_SPEED, 0, "max_speed_deg_s = 225 is beyond the drive's own 0 deg/s"),
        (cia402.MAX_MOTOR_SPEED, 600, "max_speed_deg_s = 225 is beyond the drive's own 180 deg/s"),
        (cia402.SUPPORTED_MODES, 0x4, "the drive lacks a mode: expected 0x1, got 0x4"),
    ],
)
def test_a_drive_that_cannot_be_is_one_clear_line_and_no_motion(item, value, fault):
    bench = Bench()
    if item is cia402.LOWEST:
        bench.set(cia402.HIGHEST, 5)
    bench.set(item, value)
    bench.open()
    assert bench.fault == fault
    assert bench.drive_state is State.SWITCH_ON_DISABLED
    assert bench.far_end.angle() == 0.0


def test_a_travel_beyond_the_drive_s_limits_is_refused():
    bench = Bench(lower_deg=-100, upper_deg=100)
    bench.set(cia402.HIGHEST, bench.options.counts(math.radians(90)))
    bench.open()
    assert "the travel of -22756 to 22756 counts is beyond the drive's software limits" in bench.fault


def test_a_refusal_is_told_in_words():
    bench = Bench()
    del bench.drive.objects.entries[0x6007, 0]
    bench.open()
    assert bench.fault == "node 5 refuses to write 0x6007 = 3: no such object"


def test_a_drive_is_known_by_its_maker_s_numbers():
    bench = Bench()
    assert bench.actuator.identity == ""
    assert bench.open().actuator.identity == "vendor 0x0, product 0x402, revision 0x10000, serial 0x1"


def test_what_not_every_drive_has_is_not_needed():
    bench = Bench()
    for item in ABSENT:
        del bench.drive.objects.entries[item.index, item.sub]
    bench.open()
    bench.go(10)
    bench.settle()
    assert bench.true_deg == pytest.approx(10, abs=0.1)


# -------------------------------------------------------------------------------------------------- moves


def test_a_set_point_is_offered_once_and_taken_back_when_it_is_acknowledged():
    bench = Bench().open()
    bench.go(20)
    bench.settle()
    bench.wire.sent.clear()
    bench.go(-20)
    bench.settle()
    words = [word for word, *_ in orders(bench)]
    assert words[0] == 0x3F
    assert set(words[1:]) == {0x0F}
    assert orders(bench)[0][1:] == (bench.options.counts(math.radians(-20)), 1)


@pytest.mark.parametrize("seed", [0, *in_soak(1, 2, 3, 4)])
def test_a_bus_that_loses_a_quarter_of_the_set_points_only_makes_moves_later(seed):
    chance = random.Random(seed)  # noqa: S311
    bench = Bench().open()
    bench.wire.passes = lambda frame: frame.id not in (RPDO_ORDER, RPDO_SPEED, 0x180 + NODE) or chance.random() < 0.75
    for degrees in (50, -30, 10):
        bench.go(degrees, 0.3)
    bench.settle()
    assert bench.true_deg == pytest.approx(10, abs=0.1)
    assert bench.state.healthy


@pytest.mark.parametrize("every", [0.12, *in_soak(0.05)])
def test_a_computer_that_is_busy_takes_no_late_reports_for_jumps(every):
    bench = Bench(every=every)
    bench.actuator.__enter__()
    bench.clock.sleep(10.0)
    for degrees in (180, -180):
        bench.go(degrees)
        bench.settle(within=12.0)
    assert bench.true_deg == pytest.approx(-180, abs=0.1)


def test_goals_that_come_faster_than_handshakes_end_at_the_last_one():
    bench = Bench().open()
    for degrees in range(0, 100, 5):
        bench.go(degrees, QUANTUM)
    bench.settle()
    assert bench.true_deg == pytest.approx(95, abs=0.1)


def test_a_gear_that_turns_the_other_way_and_a_zero_elsewhere_change_counts_and_not_angles():
    bench = Bench(gear_ratio=-10.0, zero_deg=30.0).open()
    bench.go(75)
    bench.settle()
    assert bench.true_deg == pytest.approx(75, abs=0.1)
    assert bench.drive.axis.position == pytest.approx(-45 / 360 * 10 * 4096, abs=12)


def test_stop_before_the_drive_is_enabled_leaves_it_at_rest():
    bench = Bench().open()
    bench.go(90)
    bench.actuator.stop()
    bench.clock.sleep(1.0)
    assert abs(bench.true_deg) < 0.1
    assert bench.state.settled


def test_a_halted_drive_does_not_go_on_to_its_old_goal():
    bench = Bench().open()
    bench.go(180, 1.0)
    bench.actuator.stop()
    bench.clock.sleep(3.0)
    here = bench.true_deg
    assert bench.drive_state is State.OPERATION_ENABLED
    bench.actuator.rearm()
    bench.go(here - 5)
    seen = []
    while not bench.state.settled:
        bench.clock.sleep(QUANTUM)
        seen.append(bench.true_deg)
    assert max(seen) < here + 0.1
    assert bench.true_deg == pytest.approx(here - 5, abs=0.1)


def test_release_takes_the_torque_away_and_the_encoder_goes_on_counting():
    bench = Bench().open()
    bench.go(10)
    bench.settle()
    bench.actuator.release()
    bench.clock.sleep(0.1)
    assert bench.drive_state is State.SWITCH_ON_DISABLED
    bench.far_end.axle.angle += 0.2  # somebody turns it by hand
    bench.clock.sleep(1.0)
    assert bench.state.angle == pytest.approx(bench.far_end.angle(), abs=1e-3)
    assert bench.state.homed


def test_a_rerun_is_the_same_to_the_bit():
    def sent():
        bench = Bench().open()
        bench.far_end.afflict(Fault.NOISY)
        bench.go(60, 1.0)
        return bench.wire.sent, bench.state

    assert sent() == sent()
