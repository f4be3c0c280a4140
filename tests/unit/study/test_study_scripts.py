"""Scripts of the studies, on a user's mistake: one line that says what was expected, and exit code 2."""

from __future__ import annotations

import os
from argparse import ArgumentParser
from pathlib import Path
from types import ModuleType

import click
import pytest
from click.testing import CliRunner

from ross_payload.errors import OutputError
from ross_sim.study import (
    calibrate_voice_model,
    elevation_study,
    fit_evidence_in_noise,
    fit_talker_evidence,
    live_separation,
    moving_talkers,
    predicted_gain_study,
    quality_study,
    resting_talkers,
    separation_cost,
    train_refiner,
    train_voiceprint,
    voiceprint_study,
)
from ross_sim.study.script_errors import told_by, told_in_a_line, write_result

MISTAKES = [
    pytest.param(train_refiner.main, ["--readers", "{none}", "--work", "{work}", "{out}"], "none", id="train_refiner"),
    pytest.param(
        train_voiceprint.main,
        ["--readers", "{none}", "--speech", "{none}", "--work", "{work}", "{out}"],
        "none",
        id="train_voiceprint",
    ),
    pytest.param(
        train_refiner.main,
        ["--readers", "{none}", "--work", "{work}", "{folder}"],
        "expected a file",
        id="refiner, out",
    ),
    pytest.param(
        train_voiceprint.main,
        ["--readers", "{none}", "--speech", "{none}", "--work", "{work}", "{folder}"],
        "expected a file",
        id="voiceprint, out",
    ),
    pytest.param(predicted_gain_study.main, ["--speech", "{none}"], "none", id="predicted_gain_study"),
    pytest.param(predicted_gain_study.main, ["--rooms", "S9"], "room 'S9' is unknown", id="room"),
    pytest.param(
        predicted_gain_study.main,
        ["--k", "three"],
        "expected whole numbers from 2 to 8 separated by commas, got 'three'",
        id="k",
    ),
    pytest.param(live_separation.main, ["{out}", "--speech", "{none}"], "none", id="live_separation"),
    pytest.param(live_separation.main, ["{out}"], "expected rows of the study", id="no rows"),
    pytest.param(live_separation.main, ["{out}", "--settings", "S1,S9"], "room 'S9' is unknown", id="setting"),
    pytest.param(live_separation.main, ["{out}", "--rates", "5"], "expected whole numbers from 8000", id="rate"),
    pytest.param(
        live_separation.main,
        ["{out}", "--settings", os.fsdecode(b"\xe9.toml")],
        "expected names in UTF-8, as the results are, got",
        id="not UTF-8",
    ),
    pytest.param(live_separation.main, ["{out}", "--k", ""], "separated by commas, got none", id="no k"),
    pytest.param(live_separation.main, ["{out}", "--seed", "-1"], "-1 is not in the range x>=0", id="live seed"),
    pytest.param(
        train_refiner.main,
        ["--readers", "{none}", "--work", "{work}", "--seed", "-1", "{out}"],
        "-1 is not in the range x>=0",
        id="refiner seed",
    ),
    pytest.param(predicted_gain_study.main, ["--seconds", "nan"], "expected a finite number", id="seconds"),
    pytest.param(separation_cost.main, ["--speech", "{none}"], "none", id="separation_cost"),
]


@pytest.mark.parametrize(("command", "arguments", "said"), MISTAKES)
def test_a_mistake_ends_with_one_line_and_exit_code_2(
    command: click.Command, arguments: list[str], said: str, tmp_path: Path
) -> None:
    paths = {name: str(tmp_path / name) for name in ("none", "work", "out", "folder")}
    (tmp_path / "folder").mkdir()
    done = CliRunner().invoke(command, [argument.format(**paths) for argument in arguments])
    (line,) = [line for line in done.output.splitlines() if line.startswith("Error: ")]
    assert said in line
    assert done.exit_code == 2
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("script", "arguments", "said"),
    [
        (elevation_study, ["--speech", "{none}"], "no such folder of recordings"),
        (quality_study, ["--speech", "{none}"], "no such folder of recordings"),
        (resting_talkers, ["--speech", "{none}"], "no such folder of recordings"),
        (moving_talkers, ["--speech", "{none}"], "no such folder of recordings"),
        (moving_talkers, ["--settings", "S1,S9"], "room 'S9' is unknown"),
        (moving_talkers, ["--speeds", "5,fast"], "'5,fast'"),
        (moving_talkers, ["--speeds", "nan"], "expected finite numbers from 0.1 to 180 separated by commas, got 'nan'"),
        (moving_talkers, ["--draws", "0"], "--draws: 0 is not in the range x>=1"),
        (elevation_study, ["--layouts", "0"], "--layouts: 0 is not in the range x>=1"),
        (elevation_study, ["--seed", "-1"], "--seed: -1 is not in the range x>=0"),
        (resting_talkers, ["--seed", "-1"], "--seed: -1 is not in the range x>=0"),
        (resting_talkers, ["--k", ""], "--k: expected names separated by commas, got none"),
        (quality_study, ["--draws", "x"], "--draws: 'x' is not a valid integer"),
        (fit_talker_evidence, ["{none}", "{out}", "{out}", "--seeds", "-1"], "--seeds: -1 is not in the range x>=0"),
        (voiceprint_study, ["--speech", "{none}"], "no such folder of recordings"),
        (voiceprint_study, ["--built-in", "{none}"], "no voice model can be read"),
        (calibrate_voice_model, ["{none}", "{out}", "--speech", "{none}"], "no voice model can be read"),
        (fit_talker_evidence, ["{none}", "{out}", "{out}"], "no such folder of recordings"),
        (fit_evidence_in_noise, ["{none}", "{none}", "{out}"], "{none}"),
        (fit_evidence_in_noise, ["{none}", "{none}", "{file}/out"], "{file} is a file"),
        (fit_talker_evidence, ["{none}", "{out}", "{file}/deep/out"], "{file} is a file"),
        (calibrate_voice_model, ["{none}", "{folder}", "--speech", "{none}"], "{folder}: expected a file"),
        (moving_talkers, ["--out", "{folder}"], "{folder}: expected a file"),
    ],
)
def test_scripts_with_a_parser_of_their_own_say_the_same(
    script: ModuleType, arguments: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    paths = {name: str(tmp_path / name) for name in ("none", "out", "file", "folder")}
    (tmp_path / "file").touch()
    (tmp_path / "folder").mkdir()
    with pytest.raises(SystemExit) as ended:
        script.main([argument.format(**paths) for argument in arguments])
    assert ended.value.code == 2
    line = capsys.readouterr().err.splitlines()[-1]
    assert ": error: " in line
    assert said.format(**paths) in line
    assert not (tmp_path / "out").exists()


def test_a_script_with_a_parser_says_that_results_cannot_be_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(SystemExit) as ended, told_by(ArgumentParser("prog")):
        write_result(tmp_path / "file" / "out", b"")
    assert ended.value.code == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"prog: error: {tmp_path / 'file' / 'out'}: cannot be written: ")


def test_results_that_cannot_be_written_end_with_exit_code_1() -> None:
    with pytest.raises(click.ClickException, match="full") as ended, told_in_a_line():
        raise OutputError("full")
    assert ended.value.exit_code == 1
