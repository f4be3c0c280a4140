"""A recorded mission runs again: the same, or as another configuration would have had it."""

import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from command_line import called_once
from mission_fixtures import without_picture
from processes import ROSS
from replay_bench import SHORT, replayed
from ross_payload.service.replay import in_words
from short_mission import CHEAP, SOON, brief

pytestmark = pytest.mark.lockstep


@pytest.fixture(scope="module")
def taped(tmp_path_factory):
    """One short mission of `ross sitl --record`: its results and its session."""
    base = tmp_path_factory.mktemp("taped")
    (base / "short.toml").write_text(SHORT)
    with without_picture():
        code, _, said = called_once(
            "sitl", "-s", base / "short.toml", "--seed", 3, "--out", base / "out", "--record", base / "all", "--json"
        )
    assert code in (0, 3), said
    return base / "out", base / "all" / "0001"


@pytest.fixture(scope="module")
def again(taped, tmp_path_factory):
    """A replay of it: the exit code, what it says, and the folder of its results."""
    folder = tmp_path_factory.mktemp("again") / "out"
    return *replayed(taped[1], folder, called_once), folder


def test_a_replay_says_the_same_to_the_byte(taped, again):
    (results, session), (code, values, folder) = taped, again
    assert code == 0
    assert values["identical"]
    assert {path.stat().st_mode & 0o077 for path in (folder, *folder.iterdir())} == {0}  # what people have said
    assert values["parted"] == values["ended_early"] == ""
    assert (
        (folder / "events.jsonl").read_bytes()
        == (session / "events.jsonl").read_bytes()
        == (results / "events.jsonl").read_bytes()
    )
    assert values["outcome"] == json.loads((results / "report.json").read_text())["outcome"]
    for voice in results.glob("[tg][ar]*.wav"):
        assert (folder / voice.name).read_bytes() == voice.read_bytes()


@pytest.mark.soak  # one says what was recorded, to the byte: above
def test_two_replays_write_the_same_bytes(taped, again, tmp_path, run):
    *_, one = again
    replayed(taped[1], tmp_path / "two", run)
    files = {path.name for path in one.iterdir()}
    assert {"events.jsonl", "replay.json"} <= files
    for name in files:
        assert (one / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


def test_two_recordings_of_one_seed_have_the_same_bytes_also_in_another_process(taped, tmp_path):
    _, session = taped
    (tmp_path / "short.toml").write_text(SHORT)
    command = [*ROSS, "sitl", "-s", "short.toml", "--seed", "3", "--record", "all"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=250)
    assert done.returncode in (0, 3), done.stderr
    for path in session.iterdir():
        assert (tmp_path / "all" / "0001" / path.name).read_bytes() == path.read_bytes(), path.name


def test_another_separator_separates_the_same_recording_otherwise_and_other_versions_are_named(taped, tmp_path, run):
    copied = tmp_path / "0001"
    shutil.copytree(taped[1], copied)
    manifest = json.loads((copied / "session.json").read_text())
    manifest["versions"]["numpy"] = "0.1"
    (copied / "session.json").write_text(json.dumps(manifest))
    code, said, _ = run("replay", copied, "--set", "exploit.separator=duet", "--out", tmp_path / "duet")
    assert code in (0, 3)
    assert "recorded with numpy 0.1, not" in said
    values = json.loads((tmp_path / "duet" / "replay.json").read_text())
    assert not values["identical"]
    assert values["changes"] == {"exploit.separator": ["gaussian", "duet"]}


def test_other_versions_are_not_named_where_a_replay_does_not_differ(again):
    was = again[1] | {"recorded": again[1]["recorded"] | {"versions": {"numpy": "0.1"}}}
    said = list(in_words(was))
    assert "identical to the recorded mission" in said
    assert not [line for line in said if "recorded with" in line]


def test_what_another_configuration_does_not_touch_stays_the_same(taped, tmp_path, run, monkeypatch):
    """A person of the target's name is not taken for a synthetic talker, as for who has enrolled that of a scenario."""
    out, session = taped
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    assert run("enroll", json.loads((session / "session.json").read_text())["voice"], out / "mixture.wav")[0] == 0
    _, values = replayed(session, tmp_path / "out", run, "exploit.run_s=1")
    assert values["voice"].startswith("the synthetic voice")
    same = values["first_difference"]["line"] - 1
    recorded = (session / "events.jsonl").read_text().splitlines()
    assert any(json.loads(line)["event"] == "Checked" for line in recorded[:same])


def test_shorter_listening_waits_for_the_recorded_turns(taped, tmp_path, run):
    _, session = taped
    _, values = replayed(session, tmp_path / "out", run, "explore.unit_s=0.5")
    assert "the replay turns to joint angle 15.0 deg counter-clockwise at 1.5" in values["parted"]
    events = [json.loads(line) for line in (tmp_path / "out" / "events.jsonl").read_text().splitlines()]
    second = [event for event in events if event["event"] == "OrientationHeard"][1]
    recorded = [json.loads(line) for line in (session / "events.jsonl").read_text().splitlines()]
    turn = next(event for event in recorded if event["event"] == "TurnStarted")
    assert second["joint"] == pytest.approx(turn["joint"], abs=2e-3)  # of a stepper
    assert second["time"] > turn["time"] + 0.5  # heard where and when the recorded array stood there


def test_longer_listening_ends_where_the_recorded_array_turns_away(taped, tmp_path, run):
    _, session = taped
    code, values = replayed(session, tmp_path / "out", run, "explore.unit_s=3")
    assert code == 3
    assert "the recorded mission turned to joint angle 15.0 deg counter-clockwise at 2.0" in values["parted"]
    assert "turning" in values["ended_early"]


def test_a_goal_that_the_record_never_visits_ends_the_replay(taped, tmp_path, run):
    _, session = taped
    code, values = replayed(session, tmp_path / "out", run, "explore.step_deg=50")
    assert code == 3
    assert "never at rest at joint angle 50.0 deg counter-clockwise" in values["ended_early"]


def test_what_the_record_decides_has_no_effect_and_is_said(taped, tmp_path, run):
    _, session = taped
    code, values = replayed(session, tmp_path / "out", run, "array.offset_deg=7", "links=[]")
    assert code == 0
    assert values["without_effect"] == ["array.offset_deg"]
    assert values["identical"]


@pytest.mark.soak
@pytest.mark.parametrize(
    ("key", "change"),
    [("audio.invert", [[False, False], [False, True]]), ("audio.roll_off_hz", [[0.0, 0.0], [0.0, 40.0]])],
)
def test_a_later_correction_is_heard(taped, tmp_path, run, key, change):
    _, session = taped
    _, values = replayed(session, tmp_path / "out", run, f"{key}={json.dumps(change[1])}")
    assert not values["identical"]
    assert values["changes"] == {key: change}


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("audio.rate_hz=48000", "expected 16000, as recorded"),
        ("exploit.bla=1", "unknown key 'exploit.bla'"),
        ("exploit.run_s", "expected key=value"),
        ("exploit.run_s=-1", "greater than or equal to 1"),
        ("seed.deep=1", "expected a table"),
        ("exploit.separator=karaoke", "'karaoke' is unknown"),
    ],
)
def test_a_wrong_change_gets_one_line(taped, tmp_path, run, setting, words):
    code, error = replayed(taped[1], tmp_path / "out", run, setting)
    assert code == 2
    assert words in error
    assert error.count("\n") == 1


def test_without_the_voice_recorded_answers_serve_the_same_mission_only(taped, tmp_path, run, monkeypatch):
    _, session = taped
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))  # nobody is enrolled there
    copied = tmp_path / "0001"
    shutil.copytree(session, copied)
    (copied / "voice.npz").unlink()
    _, values = replayed(copied, tmp_path / "out", run)
    assert values["identical"]
    assert "recorded answers" in values["voice"]
    code, error = replayed(copied, tmp_path / "refused", run, "exploit.separator=duet")
    assert code == 2
    assert not (tmp_path / "refused").exists()
    assert "not enrolled here" in error


def test_a_file_stands_for_a_configuration_of_another_version(taped, tmp_path, run):
    copied = tmp_path / "0001"
    shutil.copytree(taped[1], copied)
    values = json.loads((copied / "config.json").read_text())
    (copied / "config.json").write_text(json.dumps(values | {"telepathy": {}}))
    code, error = replayed(copied, tmp_path / "out", run)
    assert code == 2
    assert "unknown key 'telepathy'" in error
    assert "--config FILE" in error
    (tmp_path / "own.toml").write_text(
        "[explore]\nlead_in_s = 1.0\nunit_s = 1.0\nmax_rotations = 1\nmin_rotations = 1\n"
    )
    code, said, _ = run("replay", copied, "--config", tmp_path / "own.toml", "--json")
    assert code in (0, 3)
    assert json.loads(said)["events"] > 5


def test_results_do_not_go_into_a_session(taped, run):
    code, error = replayed(taped[1], taped[1], run)
    assert code == 2
    assert "expected a folder for the results, got the session" in error


def test_a_folder_that_cannot_be_made_is_refused_before_the_mission(tmp_path, run):
    (tmp_path / "short.toml").write_text(SHORT)
    code, _, error = run("sitl", "-s", tmp_path / "short.toml", "--record", tmp_path / "short.toml", "--json")
    assert code == 2
    assert "--record" in error
    assert error.count("\n") == 1


def test_a_folder_that_is_no_session_gets_one_line(tmp_path, run):
    code, _, error = run("replay", tmp_path)
    assert code == 2
    assert "not a session folder" in error


def test_a_session_of_somebody_else_cannot_write_to_the_terminal(taped, tmp_path, run):
    copied = shutil.copytree(taped[1], tmp_path / "copied")
    about = json.loads((copied / "session.json").read_text())
    (copied / "session.json").write_text(json.dumps(about | {"voice": "\x1b[2J"}))
    code, said, _ = run("replay", copied)
    assert code in (0, 3)
    assert r"'\x1b[2J' is synthetic" in said


@pytest.mark.parametrize(
    "arrays", [{"noise": np.zeros((3, 16_000))}, {"noise": np.zeros(5)}, {"noise_speeds": np.zeros(5)}]
)
def test_noise_of_another_shape_is_refused_with_one_line(taped, tmp_path, run, arrays):
    copied = shutil.copytree(taped[1], tmp_path / "copied")
    np.savez(copied / "memory.npz", **arrays)
    code, _, error = run("replay", copied)
    assert code == 2
    assert error == f"ross: {copied}/memory.npz: damaged: {next(iter(arrays))} has the shape " + (
        f"{next(iter(arrays.values())).shape}\n"
    )


@pytest.mark.parametrize(
    "values",
    [
        {"samples": "1" + 400 * "0"},
        {"noise_aboard": "NaN"},
        {"estimate": '{"sources":[{"azimuth":NaN,"sigma":0.1,"confidence":1,"resolved":true}]}'},
        {"estimate": '{"sources":[],"rival":{"sources":[{"azimuth":1e999,"sigma":0,"confidence":1,"resolved":true}]}}'},
    ],
)
def test_numbers_that_cannot_be_in_what_a_session_knew_are_refused_with_one_line(taped, tmp_path, run, values):
    copied = shutil.copytree(taped[1], tmp_path / "copied")
    np.savez(copied / "memory.npz", **{name: np.array(text) for name, text in values.items()})
    code, _, error = run("replay", copied)
    assert code == 2
    assert error == f"ross: {copied}/memory.npz: damaged: expected finite numbers\n"


# ---------------------------------------------------------------------------------------------- the guide


@pytest.mark.soak
def test_the_guide_works_as_printed(run, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("ross_sim.scenario._folder", lambda: tmp_path)  # where its scenario takes less time
    soon = SOON | {"unit_s": 1.0, "min_rotations": 1, "max_rotations": 1}
    brief("one-talker", tmp_path, explore=soon, check_s=1.0, run_s=5.5, **CHEAP)
    page = (Path(__file__).parents[2] / "docs" / "how-to" / "record-and-replay.md").read_text(encoding="utf-8")
    lines = [line for block in re.findall(r"```sh\n(.*?)```", page, re.DOTALL) for line in block.splitlines()]
    assert len(lines) == 6
    said = ""
    for line in lines:
        with without_picture():
            code, told, wrong = run(*shlex.split(line)[1:])
        assert code == 0, wrong
        said += told
    assert "identical to the recorded mission" in said
    assert "deleted 0001" in said
    assert not (tmp_path / "tapes" / "0001").exists()


# ---------------------------------------------------------------------------------------------- cut off


def test_a_killed_simulation_leaves_a_session_that_can_be_replayed(tmp_path, run):
    (tmp_path / "short.toml").write_text(SHORT)
    command = [*ROSS, "sitl", "-s", tmp_path / "short.toml", "--speed", "4"]
    with subprocess.Popen([*command, "--record", tmp_path / "all", "--json"], stdout=subprocess.PIPE) as process:
        inputs = tmp_path / "all" / "0001" / "inputs.jsonl"
        deadline = time.monotonic() + 120
        while not (inputs.exists() and inputs.stat().st_size > 60_000) and time.monotonic() < deadline:
            time.sleep(0.05)
        os.kill(process.pid, signal.SIGKILL)
    code, values = replayed(inputs.parent, tmp_path / "out", run)
    assert code == 0
    assert values["outcome"] is None
    assert values["identical"]
    assert "cut off" in values["notes"][0]
    code, said, _ = run("sessions", "check", inputs.parent)
    assert code == 0
    assert "cut off" in said
