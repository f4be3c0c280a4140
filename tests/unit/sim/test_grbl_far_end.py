"""The simulated grbl: it moves as physics and its settings say, and refuses what the stock firmware refuses."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from examples import examples
from ross_payload.actuators.grbl.options import Options
from ross_protocols.grbl.protocol import JOG_CANCEL, RESET, STATUS, Alarm, Error, Lines, Ok, Report, State
from ross_sim.devices.far_end import Fault
from ross_sim.devices.grbl_far_end import GrblFarEnd, far_end
from ross_sim.devices.grbl_firmware import RECEIVE_BUFFER, Firmware
from ross_sim.devices.grbl_planner import PIECE, Axis, Motion
from ross_sim.devices.stepper import Motor


class Terminal:
    """Types at a firmware and reads what it prints."""

    def __init__(self, firmware):
        self.firmware = firmware
        self._lines = Lines()
        self.said = self.wait(0.01)

    def wait(self, seconds):
        for _ in range(round(seconds / PIECE)):
            self.firmware.tick()
        said, self.firmware.out[:] = bytes(self.firmware.out), b""
        return self._lines.feed(said)

    def type(self, text, seconds=0.01):
        self.firmware.on_bytes(text if isinstance(text, bytes) else text.encode())
        return self.wait(seconds)

    def answer(self, text):
        return self.type(text + "\n")[-1]

    @property
    def report(self):
        return next(message for message in self.type(STATUS) if isinstance(message, Report))


@pytest.fixture
def terminal():
    return Terminal(Firmware({100: 10.0, 110: 6000.0, 120: 100.0, 130: 300.0}, "XYZ", "X", lambda: False))


def place(report):
    return round(math.degrees(report.machine[0]), 3)


def duration(motion):
    n = 0
    while motion.moving:
        motion.piece()
        n += 1
    return n * PIECE


@pytest.mark.parametrize(("length", "seconds"), [(1.0, 0.2), (25.0, 1.0), (200.0, 3.0)])
def test_a_line_takes_the_time_of_its_trapezoid(length, seconds):
    motion = Motion((Axis(100.0, 6000.0, 100.0),), 0.01)
    motion.add((round(length * 100),), 6000.0)
    assert duration(motion) == pytest.approx(seconds, abs=0.011)
    assert motion.position == (round(length * 100),)


def test_lines_of_one_direction_are_chained_without_a_stop():
    motion = Motion((Axis(100.0, 6000.0, 100.0),), 0.01)
    for n in range(1, 11):
        motion.add((1000 * n,), 6000.0)
    assert duration(motion) == pytest.approx(100 / 100 + 1.0, abs=0.011)


def test_a_line_back_begins_from_rest():
    motion = Motion((Axis(100.0, 6000.0, 100.0),), 0.01)
    motion.add((2500,), 6000.0)
    motion.add((0,), 6000.0)
    assert duration(motion) == pytest.approx(2.0, abs=0.02)


@settings(max_examples=examples(25))
@given(
    st.lists(st.tuples(st.integers(-800, 800), st.integers(-300, 300), st.floats(600, 9000)), min_size=1, max_size=6)
)
def test_no_path_exceeds_speed_or_acceleration_and_every_path_ends_at_its_goal(path):
    axes = (Axis(10.0, 6000.0, 100.0), Axis(20.0, 3000.0, 400.0))
    motion = Motion(axes, 0.01)
    for x, y, feed in path:
        motion.add((x, y), feed)
    before = 0.0
    while motion.moving:
        start, end = motion.piece()
        speed = abs(end[0] - start[0]) / 10.0 / PIECE
        assert speed <= 100.0 * (1 + 1e-6)
        before = speed
    assert before <= 1.0
    assert motion.position == (path[-1][0], path[-1][1])


def test_a_jog_ends_where_it_was_told_to(terminal):
    assert terminal.answer("$J=G90G21X30F3000") == Ok()
    assert terminal.report.state is State.JOG
    terminal.wait(3.0)
    report = terminal.report
    assert (report.state, place(report)) == (State.IDLE, 30.0)


def test_a_jog_that_is_cancelled_brakes_and_takes_the_ones_behind_it_along(terminal):
    terminal.type("$J=G91X100F6000\n$J=G91X100F6000\n", seconds=0.5)
    here = place(terminal.report)
    terminal.type(JOG_CANCEL, seconds=2.0)
    report = terminal.report
    assert report.state is State.IDLE
    assert 50**2 / 200 < place(report) - here < 56**2 / 200 + 0.06 * 56


def test_a_cancel_that_comes_before_the_jog_is_ignored(terminal):
    terminal.type(JOG_CANCEL)
    terminal.type("$J=X10F6000\n", seconds=2.0)
    assert place(terminal.report) == 10.0


def test_a_jog_accepted_while_another_is_being_cancelled_is_lost_with_it(terminal):
    terminal.type("$J=X100F6000\n", seconds=1.0)
    terminal.type(JOG_CANCEL, seconds=0.1)
    assert terminal.answer("$J=X-50F6000") == Ok()
    terminal.wait(3.0)
    assert place(terminal.report) > 0


def test_beyond_the_soft_limits_a_jog_is_refused_and_nothing_moves(terminal):
    terminal.answer("$20=1")
    assert terminal.answer("$J=G90X10F3000") == Error(15)
    assert terminal.answer("$J=G90X-301F3000") == Error(15)
    assert terminal.report.state is State.IDLE
    assert terminal.answer("$J=G90X-300F3000") == Ok()


@pytest.mark.parametrize(
    ("line", "number"),
    [("$J=G0X1F9", 16), ("$J=X1", 22), ("$J=F100", 26), ("$JX1", 3), ("$H", 5), ("$100=x", 2), ("$999=1", 3),
     ("$100=-1", 4), ("G2X1", 20), ("X", 2), ("G1X1", 22), ("1", 1), ("G1X1X2F9", 25), ("$" + "Q" * 90, 11)],
)  # fmt: skip
def test_a_wrong_line_has_its_error_number(terminal, line, number):
    assert terminal.answer(line) == Error(number)


def test_a_reset_in_mid_move_is_an_alarm_until_it_is_unlocked(terminal):
    terminal.type("$J=X100F6000\n", seconds=0.5)
    assert Alarm(3) in terminal.type(RESET)
    assert terminal.report.state is State.ALARM
    assert terminal.answer("G1X0F100") == Error(9)
    terminal.answer("$X")
    assert terminal.report.state is State.IDLE


def test_asleep_it_answers_no_line_until_it_is_reset(terminal):
    assert terminal.type("$SLP\n")[-1] == Ok()
    assert not terminal.firmware.energised
    assert terminal.type("$I\n") == []
    terminal.type(RESET)
    assert terminal.report.state is State.ALARM


def test_what_does_not_fit_into_the_receive_buffer_is_lost(terminal):
    for _ in range(16):
        terminal.type(b"$J=G91X10F60\n")
    assert terminal.firmware.motion.free == 0
    terminal.type(b"$J=G91X1F60\n" * 20, seconds=0.0)
    n = len(terminal.firmware._received)
    assert n == RECEIVE_BUFFER


def test_homing_finds_the_switch_and_tells_nothing_meanwhile():
    where = [0.0]
    firmware = Firmware({100: 10.0, 22: 1, 25: 1200.0, 24: 300.0, 110: 6000.0, 120: 100.0}, "XYZ", "X",
                        lambda: where[0] >= 200)  # fmt: skip
    terminal = Terminal(firmware)
    assert terminal.report.state is State.ALARM
    terminal.type("$H\n")
    firmware.on_bytes(STATUS)
    while firmware.state is not State.IDLE:
        assert firmware.out == b""
        before, after = firmware.tick()
        where[0] += after - before
    assert terminal.wait(0.01)[0] == Ok()
    assert place(terminal.report) == -1.0
    assert where[0] == pytest.approx(190, abs=3)


def test_homing_without_a_switch_is_an_alarm():
    terminal = Terminal(Firmware({100: 10.0, 22: 1, 25: 6000.0, 110: 6000.0, 120: 1000.0, 130: 50.0}, "XYZ", "X",
                                 lambda: False))  # fmt: skip
    assert Alarm(9) in terminal.type("$H\n", seconds=10.0)


@pytest.mark.parametrize("axis", ["X", "Z", "A"])
def test_the_motor_follows_its_axis(axis):
    end = far_end.make(Options(axis=axis))
    end.port.send(f"$J=G90{axis}45F9000\n".encode())
    for n in range(1, 300):
        end.advance(n * 0.01)
    assert math.degrees(end.angle()) == pytest.approx(45.0, abs=1e-4)
    assert end.complaints() == []


def test_a_load_too_heavy_for_the_acceleration_loses_steps_and_grbl_does_not_know():
    end = far_end.make(Options(max_acceleration_deg_s2=20000.0), motor=Motor(load_inertia=2e-2))
    end.port.send(b"$J=G90X90F13500\n")
    for n in range(1, 300):
        end.advance(n * 0.01)
    end.port.send(STATUS)
    end.advance(3.1)
    (report,) = (each for data in end.port.receive() for each in Lines().feed(data) if isinstance(each, Report))
    assert math.degrees(report.machine[0]) == pytest.approx(90, abs=0.06)
    assert math.degrees(end.angle()) < 80
    assert "steps lost" in end.complaints()[0]


def test_a_slow_line_delivers_late():
    end = far_end.make(Options())
    end.port.send(b"$$\n")
    end.advance(0.01)
    end.advance(0.02)
    assert sum(map(len, end.port.receive())) <= 0.02 * 11520 + 1


@pytest.mark.parametrize("fault", [Fault.NOISY, Fault.SATURATED, Fault.DUPLICATE])
def test_a_fault_that_makes_no_sense_is_refused(fault):
    end: GrblFarEnd = far_end.make(Options())
    with pytest.raises(ValueError, match="expected one of"):
        end.afflict(fault)
