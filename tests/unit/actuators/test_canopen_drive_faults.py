"""A CANopen drive in trouble: without us, with faults of its own, with others on the bus."""

import math
import struct

import pytest

from drive_bench import NODE, OPENING, OWN, Bench
from examples import in_soak
from ross_payload.actuators.canopen_drive.cia402_controller import Cia402Controller, DriveDiagnostics
from ross_payload.actuators.canopen_drive.drive_client import DriveReport
from ross_payload.errors import ActuatorFault
from ross_protocols.can import CanFrame
from ross_protocols.canopen import cia402
from ross_protocols.canopen.cia402 import State
from ross_protocols.canopen.frames import NmtCommand, NmtState, heartbeat, nmt
from ross_sim.clock import QUANTUM
from ross_sim.devices.far_end import Fault

RPDO_SPEED, RPDO_ORDER = 0x200 + NODE, 0x300 + NODE


def braking(degrees_per_second):
    return degrees_per_second / 112.5


def resets(bench):
    return [data for data in bench.frames(RPDO_ORDER) if data[0] & cia402.FAULT_RESET]


# -------------------------------------------------------------------------------------------------- without us


def test_a_drive_whose_master_dies_brakes_and_switches_off():
    bench = Bench().open()
    bench.go(-150)
    bench.settle()
    bench.go(190, 0.8)
    bench.cancel()  # nobody polls any more
    here, fastest = bench.true_deg, 0.8 * 112.5 + 0.52 * 112.5  # it accelerates on until it misses us
    bench.clock.sleep(0.5 + braking(fastest) + 0.2)
    assert bench.drive_state is State.SWITCH_ON_DISABLED
    stopped = bench.true_deg
    assert stopped - here < 0.52 * fastest + fastest**2 / (2 * 112.5)
    assert stopped < 150
    bench.clock.sleep(2.0)
    assert bench.true_deg == stopped


def test_a_program_that_pauses_finds_the_drive_stopped_and_knows_why():
    bench = Bench().open()
    bench.go(190, 0.5)
    bench.cancel()
    bench.clock.sleep(1.5)
    bench.clock.every(QUANTUM, lambda: bench.actuator.poll(bench.clock.now()))
    bench.clock.sleep(0.1)
    assert "left 'operation enabled' unexpectedly" in bench.fault
    assert bench.fault.endswith("; it reports heartbeat or life guard missed (0x8130)")


def test_closing_tells_the_drive_to_expect_nothing():
    bench = Bench().open()
    bench.go(10)
    bench.settle()
    bench.close()
    bench.clock.sleep(QUANTUM)
    assert bench.drive_state is State.SWITCH_ON_DISABLED
    assert bench.drive.nmt is NmtState.PRE_OPERATIONAL
    bench.far_end.port.receive()
    bench.clock.sleep(3.0)
    assert {frame.id for frame in bench.far_end.port.receive()} == {0x700 + NODE}  # no emergency


@pytest.mark.parametrize("outage", [2.0, *in_soak(0.1)])
def test_a_bus_that_comes_back_finds_the_drive_stopped_and_leaves_it_so(outage):
    bench = Bench().open()
    bench.go(-150)
    bench.settle()
    bench.go(190, 0.8)
    bench.wire.down = True
    bench.clock.sleep(outage)
    assert bench.fault == "the bus is down"
    bench.wire.down = False
    bench.clock.sleep(3.0)
    stopped = bench.true_deg
    bench.clock.sleep(1.0)
    assert bench.true_deg == stopped < 150
    assert bench.drive_state is State.SWITCH_ON_DISABLED
    bench.actuator.home()
    bench.clock.sleep(0.2)
    bench.actuator.rearm()
    bench.go(0)
    bench.settle()
    assert bench.true_deg == pytest.approx(0, abs=0.1)


def test_closing_does_not_hang_on_a_bus_that_is_gone():
    bench = Bench().open()
    bench.go(90, 0.5)
    bench.wire.passes = lambda frame: False
    began = bench.clock.now()
    bench.close()
    assert bench.clock.now() - began < 225 / 112.5 + 1.2


def test_our_heartbeat_beats_ten_times_a_second():
    bench = Bench().open()
    began = bench.clock.now()
    bench.clock.sleep(2.0)
    assert len(bench.frames(0x700 + OWN, began)) in (20, 21)


# -------------------------------------------------------------------------------------------------- faults


@pytest.mark.parametrize(
    ("code", "words"),
    [(0x3210, "overvoltage in the DC link (0x3210)"), (0x4310, "drive too hot (0x4310)"), (0x7305, "encoder fault")],
)
def test_a_fault_is_told_in_the_drive_s_words_and_stops_it(code, words):
    bench = Bench().open()
    bench.go(120, 0.8)
    bench.drive.axis.fail(code)
    bench.clock.sleep(0.05)
    assert bench.fault.startswith("the drive is in fault: ")
    assert words in bench.fault
    bench.clock.sleep(2.0)
    assert bench.drive_state is State.FAULT
    with pytest.raises(ActuatorFault):
        bench.go(0)


def test_only_home_resets_a_fault_and_the_drive_stays_off_until_a_goal():
    bench = Bench().open()
    bench.go(40, 0.3)
    bench.drive.axis.fail(0x2310)
    bench.clock.sleep(3.0)
    assert resets(bench) == []
    bench.actuator.home()
    bench.clock.sleep(1.0)
    assert bench.drive_state is State.SWITCH_ON_DISABLED
    bench.actuator.rearm()
    bench.clock.sleep(1.0)
    assert bench.drive_state is State.SWITCH_ON_DISABLED
    bench.go(-10)
    bench.settle()
    assert bench.true_deg == pytest.approx(-10, abs=0.1)


def test_a_release_on_a_fault_resets_nothing():
    bench = Bench(guard={"on_fault": "release"}).open()
    bench.go(40, 0.3)
    bench.drive.axis.fail(0x2310)
    bench.clock.sleep(3.0)
    assert bench.drive_state is State.FAULT
    assert resets(bench) == []


def test_a_drive_that_is_in_fault_when_it_is_opened_stays_so():
    bench = Bench()
    bench.drive.axis.fail(0x5441)
    bench.open()
    bench.clock.sleep(1.0)
    assert bench.fault.startswith("the drive is in fault")
    assert resets(bench) == []


def test_a_fault_that_comes_back_is_told_again():
    bench = Bench().open()
    bench.far_end.afflict(Fault.STUCK)
    for _ in range(2):
        bench.go(30, 2.0)
        assert "following error (0x8611)" in bench.fault
        bench.actuator.home()
        bench.clock.sleep(0.5)
        bench.actuator.rearm()


def test_a_fault_that_cannot_be_reset_and_a_drive_that_does_not_switch_on_are_told():
    faulty, off = DriveReport(State.FAULT.bits | 0x200), DriveReport(State.SWITCH_ON_DISABLED.bits | 0x200)
    axis, watch = Cia402Controller(), DriveDiagnostics()
    axis.reset()
    assert watch.trouble(axis, faulty, None, 0.0) == ""
    assert "cannot be reset: no error code" in watch.trouble(axis, faulty, None, 1.01)
    axis.go(0, 1)
    assert watch.trouble(axis, off, None, 2.0) == ""
    found = watch.trouble(axis, off, None, 3.01)
    assert found == "the drive does not switch on: it is in 'switch on disabled', without voltage at its motor"


def test_a_drive_that_is_switched_off_in_a_move_is_not_switched_on_again():
    bench = Bench().open()
    bench.go(120, 0.8)
    bench.drive.axis.obey(0)  # its safety input
    bench.clock.sleep(2.0)
    assert "left 'operation enabled' unexpectedly: it is in 'switch on disabled'" in bench.fault
    assert bench.drive_state is State.SWITCH_ON_DISABLED


def test_homing_in_a_move_is_a_stop_and_settled_only_when_it_is_over():
    bench = Bench().open()
    bench.go(117, 0.5)
    bench.actuator.home()
    moving = []
    for _ in range(300):
        bench.clock.sleep(QUANTUM)
        if bench.state.settled:
            moving.append(bench.far_end.axle.rate)
    assert moving
    assert set(moving) == {0.0}
    assert bench.true_deg < 45


def test_a_place_that_cannot_be_is_not_told():
    bench = Bench().open()
    bench.go(60, 0.5)
    damaged = struct.pack("<Hib", State.OPERATION_ENABLED.bits, 2**30, 1)
    bench.wire.brought.append(CanFrame(0x180 + NODE, damaged, extended=False))
    bench.clock.sleep(QUANTUM)
    assert "implausible position from the drive: it jumps by" in bench.fault
    assert bench.state.angle == pytest.approx(bench.far_end.angle(), abs=math.radians(3))


@pytest.mark.parametrize(("beyond_deg", "doubted"), [(0, False), (45, True)])
def test_a_report_from_before_a_pause_and_one_after_it_are_no_jump(beyond_deg, doubted):
    """A pause of the whole computer, on which the other end of the bus runs, too: nothing was sent meanwhile."""
    bench = Bench().open()
    bench.go(-150)
    bench.settle()
    bench.go(190, 0.8)
    bench.cancel()
    bench.clock.sleep(QUANTUM)
    before = [frame for frame in bench.wire.receive() if frame.id == 0x180 + NODE]
    bench.clock.sleep(0.15)
    bench.wire.receive()
    bench.wire.brought = before
    bench.actuator.poll(bench.clock.now())
    bench.far_end.axle.angle += math.radians(beyond_deg)
    bench.clock.sleep(QUANTUM)
    bench.actuator.poll(bench.clock.now())
    assert ("it jumps by" in bench.fault) is doubted


@pytest.mark.parametrize("silent", [False, True])
def test_a_pause_of_the_whole_computer_is_no_silence_of_the_drive(silent):
    bench = Bench().open()
    bench.go(90, 0.4)
    bench.cancel()
    bench.clock.sleep(0.36)
    bench.wire.receive()  # what was not sent
    bench.actuator.poll(bench.clock.now())
    assert not bench.fault
    bench.far_end.afflict(Fault.SILENT, on=silent)
    bench.clock.every(QUANTUM, lambda: bench.actuator.poll(bench.clock.now()))
    bench.clock.sleep(0.4)
    assert bool(bench.fault) is silent


def test_the_silence_of_a_drive_is_noticed_by_a_program_that_polls_seldom():
    """Every poll looks like the end of a pause; only the first one after its last word excuses the drive."""
    bench = Bench(guard={"watchdog_s": 2.0}).open()
    bench.cancel()
    bench.far_end.afflict(Fault.SILENT)
    for _ in range(6):
        bench.clock.sleep(0.11)
        bench.actuator.poll(bench.clock.now())
    assert "node 5 has sent nothing" in bench.fault


def test_a_jump_soon_after_a_long_pause_is_a_jump():
    """Half a second is what a simulated drive may take to make up for it, however long it was."""
    bench = Bench(guard={"watchdog_s": 60.0}).open()
    bench.cancel()
    bench.clock.sleep(10.0)
    bench.clock.every(QUANTUM, lambda: bench.actuator.poll(bench.clock.now()))
    bench.clock.sleep(1.0)
    bench.actuator.home()
    bench.clock.sleep(1.0)
    assert not bench.fault
    bench.far_end.axle.angle += math.radians(45)
    bench.clock.sleep(0.1)
    assert "it jumps by" in bench.fault


def test_a_drive_that_restarted_while_nothing_was_heard_of_it_is_set_up_by_homing():
    bench = Bench().open()
    bench.far_end.afflict(Fault.SILENT)
    bench.drive.boot()
    bench.clock.sleep(0.2)
    bench.far_end.afflict(Fault.SILENT, on=False)
    bench.clock.sleep(1.0)
    assert "node 5 has sent nothing" in bench.fault
    bench.actuator.home()
    bench.clock.sleep(OPENING)
    bench.actuator.rearm()
    bench.go(30, 3.0)
    assert bench.state.settled
    assert bench.true_deg == pytest.approx(30, abs=0.2)


def test_a_heartbeat_from_before_the_start_that_is_read_late_is_no_fault():
    bench = Bench()
    bench.actuator.__enter__()
    while nmt(NmtCommand.START, NODE).data not in bench.frames(0):
        bench.clock.sleep(QUANTUM)
    bench.cancel()
    bench.clock.sleep(0.4)
    bench.wire.brought = [heartbeat(NODE, NmtState.PRE_OPERATIONAL), *bench.wire.receive()]
    bench.actuator.poll(bench.clock.now())
    assert not bench.fault


def test_a_goal_right_after_homing_is_not_forgotten():
    bench = Bench().open()
    bench.actuator.home()
    bench.go(10)
    bench.settle()
    assert bench.true_deg == pytest.approx(10, abs=0.1)


def test_home_waits_until_a_quick_stop_is_over():
    bench = Bench().open()
    bench.go(180, 1.2)
    bench.wire.brought.append(heartbeat(OWN, NmtState.OPERATIONAL))
    bench.clock.sleep(0.1)
    bench.actuator.home()
    bench.clock.sleep(0.1)
    bench.actuator.rearm()
    bench.go(0)
    assert bench.drive_state is State.QUICK_STOP_ACTIVE
    bench.settle()
    assert bench.true_deg == pytest.approx(0, abs=0.1)


def test_a_drive_that_somebody_stopped_is_set_up_and_started_by_home():
    bench = Bench().open()
    bench.wire.brought.append(nmt(NmtCommand.STOP, NODE))
    bench.drive.on_frame(nmt(NmtCommand.STOP, NODE))
    bench.clock.sleep(0.5)
    bench.actuator.home()
    bench.clock.sleep(OPENING)
    bench.actuator.rearm()
    bench.go(10)
    bench.settle()
    assert bench.true_deg == pytest.approx(10, abs=0.1)
