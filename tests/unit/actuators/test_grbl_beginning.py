"""Opening a grbl board: its settings, its version, its boot, and what it was doing."""

from __future__ import annotations

import logging
import math

import pytest

from grbl_bench import TURN, Bench
from ross_payload.actuators.grbl.driver import backend
from ross_payload.actuators.grbl.options import Options, complaint
from ross_payload.errors import ActuatorFault, NotHomed
from ross_payload.interfaces import Services
from ross_protocols.grbl.protocol import State
from ross_sim.clock import QUANTUM


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({120: 500.0}, r"\$120 is 500, above the acceleration of 112.5 deg/s\^2 that is allowed: set \$120=112.5"),
        ({100: 250.0}, r"\$100 is 250 steps per degree: motor and gear need \$100=8.888889"),
        ({1: 25}, r"\$1 is 25: the motor would lose its torque at rest .* set \$1=255"),
        ({10: 2}, r"\$10 is 2: .* set \$10=1"),
        ({13: 1}, r"\$13 is 1: .* set \$13=0"),
    ],
)
def test_a_wrong_setting_is_one_clear_line_and_nothing_moves(settings, words):
    bench = Bench(settings).open()
    (line,) = bench.state.fault.splitlines()
    assert line.startswith("grbl's ")
    with pytest.raises(ActuatorFault, match=words):
        bench.actuator.command(TURN)
    bench.clock.sleep(1.0)
    assert bench.end.angle() == 0.0
    assert not bench.state.settled


@pytest.mark.parametrize("value", [0.0, -1.0])
@pytest.mark.parametrize("number", [100, 110, 120])
def test_an_absurd_setting_is_one_clear_line(number, value):
    good = {1: 255, 10: 1, 13: 0, 22: 0, 100: 8.889, 110: 13500, 120: 112.5}
    assert complaint(good, Options()) == ""
    assert complaint(good | {number: value}, Options()) == f"grbl's ${number} is {value:g}: expected a value above 0"


def test_settings_are_never_written():
    bench = Bench({120: 500.0}).open()
    assert bench.firmware.settings[120] == 500.0


def test_a_setting_that_was_mended_is_read_again_at_homing():
    bench = Bench({120: 500.0}).open()
    bench.firmware.obey("$120=112.5")
    bench.homed().go(TURN)
    assert bench.end.angle() == pytest.approx(TURN, abs=0.002)


def test_a_switch_needs_homing_to_be_enabled():
    bench = Bench({22: 0}, zero="switch").open()
    assert "set $22=1" in bench.state.fault


def test_an_axis_that_grbl_does_not_have_is_named():
    bench = Bench()
    bench.actuator = backend.open(Options(axis="A"), Services(bench.clock, lambda url: bench.wire))
    bench.open()
    assert "$103: does it have an axis A" in bench.state.fault


def test_a_grbl_that_is_slower_than_the_options_is_told_in_the_log(caplog):
    with caplog.at_level(logging.WARNING):
        bench = Bench({110: 3000.0}).open()
    assert "$110 is 3000, 50 deg/s: slower than max_speed_deg_s = 225" in caplog.text
    assert bench.state.healthy


def test_another_version_is_refused(monkeypatch):
    monkeypatch.setattr("ross_sim.devices.grbl_firmware.BUILD", ("[VER:0.9j.20160303:]",))
    assert "expected grbl 1.1, got 0.9j.20160303:" in Bench().open().state.fault


def test_where_nobody_answers_that_is_said_after_five_seconds():
    bench = Bench()
    bench.wire.cut = True
    bench.open(seconds=4.9)
    assert bench.state.fault == ""
    bench.clock.sleep(0.2)
    assert "no response from grbl 1.1 on serial:/dev/ttyUSB0:115200" in bench.state.fault


def test_a_wrong_baud_rate_is_suspected():
    bench = Bench()
    bench.wire.receive = lambda: [b"\xf8\x00\x86\n"]
    bench.open(seconds=5.2)
    assert "is the baud rate right?" in bench.state.fault


def test_a_board_that_boots_when_it_is_opened_is_waited_for():
    bench = Bench()
    bench.wire.cut = True
    bench.open(seconds=1.6)
    bench.firmware.boot()
    bench.wire.cut = False
    bench.clock.sleep(0.5)
    assert bench.state.homed
    assert bench.state.healthy


def test_a_board_that_boots_in_the_middle_of_being_asked_is_asked_again():
    for quanta in range(1, 15):
        bench = Bench().open(seconds=quanta * QUANTUM)
        bench.firmware.boot()
        bench.clock.sleep(3.0)
        assert bench.state.homed or "has restarted" in bench.state.fault
        assert bench.state.settled == bench.state.homed


def test_a_jog_that_a_dead_program_left_behind_ends_when_we_open():
    bench = Bench()
    bench.end.port.send(b"$J=G90X180F13500\n")
    bench.clock.sleep(0.8)
    bench.open(seconds=2.0)
    assert bench.end.angle() < math.radians(120)
    assert bench.state.settled
    assert bench.state.angle == 0.0  # declared: it stands at its zero when opened


def test_a_jog_of_which_only_the_end_of_the_line_is_missing_does_not_begin():
    bench = Bench()
    bench.firmware.on_bytes(b"$J=G90G21G53X60.0000F13500.0")
    bench.open(2.0)
    assert bench.end.angle() == 0.0
    assert bench.state.healthy
    bench.go(0.2)


def test_a_jog_whose_end_of_the_line_was_lost_is_forgotten_by_homing():
    bench = Bench().open()
    bench.firmware.on_bytes(b"$J=G90G21G53X60.0000F13500.0")
    bench.homed()
    assert bench.end.angle() == 0.0
    bench.go(0.2)


@pytest.mark.parametrize("opened_before", [True, False])
def test_a_homing_whose_end_of_the_line_was_lost_does_not_keep_grbl_from_homing(opened_before):
    bench = Bench({22: 1}, zero="switch")
    if opened_before:
        bench.open()
    bench.firmware.on_bytes(b"$H")
    if not opened_before:
        bench.open(2.0)
    for _ in range(
        2
    ):  # each ends: grbl refuses the first, which leaves it in its state of homing, where it does not move
        bench.actuator.home()
        bench.clock.sleep(20.0)
    bench.actuator.home()
    bench.until(lambda: bench.state.homed and bench.state.settled, within=40.0)


def test_half_a_line_that_somebody_left_does_not_hurt():
    bench = Bench()
    bench.end.port.send(b"G1 X5")
    bench.open()
    assert bench.state.homed
    assert bench.end.angle() == 0.0


@pytest.mark.parametrize("home_deg", [0.0, 20.0])
def test_with_a_switch_nothing_moves_before_homing_and_then_zero_is_where_it_was_measured(home_deg):
    bench = Bench(zero="switch", home_deg=home_deg).open()
    with pytest.raises(NotHomed, match="home first"):
        bench.actuator.command(0.0)
    bench.clock.sleep(0.5)
    assert bench.end.angle() == 0.0
    bench.homed()
    assert bench.state.angle == pytest.approx(math.radians(home_deg), abs=0.002)
    bench.go(0.1)
    assert bench.end.angle() == pytest.approx(0.1, abs=math.radians(0.3))  # as exact as the switch at that rate


def test_it_says_who_it_is():
    bench = Bench()
    assert bench.actuator.identity == ""
    assert bench.open().actuator.identity == "grbl 1.1h.20190825"


def test_it_has_no_report_before_it_knows_who_is_there():
    bench = Bench().open(seconds=0.05)
    assert math.isinf(bench.state.time)
    bench.until(lambda: bench.state.settled)
    assert bench.state.homed


def test_opened_asleep_it_stays_without_torque_until_homing():
    bench = Bench()
    bench.end.port.send(b"$SLP\n")
    bench.clock.sleep(0.1)
    bench.open()
    assert (bench.state.homed, bench.state.healthy) == (False, True)
    assert bench.firmware.state is State.SLEEP
    bench.homed().go(0.2)


def test_reopened_after_a_reset_the_position_is_unknown():
    bench = Bench().open()
    bench.go(TURN)
    bench.actuator.__exit__(None, None, None)
    bench.firmware.boot()
    bench.open()
    with pytest.raises(NotHomed):
        bench.actuator.command(0.0)


@pytest.mark.parametrize("quanta", range(6))
def test_a_stop_is_not_lost_however_soon_it_follows_the_command(quanta):
    bench = Bench().open()
    bench.actuator.command(math.pi)
    bench.clock.sleep(quanta * QUANTUM)
    bench.actuator.stop()
    bench.clock.sleep(1.0)
    assert abs(bench.end.angle()) < 0.1
    assert bench.state.settled
    assert bench.end.firmware.state is State.IDLE


def test_more_steps_than_the_processor_of_grbl_makes_are_told_in_the_log(caplog):
    with caplog.at_level(logging.WARNING):
        Bench({110: 540_000.0}, max_speed_deg_s=225.0, microsteps=16).open()
    assert "$110 asks for 80001 steps/s: grbl on an AVR loses steps above 30000" in caplog.text


def test_settings_that_came_damaged_are_read_again_when_it_is_homed():
    """Without a digit of its acceleration every turn seemed to brake too late, until the payload was restarted."""
    bench = Bench()
    port, receive = bench.end.port, bench.end.port.receive
    port.receive = lambda: [data.replace(b"$120=1", b"$120=").replace(b"$130", b"$1x30") for data in receive()]
    bench.open(1.0)
    port.receive = receive
    bench.actuator.command(math.radians(10))
    bench.clock.sleep(2.0)
    assert "does not brake before the goal" in bench.state.fault
    bench.actuator.home()
    bench.until(lambda: bench.state.homed and bench.state.settled)
    bench.go(math.radians(10))


def test_settings_that_a_stop_kept_from_being_read_again_are_read_when_it_is_homed():
    """Without them every position seemed possible, and none was within soft limits."""
    bench = Bench()
    bench.open(1.0)
    port, send, receive, said = bench.end.port, bench.end.port.send, bench.end.port.receive, []
    port.send = lambda data: (said.append(data), send(data))
    port.receive = lambda: [b"[x\r\n", *receive()]
    bench.clock.sleep(0.01)
    port.receive = receive
    bench.clock.sleep(15.0)
    bench.actuator.home()
    bench.until(lambda: b"$$\n" in said)
    bench.actuator.stop()
    bench.clock.sleep(1.0)
    said.clear()
    bench.actuator.home()
    bench.until(lambda: bench.state.homed and bench.state.settled)
    assert b"$$\n" in said
