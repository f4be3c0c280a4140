"""A study in shards ends with the rows of the study done at once; what does not belong together is refused."""

import fcntl
import re
import shutil

import pytest

from mission_fixtures import without_figures
from voice_folders import SMALL_STUDY, voice_folder

STUDY = SMALL_STUDY.replace("starts = 2", "starts = 1")


@pytest.fixture(scope="module", autouse=True)
def undrawn():
    """No figure of these studies is drawn."""
    with without_figures():
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    (folder / "tiny.toml").write_text(STUDY)
    (folder / "speech").mkdir()
    voice_folder(folder / "speech", (0, 1), 12)
    return folder


@pytest.fixture
def study(run, folder):
    def done(out, *more):
        if not out.exists():
            tiny = ("study", str(folder / "tiny.toml"), "--speech", str(folder / "speech"), "--workers", "1")
            assert run(*tiny, "--out", str(out), *more)[0] == 0
        return out

    return done


@pytest.fixture
def halves(study, folder):
    return [study(folder / f"half-{number}", "--shard", f"{number}/2") for number in (1, 2)]


def merge(run, shards, out):
    return run("study", "merge", *map(str, shards), "--out", str(out))


def test_the_status_says_how_far_a_study_is(run, study, halves, folder, tmp_path):
    half, whole = halves[0], study(folder / "whole")
    assert re.fullmatch(
        r"2 of 4 tasks are done \(50 %\), the last one .* ago; not running\n", run("study", "status", str(half))[1]
    )
    assert run("study", "status", str(whole))[1].endswith("; complete\n")
    with (half / "journal.jsonl").open("rb") as held:
        fcntl.flock(held, fcntl.LOCK_EX)  # as who writes there does
        assert run("study", "status", str(half))[1].endswith("; running\n")
    code, _, err = run("study", "status", str(tmp_path))
    assert code == 2
    assert "expected what a shard belongs to" in err
    assert err.count(str(tmp_path)) == 1
    assert err.endswith("got nothing that can be read: No such file or directory\n")


def test_the_rows_of_two_shards_are_those_of_the_whole(run, study, halves, folder, tmp_path):
    whole = study(folder / "whole")
    code, said, err = merge(run, reversed(halves), tmp_path / "merged")
    assert (code, err) == (0, "")
    assert "Mean SI-SDRi" in said
    for name in (
        "separations.csv",
        "explorations.csv",
        "gains.csv",
        "ends.csv",
        "sigmas.csv",
        "tables.md",
        "study.json",
    ):
        assert (tmp_path / "merged" / name).read_bytes() == (whole / name).read_bytes(), name
    assert not (halves[0] / "separations.csv").exists()


def refused(run, shards, out):
    code, said, err = merge(run, shards, out)
    assert (code, said, err.count("\n")) == (2, "", 1)
    assert not (out / "study.json").exists()
    return err


def test_a_shard_twice(run, halves, tmp_path):
    shutil.copytree(halves[0], tmp_path / "copy")
    assert "expected tasks that no other shard has, got '" in refused(
        run, [*halves, tmp_path / "copy"], tmp_path / "merged"
    )


def test_a_shard_that_is_not_there_or_only_half_written(run, halves, tmp_path):
    assert "is in no shard" in refused(run, halves[:1], tmp_path / "merged")
    torn = shutil.copytree(halves[1], tmp_path / "torn")
    content = (torn / "journal.jsonl").read_bytes()
    (torn / "journal.jsonl").write_bytes(content[:-20])
    assert "is in no shard" in refused(run, [halves[0], torn], tmp_path / "merged")
    (torn / "journal.jsonl").write_bytes(b'{"task": 1}\n')
    assert "expected lines of a study" in refused(run, [halves[0], torn], tmp_path / "merged")


def test_a_folder_of_something_else(run, halves, folder, tmp_path):
    assert "expected what a shard belongs to" in refused(run, [*halves, tmp_path], tmp_path / "merged")
    other = shutil.copytree(halves[1], tmp_path / "other")
    (other / "study.json").write_text((other / "study.json").read_text().replace('"code": "', '"code": "0'))
    assert "got another one: code is" in refused(run, [halves[0], other], tmp_path / "merged")


def test_into_a_shard(run, halves):
    code, _, err = merge(run, halves, halves[0])
    assert (code, "expected another folder than those of the shards" in err) == (2, True)


@pytest.mark.parametrize("wrong", ["0/2", "3/2", "1", "a/b", "-1/2"])
def test_a_share_that_is_none(run, wrong, tmp_path):
    code, _, err = run("study", "quick", "--out", str(tmp_path / "out"), f"--shard={wrong}")
    assert (code, f"expected I/N with I from 1 to N, got '{wrong}'" in err) == (2, True)
