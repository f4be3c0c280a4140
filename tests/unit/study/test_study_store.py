"""The journal of a study loses nothing but what was cut short, and never mixes two studies."""

import io
import json
import math
import os
import shutil
import sys
import time
from dataclasses import asdict, replace
from functools import partial

import pytest
from rich.console import Console

from ross_payload.errors import ConfigError, OutputError
from ross_payload.plugins import install_line
from ross_sim.study import calibration_study
from ross_sim.study.rows import row_files
from ross_sim.study.rows.result_rows import Exploration, Result, Separation, Timing, columns, decode
from ross_sim.study.rows.row_files import as_csv, read_rows
from ross_sim.study.runs import row_manifest, study_run, study_store, task_engine
from ross_sim.study.runs.missions_run import CODE
from ross_sim.study.runs.study_case import Failure
from ross_sim.study.runs.study_design import Study, Task
from ross_sim.study.runs.study_run import Lines, measure, study_manifest
from ross_sim.study.runs.study_store import FINGERPRINTED, plugin_versions, sources
from ross_sim.study.runs.talker_placement import Source

Store = partial(study_store.Store, decode=decode)
WANTED = {"study": {"seed": 1, "settings": ["S1", "S2"]}, "code": "abc"}
ROW = Separation("a", "S1", 3, 0, 1, "0.1", "aligned", 2, "anna", 10.5, si_sdri_db=3.25, all_found=True)
FOUND = Exploration(
    "a", "S1", 2, 0, 1, "0.1", 0, 0.0, "joint", 3.0, 4, 60.0, ("anna", "ben"), (10.0, -20.0), (11.0,), (1.0,),
    (0.9,), (1.0, 180.0), 1, False, False, None,
)  # fmt: skip


def result(name):
    return Result(name, (ROW,), (FOUND,), (Timing(name, "S1", 3, "duet", 10.0, 0.5),))


def test_results_come_back_as_they_were():
    assert decode(json.loads(json.dumps(asdict(result("a"))))) == result("a")


def test_a_torn_line_is_dropped_and_the_next_result_follows_the_last_whole_one(tmp_path):
    with Store(tmp_path, WANTED) as first:
        first.add(result("a"))
        first.add(result("b"))
    journal = tmp_path / "journal.jsonl"
    whole = journal.read_bytes()
    for cut in (len(whole) - 1, len(whole) - 40, whole.index(b"\n") + 2):
        journal.write_bytes(whole[:cut])
        with Store(tmp_path, WANTED) as second:
            assert list(second.results) == ["a"]
            second.add(result("c"))
        with Store(tmp_path, WANTED) as third:
            assert third.results == {"a": result("a"), "c": result("c")}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"study": {"seed": 2, "settings": ["S1", "S2"]}}, "seed is 1, not 2"),
        ({"study": {"seed": 1, "settings": ["S1"]}}, "settings is S1, S2, not S1"),
        ({"code": "def"}, "code is abc, not def"),
    ],
)
def test_another_study_is_refused_in_one_line_and_nothing_is_touched(tmp_path, change, words):
    with Store(tmp_path, WANTED) as first:
        first.add(result("a"))
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(ConfigError, match=words), Store(tmp_path, WANTED | change):
        pass
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_study_goes_on_when_a_package_that_was_absent_has_been_installed(tmp_path):
    def wanted(package):
        return WANTED | {"versions": {"python": "3.11", "scikit-learn": package}}

    for package in (None, "1.7", "1.7"):
        with Store(tmp_path, wanted(package)) as store:
            store.add(result("a"))
    for package in ("1.8", None):
        with pytest.raises(ConfigError, match=f"scikit-learn is 1.7, not {package}"), Store(tmp_path, wanted(package)):
            pass


@pytest.fixture
def plugin(tmp_path, monkeypatch):
    """A separator of another distribution, as it is installed."""
    (tmp_path / "quiet.py").write_text("separator = object()\n")
    about = tmp_path / "quiet_separator-2.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: quiet-separator\nVersion: 2.0\n")
    (about / "entry_points.txt").write_text("[ross_payload.separators]\nquiet = quiet:separator\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path / "quiet.py"
    sys.modules.pop("quiet", None)


def wanted(*separators):
    study = Study(settings=("S1",), k=(2,), separators=separators, explorers=("joint",))
    return study_manifest(study, Source(None, (), 24000))


def test_code_of_a_plug_in_belongs_to_a_study_and_that_of_built_in_ones_is_not_named_twice(plugin):
    before = wanted("duet", "quiet")
    plugin.write_text("separator = 1 * object()\n")
    after = wanted("duet", "quiet")
    assert before["plug-ins"]["quiet"].startswith("quiet-separator 2.0, code ")
    assert study_store.difference(before, after).startswith("quiet is quiet-separator 2.0, code ")
    assert "plug-ins" not in wanted("duet", "irm")


def test_a_plug_in_in_a_package_counts_with_all_of_it(plugin):
    package = plugin.parent / "quiet"
    package.mkdir()
    plugin.rename(package / "__init__.py")
    (package / "inner.py").write_text("")
    before = plugin_versions([("ross_payload.separators", "quiet")])
    (package / "inner.py").write_text("LOUD = 1\n")
    assert plugin_versions([("ross_payload.separators", "quiet")]) != before


def test_a_plug_in_that_is_not_there_is_refused_by_name():
    with pytest.raises(ConfigError, match="separator 'loud' is unknown"):
        plugin_versions([("ross_payload.separators", "loud")])


def test_a_study_depends_on_all_modules_of_ours_behind_its_rows():
    """Configuration, the course of a turn, and what is asked of a study belong to it; the stage to missions."""
    rows, missions = ({path.name for path in sources(code)} for code in (FINGERPRINTED, CODE))
    assert {"mission_options.py", "motion.py", "study_design.py", "events.py", "interfaces.py"} <= rows
    assert {"stage.py", "learning.py", "audio_health.py", "sink_runner.py", "consistency.py"} <= missions


@pytest.mark.parametrize("code", [FINGERPRINTED, CODE, row_manifest.CODE, calibration_study.CODE])
def test_every_file_that_a_study_depends_on_is_there(code):
    """A module that has moved would go out of the fingerprint without a word."""
    missing = [
        pattern
        for package, patterns in code.items()
        for pattern in patterns
        if not list(sources({package: (pattern,)}))
    ]
    assert missing == []


def test_a_folder_in_which_nothing_was_measured_can_be_taken(tmp_path):
    with Store(tmp_path, WANTED):
        pass
    with Store(tmp_path, WANTED | {"code": "def"}) as second:
        assert second.results == {}


def test_two_runs_do_not_write_into_one_folder(tmp_path):
    with Store(tmp_path, WANTED), pytest.raises(ConfigError, match="writing there"), Store(tmp_path, WANTED):
        pass


def test_a_journal_of_somebody_else_is_refused(tmp_path):
    (tmp_path / "journal.jsonl").write_text('{"mine": 1}\n')
    with pytest.raises(ConfigError, match="expected lines of a study"), Store(tmp_path, WANTED):
        pass
    assert (tmp_path / "journal.jsonl").read_text() == '{"mine": 1}\n'


def test_a_file_is_the_old_one_or_the_new_one(tmp_path):
    with Store(tmp_path, WANTED) as here:
        here.write("tables.md", b"old")
        with pytest.raises(OutputError), here.writing("tables.md") as path:
            path.write_bytes(b"ne")
            raise OSError(28, "No space left on device")
    assert (tmp_path / "tables.md").read_bytes() == b"old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["journal.jsonl", "study.json", "tables.md"]


def test_csv_has_a_column_per_field_and_lists_in_one_cell():
    head, line = as_csv([FOUND], Exploration).decode().splitlines()
    cells = dict(zip(head.split(","), line.split(","), strict=True))
    assert tuple(cells) == columns(Exploration)
    assert cells["talkers"] == "anna ben"
    assert cells["errors_deg"] == "1.0 180.0"
    assert cells["directness"] == ""
    assert cells["all_found"] == "false"


def test_parquet_keeps_types_lists_and_what_is_not_known(tmp_path):
    pq = pytest.importorskip("pyarrow.parquet", reason="needs the extra study")

    for kind, row in ((Separation, ROW), (Exploration, FOUND)):
        row_files.write_parquet(tmp_path / "rows.parquet", [row, row], kind)
        (first, _) = pq.read_table(tmp_path / "rows.parquet").to_pylist()
        assert {name: tuple(value) if isinstance(value, list) else value for name, value in first.items()} == {
            name: getattr(row, name) for name in columns(kind)
        }


def test_a_study_may_be_in_a_folder_whose_name_is_not_utf_8(tmp_path):
    pytest.importorskip("pyarrow", reason="needs the extra study")

    folder = tmp_path / os.fsdecode(b"\xe9tude")
    folder.mkdir()
    row_files.write_parquet(folder / "rows.parquet", [FOUND], Exploration)
    shutil.copy(folder / "rows.parquet", tmp_path)
    assert read_rows(tmp_path / "rows.parquet", [Exploration]) == (Exploration, [FOUND])


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_rows_come_back_from_a_file_as_they_were(tmp_path, suffix):
    path = tmp_path / f"rows.{suffix}"
    other = replace(FOUND, azimuths_deg=(), sigmas_deg=(), confidences=(), directness=0.5)
    if suffix == "csv":
        path.write_bytes(as_csv([FOUND, other], Exploration))
    else:
        pytest.importorskip("pyarrow.parquet", reason="needs the extra study")
        row_files.write_parquet(path, [FOUND, other], Exploration)
    assert read_rows(path, [Separation, Exploration]) == (Exploration, [FOUND, other])


@pytest.mark.parametrize("text", ["", "a,b\n1,2\n", "task,setting,k,step,audio_s,cpu_s\nt,S1,three,duet,1,1\n"])
def test_what_is_no_file_of_rows_is_refused_in_one_line(tmp_path, text):
    path = tmp_path / "rows.csv"
    path.write_text(text)
    with pytest.raises(ConfigError, match="expected the rows of a study") as refused:
        read_rows(path, [Separation, Timing])
    assert "\n" not in str(refused.value)


def test_the_code_is_recognised_by_its_content():
    assert study_store.code_hash() == study_store.code_hash()
    assert len(list(study_store.sources())) > 20


@pytest.mark.parametrize("run", [task_engine.serial, task_engine.processes(2)])
def test_an_engine_does_every_task_once(run):
    assert sorted(run(math.sqrt, [4.0, 9.0, 16.0])) == [2.0, 3.0, 4.0]


def test_an_engine_that_is_closed_leaves_nobody_behind():
    import multiprocessing

    running = task_engine.processes(2)(math.factorial, [3, 2, 4])
    assert next(running) in {6, 2, 24}
    running.close()
    deadline = time.monotonic() + 10
    while multiprocessing.active_children() and time.monotonic() < deadline:  # the pool's own thread reaps them, too
        time.sleep(0.01)
    assert not multiprocessing.active_children()


def test_processes_have_one_numeric_thread_each_and_the_environment_is_as_before(monkeypatch):
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    before = dict(os.environ)
    assert set(task_engine.processes(2)(os.getenv, ["OMP_NUM_THREADS"] * 5)) == {"1"}
    assert dict(os.environ) == before


def test_a_worker_that_dies_is_one_error_and_not_a_hang():
    with pytest.raises(OutputError, match="died"):
        list(task_engine.processes(1)(os._exit, [3]))


def test_what_fails_is_told_and_not_kept_so_that_it_is_tried_again(tmp_path):
    def function(task):
        return Failure(task.id, "no") if task.target == 1 else result(task.id)

    left = [Task("S1", 2, 0, target=target) for target in (0, 1)]
    with Store(tmp_path, WANTED) as here:
        failures = measure(task_engine.serial, function, left, here, lambda: 0.0, console=Console())
    assert failures == [Failure("S1-K2-L0-T1", "no")]
    with Store(tmp_path, WANTED) as again:
        assert list(again.results) == ["S1-K2-L0-T0"]


def test_lines_tell_the_time_that_is_left(capsys):
    times = iter([0.0, 0.0, 30.0, 30.0, 90.0, 90.0, 90.0, 120.0, 120.0, 120.0])
    view = Lines(Console(), 5, 2, lambda: next(times))
    for name in "abc":
        view.done(name)
    said = capsys.readouterr().out.splitlines()
    assert said[0] == "2 of 5 tasks were done before"
    assert said[-1].startswith("5 of 5 tasks")
    assert any("left" in line for line in said)


def test_what_parquet_needs_is_a_line_that_can_be_copied(tmp_path, monkeypatch):
    monkeypatch.setattr(study_run, "has_parquet", lambda: False)
    console = Console(file=io.StringIO(), width=40)
    study_run._print_summary(console, tmp_path, 1, 1.0, ())
    assert f"No Parquet was written; it needs: {install_line('study')}\n" in console.file.getvalue()
