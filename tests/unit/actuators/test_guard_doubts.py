"""The guard against devices that are absurd or lie, moves that never end, and runaways."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from clocks import FakeClock
from guard_bench import ABLE, Device, bench
from ross_payload import config
from ross_payload.actuators.guard import Guard
from ross_payload.actuators.guard_checks import beyond, doubt
from ross_payload.errors import ActuatorFault, ConfigError, LimitError
from ross_payload.interfaces import ActuatorState

HOLDS = ActuatorState(0.0, 0.0, True, True, True, 0.0)


# ------------------------------------------------------------------------------------------ absurd devices


@pytest.mark.parametrize("value", [math.nan, math.inf, 0.0, -1.0])
@pytest.mark.parametrize("name", ["max_speed", "max_acceleration", "resolution"])
def test_a_device_whose_numbers_are_absurd_cannot_be_opened(name: str, value: float) -> None:
    with pytest.raises(ConfigError, match=f"{name.removeprefix('max_')} to be finite and above 0, got"):
        bench(Device(replace(ABLE, **{name: value})))


@pytest.mark.parametrize("travel", [(math.nan, 2.0), (-2.0, math.nan), (2.0, -2.0), (1.0, 1.0)])
def test_a_travel_that_is_none_cannot_be_opened(travel: tuple[float, float]) -> None:
    with pytest.raises(ConfigError, match=r"lower limit of the actuator's travel first, got"):
        bench(Device(replace(ABLE, lower=travel[0], upper=travel[1])))


def test_a_step_as_large_as_the_travel_cannot_be_opened() -> None:
    with pytest.raises(ConfigError, match="farther apart than one step"):
        bench(Device(replace(ABLE, resolution=math.radians(40))), lower_deg=-20, upper_deg=20)


def test_a_speed_at_which_nothing_turns_cannot_be_opened() -> None:
    with pytest.raises(ConfigError, match="a speed of at least 1e-06 rad/s, got"):
        bench(max_speed_deg_s=1e-6)


def test_a_turntable_without_end_still_has_the_configured_limits() -> None:
    able = replace(ABLE, lower=-math.inf, upper=math.inf, continuous=True)
    on = bench(Device(able))
    assert not on.guard.capabilities.continuous
    assert math.degrees(on.guard.capabilities.upper) == pytest.approx(200)


# ------------------------------------------------------------------------------------------ told after opening


class LateDevice(Device):
    """Learns what it is when it is opened."""

    late = ABLE

    def __enter__(self) -> LateDevice:
        self.capabilities = self.late
        return self


def late(**told: Any) -> LateDevice:
    device = LateDevice()
    device.late = replace(ABLE, **told)
    return device


def test_limits_that_a_device_tells_when_opened_count() -> None:
    on = bench(late(lower=-0.5, upper=0.25))
    assert (on.guard.capabilities.lower, on.guard.capabilities.upper) == (-0.5, 0.25)
    with pytest.raises(LimitError):
        on.guard.command(0.3)
    assert on.device.asked == []


@pytest.mark.parametrize("told", [{"upper": math.nan}, {"max_speed": 0.0}, {"max_acceleration": 99.0}])
def test_a_device_that_turns_out_absurd_is_closed_again(told: dict[str, float]) -> None:
    device = late(**told)
    with pytest.raises(ConfigError, match=r"^guard.*: expected "):
        bench(device)
    assert device.asked == ["close"]


def test_limits_told_later_never_widen_what_the_configuration_allows() -> None:
    on = bench(lower_deg=-30, upper_deg=30)
    on.device.capabilities = replace(ABLE, lower=-9.0, upper=9.0, max_speed=99.0)
    on.clock.sleep(0.02)
    assert math.degrees(on.guard.capabilities.upper) == pytest.approx(30)
    assert on.guard.capabilities.max_speed == pytest.approx(math.radians(225))


def test_limits_told_in_a_move_that_exclude_its_goal_end_it() -> None:
    on = bench()
    on.device.jammed = True
    on.guard.command(1.0)
    on.device.capabilities = replace(ABLE, upper=0.5)
    on.clock.sleep(0.02)
    assert on.device.asked[-1] == "stop"
    assert on.guard.state().fault == "the goal 57.30 deg is outside the travel that the device reports"


def test_absurd_limits_told_in_a_move_end_it_and_stay_a_fault_until_they_are_sane() -> None:
    on = bench()
    on.guard.command(1.0)
    on.device.capabilities = replace(ABLE, upper=math.nan)
    on.clock.sleep(0.02)
    assert on.device.asked[-1] == "stop"
    assert "travel first, got" in on.guard.state().fault
    with pytest.raises(ActuatorFault, match="still at fault: guard: expected the lower limit of the actuator's travel"):
        on.guard.rearm()
    on.device.capabilities = ABLE
    on.clock.sleep(0.02)
    on.guard.rearm()
    on.guard.command(0.5)


def test_absurd_limits_at_rest_refuse_the_next_goal() -> None:
    on = bench()
    on.device.capabilities = replace(ABLE, max_speed=math.nan)
    with pytest.raises(ActuatorFault, match="speed to be finite and above 0, got nan"):
        on.guard.command(1.0)
    assert on.device.asked == []


# ------------------------------------------------------------------------------------------ reports that are none

LIES = {
    "an angle of nan": {"angle": math.nan},
    "an angle of inf": {"angle": math.inf},
    "a rate of nan": {"rate": math.nan},
    "a rate of -inf": {"rate": -math.inf},
    "ahead of the clock": {"time": 1e9},
    "nan s ahead of the clock": {"time": math.nan},
}


@pytest.mark.parametrize("words", LIES)
def test_a_report_that_is_none_ends_the_move_and_is_never_settled(words: str) -> None:
    on = bench()
    on.guard.command(1.0)
    on.clock.sleep(0.03)
    assert on.guard.state().settled
    on.device.silent = True
    on.device.now = replace(on.device.now, **LIES[words])
    assert not on.guard.state().settled
    assert words in on.guard.state().fault
    on.clock.sleep(0.02)
    assert on.device.asked[-1] == "stop"
    with pytest.raises(ActuatorFault):
        on.guard.command(0.0)


@pytest.mark.parametrize(("age", "believed"), [(-0.06, False), (-0.04, True), (0.49, True), (0.51, False)])
def test_a_report_is_believed_while_it_is_fresh_and_not_from_the_future(age: float, believed: bool) -> None:
    assert (doubt(HOLDS, age, 0.5) == "") is believed


def test_the_limits_themselves_are_inside() -> None:
    assert beyond(2.0, ABLE) == beyond(-2.0, ABLE) == 0.0
    assert beyond(-2.5, ABLE) == 0.5


# ------------------------------------------------------------------------------------------ moves that never end


def test_the_deadline_runs_from_the_last_goal_and_ends_with_arrival() -> None:
    on = bench(max_move_s=1.0)
    on.device.jammed = True
    on.guard.command(1.0)
    on.clock.sleep(0.9)
    on.guard.command(1.1)
    on.clock.sleep(0.9)
    assert on.guard.state().healthy
    on.device.jammed = False
    on.clock.sleep(0.02)
    on.clock.sleep(5.0)
    assert on.guard.state().healthy


def test_a_device_that_does_not_obey_a_stop_is_a_fault_and_is_told_again() -> None:
    on = bench()
    on.guard.command(1.0)
    on.device.now = replace(on.device.now, rate=1.0)
    on.guard.halt()
    braking = 2 * math.radians(225) / math.radians(100) + 1.0
    on.clock.sleep(braking - 0.02)
    assert on.guard.state().healthy
    on.clock.sleep(0.05)
    assert on.guard.state().fault == "still turning after a stop, at 57.3 deg/s"
    assert on.device.asked[1:] == ["stop", "stop"]


def test_stopping_again_and_again_gives_no_more_time_to_stop() -> None:
    on = bench()
    on.guard.command(1.0)
    on.device.now = replace(on.device.now, rate=1.0)
    for _ in range(60):
        on.guard.halt()
        on.clock.sleep(0.1)
    assert "still turning" in on.guard.state().fault


def test_one_that_came_to_rest_after_a_stop_may_be_turned_by_hand_later() -> None:
    on = bench()
    on.guard.command(1.0)
    on.device.now = replace(on.device.now, rate=1.0)
    on.guard.halt()
    on.clock.sleep(0.5)
    on.device.now = replace(on.device.now, rate=0.0)
    on.clock.sleep(0.02)
    on.device.now = replace(on.device.now, rate=1.0)
    on.clock.sleep(20.0)
    assert on.guard.state().healthy


def test_a_stop_at_rest_waits_for_nothing() -> None:
    on = bench()
    on.guard.stop()
    on.device.silent = True
    on.clock.sleep(20.0)
    on.device.silent = False
    on.clock.sleep(0.02)
    assert on.guard.state().healthy


def test_one_that_has_never_reported_is_not_well_and_no_fault_is_latched() -> None:
    device = Device()
    device.silent = True
    on = bench(device)
    on.clock.sleep(5.0)
    assert on.guard.state().fault == "no report yet"
    device.silent = False
    on.clock.sleep(0.02)
    on.guard.command(0.5)


# ------------------------------------------------------------------------------------------ runaways


def test_one_that_runs_away_beyond_its_limit_is_stopped() -> None:
    on = bench()
    on.device.jammed = True
    on.guard.command(-1.0)
    on.device.now = replace(on.device.now, angle=2.0 + math.radians(1.9))
    on.clock.sleep(0.02)
    assert on.guard.state().healthy
    on.device.now = replace(on.device.now, angle=2.0 + math.radians(2.1))
    on.clock.sleep(0.02)
    assert on.guard.state().fault == "at 116.69 deg, beyond its limits"
    assert on.device.asked[-1] == "stop"


def test_one_that_wind_takes_from_its_goal_has_run_away_only_when_it_is_farther() -> None:
    on = bench(Device(replace(ABLE, disturbance=math.radians(10))))
    on.device.jammed = True
    on.guard.command(2.0)
    for off, healthy in ((9.9, True), (10.1, False)):
        on.device.now = replace(on.device.now, angle=2.0 + math.radians(off))
        on.clock.sleep(0.02)
        assert on.guard.state().healthy is healthy


@pytest.mark.parametrize("disturbance", [math.nan, math.inf, -0.1])
def test_a_disturbance_that_is_none_cannot_be_opened(disturbance: float) -> None:
    with pytest.raises(ConfigError, match="disturbance to be finite and not negative, got"):
        bench(Device(replace(ABLE, disturbance=disturbance)))


def test_one_that_was_pushed_beyond_its_limit_may_come_back() -> None:
    on = bench()
    on.device.jammed = True
    on.device.now = replace(on.device.now, angle=2.5)
    on.guard.command(1.0)
    on.device.now = replace(on.device.now, angle=2.4)
    on.clock.sleep(0.02)
    assert on.guard.state().healthy
    on.device.now = replace(on.device.now, angle=2.6)
    on.clock.sleep(0.02)
    assert "beyond its limits" in on.guard.state().fault


def test_one_that_turns_unasked_and_says_that_it_is_ill_is_stopped() -> None:
    on = bench()
    on.device.now = replace(on.device.now, rate=1.0, healthy=False, fault="possessed")
    on.clock.sleep(0.02)
    assert on.device.asked == ["stop"]
    assert on.guard.state().fault == "possessed"


# ------------------------------------------------------------------------------------------ pauses of the computer


def test_a_pause_of_the_whole_computer_makes_no_report_stale_until_the_pump_has_looked() -> None:
    clock, device = FakeClock(), Device()
    with Guard(device, config.Guard(watchdog_s=0.5), clock) as guard:
        guard.poll(clock.now())
        clock.sleep(1.5)
        assert guard.state().healthy
        device.silent = True
        guard.poll(clock.now())
        assert guard.state().fault == "no report for 1.50 s"
        device.silent = False
        guard.poll(clock.now())
        assert guard.state().healthy


def at_its_goal_before_a_pause(pause: float, *, jammed: bool = False) -> tuple[FakeClock, Device, Guard]:
    """A guard at its first poll after a pause, before which the device rested at its goal or was on its way there.

    It reports late, as one that tells its position only when it is asked.
    """
    clock, device = FakeClock(), Device()
    guard = Guard(device, config.Guard(watchdog_s=0.5), clock).__enter__()
    device.jammed = jammed
    for request in (lambda: None, lambda: guard.command(1.0), lambda: None):
        guard.poll(clock.now())
        request()
        clock.sleep(0.01)
    guard.poll(clock.now())
    device.silent = True
    clock.sleep(pause)
    guard.poll(clock.now())
    return clock, device, guard


def test_a_pause_at_rest_is_no_fault_when_a_report_comes_soon_after_it() -> None:
    clock, device, guard = at_its_goal_before_a_pause(1.5)
    assert guard.state().healthy
    clock.sleep(0.02)
    device.silent = False
    guard.poll(clock.now())
    assert guard.state().healthy
    assert guard.state().settled


def test_silence_after_a_pause_at_rest_is_a_fault_after_its_time() -> None:
    clock, _, guard = at_its_goal_before_a_pause(1.5)
    for _ in range(50):
        clock.sleep(0.01)
        guard.poll(clock.now())
        assert guard.state().healthy
    clock.sleep(0.02)
    guard.poll(clock.now())
    assert "no report for" in guard.state().fault
    with pytest.raises(ActuatorFault, match="re-arm first"):
        guard.command(0.0)


def test_silence_at_rest_is_a_fault_also_where_every_poll_comes_late() -> None:
    clock, _, guard = at_its_goal_before_a_pause(0.2)
    for _ in range(4):
        clock.sleep(0.2)
        guard.poll(clock.now())
    assert "no report for" in guard.state().fault


def test_a_pause_in_a_move_is_a_fault_when_no_report_has_come_by_its_end() -> None:
    _, _, guard = at_its_goal_before_a_pause(1.5, jammed=True)
    assert "no report for" in guard.state().fault


def test_without_a_pump_every_report_grows_stale() -> None:
    clock = FakeClock()
    with Guard(Device(), config.Guard(watchdog_s=0.5), clock) as guard:
        guard.poll(clock.now())
        clock.sleep(3.0)
        assert guard.state().fault == "no report for 1.00 s"
