"""Homing under the guard, and what no longer counts when it is over."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from guard_bench import Bench, Device, bench
from ross_payload.errors import ActuatorFault, LimitError

# ------------------------------------------------------------------------------------------ homing


def lost(**rules: Any) -> Bench:
    """A device in a fault that only homing clears."""
    on = bench(**rules)
    on.guard.command(1.0)
    on.device.jammed = True
    on.device.now = replace(on.device.now, healthy=False, homed=False, fault="lost")
    on.clock.sleep(0.1)
    return on


@pytest.mark.parametrize("action", ["hold", "release", "park"])
def test_homing_clears_a_fault_whatever_was_done_about_it(action: str) -> None:
    on = lost(on_fault=action)
    before = len(on.device.asked)
    on.guard.home()
    on.clock.sleep(1.0)  # the fault lasts while it homes
    on.device.jammed = False
    on.device.now = replace(on.device.now, healthy=True, homed=True, fault="")
    on.clock.sleep(0.02)
    on.guard.rearm()
    assert on.device.asked[before:] == ["home"]
    assert on.guard.state().settled


def test_homing_that_never_ends_is_stopped() -> None:
    on = lost(max_move_s=2.0)
    on.guard.home()
    on.clock.sleep(1.9)
    assert on.device.asked[-1] == "home"
    on.clock.sleep(0.2)
    assert on.device.asked[-1] == "stop"
    assert on.guard.state().fault == "lost; while homing: at 0.00 deg, not homed after 2 s"


def test_a_fault_that_comes_while_homing_is_acted_on() -> None:
    on = lost()
    on.guard.home()
    on.device.now = replace(on.device.now, healthy=True, fault="")
    on.clock.sleep(0.1)
    on.device.now = replace(on.device.now, healthy=False, fault="no switch")
    on.clock.sleep(0.02)
    assert on.device.asked[-1] == "stop"
    assert on.guard.state().fault == "lost; while homing: no switch"


def test_silence_while_homing_is_acted_on_after_the_watchdog_s_time() -> None:
    on = lost(watchdog_s=0.3)
    on.device.silent = True
    on.clock.sleep(2.0)
    on.guard.home()
    on.clock.sleep(0.28)
    assert on.device.asked[-1] == "home"
    on.clock.sleep(0.05)
    assert on.device.asked[-1] == "stop"


def test_a_stop_ends_homing() -> None:
    on = lost()
    on.guard.home()
    on.guard.stop()
    assert on.device.asked[-1] == "stop"
    on.clock.sleep(1.0)
    assert on.device.asked[-2:] == ["home", "stop"]


def test_a_stop_that_falls_into_the_request_to_home_wins() -> None:
    class Stopped(Device):
        """Somebody stops in the very moment."""

        def home(self) -> None:
            on.guard.stop()
            super().home()

    on = bench(Stopped())
    with pytest.raises(ActuatorFault, match="stopped"):
        on.guard.home()
    assert on.device.asked[-1] == "stop"


def test_homing_that_is_refused_is_not_waited_for() -> None:
    on = bench(max_move_s=0.5)
    on.device.raises["home"] = ActuatorFault("not in this mode")
    with pytest.raises(ActuatorFault, match="not in this mode"):
        on.guard.home()
    on.device.now = replace(on.device.now, homed=False)
    on.clock.sleep(2.0)
    assert on.guard.state().healthy


def test_a_release_is_waited_for_by_nobody() -> None:
    on = bench(max_move_s=0.5)
    on.device.jammed = True
    on.guard.command(1.0)
    on.guard.release()
    on.clock.sleep(3.0)
    assert on.guard.state().healthy
    assert on.device.asked[-1] == "release"


# ------------------------------------------------------------------------------------------ what is over is over


def test_silence_after_a_stop_that_has_ended_is_no_fault() -> None:
    on = bench()
    on.guard.command(1.0)
    on.clock.sleep(0.05)
    on.guard.halt()
    on.clock.sleep(0.05)
    on.device.silent = True
    on.clock.sleep(20.0)
    on.device.silent = False
    on.clock.sleep(0.02)
    assert on.guard.state().healthy


def test_a_goal_right_after_a_halt_may_keep_it_turning() -> None:
    on = bench()
    on.device.jammed = True
    on.guard.command(1.0)
    on.device.now = replace(on.device.now, rate=1.0)
    on.guard.halt()
    on.guard.command(1.5)
    on.clock.sleep(20.0)
    assert on.guard.state().healthy


def test_while_it_homes_no_goal_and_no_limit_counts() -> None:
    on = bench()
    on.guard.command(1.0)
    on.clock.sleep(0.05)
    on.guard.home()
    on.device.jammed = True
    on.device.now = replace(on.device.now, angle=3.0)
    on.clock.sleep(1.0)
    assert on.guard.state().healthy
    assert on.device.asked[-1] == "home"


def test_a_second_fault_after_homing_is_not_one_of_homing() -> None:
    on = lost()
    on.guard.home()
    on.guard.release()
    on.device.now = replace(on.device.now, rate=1.0, fault="hot")
    on.clock.sleep(0.1)
    assert on.guard.state().fault == "lost"


def test_a_fault_after_a_park_that_was_forgiven_is_a_first_one() -> None:
    on = bench(on_fault="park", max_move_s=0.5)
    on.device.jammed = True
    on.guard.command(1.0)
    on.clock.sleep(0.52)
    on.guard.rearm()
    on.guard.command(1.5)
    on.device.now = replace(on.device.now, healthy=False, fault="hot")
    on.clock.sleep(0.1)
    on.device.now = replace(on.device.now, fault="hotter")
    on.clock.sleep(0.1)
    assert on.guard.state().fault == "hot"
    assert on.device.asked[-1] == "stop"


def test_nothing_is_settled_while_a_request_is_on_its_way() -> None:
    class Polled(Device):
        """The pump polls in the very moment of the command."""

        def command(self, angle: float, rate: float | None = None) -> None:
            on.guard.poll(on.clock.now() + 0.001)
            settled.append(on.guard.state().settled)
            super().command(angle, rate)

    settled: list[bool] = []
    on = bench(Polled())
    on.guard.command(1.0)
    assert settled == [False]


def test_a_goal_that_the_driver_refuses_leaves_it_settled_where_it_is() -> None:
    on = bench()
    on.guard.command(1.0)
    on.clock.sleep(0.05)
    on.device.raises["command"] = LimitError("not there")
    with pytest.raises(LimitError, match="not there"):
        on.guard.command(1.5)
    on.clock.sleep(0.05)
    assert on.guard.state().settled


def test_a_fault_after_homing_was_refused_is_not_one_of_homing() -> None:
    on = lost()
    on.device.raises["home"] = ActuatorFault("not in this mode")
    with pytest.raises(ActuatorFault):
        on.guard.home()
    on.device.jammed = True
    on.device.now = replace(on.device.now, rate=1.0, healthy=True, fault="")
    on.clock.sleep(0.1)
    on.device.now = replace(on.device.now, fault="hot")
    on.clock.sleep(0.1)
    assert on.guard.state().fault == "lost"


def test_a_report_from_before_the_goal_does_not_end_the_wait_for_it() -> None:
    on = bench(max_move_s=1.0, watchdog_s=10)
    on.device.silent = True
    on.guard.command(1.0)
    on.clock.sleep(1.1)
    assert on.guard.state().fault == "at 0.00 deg, not at rest at the goal after 1 s"


def test_one_that_stands_still_without_a_zero_is_not_homed() -> None:
    on = bench(max_move_s=1.0)
    on.device.now = replace(on.device.now, homed=False)
    on.guard.home()
    on.clock.sleep(1.1)
    assert on.guard.state().fault == "at 0.00 deg, not homed after 1 s"
