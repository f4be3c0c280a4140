"""The grbl driver against the simulated controller: who is there, what is set, what is lost, and how it comes back."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from grbl_bench import TURN, Bench
from rigs import rig_of
from ross_payload.actuators.grbl.driver import backend
from ross_payload.errors import ActuatorFault, LimitError, LinkError, NotHomed
from ross_payload.interfaces import Services
from ross_protocols.grbl.protocol import State
from ross_sim.clock import QUANTUM
from ross_sim.devices.far_end import Fault


@pytest.mark.parametrize("gives_up", ["home", "release"])
def test_a_goal_in_the_same_instant_as_homing_is_refused_not_forgotten(gives_up):
    bench = Bench().open()
    bench.actuator.command(1.0)
    bench.clock.sleep(0.5)
    getattr(bench.actuator, gives_up)()
    with pytest.raises(NotHomed):
        bench.actuator.command(1.5)


def test_a_slip_is_put_right_by_homing_with_a_switch():
    bench = Bench(zero="switch").open()
    bench.homed()
    bench.go(-0.5)  # grbl does not find a switch that it stands on
    bench.end.afflict(Fault.SLIP)
    assert abs(bench.state.angle - bench.end.angle()) > math.radians(9)
    bench.homed()
    assert bench.state.angle == pytest.approx(bench.end.angle(), abs=math.radians(0.3))
    assert bench.actuator.capabilities.finds_zero


def test_while_it_homes_reports_stay_fresh_and_it_is_not_settled_before_it_is_homed():
    bench = Bench(zero="switch", home_deg=20.0).open()
    bench.actuator.home()
    bench.clock.sleep(0.1)
    seen = []
    while not bench.state.settled:
        bench.clock.sleep(QUANTUM)
        seen.append(bench.state.homed)
        assert bench.clock.now() - bench.state.time < 0.05
    assert seen[-1]
    assert not seen[0]
    assert len(seen) > 50


def test_a_rate_that_grbl_would_round_to_none_is_the_least_that_it_moves_at():
    bench = Bench().open()
    bench.actuator.command(math.radians(0.2), 1e-6)
    bench.until(lambda: bench.state.settled and abs(bench.state.angle) > math.radians(0.1), within=20.0)
    assert bench.state.healthy


def test_a_stop_ends_homing():
    bench = Bench(zero="switch", home_deg=60.0).open()
    bench.actuator.home()
    bench.clock.sleep(0.5)
    bench.actuator.stop()
    bench.clock.sleep(0.5)
    here = bench.end.angle()
    bench.clock.sleep(1.0)
    assert bench.end.angle() == pytest.approx(here, abs=1e-3)
    assert not bench.state.homed
    bench.homed()


def test_a_restart_after_a_homing_that_was_stopped_loses_the_position_too():
    bench = Bench(zero="switch", home_deg=60.0).open()
    bench.actuator.home()
    bench.clock.sleep(0.5)
    bench.actuator.stop()
    bench.clock.sleep(1.0)
    bench.homed()
    bench.end.afflict(Fault.REBOOT)
    bench.clock.sleep(3.0)
    assert (bench.state.homed, bench.state.healthy) == (False, False)
    assert "grbl has restarted: the position is lost" in bench.state.fault


def test_homing_that_finds_no_switch_is_a_fault_in_words():
    bench = Bench({25: 60000.0, 130: 20.0}, zero="switch", home_deg=90.0).open()
    bench.actuator.home()
    bench.until(lambda: bench.state.fault, within=20.0)
    assert "no limit switch found" in bench.state.fault
    assert not bench.state.homed


def test_an_unknown_zero_is_declared_by_homing():
    bench = Bench(zero="unknown").open()
    with pytest.raises(NotHomed):
        bench.actuator.command(0.0)
    bench.homed().go(TURN)
    assert bench.end.angle() == pytest.approx(TURN, abs=0.002)


def test_a_restart_in_mid_move_loses_the_position_until_homing():
    bench = Bench().open()
    bench.actuator.command(TURN)
    bench.clock.sleep(0.5)
    bench.end.afflict(Fault.REBOOT)
    bench.clock.sleep(0.1)
    assert (bench.state.homed, bench.state.healthy) == (False, False)
    with pytest.raises(ActuatorFault, match="restarted: the position is lost"):
        bench.actuator.command(0.0)
    here = bench.homed().end.angle()
    assert bench.state.angle == 0.0
    bench.go(0.3)
    assert bench.end.angle() - here == pytest.approx(0.3, abs=0.01)


def test_a_hard_limit_loses_the_position_and_homing_unlocks():
    bench = Bench().open()
    bench.actuator.command(TURN)
    bench.clock.sleep(0.5)
    bench.firmware._alarm(1)
    bench.clock.sleep(0.2)
    assert bench.state.fault == "grbl: alarm 1: a limit switch was hit; the position is lost"
    assert not bench.state.homed
    bench.homed().go(0.2)


def test_goals_beyond_grbl_s_soft_limits_are_refused():
    bench = Bench({20: 1, 22: 1, 130: 90.0}, zero="switch", home_deg=10.0).open().homed()
    with pytest.raises(LimitError, match="soft limits"):
        bench.actuator.command(math.radians(15))
    with pytest.raises(LimitError, match="soft limits"):
        bench.actuator.command(math.radians(-85))
    bench.go(math.radians(-70))


def test_a_jog_that_grbl_refuses_is_a_fault_in_words():
    bench = Bench().open()
    bench.firmware.settings.assign("20=1")  # behind our back
    bench.actuator.command(TURN)
    bench.clock.sleep(0.2)
    assert "grbl refuses '$J=" in bench.state.fault
    assert "error 15: the goal is beyond its soft limits" in bench.state.fault


def test_release_takes_the_torque_away_and_homing_gives_it_back():
    bench = Bench().open()
    bench.actuator.command(TURN)
    bench.clock.sleep(0.6)
    bench.actuator.release()
    bench.clock.sleep(2.0)
    assert bench.firmware.state is State.SLEEP
    assert not bench.state.homed
    with pytest.raises(NotHomed):
        bench.actuator.command(0.0)
    bench.homed()
    assert bench.firmware.energised
    bench.go(0.2)


def test_a_second_release_is_no_fault():
    """Asleep grbl answers no line."""
    bench = Bench().open()
    bench.actuator.release()
    bench.clock.sleep(1.0)
    assert bench.firmware.state is State.SLEEP
    bench.actuator.release()
    bench.clock.sleep(2.0)
    assert not bench.state.fault
    bench.homed().go(0.2)


def test_an_answer_that_is_lost_does_not_stop_a_stop():
    bench = Bench().open()
    bench.actuator.command(math.pi)
    bench.wire.cut = True
    bench.clock.sleep(0.3)
    bench.wire.cut = False
    bench.actuator.stop()
    bench.clock.sleep(2.5)
    assert bench.state.settled
    bench.go(0.1)


def test_when_our_process_is_killed_grbl_finishes_its_jog_and_no_more():
    bench = Bench().open()
    bench.actuator.command(TURN)
    bench.clock.sleep(0.3)
    bench.actuator = backend.open(
        bench.options, Services(bench.clock, lambda url: bench.wire)
    )  # the other one is no more
    bench.clock.sleep(3.0)
    assert bench.end.angle() == pytest.approx(TURN, abs=0.002)
    assert bench.firmware.state is State.IDLE


def test_somebody_who_jogs_while_we_rest_is_noticed():
    bench = Bench().open()
    bench.firmware.obey("$J=G91X20F600")
    bench.clock.sleep(0.2)
    assert bench.state.fault == "another controller moves grbl"


def test_somebody_who_runs_a_program_is_noticed_and_held_and_homing_ends_it():
    bench = Bench().open()
    bench.firmware.obey("G1X170F3000")
    bench.until(lambda: bench.state.fault)
    assert "another controller runs a program" in bench.state.fault
    bench.actuator.stop()
    bench.clock.sleep(1.0)
    assert bench.firmware.state is State.HOLD
    assert bench.state.rate == 0.0
    bench.homed().go(0.2)


def test_a_line_that_goes_and_comes_back_needs_homing():
    bench = Bench().open()
    whole = bench.wire.receive

    def broken():
        raise LinkError("wire 'serial:/dev/ttyUSB0:115200': the device was disconnected")

    bench.wire.receive = broken
    bench.clock.sleep(0.5)
    assert "the device was disconnected" in bench.state.fault
    assert bench.failures
    assert not bench.state.homed
    bench.wire.receive = whole
    bench.firmware.boot()
    bench.clock.sleep(0.5)
    bench.homed().go(0.2)


def test_a_finer_gear_moves_as_far():
    bench = Bench(microsteps=32, gear_ratio=3.0, axis="Y").open()
    bench.go(TURN)
    assert bench.end.angle() == pytest.approx(TURN, abs=0.0005)
    assert bench.state.angle == pytest.approx(bench.end.angle(), abs=1e-6)


def test_the_speed_told_is_the_speed():
    bench = Bench().open()
    bench.actuator.command(math.pi)
    worst = 0.0
    before = bench.end.firmware.count
    for _ in range(150):
        bench.clock.sleep(2 * QUANTUM)
        after = bench.end.firmware.count
        truth, before = (after - before) * bench.options.resolution / (2 * QUANTUM), after
        worst = max(worst, abs(bench.state.rate - truth))
    assert worst < 0.15  # 40 ms of acceleration, and a step


def test_a_state_without_its_report_is_not_settled():
    bench = Bench().open()
    assert bench.state.settled
    bench.wire.cut = True
    bench.clock.sleep(0.4)
    assert not bench.state.settled
    assert replace(bench.state, time=0.0).homed


def test_a_goal_that_was_damaged_on_its_way_is_noticed_before_the_right_one_is_passed():
    """A serial line has no checksum: one bit, and 15 degrees are 95."""
    rig = rig_of("grbl", lower_deg=-45, upper_deg=45).open()
    rig.actuator.command(math.radians(-45))
    rig.settle(within=5.0)
    port = rig.far_end.port
    send = port.send
    port.send = lambda frame: send(frame.replace(b"X1", b"X9"))
    rig.actuator.command(math.radians(15))
    end, highest = rig.clock.now() + 4.0, -math.inf
    while rig.clock.now() < end:
        rig.clock.sleep(QUANTUM)
        highest = max(highest, math.degrees(rig.far_end.angle()))
    assert rig.state.fault == "grbl does not brake before the goal: it was told another one"
    assert highest < 45
    assert rig.state.rate == 0.0


def test_a_position_out_of_reach_soon_after_a_long_pause_is_not_believed():
    """Half a second is what a simulated grbl may take to make up for it, however long it was."""
    bench = Bench().open()
    poll, receive = bench.actuator.poll, bench.wire.receive
    bench.actuator.poll = lambda now: None
    bench.clock.sleep(10.0)
    bench.actuator.poll = poll
    bench.clock.sleep(1.0)
    assert bench.state.healthy
    bench.wire.receive = lambda: [*receive(), b"<Idle|MPos:60.000,0.000,0.000|FS:0,0>\r\n"]
    bench.clock.sleep(3 * QUANTUM)
    assert "a position out of reach" in bench.state.fault
    assert bench.state.angle == 0.0
