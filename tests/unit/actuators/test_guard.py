"""The guard's faults and their actions, and the registry, on a device that fails as told."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from guard_bench import ABLE, Device, bench
from ross_payload import config
from ross_payload.actuators import registry
from ross_payload.actuators.registry import checked_options, describe
from ross_payload.errors import ActuatorFault, ConfigError, LimitError, NotHomed, PluginError


def test_the_travel_is_where_both_the_hardware_and_the_configuration_allow_it() -> None:
    guard = bench(lower_deg=-300, upper_deg=90).guard
    assert (guard.capabilities.lower, guard.capabilities.upper) == pytest.approx((-2.0, math.pi / 2))
    assert guard.capabilities.max_speed == pytest.approx(math.radians(225))


def test_a_goal_at_the_limit_is_allowed_but_kept_half_a_step_inside() -> None:
    on = bench(Device(replace(ABLE, resolution=0.1)))
    on.guard.command(2.0)
    assert on.device.asked == [f"go 1.95 at {math.radians(225):.2f}"]


def test_hardware_that_accelerates_beyond_the_cap_cannot_be_opened() -> None:
    with pytest.raises(ConfigError, match=r"expected an actuator with at most 50, got one with 100 deg"):
        bench(max_acceleration_deg_s2=50)


def test_an_unknown_zero_refuses_moves() -> None:
    on = bench()
    on.device.now = replace(on.device.now, homed=False)
    with pytest.raises(NotHomed):
        on.guard.command(1.0)


def test_a_report_made_before_the_command_is_not_taken_for_its_answer() -> None:
    on = bench()
    assert on.guard.state().settled
    on.guard.command(0.0)
    assert not on.guard.state().settled
    on.clock.sleep(0.01)
    assert on.guard.state().settled


@pytest.mark.parametrize("end", ["stop", "halt"])
def test_a_report_made_before_a_stop_is_not_taken_for_rest(end: str) -> None:
    on = bench()
    on.guard.command(1.0)
    on.clock.sleep(0.01)
    on.device.now = replace(on.device.now, settled=True)  # it has not seen yet that it turns
    on.device.silent = True
    on.clock.sleep(0.1)
    getattr(on.guard, end)()
    assert not on.guard.state().settled


@pytest.mark.parametrize(
    ("action", "asked"), [("hold", "stop"), ("release", "release"), ("park", f"go 0.50 at {math.radians(225):.2f}")]
)
def test_a_move_that_never_ends_triggers_the_fault_action(action: str, asked: str) -> None:
    on = bench(on_fault=action, max_move_s=1.0, park_deg=math.degrees(0.5))
    on.device.jammed = True
    on.guard.command(1.0)
    on.clock.sleep(1.2)
    assert on.device.asked[1] == asked
    assert "not at rest at the goal after 1 s" in on.guard.state().fault
    with pytest.raises(ActuatorFault, match="re-arm"):
        on.guard.command(0.0)


def test_parking_that_fails_too_ends_in_a_stop() -> None:
    on = bench(on_fault="park", max_move_s=1.0)
    on.device.jammed = True
    on.guard.command(1.0)
    on.clock.sleep(3.0)
    assert on.device.asked[1:] == [f"go 0.00 at {math.radians(225):.2f}", "stop"]
    assert "while parking" in on.guard.state().fault


def test_a_stop_ends_parking() -> None:
    on = bench(on_fault="park", max_move_s=0.2)
    on.device.jammed = True
    on.guard.command(1.0)
    on.clock.sleep(0.3)
    on.guard.stop()
    on.clock.sleep(3.0)
    assert on.device.asked[-1] == "stop"
    assert len(on.device.asked) == 3


def test_nobody_parks_on_feedback_that_is_missing() -> None:
    on = bench(on_fault="park", watchdog_s=0.3)
    on.guard.command(1.0)
    on.device.silent = True
    on.clock.sleep(0.5)
    assert on.device.asked[-1] == "stop"
    assert on.guard.state().fault.startswith("no report for 0.3")


def test_the_watchdog_bites_after_its_time_and_not_before() -> None:
    on = bench(watchdog_s=0.3)
    on.guard.command(1.0)
    on.device.silent = True
    on.clock.sleep(0.29)
    assert on.guard.state().healthy
    on.clock.sleep(0.03)
    assert not on.guard.state().healthy
    assert on.device.asked[-1] == "stop"


def test_silence_at_rest_without_a_goal_is_not_settled_and_refuses_goals_but_latches_nothing() -> None:
    on = bench(watchdog_s=0.3)
    on.device.silent = True
    on.clock.sleep(1.0)
    assert not on.guard.state().settled
    assert on.device.asked == []
    with pytest.raises(ActuatorFault, match="no report"):
        on.guard.command(1.0)
    on.device.silent = False
    on.clock.sleep(0.01)
    on.guard.command(1.0)


def test_a_fault_of_the_device_is_passed_on_in_words() -> None:
    on = bench()
    on.guard.command(1.0)
    on.device.now = replace(on.device.now, healthy=False, fault="too hot")
    on.clock.sleep(0.02)
    assert on.guard.state().fault == "too hot"
    assert not on.guard.state().settled
    assert on.device.asked[-1] == "stop"


def test_a_broken_wire_is_a_fault_and_does_not_kill_the_pump() -> None:
    on = bench()
    on.guard.command(1.0)
    on.device.broken_wire = True
    on.clock.sleep(0.05)
    assert on.guard.state().fault.startswith("the wire is broken; and the stop failed")
    assert not on.guard.state().healthy


def test_a_bug_in_a_driver_stops_it_and_goes_on_polling() -> None:
    on = bench()
    on.guard.command(1.0)
    on.device.buggy = True
    on.clock.sleep(0.02)
    assert on.guard.state().fault == "the driver broke: ZeroDivisionError()"
    assert on.device.asked[-1] == "stop"
    on.device.buggy = False
    on.clock.sleep(0.01)
    assert on.device.now.time == on.clock.now()


def test_a_refused_request_leaves_the_last_goal_alone() -> None:
    on = bench()
    on.guard.command(1.0)
    on.clock.sleep(0.02)
    with pytest.raises(LimitError):
        on.guard.command(3.0)
    on.clock.sleep(0.02)
    assert on.guard.state().settled
    assert on.guard.state().angle == 1.0


def test_rearm_forgives_what_is_over() -> None:
    on = bench(max_move_s=0.5)
    on.device.jammed = True
    on.guard.command(1.0)
    on.clock.sleep(1.0)
    on.device.jammed = False
    on.guard.rearm()
    on.guard.command(0.5)
    on.clock.sleep(0.02)
    assert on.guard.state().settled
    assert on.guard.state().angle == 0.5


def test_a_stop_that_falls_between_the_check_and_the_request_wins() -> None:
    class Stopped(Device):
        """Somebody stops in the very moment of the command."""

        def command(self, angle: float, rate: float | None = None) -> None:
            on.guard.stop()
            super().command(angle, rate)

    on = bench(Stopped())
    with pytest.raises(ActuatorFault, match="stopped"):
        on.guard.command(1.0)
    assert on.device.asked[-1] == "stop"
    on.clock.sleep(0.1)
    assert on.device.now.angle == 0.0


def test_homing_is_refused_after_a_stop() -> None:
    on = bench()
    on.guard.stop()
    assert on.guard.stopped
    with pytest.raises(ActuatorFault, match="re-arm"):
        on.guard.home()
    assert "home" not in on.device.asked


# ------------------------------------------------------------------------------------------ the registry


def settings_of(kind: str, **options: Any) -> config.Config:
    return config.Config.model_validate({"actuator": {"kind": kind, "options": options}})


def test_options_are_lowered_to_the_caps_of_the_guard() -> None:
    settings = settings_of("tb6600", max_speed_deg_s=999, max_acceleration_deg_s2=50)
    options = checked_options(settings)
    assert (options.max_speed_deg_s, options.max_acceleration_deg_s2) == (225, 50)


def test_a_wrong_option_is_named_with_its_back_end() -> None:
    with pytest.raises(ConfigError, match=r"actuator\.options of 'tb6600': unknown key 'microstep'"):
        checked_options(settings_of("tb6600", microstep=8))


def test_an_unknown_kind_lists_those_that_exist() -> None:
    with pytest.raises(PluginError, match=r"actuator 'crane' is unknown; there are: .*ideal.*tb6600"):
        checked_options(settings_of("crane"))


def test_a_broken_plug_in_hurts_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    info = tmp_path / "breaking-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: breaking\nVersion: 1\n")
    points = "aaa_broken = breaking:backend\naaa_odd = math:pi\naaa_lacking = lacking:backend\n"
    (info / "entry_points.txt").write_text(f"[ross_payload.actuators]\n{points}")
    (tmp_path / "breaking.py").write_text("1 / 0\n")
    (tmp_path / "lacking.py").write_text("raise ModuleNotFoundError('x', name='can')\n")
    monkeypatch.syspath_prepend(tmp_path)
    rows = {row.name: row for row in describe()}
    assert rows["ideal"].usable
    assert rows["tb6600"].usable
    assert rows["grbl"].usable
    monkeypatch.setattr(registry, "find_spec", lambda _: None)
    lacking = {row.name: row.about for row in describe() if row.about.startswith("needs the package")}
    assert lacking.keys() == {"grbl", "canopen_drive", "dronecan_servo"}
    assert lacking["grbl"].endswith("pip install 'pyserial>=3.5'")
    assert "stepper" in rows["tb6600"].about.lower()
    assert not rows["aaa_broken"].usable
    assert "ZeroDivisionError" in rows["aaa_broken"].about
    assert "pip install 'python-can>=" in rows["aaa_lacking"].about
    assert "expected an object with Config and open" in rows["aaa_odd"].about
    checked_options(settings_of("ideal"))
