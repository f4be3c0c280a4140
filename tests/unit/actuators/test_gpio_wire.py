"""Pulses on pins: what lgpio is given, what comes out of it, and what the module and motor make of that."""

from __future__ import annotations

import math
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from examples import examples, rows_in_soak
from fake_lgpio import FakeLgpio
from pulse_trains import pulse, segment
from ross_payload.actuators.guard import Guard
from ross_payload.actuators.registry import checked_options, open_actuator
from ross_payload.actuators.tb6600.pulse_segments import Level, Played, PulseLine, RanOut, Segment
from ross_payload.actuators.wires import open_wire
from ross_payload.actuators.wires.gpio import GpioPulses, pins_of
from ross_payload.config import Config
from ross_payload.errors import ConfigError, LinkError, PluginError
from ross_payload.interfaces import Services
from ross_sim.clock import QUANTUM, SimClock
from ross_sim.devices.tb6600_far_end import Tb6600FarEnd, far_end
from tb6600_bench import Turning

URL = "pulses:lgpio:0:17,27,22"

SWITCH_PIN = 23


class Bench(Turning):
    """The driver on pins, the module and the motor on the same pins, in simulated time."""

    def __init__(self, phase: float = 0.0, **options: Any) -> None:
        options = {"port": URL} | options
        config = Config.model_validate({"actuator": {"kind": "tb6600", "options": options}})
        self.clock = SimClock()
        self.gpio = FakeLgpio(self.clock, phase)
        self.far: Tb6600FarEnd = far_end.make(checked_options(config))
        self.clock.before_calls(self._carry)
        self.guard: Guard = open_actuator(config, Services(self.clock, self.open_port))
        self.guard.__enter__()
        self.clock.every(QUANTUM, lambda: self.guard.poll(self.clock.now()))
        self.clock.sleep(0.2)

    def open_port(self, url: str) -> GpioPulses:
        return GpioPulses(self.gpio, pins_of(url), self.clock)

    def _carry(self, now: float) -> None:
        edges = self.gpio.new_edges()
        self.far.port.send(Segment(0.0, now, edges))
        self.far.advance(now)
        for report in self.far.port.receive():
            if isinstance(report, Level):
                self.gpio.inputs[SWITCH_PIN] = int(report.level)


@pytest.fixture
def clock() -> SimClock:
    return SimClock()


@pytest.fixture
def gpio(clock: SimClock) -> FakeLgpio:
    return FakeLgpio(clock)


@pytest.fixture
def port(gpio: FakeLgpio, clock: SimClock) -> GpioPulses:
    return GpioPulses(gpio, pins_of(URL), clock)


# ------------------------------------------------------------------------------------------ the port


def test_the_lines_are_claimed_with_the_level_that_the_first_segment_wants(gpio: FakeLgpio, port: GpioPulses) -> None:
    assert gpio.claimed == []
    port.send(segment(0.0, 0.005, (0.0, PulseLine.ENABLE, True)))
    assert gpio.claimed == [([17, 27, 22], [0, 0, 1])]


def test_segments_that_follow_one_another_come_out_without_a_gap(
    gpio: FakeLgpio, port: GpioPulses, clock: SimClock
) -> None:
    for index in range(8):
        port.send(segment(index * 0.0101, 0.0101, *pulse(0.0)))
        if index > 1:
            clock.sleep(0.01)
    clock.sleep(0.2)
    port.receive()
    rises = [time for time, line, level in gpio.edges if (line, level) == (PulseLine.STEP, 1)]
    assert np.diff(rises).tolist() == [10_100] * 7
    assert len(gpio.starts) == 1


def test_a_segment_is_reported_when_it_is_out_and_not_before(port: GpioPulses, clock: SimClock) -> None:
    port.send(segment(0.0, 0.03, *pulse(0.0)))
    seen = []
    for _ in range(8):
        clock.sleep(0.01)
        seen.append(port.receive())
    assert seen[:4] == [[]] * 4  # the thread wakes at 20 ms
    assert seen[4] == [Played(0.03)]
    assert seen[5:] == [[]] * 3


def test_more_segments_than_the_library_takes_wait_for_room(gpio: FakeLgpio, port: GpioPulses, clock: SimClock) -> None:
    for index in range(25):
        port.send(segment(index * 0.002, 0.002, *pulse(0.0)))
    assert gpio.most == 10
    for _ in range(10):
        clock.sleep(0.01)
        port.receive()
    assert sum(level for _, line, level in gpio.edges if line == PulseLine.STEP) == 25


def test_torque_that_comes_on_late_is_no_underrun(port: GpioPulses, clock: SimClock) -> None:
    port.send(segment(0.0, 0.01, *pulse(0.0)))
    clock.sleep(0.05)
    port.send(segment(0.01, 0.01, (0.0, PulseLine.ENABLE, False)))
    clock.sleep(0.05)
    assert port.receive() == [Played(0.01), Played(0.02)]


def test_a_stream_that_ran_dry_takes_no_step_until_it_is_told_again(
    gpio: FakeLgpio, port: GpioPulses, clock: SimClock
) -> None:
    port.send(segment(0.0, 0.01, *pulse(0.0)))
    clock.sleep(0.05)
    port.send(segment(0.01, 0.01, (0.0, PulseLine.DIRECTION, True), *pulse(0.001)))
    assert port.receive() == [Played(0.01), RanOut(0.02)]
    clock.sleep(0.05)
    assert port.receive() == [Played(0.02)]
    assert sum(level for _, line, level in gpio.edges if line == PulseLine.STEP) == 1
    assert gpio.edges[-1][1:] == (PulseLine.DIRECTION, 1)
    port.send(segment(clock.now(), 0.01, *pulse(0.001)))
    clock.sleep(0.05)
    assert port.receive() == [Played(0.11)]
    assert sum(level for _, line, level in gpio.edges if line == PulseLine.STEP) == 2


def test_closing_waits_until_the_last_edge_is_out_and_gives_the_chip_back(
    gpio: FakeLgpio, port: GpioPulses, clock: SimClock
) -> None:
    for index in range(20):
        port.send(segment(index * 0.1, 0.1, *pulse(0.05)))
    port.close()
    port.close()
    assert sum(level for _, line, level in gpio.edges if line == PulseLine.STEP) == 20
    assert gpio.open_handles == 0
    assert 2.0 <= clock.now() <= 2.1
    assert port.receive() == []
    with pytest.raises(LinkError, match="closed"):
        port.send(segment(3.0, 0.01))


def test_a_switch_is_read_at_every_look_with_its_pull_up(gpio: FakeLgpio, clock: SimClock) -> None:
    port = GpioPulses(gpio, pins_of(f"{URL},{SWITCH_PIN}"), clock)
    assert gpio.flags == {SWITCH_PIN: FakeLgpio.SET_PULL_UP}
    clock.sleep(0.01)
    gpio.inputs[SWITCH_PIN] = 0
    assert port.receive() == [Level(PulseLine.HOME, False, 0.01)]


@pytest.mark.parametrize(
    ("url", "words"),
    [
        (f"{URL},{SWITCH_PIN},5", "expected pulses:lgpio:CHIP:STEP,DIRECTION,ENABLE"),
        ("pulses:lgpio:17,27,22", "expected pulses:lgpio:CHIP"),
        ("pulses:lgpio:0:17,x,22", "all numbers"),
        ("pulses:lgpio:0:17,27,17", "one twice"),
    ],
)
def test_a_url_that_names_no_pins_is_one_clear_line(url: str, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        open_wire(url, SimClock())


def test_no_chip_and_a_line_that_is_taken_are_one_clear_line_and_leave_nothing_open(clock: SimClock) -> None:
    gpio = FakeLgpio(clock, taken=(22, SWITCH_PIN))
    with pytest.raises(LinkError, match=r"/dev/gpiochip3: can not open gpiochip: does it exist"):
        GpioPulses(gpio, pins_of("pulses:lgpio:3:17,27,22"), clock)
    with pytest.raises(LinkError, match="/dev/gpiochip0: GPIO busy"):
        GpioPulses(gpio, pins_of(f"{URL},{SWITCH_PIN}"), clock)
    assert gpio.open_handles == 0
    with pytest.raises(LinkError, match="/dev/gpiochip0: GPIO busy"):
        GpioPulses(gpio, pins_of(URL), clock).send(segment(0.0, 0.01))


def test_a_missing_library_is_one_line_with_both_remedies(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "lgpio", None)
    before = Path.cwd()
    with pytest.raises(PluginError, match=r"needs the package lgpio: .*pip install 'lgpio>=.* python3-lgpio"):
        open_wire(URL, SimClock())
    assert Path.cwd() == before


def test_threads_of_the_library_are_born_urgent_where_that_is_allowed_and_ours_stays_as_it_was(clock: SimClock) -> None:
    class Curious(FakeLgpio):
        def gpiochip_open(self, chip: int) -> int:
            self.policy = os.sched_getscheduler(0), os.sched_getparam(0).sched_priority
            return super().gpiochip_open(chip)

    before = os.sched_getscheduler(0)
    gpio = Curious(clock)
    GpioPulses(gpio, pins_of(URL), clock)
    assert gpio.policy in ((os.SCHED_RR, 20), (before, 0))
    assert os.sched_getscheduler(0) == before


def test_options_that_do_not_fit_pins_are_refused() -> None:
    with pytest.raises(ConfigError, match="expected at most 40"):
        Bench(ahead_ms=50)
    with pytest.raises(ConfigError, match="expected a HOME line"):
        Bench(zero="switch")


# ------------------------------------------------------------------------------------------ the whole way


OTHERWISE = {"invert_direction": True, "enable_means_off": False, "gear_ratio": 3.0}


@pytest.mark.parametrize(
    ("phase", "options"),
    [
        (0.003, OTHERWISE),
        *rows_in_soak((0.0, {}), (0.0199, {}), (0.0, OTHERWISE), (0.003, {}), (0.0199, OTHERWISE)),
    ],
)
def test_a_move_on_pins_ends_at_its_goal_with_the_module_s_timing_kept(phase: float, options: dict[str, Any]) -> None:
    bench = Bench(phase, **options).go(90.0).go(-45.0)
    assert bench.true_deg == pytest.approx(-45.0, abs=1e-9)
    assert bench.far.complaints() == []
    assert bench.guard.state().settled
    assert bench.gpio.most <= 8  # 60 ms: what is handed over ahead, and until the thread wakes


def test_a_stop_on_pins_travels_the_braking_distance_and_100_ms_at_most() -> None:
    bench = Bench()
    bench.guard.command(math.radians(190))
    bench.clock.sleep(1.0)
    here, rate = bench.true_deg, math.degrees(bench.guard.state().rate)
    bench.guard.stop()
    bench.clock.sleep(3.0)
    assert rate**2 / (2 * 112.5) * 0.9 < bench.true_deg - here <= rate**2 / (2 * 112.5) + 0.1 * (rate + 112.5 * 0.05)
    assert bench.far.complaints() == []


def test_closing_in_mid_move_decelerates_and_opening_again_sends_direction_and_enable_again() -> None:
    bench = Bench()
    bench.guard.command(math.radians(190))
    bench.clock.sleep(1.0)
    here = bench.true_deg
    bench.guard.__exit__(None, None, None)
    assert bench.true_deg - here > 40
    assert bench.gpio.open_handles == 0
    bench.guard.__enter__()
    bench.clock.sleep(0.2)
    assert bench.gpio.claimed[-1] == ([17, 27, 22], [0, 0, 0])
    bench.go(190.0)
    assert bench.true_deg == pytest.approx(190.0, abs=0.06)
    assert bench.far.complaints() == []


def test_homing_on_pins_finds_the_switch() -> None:
    bench = Bench(port=f"{URL},{SWITCH_PIN}", zero="switch", home_offset_deg=-15.0)
    bench.guard.home()
    bench.clock.sleep(12.0)
    assert bench.guard.state().homed
    assert bench.go(30.0).true_deg == pytest.approx(30.0, abs=0.12)
    assert bench.far.complaints() == []


def test_a_process_that_dies_at_full_speed_stops_the_edges_at_once() -> None:
    """The thread of the library dies with it; a light array then falls into step where the windings stand."""
    bench = Bench()
    bench.guard.command(math.radians(190))
    bench.clock.sleep(1.5)
    bench.gpio.gpiochip_close(0)
    here = bench.true_deg
    bench.guard.poll = lambda now: None  # type: ignore[method-assign]
    bench.clock.sleep(2.0)
    assert bench.true_deg - here < 7.2 + 1.8


step = st.tuples(st.floats(-199, 199), st.floats(1, 400), st.integers(1, 80), st.booleans())


@settings(max_examples=examples(15))
@given(
    steps=st.lists(step, min_size=1, max_size=5), microsteps=st.sampled_from([1, 4, 16, 32]), phase=st.floats(0, 0.02)
)
def test_no_sequence_of_goals_and_stops_breaks_the_module_s_timing_on_pins(
    steps: list[tuple[float, float, int, bool]], microsteps: int, phase: float
) -> None:
    bench = Bench(phase, microsteps=microsteps)
    for goal, rate, quanta, stop in steps:
        bench.guard.command(math.radians(goal), math.radians(rate))
        bench.clock.sleep(quanta * QUANTUM)
        if stop:
            bench.guard.stop()
            bench.guard.rearm()
    bench.guard.stop()
    bench.clock.sleep(3.0)
    assert bench.far.complaints() == []
    assert bench.far.angle() == pytest.approx(bench.guard.state().angle, abs=1e-9)
