"""`ross study missions` from the outside: rows and a table, what was stopped goes on, and bad input in one line."""

import csv
import json

import pytest

from short_mission import PAIR
from voice_folders import voice_folder

pytestmark = pytest.mark.lockstep


@pytest.fixture(scope="module")
def speech(tmp_path_factory):
    return voice_folder(tmp_path_factory.mktemp("voices"), range(3), 6)


@pytest.fixture
def asked(tmp_path, speech):
    (tmp_path / "short.toml").write_text(PAIR)
    asked = ["study", "missions", "--scenarios", str(tmp_path / "short.toml"), "--draws", "2", "--seed", "3"]
    asked += ["--speech", str(speech), "--workers", "1", "--k", "1", "--set", "explore.max_rotations=1"]
    return [*asked, "--set", "explore.lead_in_s=0.5", "--set", "exploit.separator=duet"]


def rows(folder):
    return list(csv.DictReader((folder / "missions.csv").read_text().splitlines()))


def without_times(table):
    return [{name: cell for name, cell in row.items() if name != "cpu_s"} for row in table]


def test_a_study_writes_a_row_for_every_mission_and_a_table(run, asked, tmp_path):
    code, said, err = run(*asked, "--draws", "1", "--out", tmp_path / "whole")
    assert (code, err) == (0, "")
    assert "target found" in said
    found = rows(tmp_path / "whole")
    assert [(row["draw"], row["target_is"]) for row in found] == [("0", "present"), ("0", "absent")]
    for row in found:
        assert (row["target"] in row["talkers"].split()) == (row["target_is"] == "present")
        assert len(row["errors_deg"].split()) == int(row["k"]) == 1


@pytest.mark.soak  # of a study of another kind: test_study
def test_a_study_that_was_cut_short_goes_on_and_ends_with_the_same_rows(run, asked, tmp_path):
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    code, said, err = run(*asked, "--out", whole)
    assert (code, err) == (0, "")
    assert "target found" in said
    found = rows(whole)
    assert [(row["draw"], row["target_is"]) for row in found] == [
        ("0", "present"), ("0", "absent"), ("1", "present"), ("1", "absent"),
    ]  # fmt: skip
    for row in found:
        assert (row["target"] in row["talkers"].split()) == (row["target_is"] == "present")
        assert len(row["errors_deg"].split()) == int(row["k"]) == 1
        assert float(row["cpu_s"]) > 0
    first, second = (whole / "journal.jsonl").read_text().splitlines()
    assert len({json.loads(line)["task"] for line in (first, second)}) == 2

    cut.mkdir()
    (cut / "study.json").write_bytes((whole / "study.json").read_bytes())
    (cut / "journal.jsonl").write_text(first + "\n" + second[: len(second) // 2])
    code, said, _ = run(*asked, "--out", cut)
    assert code == 0
    assert "1 of 2 tasks were done before" in said
    assert without_times(rows(cut)) == without_times(found)

    code, _, err = run(*asked, "--targets", "present", "--out", cut)
    assert code == 2
    assert "holds another study (targets is present, absent, not present)" in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--scenarios", "dmo"], "scenario 'dmo' is unknown"),
        (["--scenarios", "demo", "--k", "9"], "k"),
        (["--scenarios", "demo", "--targets", "somewhere"], "targets"),
        (["--scenarios", "demo", "--set", "explore"], "expected key=value"),
    ],
)
def test_bad_input_is_one_line_and_leaves_no_folder(run, tmp_path, arguments, words):
    code, out, err = run("study", "missions", *arguments, "--out", tmp_path / "out")
    assert (code, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1
    assert not (tmp_path / "out").exists()
