"""Pipelined and informed missions in the simulator, as their user runs them."""

import json
import subprocess

import pytest

from command_line import called_once
from processes import ROSS
from short_mission import CHEAP, THREE, brief

pytestmark = [pytest.mark.lockstep, pytest.mark.usefixtures("undrawn")]


BRIEF = {"explore": {"lead_in_s": 1.0, "unit_s": 1.0, "max_rotations": 6}, "check_s": 1.0, "run_s": 1.0, **CHEAP}


def quick(name, folder):
    return brief(name, folder, **BRIEF)


@pytest.fixture
def mission(run, tmp_path):
    def fly(name, *arguments):
        code, _, err = run("sitl", "--json", "--out", tmp_path / name, *arguments)
        assert "Traceback" not in err
        return code, json.loads((tmp_path / name / "report.json").read_text())

    return fly


def test_a_mission_outlives_the_reader_of_its_lines_where_it_writes_files(tmp_path):
    scenario, out = brief("no-target", tmp_path, **BRIEF), tmp_path / "out"

    def fly(*options):
        command = [*ROSS, "sitl", "-s", scenario, "--seed", "1", *options]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
            running.stdout.readline()
            running.stdout.close()
            return running.wait(120), running.stderr.read()

    gone = "ross: nobody reads the output any more; the mission goes on for what it writes\n"
    assert fly("--out", out) == (3, gone)
    assert json.loads((out / "report.json").read_text())["outcome"] == "no_target"
    assert fly() == (1, "")  # nothing would be left of it


def target(report):
    return next(group for group in report["groups"] if group["target"])


@pytest.fixture(scope="module")
def pipelined(tmp_path_factory):
    """A pipelined mission, seed 1: the exit code, its report, and the folder of its results."""
    folder = tmp_path_factory.mktemp("pipelined")
    out = folder / "out"
    code, _, err = called_once("sitl", "--json", "--out", out, "-s", quick("pipelined", folder), "--seed", 1)
    assert "Traceback" not in err
    return code, json.loads((out / "report.json").read_text()), out


@pytest.mark.soak  # without a room: test_modes
def test_a_pipelined_mission_hears_the_same_target_sooner(mission, pipelined, tmp_path):
    code, report, _ = pipelined
    plain_code, plain = mission("demo", "--scenario", quick("demo", tmp_path), "--actuator", "ideal", "--seed", 1)
    assert (code, plain_code) == (0, 0)
    assert report["k"] == 3
    assert target(report)["talkers"] == [report["target"]]
    assert report["heard_from_s"] < plain["heard_from_s"] - 4
    assert target(report)["si_sdri_db"] > 12


@pytest.mark.soak  # told by eye: below
def test_an_informed_mission_turns_at_once_and_says_that_it_was_informed(mission, tmp_path):
    code, report = mission("informed", "--scenario", quick("demo", tmp_path), "--informed", "--seed", 1)
    assert (code, report["informed"], report["rotations"]) == (0, True, 0)
    assert [source["azimuth_error_deg"] for source in report["sources"]] == [0.0, 0.0, 0.0]
    assert report["configuration"]["payload"]["informed"]["azimuths_deg"] == [40.0, 155.0, -80.0]
    assert target(report)["si_sdri_db"] > 12


def test_azimuths_that_are_told_by_eye_will_do(mission, tmp_path):
    code, report = mission("informed", "--scenario", quick("informed", tmp_path), "--seed", 1)
    assert (code, report["informed"]) == (0, True)
    assert report["checks"][0]["candidate"] == 0
    assert target(report)["talkers"] == [report["target"]]


def same_files(one, two):
    names = sorted(path.name for path in one.iterdir())
    assert names == sorted(path.name for path in two.iterdir())
    for name in set(names) - {"timing.json"}:
        assert (one / name).read_bytes() == (two / name).read_bytes(), name


@pytest.mark.soak  # of another mission: test_sitl
def test_a_rerun_gives_the_same_bytes(mission, pipelined, tmp_path):
    mission("again", "-s", quick("pipelined", tmp_path), "--seed", 1)
    same_files(pipelined[2], tmp_path / "again")


@pytest.mark.soak
def test_a_rerun_of_an_informed_mission_gives_the_same_bytes(mission, tmp_path):
    for name in ("one", "two"):
        mission(name, "--scenario", "demo", "--informed", "--seed", 2)
    same_files(tmp_path / "one", tmp_path / "two")


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ("azimuths_deg = []", "azimuths_deg"),
        ("azimuths_deg = [nan, 155, -80]", "expected a number, got nan"),
        ("azimuths_deg = [40, 40.5]", "between them"),
        ("azimuths_deg = [40]\ntarget = 1", "target"),
        ("azimuths_deg = [0, 50, 100, 150, 200, 250, 300]", "at most 6"),
    ],
)
def test_what_cannot_be_told_is_one_line_and_exit_code_2(run, tmp_path, told, words):
    path = tmp_path / "told.toml"
    path.write_text(f"title = 'told'\n{THREE}[payload.informed]\n{told}\n")
    code, out, err = run("sitl", "--scenario", path, "--out", tmp_path / "out")
    assert (code, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_nobody_to_tell_of_is_one_line_and_exit_code_2(run):
    code, out, err = run("sitl", "--scenario", "silence", "--informed")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "expected a scenario with talkers" in err
