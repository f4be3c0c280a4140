"""The grbl driver against the simulated controller: who is there, what is set, what is lost, and how it comes back."""

from __future__ import annotations

import logging
import math
from dataclasses import replace

import pytest

from rigs import CuttableWire
from ross_payload.actuators.grbl.driver import Grbl
from ross_payload.actuators.grbl.options import Options, complaint
from ross_payload.actuators.wires import open_wire
from ross_payload.clock import SystemClock
from ross_payload.errors import ActuatorFault, LimitError, LinkError, NotHomed
from ross_payload.interfaces import Services
from ross_protocols.grbl import State
from ross_sim.clock import QUANTUM, SimClock
from ross_sim.devices.far_end import Fault
from ross_sim.devices.grbl import far_end
from ross_sim.devices.wires import WireServer, side_of

TURN = math.radians(60)


class Bench:
    """A driver without its guard, and its controller."""

    def __init__(self, settings=None, **options):
        self.options = Options(**options)
        self.clock = SimClock()
        self.end = far_end.make(self.options, settings=settings)
        self.firmware = self.end.firmware
        self.clock.before_calls(self.end.advance)
        self.wire = CuttableWire(self.end.port)
        self.actuator = Grbl(self.options, Services(self.clock, lambda url: self.wire))
        self.failures = []
        self.clock.every(QUANTUM, self.poll)

    def poll(self):
        try:
            self.actuator.poll(self.clock.now())
        except LinkError as error:
            self.failures.append(str(error))

    def open(self, seconds=0.3):
        self.actuator.__enter__()
        self.clock.sleep(seconds)
        return self

    @property
    def state(self):
        return self.actuator.state()

    def go(self, angle, within=5.0):
        self.actuator.command(angle)
        self.until(lambda: self.state.settled, within)

    def until(self, true, within=5.0):
        end = self.clock.now() + within
        while not true():
            assert self.clock.now() < end, self.state
            self.clock.sleep(QUANTUM)

    def homed(self):
        self.actuator.home()
        self.until(lambda: self.state.homed and self.state.settled, within=40.0)
        return self


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({120: 500.0}, r"\$120 is 500, above the acceleration of 112.5 deg/s\^2 that is allowed: wanted \$120=112.5"),
        ({100: 250.0}, r"\$100 is 250 steps per degree: motor and gear want \$100=8.889"),
        ({1: 25}, r"\$1 is 25: the motor would lose its torque at rest .* wanted \$1=255"),
        ({10: 2}, r"\$10 is 2: .* wanted \$10=1"),
        ({13: 1}, r"\$13 is 1: .* wanted \$13=0"),
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
    assert complaint(good | {number: value}, Options()) == f"grbl's ${number} is {value:g}: wanted a value above 0"


def test_settings_are_never_written():
    bench = Bench({120: 500.0}).open()
    assert bench.firmware.settings[120] == 500.0


def test_a_setting_that_was_mended_is_read_again_at_homing():
    bench = Bench({120: 500.0}).open()
    bench.firmware.settings.assign("120=112.5")
    bench.homed().go(TURN)
    assert bench.end.angle() == pytest.approx(TURN, abs=0.002)


def test_a_switch_needs_homing_to_be_enabled():
    bench = Bench({22: 0}, zero="switch").open()
    assert "wanted $22=1" in bench.state.fault


def test_an_axis_that_grbl_does_not_have_is_named():
    bench = Bench()
    bench.actuator = Grbl(Options(axis="A"), Services(bench.clock, lambda url: bench.wire))
    bench.open()
    assert "$103: has it an axis A" in bench.state.fault


def test_a_grbl_that_is_slower_than_the_options_is_told_in_the_log(caplog):
    with caplog.at_level(logging.WARNING):
        bench = Bench({110: 3000.0}).open()
    assert "$110 is 3000, 50 deg/s: slower than max_speed_deg_s = 225" in caplog.text
    assert bench.state.healthy


def test_another_version_is_refused(monkeypatch):
    monkeypatch.setattr("ross_sim.devices.grbl_firmware.BUILD", ("[VER:0.9j.20160303:]",))
    assert "found grbl 0.9j.20160303:: wanted 1.1" in Bench().open().state.fault


def test_where_nobody_answers_that_is_said_after_five_seconds():
    bench = Bench()
    bench.wire.cut = True
    bench.open(seconds=4.9)
    assert bench.state.fault == ""
    bench.clock.sleep(0.2)
    assert "nobody answers on serial:/dev/ttyUSB0:115200 as grbl 1.1 does" in bench.state.fault


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
    bench.actuator = Grbl(bench.options, Services(bench.clock, lambda url: bench.wire))  # the other one is no more
    bench.clock.sleep(3.0)
    assert bench.end.angle() == pytest.approx(TURN, abs=0.002)
    assert bench.firmware.state is State.IDLE


def test_somebody_who_jogs_while_we_rest_is_noticed():
    bench = Bench().open()
    bench.firmware.obey("$J=G91X20F600")
    bench.clock.sleep(0.2)
    assert bench.state.fault == "somebody else moves grbl"


def test_somebody_who_runs_a_program_is_noticed_and_held_and_homing_ends_it():
    bench = Bench().open()
    bench.firmware.obey("G1X170F3000")
    bench.until(lambda: bench.state.fault)
    assert "somebody else runs a program" in bench.state.fault
    bench.actuator.stop()
    bench.clock.sleep(1.0)
    assert bench.firmware.state is State.HOLD
    assert bench.state.rate == 0.0
    bench.homed().go(0.2)


def test_a_line_that_goes_and_comes_back_needs_homing():
    bench = Bench().open()
    whole = bench.wire.receive

    def broken():
        raise LinkError("wire 'serial:/dev/ttyUSB0:115200': the device has vanished")

    bench.wire.receive = broken
    bench.clock.sleep(0.5)
    assert "the device has vanished" in bench.state.fault
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


def test_over_tcp_it_turns_in_real_time_as_in_simulated():
    clock = SystemClock()
    end, epoch = far_end.make(Options()), clock.now()
    side = side_of("serial", end.port, epoch)
    with WireServer("127.0.0.1", 0, side, clock) as server:
        options = Options(port=f"serial:tcp:127.0.0.1:{server.port}")
        deadline = clock.now() + 60

        def live(until):
            while not until():
                assert clock.now() < deadline, actuator.state()
                clock.sleep(0.005)
                side.exchange(clock.now() - epoch)
                end.advance(clock.now() - epoch)
                actuator.poll(clock.now())

        with Grbl(options, Services(clock, lambda url: open_wire(url, clock))) as actuator:
            live(lambda: actuator.state().homed and actuator.state().settled)
            actuator.command(0.5)
            live(lambda: actuator.state().settled)
    assert end.angle() == pytest.approx(0.5, abs=options.resolution)
