"""Looking for a home switch: from wherever it stands, past bounces, and when it is not there."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from examples import examples, rows_in_soak
from ross_payload.actuators.guard import Guard
from ross_payload.actuators.registry import checked_options, open_actuator
from ross_payload.actuators.tb6600.homing import Debouncer
from ross_payload.actuators.tb6600.pulse_segments import Level
from ross_payload.config import Config
from ross_payload.errors import ActuatorFault, NotHomed
from ross_payload.interfaces import Services
from ross_sim.clock import QUANTUM, SimClock
from ross_sim.devices.tb6600_far_end import HomeSwitch, Tb6600FarEnd, far_end
from tb6600_bench import Turning

pytestmark = pytest.mark.lockstep

PERIOD = 7.2  # of the rotor's teeth: a module that is switched on pulls it to the nearest of these [deg]
STEP = 0.1125 * 1.01  # [deg]


class Bench(Turning):
    """A driver that looks for its switch; the array stands `start` whole periods from the module's zero."""

    def __init__(self, start: int = 0, home: HomeSwitch | None = None, guard: Any = None, **options: Any) -> None:
        options = {"zero": "switch", "home_offset_deg": -15.0} | options
        config = Config.model_validate({"actuator": {"kind": "tb6600", "options": options}, "guard": guard or {}})
        self.clock = SimClock()
        self.options = checked_options(config)
        self.far: Tb6600FarEnd = far_end.make(self.options, home=home)
        self.far.rotor.angle = math.radians(start * PERIOD)
        self.clock.before_calls(self.far.advance)
        self.guard: Guard = open_actuator(config, Services(self.clock, lambda url: self.far.port))
        self.guard.__enter__()
        self.clock.every(QUANTUM, lambda: self.guard.poll(self.clock.now()))
        self.clock.sleep(0.3)

    def home(self, within: float = 29.0) -> Bench:
        self.guard.home()
        end = self.clock.now() + within
        while not self.guard.state().homed and self.guard.state().healthy and self.clock.now() < end:
            self.clock.sleep(QUANTUM)
            assert not self.guard.state().settled or self.guard.state().homed
        return self


def test_after_power_up_nothing_moves_and_nothing_holds_until_it_is_homed() -> None:
    bench = Bench()
    with pytest.raises(NotHomed):
        bench.guard.command(0.1)
    assert [bool(edge["level"]) for edge in bench.far.port.sent[0].edges] == [bench.options.enable_means_off]
    assert bench.far.port.n_sent == 1
    bench.home()
    bench.clock.sleep(0.2)
    assert bench.guard.state().settled
    assert bench.go(20.0).true_deg == pytest.approx(20.0, abs=STEP)


@pytest.mark.parametrize(
    ("start", "way"),
    [
        (0, "clockwise"),
        (3, "clockwise"),
        (-3, "clockwise"),
        (3, "counter-clockwise"),
        (-3, "counter-clockwise"),
        *rows_in_soak((20, "clockwise"), (-20, "clockwise"), (0, "counter-clockwise")),
        *rows_in_soak((20, "counter-clockwise"), (-20, "counter-clockwise")),
    ],
)
def test_it_finds_the_zero_from_either_side_of_the_switch(start: int, way: str) -> None:
    bench = Bench(start, home_direction=way).home()
    assert bench.guard.state().homed
    assert bench.go(33.0).true_deg == pytest.approx(33.0, abs=STEP)
    assert bench.far.violations == ()


def test_a_switch_that_is_high_when_pressed_and_a_motor_that_turns_the_other_way() -> None:
    bench = Bench(home_level="high", invert_direction=True, gear_ratio=2.0).home()
    assert bench.go(45.0).true_deg == pytest.approx(45.0, abs=STEP)


@pytest.mark.soak
@settings(max_examples=examples(6))
@given(start=st.integers(-20, 20), bounce=st.sampled_from([0.0, 0.02, 0.05]), speed=st.floats(5, 90))
def test_wherever_it_stands_and_however_the_switch_chatters_the_zero_is_within_two_steps(
    start: int, bounce: float, speed: float
) -> None:
    plain = Bench().options
    switch = HomeSwitch(math.radians(-15.0) + plain.resolution / 2, -1, bounce=bounce)
    bench = Bench(start, home=switch, home_speed_deg_s=speed, guard={"max_move_s": 120}).home(within=119)
    assert bench.guard.state().homed, bench.guard.state()
    steps = (bench.far.angle() - bench.guard.state().angle) / plain.resolution
    late = math.radians(speed / 10) * (QUANTUM + bounce) / plain.resolution
    assert abs(steps) <= 1.5 + late


def test_a_search_never_exceeds_its_speed_and_measures_at_a_tenth_of_it() -> None:
    bench = Bench(home_speed_deg_s=30.0)
    bench.guard.home()
    rates = []
    while not bench.guard.state().homed:
        bench.clock.sleep(QUANTUM)
        rates.append(math.degrees(bench.guard.state().rate))
    assert min(rates) == pytest.approx(-30.0)
    assert max(rates) <= 30.0 + 1e-9
    last = next(rate for rate in reversed(rates) if rate)
    assert -3.0 - 1e-9 <= last < 0


def test_a_switch_that_never_closes_is_a_fault_after_the_search() -> None:
    nowhere = HomeSwitch(math.radians(-5000), -1)
    bench = Bench(home=nowhere, home_search_deg=60.0).home()
    assert "the home switch stays open over 60 deg" in bench.guard.state().fault
    assert bench.true_deg == pytest.approx(-60.0, abs=0.1)
    with pytest.raises(ActuatorFault):
        bench.guard.command(0.0)


def test_a_switch_that_never_opens_is_a_fault_after_the_search() -> None:
    always = HomeSwitch(math.radians(5000), -1, width=math.radians(10000))
    bench = Bench(home=always, home_search_deg=60.0).home()
    assert "the home switch stays closed over 60 deg" in bench.guard.state().fault
    assert bench.true_deg == pytest.approx(60.0, abs=0.1)


def test_a_wire_that_tells_nothing_of_a_switch_is_a_fault_before_anything_moves() -> None:
    bench = Bench()
    receive = bench.far.port.receive
    bench.far.port.receive = lambda: [  # type: ignore[method-assign]
        report for report in receive() if not isinstance(report, Level)
    ]
    bench.home()
    assert "no state of the home switch received for 0.5" in bench.guard.state().fault
    assert bench.true_deg == 0.0


@pytest.mark.parametrize("end", ["stop", "release"])
def test_a_stop_or_a_release_ends_the_search_and_leaves_it_without_a_zero(end: str) -> None:
    bench = Bench(20)
    bench.guard.home()
    bench.clock.sleep(2.0)
    moving = bench.true_deg
    getattr(bench.guard, end)()
    bench.clock.sleep(2.0)
    here = bench.true_deg
    assert here < moving
    bench.clock.sleep(1.0)
    assert bench.true_deg == pytest.approx(here, abs=1e-3)
    assert not bench.guard.state().homed


def test_a_stop_in_the_moment_in_which_it_is_told_to_home_lets_nothing_move() -> None:
    bench = Bench(8)
    here = bench.true_deg
    bench.guard.home()
    bench.guard.stop()
    bench.clock.sleep(3.0)
    assert bench.true_deg == pytest.approx(here, abs=1e-3)
    assert not bench.guard.state().homed
    bench.guard.rearm()
    assert bench.home().guard.state().homed


def test_after_a_fault_the_switch_gives_the_zero_back() -> None:
    """Steps are lost by four; homing finds the true zero, and the fault is over."""
    bench = Bench().home().go(60.0)
    bench.far.rotor.angle += math.radians(4 * 1.8)
    bench.clock.sleep(0.5)
    assert bench.true_deg - math.degrees(bench.guard.state().angle) == pytest.approx(7.2, abs=1e-6)
    bench.home()
    bench.clock.sleep(12.0)
    assert bench.go(-5.0).true_deg == pytest.approx(-5.0, abs=0.06)


def test_a_level_is_believed_after_15_ms_and_dated_to_its_beginning() -> None:
    debouncer = Debouncer()
    for index in range(3):
        debouncer.update(False, index * 0.01)
    assert debouncer.known
    assert not debouncer.update(True, 0.03)
    assert not debouncer.update(True, 0.04)
    assert debouncer.update(True, 0.05)
    assert debouncer.since == 0.03
