"""`ross calibrate` in a simulated room: the real turn, guard and driver of a stepper, and the session it leaves."""

import json
import math
import signal
from functools import partial

import numpy as np
import pytest

from command_line import called
from ross_payload.calibration.estimate import calibrate
from ross_payload.config import validated
from ross_payload.doctor.calibration_report import changes
from ross_payload.doctor.calibration_session import Stopped, TurnPlan
from ross_payload.errors import ActuatorFault, NotHomed
from ross_payload.events import State, StateChanged
from ross_sim.scenario import Scenario
from ross_sim.sitl.calibration_flight import turned_in
from ross_sim.study import calibration_study
from ross_sim.study.rows.calibration_rows import CalibrationRow
from ross_sim.study.rows.row_files import read_rows
from ross_sim.talkers.speech import TalkerVoice

RATE, SPEED = 16000, 343.0
TRUE = {
    "spacing_m": 0.064,
    "offset_deg": 12.0,
    "gain_db": (0.0, 1.5),
    "invert": (False, True),
    "roll_off_hz": (60.0, 25.0),
}
PLAN = TurnPlan(headings=6, seconds=0.7)
QUICKLY = {"max_speed_deg_s": 360.0, "max_acceleration_deg_s2": 1000.0}
NIMBLE = {"guard": QUICKLY, "actuator": {"kind": "tb6600", "options": QUICKLY}}  # most of the time goes into turns
AZIMUTH = math.radians(40)


def scenario(microphones=TRUE, **payload):
    values = {
        "title": "one sound",
        "payload": {"explore": {"lead_in_s": 0}} | payload,
        "noise": {"snr_db": 20},
        "talkers": [{"azimuth_deg": 40, "start_s": 0}],
        "microphones": microphones,
    }
    return validated(Scenario, values, "")


def phone():
    noise = (0.1 * np.random.default_rng(7).standard_normal(20 * RATE)).astype(np.float32)
    return [TalkerVoice("phone", noise, noise, RATE)]


class Watch:
    """Keeps where the array was, and what was said."""

    def __init__(self):
        self.joints, self.events = [], []

    def on_input(self, hop):
        self.joints.append(hop.pointing.joint)

    def on_event(self, event, hop):
        self.events.append(event)


def test_a_calibration_finds_the_true_array_and_its_session_tells_the_same(tmp_path, monkeypatch, capsys):
    watch = Watch()
    heard, _ = turned_in(scenario(**NIMBLE), phone(), PLAN, (watch,), record=tmp_path / "tapes")
    found = calibrate(heard, SPEED, azimuth=AZIMUTH)
    assert found.headings == 6
    assert found.spacing == pytest.approx(0.064, abs=5e-4)
    assert math.degrees(found.offset) == pytest.approx(12.0, abs=0.5)
    assert found.gain_db == pytest.approx(1.5, abs=0.2)
    assert found.roll_off == pytest.approx(-35.0, abs=2.0)
    assert found.inverted
    assert not found.swapped
    assert watch.joints[-1] == pytest.approx(watch.joints[0], abs=1e-3)  # it is back where it was
    assert min(watch.joints) >= math.radians(-200)
    assert max(watch.joints) <= math.radians(200)

    (session,) = (tmp_path / "tapes").iterdir()
    config = tmp_path / "ross.toml"
    config.write_text("[array]\nspacing_m = 0.05\n")
    code, out, _ = called(monkeypatch, capsys, "calibrate", config, "--session", session, "--azimuth", "320", "--json")
    values = json.loads(out)
    assert code == 0
    assert values["calibration"]["spacing"] == pytest.approx(found.spacing, abs=3e-4)
    assert math.degrees(values["calibration"]["offset"]) == pytest.approx(12.0, abs=0.5)


@pytest.mark.soak
def test_after_what_it_writes_nothing_is_left_to_change():
    found = calibrate(turned_in(scenario(**NIMBLE), phone(), PLAN)[0], SPEED, azimuth=AZIMUTH)
    mended = {"array": {}, "audio": {}}
    for key, value in changes(scenario().payload, found).items():
        table, name = key.split(".")
        mended[table][name] = value
    again = calibrate(turned_in(scenario(**NIMBLE, **mended), phone(), PLAN)[0], SPEED, azimuth=AZIMUTH)
    assert changes(scenario(**mended).payload, again) == {}


def test_it_turns_within_narrow_limits_and_says_when_they_are_too_narrow():
    watch = Watch()
    limits = {"lower_deg": -30.0, "upper_deg": 100.0, "max_speed_deg_s": 225.0, "max_acceleration_deg_s2": 112.5}
    heard, _ = turned_in(scenario(guard=limits), phone(), TurnPlan(headings=8, seconds=0.6), (watch,))
    assert math.degrees(max(watch.joints) - min(watch.joints)) == pytest.approx(130, abs=25)
    assert math.degrees(min(watch.joints)) >= -30.2
    assert math.degrees(max(watch.joints)) <= 100.2
    assert calibrate(heard, SPEED).spacing == pytest.approx(0.064, abs=1e-3)


@pytest.mark.soak
def test_swapped_cables_are_found():
    heard, _ = turned_in(scenario({"swapped": True}, **NIMBLE), phone(), PLAN)
    found = calibrate(heard, SPEED, azimuth=AZIMUTH)
    assert found.swapped
    assert changes(scenario().payload, found)["audio.channels"] == [1, 0]


def test_a_motor_that_stalls_ends_it_as_a_fault():
    stuck = scenario(guard={"max_move_s": 3.0}, actuator={"kind": "canopen_drive"}).model_copy(
        update={"troubles": validated(Scenario, scenario().model_dump(exclude_unset=True) | {
            "troubles": [{"fault": "stuck", "at_s": 1.0}]}, "").troubles}
    )  # fmt: skip
    with pytest.raises(ActuatorFault):
        turned_in(stuck, phone(), TurnPlan(headings=8, seconds=0.8, home=True))


def test_without_a_zero_nothing_turns_unless_it_may_be_found():
    unknown = scenario(actuator={"kind": "canopen_drive"})
    with pytest.raises(NotHomed, match="`--home`"):
        turned_in(unknown, phone(), PLAN)


class Interrupts(Watch):
    """Presses Ctrl-C in the turn."""

    def on_input(self, hop):
        super().on_input(hop)
        if len(self.joints) == 110:
            signal.raise_signal(signal.SIGINT)


def test_ctrl_c_brakes_it_and_ends_it():
    watch = Interrupts()
    with pytest.raises(Stopped):
        turned_in(scenario(), phone(), PLAN, (watch,))
    assert 110 < len(watch.joints) < 200
    assert abs(watch.joints[-1] - watch.joints[-2]) < 2 * math.radians(0.1125)  # at rest but for the last steps
    assert not any(isinstance(event, StateChanged) and event.state is State.DONE for event in watch.events)


def nimble(draw, asked=calibration_study.scenario_of):
    """The room of a draw, where the array turns faster."""
    values = asked(draw).model_dump(exclude_unset=True)
    return validated(Scenario, values | {"payload": values["payload"] | NIMBLE}, "")


@pytest.mark.soak
def test_a_study_writes_what_became_of_every_array(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(calibration_study, "PLAN", TurnPlan(angle=math.pi, headings=6, seconds=0.6))
    monkeypatch.setattr(calibration_study, "scenario_of", nimble)
    arguments = ("study", "calibration", "--settings", "S1", "--sounds", "noise", "--draws", "2", "--seed", "3")
    code, out, _ = called(monkeypatch, capsys, *arguments, "--out", tmp_path / "rows.csv")
    assert code == 0
    kind, rows = read_rows(tmp_path / "rows.csv", [CalibrationRow])
    assert kind is CalibrationRow
    assert [row.draw for row in rows] == [0, 1]
    assert all(abs(row.spacing_error_mm) < 1 and row.polarity_right and row.swap_right for row in rows)
    assert rows[0].spacing_mm != rows[1].spacing_mm
    assert "| S1, noise | 2/2 |" in out


def test_ctrl_c_in_a_turn_of_a_study_is_no_traceback(tmp_path, study, monkeypatch):
    turned = calibration_study.turned_in
    monkeypatch.setattr(
        calibration_study, "turned_in", lambda *asked, **more: turned(*asked, observers=(Interrupts(),), **more)
    )
    code, out, err = study("--out", tmp_path / "rows.csv", "--settings", "S1", "--sounds", "noise", "--draws", "1")
    assert (code, out) == (130, "")
    assert err.strip() == "ross: interrupted"


@pytest.fixture
def study(monkeypatch, capsys):
    """``ross study calibration`` with more arguments: exit code, output, errors."""
    return partial(called, monkeypatch, capsys, "study", "calibration")


@pytest.fixture
def calibrated(monkeypatch):
    """Draws that are calibrated, in a study that calibrates nothing; stops at the one that it is told."""
    made, last = [], []

    def measured(draw, talkers):
        if [draw.number] == last:
            raise KeyboardInterrupt
        made.append((draw.sound, draw.number))
        return calibration_study._row(draw, "too soft", 1.0)

    monkeypatch.setattr(calibration_study, "measured", measured)
    return made, last


def test_a_study_that_was_stopped_keeps_its_rows_and_goes_on(tmp_path, study, calibrated):
    made, last = calibrated
    few = ("--settings", "S1", "--draws", "3")
    assert study("--out", tmp_path / "whole.csv", *few)[0] == 0
    every = list(made)
    made.clear()
    last.append(2)
    assert study("--out", tmp_path / "rows.csv", *few)[0] == 130
    assert len(read_rows(tmp_path / "rows.csv", [CalibrationRow])[1]) == 2
    last.clear()
    assert study("--out", tmp_path / "rows.csv", *few)[0] == 0
    assert made == every
    assert (tmp_path / "rows.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()


@pytest.mark.parametrize(
    ("asked", "why"),
    [
        (("--sounds", ""), "expected names separated by commas, got none"),
        (("--settings", ""), "expected names separated by commas, got none"),
        (("--seed", "1"), "holds rows of another study (seed is 0, not 1)"),
    ],
)
def test_rows_that_are_there_are_not_lost(tmp_path, study, calibrated, asked, why):
    few = ("--out", tmp_path / "rows.csv", "--settings", "S1", "--draws", "2")
    assert study(*few)[0] == 0
    before = (tmp_path / "rows.csv").read_bytes()
    code, _, err = study(*few, *asked)
    assert (code, err.count("\n")) == (2, 1)
    assert why in err
    assert (tmp_path / "rows.csv").read_bytes() == before


def test_a_place_that_cannot_be_written_is_told_before_anything_is_calibrated(tmp_path, study, calibrated):
    (tmp_path / "file").touch()
    for out in (tmp_path, tmp_path / "file" / "rows.csv"):
        code, _, err = study("--out", out)
        assert (code, err.count("\n")) == (2, 1)
    assert calibrated[0] == []


@pytest.mark.parametrize(("asked", "why"), [(("--settings", "S9"), "room 'S9'"), (("--sounds", "hum"), "sound 'hum'")])
def test_a_study_of_what_there_is_not_is_one_line(tmp_path, monkeypatch, capsys, asked, why):
    code, _, err = called(monkeypatch, capsys, "study", "calibration", "--out", tmp_path / "rows.csv", *asked)
    assert code == 2
    assert why in err
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())
