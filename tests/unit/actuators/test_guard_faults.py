"""The guard's faults on top of faults, and drivers that raise."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pytest

from guard_bench import Device, bench
from ross_payload import config
from ross_payload.actuators.guard import Guard
from ross_payload.errors import ActuatorFault, LimitError, LinkError, OutputError
from ross_payload.interfaces import ActuatorState
from ross_sim.clock import SimClock

FAST = f"{math.radians(225):.2f}"


# ------------------------------------------------------------------------------------------ drivers that raise

NO_STATE = [
    (None, "expected a state of type ActuatorState, got NoneType"),
    (ActuatorState(None, 0.0, True, True, True, 0.0), "expected a number as angle, got None"),
    (ActuatorState(0.0, "0.1", True, True, True, 0.0), "expected a number as rate, got '0.1'"),
    (ActuatorState(0.0, 0.0, True, True, True, None), "expected a number as time, got None"),
    (ActuatorState(0.0, 0.0, None, True, True, 0.0), "expected true or false as settled, got None"),
    (ActuatorState(0.0, 0.0, True, True, False, 0.0, 7), "expected a text as fault, got 7"),
]


@pytest.mark.parametrize("error", [ZeroDivisionError("bug"), LinkError("gone"), OSError("pulled")])
def test_a_driver_that_raises_in_a_command_is_a_fault_and_is_stopped(error: Exception) -> None:
    on = bench()
    on.device.raises["command"] = error
    with pytest.raises(ActuatorFault, match=str(error)):
        on.guard.command(1.0)
    assert on.device.asked == ["stop"]
    assert str(error) in on.guard.state().fault


def test_a_driver_whose_state_raises_is_a_fault_in_every_thread() -> None:
    on = bench()
    on.guard.command(1.0)
    on.device.raises["state"] = ZeroDivisionError("bug")
    assert "the driver broke: ZeroDivisionError('bug')" in on.guard.state().fault
    on.clock.sleep(0.02)
    assert on.device.asked[-1] == "stop"
    del on.device.raises["state"]
    on.clock.sleep(0.02)
    on.guard.rearm()


@pytest.mark.parametrize(("state", "words"), NO_STATE)
def test_a_driver_that_reports_no_state_is_a_fault_and_a_stop_reaches_it(state: Any, words: str) -> None:
    on = bench()
    on.guard.command(1.0)
    on.device.state = lambda: state  # type: ignore[method-assign]
    on.guard.stop()
    assert on.device.asked == [f"go 1.00 at {FAST}", "stop"]
    assert words in on.guard.state().fault
    on.clock.sleep(0.1)  # nor does polling end
    assert on.device.asked[-1] == "stop"
    assert words in on.guard.state().fault


def test_numbers_of_numpy_in_a_report_become_those_of_python() -> None:
    on = bench()
    told = ActuatorState(np.float32(0.5), np.int64(0), np.bool_(True), True, True, np.float64(0.05))
    on.device.state = lambda: told  # type: ignore[method-assign]
    assert json.dumps(asdict(on.guard.state())).startswith('{"angle": 0.5, "rate": 0.0, "settled": true, ')


@pytest.mark.parametrize("error", [OSError("pulled"), RuntimeError("pulled")])
def test_a_driver_that_raises_while_it_is_opened_or_closed_is_a_fault(error: Exception) -> None:
    class Lost(Device):
        def __enter__(self) -> Device:
            raise OSError("no such device")

        def __exit__(self, *_: object) -> None:
            raise error

    guard = Guard(Lost(), config.Guard(), SimClock())
    with pytest.raises(ActuatorFault, match=r"^the driver broke: OSError\('no such device'\)$"):
        guard.__enter__()
    with pytest.raises(ActuatorFault, match=rf"^the driver broke: {type(error).__name__}\('pulled'\)$"):
        guard.__exit__(None, None, None)


@pytest.mark.parametrize(
    ("raised", "words"), [(OSError("pulled"), "the driver broke: OSError('pulled')"), (LinkError("gone"), "gone")]
)
def test_what_a_driver_raises_while_it_is_closed_hides_no_other_error(
    raised: Exception, words: str, caplog: pytest.LogCaptureFixture
) -> None:
    class Lost(Device):
        def __exit__(self, *_: object) -> None:
            raise raised

    def fail() -> None:
        with Guard(Lost(), config.Guard(), SimClock()):
            raise OutputError("the disk is full")

    with pytest.raises(OutputError, match="the disk is full"):
        fail()
    assert f"while closing the actuator: {words}" in caplog.text


@pytest.mark.parametrize("error", [ZeroDivisionError("bug"), LinkError("gone")])
def test_a_stop_never_raises_and_is_tried_again_until_it_is_heard(error: Exception) -> None:
    on = bench()
    on.device.jammed = True
    on.guard.command(1.0)
    on.device.raises["stop"] = error
    on.guard.stop()
    on.clock.sleep(0.1)
    assert on.guard.state().fault.startswith("the stop failed: ")
    assert str(error) in on.guard.state().fault
    assert on.device.asked == [f"go 1.00 at {FAST}"]
    del on.device.raises["stop"]
    on.clock.sleep(0.05)
    assert on.device.asked[1:] == ["stop"]


def test_a_fault_whose_action_fails_is_tried_again_when_the_wire_is_back() -> None:
    on = bench(on_fault="release")
    on.guard.command(1.0)
    on.device.broken_wire = True
    on.clock.sleep(0.1)
    assert on.guard.state().fault == "the wire is broken; and the fault action failed: the wire is broken"
    on.device.broken_wire = False
    on.clock.sleep(0.1)
    assert on.device.asked[1:] == ["release"]


def test_a_release_that_fails_holds_meanwhile() -> None:
    on = bench(on_fault="release", max_move_s=0.5)
    on.device.raises["release"] = ZeroDivisionError("bug")
    on.device.jammed = True
    on.guard.command(1.0)
    on.clock.sleep(0.52)
    assert on.device.asked[1:2] == ["stop"]
    del on.device.raises["release"]
    on.clock.sleep(0.02)
    assert on.device.asked[-1] == "release"


@pytest.mark.parametrize("error", [LimitError("not there"), ZeroDivisionError("bug")])
def test_a_park_that_is_refused_holds(error: Exception) -> None:
    on = bench(on_fault="park", max_move_s=0.5)
    on.device.jammed = True
    on.guard.command(1.0)
    on.device.raises["command"] = error
    on.clock.sleep(1.0)
    assert on.device.asked[1] == "stop"
    assert "after 0.5 s" in on.guard.state().fault
    assert str(error) in on.guard.state().fault


# ------------------------------------------------------------------------------------------ faults on faults


def test_the_first_of_two_faults_is_named_and_the_action_is_done_once() -> None:
    on = bench()
    on.guard.command(1.0)
    on.device.now = replace(on.device.now, healthy=False, fault="too hot")
    on.clock.sleep(0.1)
    on.device.now = replace(on.device.now, fault="too cold")
    on.clock.sleep(0.1)
    assert on.guard.state().fault == "too hot"
    assert on.device.asked[1:] == ["stop"]


def test_a_device_that_parks_well_goes_on_holding_its_fault() -> None:
    on = bench(on_fault="park", max_move_s=0.5, park_deg=30)
    on.device.jammed = True
    on.guard.command(1.0)
    on.clock.sleep(0.52)
    on.device.jammed = False
    on.clock.sleep(2.0)
    assert on.device.asked[1:] == [f"go 0.52 at {FAST}"]
    assert on.guard.state().angle == pytest.approx(math.radians(30))
    assert not on.guard.state().settled


def test_nobody_parks_after_a_stop() -> None:
    on = bench(on_fault="park")
    on.guard.command(1.0)
    on.device.now = replace(on.device.now, rate=1.0)
    on.guard.stop()
    on.clock.sleep(8.0)
    assert on.device.asked[1:] == ["stop"] * 4  # at once, when it was to be at rest, and every second since


def test_of_a_device_that_falls_silent_in_a_move_nobody_says_that_it_turns() -> None:
    on = bench()
    on.guard.command(1.0)
    on.device.now = replace(on.device.now, rate=1.0)
    on.device.silent = True
    on.clock.sleep(20.0)
    assert on.guard.state().fault.endswith("; and nobody knows whether it stands")


def test_a_device_that_turns_on_with_any_fault_is_told_to_stop_every_second() -> None:
    on = bench()
    on.guard.command(1.0)
    on.device.now = replace(on.device.now, rate=1.0, fault="overheated", healthy=False)
    on.clock.sleep(20.0)
    assert set(on.device.asked[1:]) == {"stop"}
    assert 13 <= len(on.device.asked) <= 17
    assert on.guard.state().fault == "overheated; and it still turns after the stop"
    on.device.now = replace(on.device.now, rate=0.0)
    on.clock.sleep(1.0)
    asked = len(on.device.asked)
    on.clock.sleep(5.0)
    assert len(on.device.asked) == asked


def test_a_device_that_turns_again_after_a_stop_is_a_fault_and_is_told_to_stop() -> None:
    """At rest nothing is expected any more of a device but to stay there."""
    on = bench()
    on.guard.command(1.0)
    on.guard.stop()
    on.clock.sleep(5.0)
    on.device.now = replace(on.device.now, rate=0.5)
    on.clock.sleep(0.25)
    assert on.guard.state().healthy
    asked = len(on.device.asked)
    on.clock.sleep(0.2)
    assert on.guard.state().fault == "turning again after a stop, at 28.6 deg/s"
    assert on.device.asked[asked:] == ["stop"]
    on.guard.rearm()
    on.clock.sleep(0.3)
    assert on.guard.state().healthy  # by somebody's hand, perhaps
    on.guard.command(-1.0)
    on.clock.sleep(0.3)
    assert on.guard.state().healthy


def test_what_a_hand_turns_after_a_stop_and_a_rearm_is_no_fault() -> None:
    on = bench()
    on.guard.command(1.0)
    on.guard.stop()
    on.clock.sleep(5.0)
    on.guard.rearm()
    on.device.now = replace(on.device.now, rate=0.5)
    on.clock.sleep(1.0)
    assert on.guard.state().healthy


def test_what_is_given_back_while_it_brakes_and_does_not_come_to_rest_is_a_fault() -> None:
    class Shared(Device):
        def take_control(self) -> None: ...

        def release_control(self) -> bool:
            return True

        def brake(self) -> None: ...

    on = bench(Shared())
    on.guard.command(1.0)
    on.device.now = replace(on.device.now, rate=1.0)
    on.guard.halt()
    on.guard.release_control()
    on.clock.sleep(15.0)
    assert on.guard.state().fault.startswith("still turning after a stop")


@pytest.mark.parametrize("lost", [{"homed": False}, {"healthy": False}])
def test_nobody_parks_when_the_place_is_lost(lost: dict[str, bool]) -> None:
    on = bench(on_fault="park", max_move_s=0.5)
    on.device.jammed = True
    on.guard.command(1.0)
    on.device.now = replace(on.device.now, **lost)
    on.clock.sleep(1.0)
    assert on.device.asked[1:] == ["stop"]


def test_a_stop_in_the_moment_in_which_parking_begins_wins() -> None:
    class Interrupted(Device):
        def command(self, angle: float, rate: float | None = None) -> None:
            if on.guard.state().fault:
                on.guard.stop()
            super().command(angle, rate)

    on = bench(Interrupted(), on_fault="park", max_move_s=0.5)
    on.device.jammed = True
    on.guard.command(1.0)
    on.clock.sleep(0.6)
    assert on.device.asked[1:] == ["stop", "go 0.00 at 3.93", "stop"]


def test_a_fault_between_the_check_and_the_request_wins() -> None:
    class Faulty(Device):
        """The pump finds a fault in the very moment of the command."""

        def command(self, angle: float, rate: float | None = None) -> None:
            self.broken_wire = True
            on.guard.poll(on.clock.now())
            self.broken_wire = False
            super().command(angle, rate)

    on = bench(Faulty())
    with pytest.raises(ActuatorFault, match="the wire is broken"):
        on.guard.command(1.0)
    assert on.device.asked[-1] == "stop"


def test_closing_closes_the_device_and_expects_nothing_more_of_it() -> None:
    on = bench(max_move_s=0.5)
    on.device.jammed = True
    on.guard.command(1.0)
    on.guard.__exit__(None, None, None)
    on.clock.sleep(2.0)
    assert on.device.asked[-1] == "close"
    with on.guard as opened:
        assert opened.state().healthy


def test_a_fault_without_words_gets_some() -> None:
    on = bench()
    on.device.now = replace(on.device.now, healthy=False)
    assert on.guard.state().fault == "the actuator reports a fault"
    assert not on.guard.state().healthy


def test_a_rearm_that_was_refused_must_be_asked_for_again() -> None:
    on = bench()
    on.device.now = replace(on.device.now, healthy=False, fault="hot")
    with pytest.raises(ActuatorFault, match="still at fault: hot"):
        on.guard.rearm()
    on.device.now = replace(on.device.now, healthy=True, fault="")
    with pytest.raises(ActuatorFault, match="hot; re-arm first"):
        on.guard.command(1.0)
    on.guard.rearm()
    on.guard.command(1.0)
