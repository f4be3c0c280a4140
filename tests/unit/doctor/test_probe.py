"""`ross actuators probe`: what it finds at good actuators and at bad ones, and that it moves nothing unasked."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from rigs import CuttableWire, kinds, options_of
from ross_payload import plugins
from ross_payload.actuators.motion import Trapezoid
from ross_payload.actuators.registry import checked_options
from ross_payload.config import Config
from ross_payload.doctor.commands import EXIT_CODES, probe_command
from ross_payload.doctor.findings import Finding, Verdict, as_json, worst
from ross_payload.doctor.probe import Results, Wishes, probe
from ross_payload.doctor.probe_moves import Leg, figures, goals, judge
from ross_payload.errors import ConfigError
from ross_payload.interfaces import ActuatorState, Capabilities, Feedback, Services
from ross_payload.service.state_folder import owned
from ross_protocols.mavlink.vehicle_control import EXTENDED_SYS_STATE
from ross_sim.clock import SimClock
from ross_sim.devices.far_end import FarEnd, Fault
from ross_sim.devices.vehicle_far_end import VehicleFarEnd

MOVED = math.radians(0.3)  # a rotor swings a little when it gets its torque [rad]
NAMES = ["direction", "error", "overshoot", "settling", "play", "speed"]


class Workbench:
    """An actuator that nobody has opened, and how far its far end has truly been from where it was."""

    def __init__(self, kind: str, far: dict[str, Any] | None = None, **options: Any) -> None:
        kind, _, role = kind.partition(":")
        self.config = self._config(kind, options_of(kind, role) | options)
        self.clock = SimClock()
        built = self._config(kind, options_of(kind, role) | (far or {}))
        self.far_end: FarEnd = plugins.load("ross_sim.far_ends", kind).make(checked_options(built))
        self.wire = CuttableWire(self.far_end.port)
        self.low = self.high = self.far_end.angle()
        self.clock.before_calls(self._live)
        self.results = Results()

    @staticmethod
    def _config(kind: str, options: dict[str, Any]) -> Config:
        return Config.model_validate({"actuator": {"kind": kind, "options": options}})

    def _live(self, now: float) -> None:
        self.far_end.advance(now)
        self.low, self.high = min(self.low, self.far_end.angle()), max(self.high, self.far_end.angle())

    def probe(self, **wishes: Any) -> list[Finding]:
        services = Services(self.clock, lambda url: self.wire)
        return list(probe(self.config, services, Wishes(**wishes), self.results))


@pytest.fixture(autouse=True)
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of what outlives a restart; it is not there yet."""
    folder = tmp_path / "state"
    monkeypatch.setenv("STATE_DIRECTORY", str(folder))
    return folder


def about(findings: list[Finding], check: str) -> Finding:
    return next(finding for finding in findings if finding.check == check)


@pytest.fixture(params=kinds())
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_nothing_moves_unless_asked(kind: str) -> None:
    on = Workbench(kind)
    findings = on.probe()
    assert on.high - on.low < MOVED
    assert worst(findings) is not Verdict.FAIL, findings
    assert {"device", "limits", "feedback", "report", "at rest"} <= {finding.check for finding in findings}
    assert on.results.report_rate_hz >= 5
    assert on.results.oldest_report_s < 0.25


def test_five_degrees_and_back_are_five_degrees_and_back(kind: str) -> None:
    on = Workbench(kind)
    findings = on.probe(home=True, move=lambda: True)
    assert worst(findings) is not Verdict.FAIL, findings
    assert [finding.check for finding in findings][-len(NAMES) :] == NAMES
    assert on.results.move is not None
    assert on.results.move.error_deg < 0.5
    assert math.degrees(on.high - on.low) > 4.5
    measured = on.results.feedback == "measured"
    assert about(findings, "direction").verdict is (Verdict.OK if measured else Verdict.WARN)


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("grbl", "grbl 1.1"),
        ("dronecan_servo", "org.ross.servo, software 1.0, hardware 1.0"),
        ("canopen_drive", "vendor 0x0, product 0x402, revision 0x10000, serial 0x1"),
        ("mavlink_gimbal", "ROSS simulated, firmware 1.0.0"),
        ("mavlink_gimbal:manager", "ROSS simulated, firmware 1.0.0"),
        ("vehicle_yaw", "ArduCopter, system 1; it may be turned"),
        ("vehicle_yaw:offboard", "PX4, system 1; "),
    ],
)
def test_a_device_is_called_what_it_calls_itself(kind: str, name: str) -> None:
    on = Workbench(kind)
    findings = on.probe()
    assert on.results.identity.startswith(name)
    assert on.results.identity in about(findings, "device").found


@pytest.mark.parametrize("told", [True, False])
def test_a_vehicle_that_does_not_fly_or_does_not_tell_is_not_said_to_be_free_to_turn(told: bool) -> None:
    on = Workbench("vehicle_yaw")
    assert isinstance(on.far_end, VehicleFarEnd)
    if told:
        on.far_end.afflict(Fault.LANDED)
    else:
        on.far_end.autopilot.withhold(EXTENDED_SYS_STATE)
    on.probe()
    why = "the vehicle is on the ground" if told else "the autopilot does not tell whether the vehicle flies"
    assert on.results.identity.startswith(f"ArduCopter, system 1; {why}")


def test_one_that_is_still_being_set_up_is_waited_for() -> None:
    findings = Workbench("canopen_drive").probe()
    assert worst(findings) is Verdict.OK, findings


def test_it_moves_slowly() -> None:
    on = Workbench("ideal")
    fastest, before = 0.0, on.far_end.angle()

    def look() -> None:
        nonlocal fastest, before
        fastest, before = max(fastest, abs(on.far_end.angle() - before) / 0.01), on.far_end.angle()

    on.clock.every(0.01, look)
    on.probe(move=lambda: True)
    assert math.degrees(fastest) == pytest.approx(5.0, abs=0.1)


@pytest.mark.parametrize("kind", ["tb6600:switch", "dronecan_servo:model"])
def test_one_that_does_not_know_where_it_is_says_what_to_do_and_is_not_moved(kind: str) -> None:
    on = Workbench(kind)
    findings = on.probe(move=lambda: pytest.fail("asked to move it"))
    assert "--home" in about(findings, "zero").todo
    assert on.high - on.low < MOVED


def test_who_says_no_is_not_moved() -> None:
    on = Workbench("ideal")
    assert worst(on.probe(move=lambda: False)) is Verdict.OK
    assert on.high == on.low


# ------------------------------------------------------------------------------------------ bad ones


def test_a_silent_one_is_not_moved() -> None:
    on = Workbench("mavlink_gimbal")
    on.far_end.afflict(Fault.SILENT)
    findings = on.probe(move=lambda: pytest.fail("asked to move it"))
    assert (findings[-1].check, findings[-1].verdict) == ("report", Verdict.FAIL)
    assert findings[-1].found


@pytest.mark.parametrize("kind", ["ideal", "dronecan_servo", "mavlink_gimbal", "canopen_drive"])
def test_a_stuck_one_fails_and_says_so(kind: str) -> None:
    on = Workbench(kind)
    on.far_end.afflict(Fault.STUCK)
    findings = on.probe(home=kind == "canopen_drive", move=lambda: True)
    assert worst(findings) is Verdict.FAIL
    assert findings[-1].check == "move"
    assert on.high - on.low < MOVED


def test_a_noisy_sensor_is_a_warning_in_degrees() -> None:
    on = Workbench("mavlink_gimbal")
    on.far_end.afflict(Fault.NOISY)
    findings = on.probe()
    noisy = [finding for finding in findings if finding.verdict is not Verdict.OK]
    assert noisy, findings


def test_one_that_turns_the_other_way_is_told_apart() -> None:
    on = Workbench("dronecan_servo", far={"at_lower": 1.0, "at_upper": -1.0})
    findings = on.probe(move=lambda: True)
    assert (findings[-1].check, findings[-1].verdict) == ("direction", Verdict.FAIL)
    assert "the wrong way" in findings[-1].found
    assert math.degrees(on.high - on.low) < 15


def test_two_that_report_are_not_taken_for_a_wrong_direction() -> None:
    on = Workbench("dronecan_servo")

    def join() -> None:
        if on.far_end.angle() < math.radians(4) < on.high:  # on its way back
            on.far_end.afflict(Fault.DUPLICATE)

    on.clock.every(0.1, join)
    findings = on.probe(move=lambda: True)
    assert (findings[-1].check, findings[-1].verdict) == ("move", Verdict.FAIL)
    assert "another node has the servo's id" in findings[-1].found


def test_a_wrong_gear_is_noticed_where_somebody_measures() -> None:
    on = Workbench("dronecan_servo", far={"gear_ratio": 2.0})
    findings = on.probe(move=lambda: True)
    assert worst(findings) is Verdict.FAIL
    assert math.degrees(on.high - on.low) < 30


def interrupted(on: Workbench) -> None:
    """Probe with a move, and interrupt that 2 deg from where it begins."""

    def interrupt() -> None:
        if on.far_end.angle() > math.radians(2) and not caught:
            caught.append(True)
            raise KeyboardInterrupt

    caught: list[bool] = []
    on.clock.every(0.01, interrupt)
    with pytest.raises(KeyboardInterrupt):
        on.probe(move=lambda: True)


def test_ctrl_c_in_a_move_stops_it() -> None:
    on = Workbench("ideal")
    interrupted(on)
    here = on.far_end.angle()
    on.clock.sleep(1.0)
    assert math.degrees(here) < 2.3
    assert on.far_end.angle() == here


# ------------------------------------------------------------------------------------------ the numbers

ABLE = Capabilities(-1.0, 1.0, 1.0, 2.0, math.radians(0.1), False, Feedback.MEASURED)


def leg(start: float, goal: float, *angles: float) -> Leg:
    """A leg in degrees, a report every 0.1 s."""
    plan = Trapezoid(math.radians(start), math.radians(goal), math.radians(5), 2.0)
    reports = [
        ActuatorState(math.radians(angle), 0.0, index == len(angles) - 1, True, True, 0.1 * index)
        for index, angle in enumerate(angles)
    ]
    return Leg(plan, 0.0, tuple(reports), True)


def test_figures_are_those_of_the_worst_leg() -> None:
    legs = [
        leg(0, 5, 0, 1.5, 2, 2.5, 3, 3.5, 5.4, 5.2),
        leg(5, 2.5, 5, 2.7),
        leg(2.5, 0, 2.5, 0),
        leg(0, 2.5, 0, 2.4),
        leg(2.5, 0, 2.5, 0.0),
    ]
    seen = figures(legs)
    assert seen.error_deg == pytest.approx(0.2)
    assert seen.overshoot_deg == pytest.approx(0.4)
    assert seen.play_deg == pytest.approx(0.3)
    assert seen.speed == pytest.approx(1.0)
    verdicts = {finding.check: finding.verdict for finding in judge(seen, ABLE)}
    assert verdicts["error"] is Verdict.WARN
    assert verdicts["overshoot"] is Verdict.WARN
    assert verdicts["speed"] is Verdict.OK


def test_it_goes_towards_the_farther_limit_and_ends_where_it_was() -> None:
    assert goals(0.9, ABLE)[0] == pytest.approx(0.9 - math.radians(5))
    assert goals(-0.9, ABLE)[0] == pytest.approx(-0.9 + math.radians(5))
    assert goals(0.3, ABLE)[-1] == 0.3


# ------------------------------------------------------------------------------------------ the command


def test_the_command_tells_machines_all(tmp_path: Path) -> None:
    file = tmp_path / "bench.toml"
    file.write_text('[actuator]\nkind = "tb6600"\n')
    done = CliRunner().invoke(probe_command, [str(file), "--json"], standalone_mode=False)
    told = json.loads(done.output)
    assert told["verdict"] == "warn"
    assert [check["found"] for check in told["checks"] if check["verdict"] == "warn"] == [
        "pulses stay in memory: nothing will turn"
    ]
    assert done.return_value == EXIT_CODES["warn"]
    assert told["figures"]["feedback"] == "model"
    assert told["figures"]["move"] is None


def test_what_is_not_known_is_null() -> None:
    assert json.loads(as_json([], figures=Results().as_values()))["figures"]["noise_deg"] is None


@pytest.mark.parametrize("option", ["--move", "--home"])
def test_what_a_command_has_stopped_is_not_moved(tmp_path: Path, option: str, state: Path) -> None:
    state.mkdir()
    (state / "stopped").touch()
    file = tmp_path / "bench.toml"
    file.write_text('[actuator]\nkind = "tb6600"\n')
    done = CliRunner().invoke(probe_command, [str(file), option, "--yes", "--json"], standalone_mode=False)
    assert [check["check"] for check in json.loads(done.output)["checks"]] == ["stop"]
    assert done.return_value == EXIT_CODES["fail"]


def test_an_actuator_that_a_payload_has_is_not_even_opened(tmp_path: Path, state: Path) -> None:
    state.mkdir()
    file = tmp_path / "bench.toml"
    file.write_text('[actuator]\nkind = "tb6600"\n')
    with owned(state), pytest.raises(ConfigError, match="expected a folder that no other payload uses"):
        CliRunner().invoke(probe_command, [str(file)], standalone_mode=False, catch_exceptions=False)
    assert CliRunner().invoke(probe_command, [str(file)], standalone_mode=False).return_value == EXIT_CODES["warn"]


@pytest.mark.parametrize("kind", ["tb6600", "grbl"])
def test_a_declared_zero_is_doubted_that_a_payload_has_died_away_from(kind: str, state: Path) -> None:
    state.mkdir()
    (state / "away").touch()
    on = Workbench(kind)
    assert "--home" in about(on.probe(move=lambda: pytest.fail("asked to move it")), "zero").todo
    assert (state / "away").exists()
    assert about(Workbench(kind).probe(home=True), "zero").verdict is Verdict.OK
    assert not (state / "away").exists()


@pytest.mark.parametrize("kind", ["tb6600", "grbl"])
def test_who_is_interrupted_away_from_a_declared_zero_leaves_a_mark(kind: str, state: Path) -> None:
    on = Workbench(kind)
    interrupted(on)
    assert (state / "away").exists()


def test_a_device_that_never_answers_has_not_left_its_zero(state: Path) -> None:
    on = Workbench("grbl")
    on.far_end.afflict(Fault.SILENT)
    assert worst(on.probe()) is Verdict.FAIL
    assert not (state / "away").exists()


def test_who_cannot_answer_is_not_moved(tmp_path: Path) -> None:
    file = tmp_path / "bench.toml"
    file.write_text('[actuator]\nkind = "tb6600"\n')
    done = CliRunner().invoke(probe_command, [str(file), "--move"], input="n\n", standalone_mode=False)
    assert "Is the way free?" in done.output
    assert "direction" not in done.output
