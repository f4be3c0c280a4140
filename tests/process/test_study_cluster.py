"""`ross study --engine` on Dask: the rows of one process, whatever becomes of workers and client."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager

import pytest

from processes import ROSS
from ross_payload.errors import ConfigError
from ross_sim.study.runs import dask_engine
from voice_folders import SMALL_STUDY, voice_folder
from waiting import wait_for

TASKS = 2 + 2 + 2
ROWS = ("separations.csv", "explorations.csv", "gains.csv", "ends.csv", "sigmas.csv", "tables.md", "study.json")
OTHER_CODE = """
from ross_sim.study.runs import study_store
study_store.code_hash = lambda code=None: "another"
"""
NO_VOICES = """
from ross_payload.errors import ConfigError
from ross_sim.study.runs import talker_placement
def none(folder, rate):
    raise ConfigError(f"{folder}: no such folder")
talker_placement.read_voices = none
"""
DEADLY = """
import os
from ross_sim.study.runs import study_case
if study_case.perform.__module__ == study_case.__name__:  # it is loaded twice
    before = study_case.perform
    def perform(task, study, source):
        if task.id == "S1-K2-L0-T1":
            os.kill(os.getpid(), 9)
        return before(task, study, source)
    study_case.perform = perform
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cluster")
    (folder / "tiny.toml").write_text(SMALL_STUDY)
    (folder / "speech").mkdir()
    voice_folder(folder / "speech", (0, 1), 12)
    return folder


def study(folder, out, *more, **how):
    command = [*ROSS, "study", "tiny.toml", "--speech", "speech", "--out", out, *more]
    return subprocess.run(
        [*map(str, command)], cwd=folder, capture_output=True, text=True, timeout=120, check=False, **how
    )


@pytest.fixture(scope="module")
def whole(folder):
    done = study(folder, folder / "whole", "--workers", "1")
    assert done.returncode == 0, done.stderr
    return folder / "whole"


@contextmanager
def background(command, log):
    """A program of others: it says tracebacks of its own when a peer leaves."""
    with log.open("w") as file, subprocess.Popen([*map(str, command)], stdout=file, stderr=file) as running:
        try:
            yield
        finally:
            running.terminate()


def dask(program, *options):
    """One of Dask's commands; what it needs of ours is imported already where it is forked (`forked_programs`)."""
    return [sys.executable, "-c", f"import ross_sim; from distributed.cli.dask_{program} import main; main()", *options]


@contextmanager
def worker(tmp_path, name, preload=None, *, nanny="--no-nanny"):
    """A worker of the scheduler in this folder."""
    own, log = tmp_path / f"{name}.py", tmp_path / f"{name}.log"
    own.write_text(preload or "")
    local = ("--scheduler-file", tmp_path / "scheduler.json", "--host", "127.0.0.1", "--no-dashboard")
    named = ("--name", name, "--preload", own, "--local-directory", tmp_path)
    with background([*dask("worker", "--nthreads", "1", nanny), *local, *named], log):
        wait_for(lambda: "Registered to" in log.read_text(), what=log.read_text)
        yield


@contextmanager
def cluster(tmp_path, *preloads, nanny="--nanny"):
    """A scheduler and a worker for every preload, None: as installed; yields the engine."""
    where = tmp_path / "scheduler.json"
    local = ("--scheduler-file", where, "--host", "127.0.0.1", "--no-dashboard")
    with ExitStack() as stack:
        log = tmp_path / "scheduler.log"
        stack.enter_context(background([*dask("scheduler", "--port", "0"), *local], log))
        wait_for(lambda: where.exists() and where.stat().st_size, what=log.read_text)
        for number, preload in enumerate(preloads):
            stack.enter_context(worker(tmp_path, f"worker-{number}", preload, nanny=nanny))
        yield json.loads(where.read_text())["address"].replace("tcp://", "dask://")


def same(one, other):
    return {name: (one / name).read_bytes() == (other / name).read_bytes() for name in ROWS}


@pytest.mark.soak
def test_a_cluster_of_this_computer_gives_the_rows_of_one_process(folder, whole, tmp_path):
    done = study(folder, tmp_path / "out", "--engine", "dask", "--workers", "2")
    assert (done.returncode, done.stderr) == (0, "")
    assert re.search(r"^Dask dashboard: http://127\.0\.0\.1:\d+/status$", done.stdout, re.MULTILINE)
    assert all(same(tmp_path / "out", whole).values())


@pytest.mark.soak
def test_a_worker_with_other_code_is_refused_and_named_and_the_others_go_on(folder, tmp_path):
    with cluster(tmp_path, None, OTHER_CODE, nanny="--no-nanny") as engine:
        done = study(folder, tmp_path / "out", "--engine", engine)
    assert (done.returncode, done.stderr) == (0, "")
    assert re.search(r"^worker tcp://127\.0\.0\.1:\d+ is refused: code is another, not \w+$", done.stdout, re.MULTILINE)
    journal = (tmp_path / "out" / "journal.jsonl").read_text().splitlines()
    assert len(journal) == TASKS
    assert all((tmp_path / "out" / name).stat().st_size for name in ROWS)


@pytest.mark.soak
def test_a_good_worker_that_restarts_on_another_port_goes_on_beside_a_refused_one(folder, tmp_path):
    out, journal = tmp_path / "out", tmp_path / "out" / "journal.jsonl"
    more = ("--layouts", "10")
    with cluster(tmp_path, OTHER_CODE, nanny="--no-nanny") as engine:
        command = [*ROSS, "study", "tiny.toml", "--speech", "speech", "--out", out, "--engine", engine, *more]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
        with worker(tmp_path, "first"):
            running = subprocess.Popen([*map(str, command)], cwd=folder, **pipes)
            wait_for(lambda: journal.exists() and journal.stat().st_size, 60)
        with worker(tmp_path, "again"):
            said, _ = running.communicate(timeout=120)
    assert running.returncode == 0, said
    assert said.count("is refused") == 1
    assert len(journal.read_text().splitlines()) == 11 * TASKS


@pytest.mark.soak
def test_a_cluster_without_the_voices_is_one_line(folder, tmp_path):
    with cluster(tmp_path, NO_VOICES) as engine:
        done = study(folder, tmp_path / "out", "--engine", engine)
    assert done.returncode == 2
    assert re.fullmatch(r"ross: --engine: expected workers .*, got none among 1; .*: no such folder\n", done.stderr)


@pytest.mark.soak
def test_a_task_that_ends_its_workers_fails_alone(folder, tmp_path):
    with cluster(tmp_path, DEADLY) as engine:
        done = study(folder, tmp_path / "out", "--engine", engine)
    assert done.returncode == 1
    assert "1 tasks failed, and the same command tries them again; S1-K2-L0-T1: its worker died" in done.stdout
    journal = (tmp_path / "out" / "journal.jsonl").read_text().splitlines()
    assert len(journal) == TASKS - 1


@pytest.mark.soak
def test_ctrl_c_ends_a_cluster_of_this_computer_and_the_same_command_goes_on(folder, whole, tmp_path):
    out, journal = tmp_path / "out", tmp_path / "out" / "journal.jsonl"
    command = [*ROSS, "study", "tiny.toml", "--speech", "speech", "--out", out, "--engine", "dask", "--workers", "2"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    with subprocess.Popen([*map(str, command)], cwd=folder, start_new_session=True, **pipes) as running:
        wait_for(lambda: journal.exists() and journal.stat().st_size, 60)
        os.killpg(running.pid, signal.SIGINT)  # as a terminal does: to the workers also
        said, _ = running.communicate(timeout=60)
    assert running.returncode == 130
    assert "the same command goes on" in said
    assert "Traceback" not in said
    done = study(folder, out, "--engine", "dask", "--workers", "2")
    assert done.returncode == 0
    assert all(same(out, whole).values())


@pytest.mark.soak
def test_a_scheduler_that_goes_is_one_line_and_nothing_is_lost(folder, tmp_path):
    out, journal = tmp_path / "out", tmp_path / "out" / "journal.jsonl"
    with cluster(tmp_path, None) as engine:
        command = [*ROSS, "study", "tiny.toml", "--speech", "speech", "--out", out, "--engine", engine]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
        running = subprocess.Popen([*map(str, command), "--layouts", "200"], cwd=folder, **pipes)
        wait_for(lambda: journal.exists() and journal.stat().st_size)
    said, _ = running.communicate(timeout=120)
    assert running.returncode == 1, said
    assert "Traceback" not in said
    assert re.search(r"the Dask scheduler at tcp://127\.0\.0\.1:\d+ is lost; what was done is kept", said)
    assert journal.read_bytes().endswith(b"\n")


@pytest.mark.soak
def test_no_scheduler_is_one_line(folder, tmp_path):
    began = time.monotonic()
    done = study(folder, tmp_path / "out", "--engine", "dask://127.0.0.1:1")
    assert done.returncode == 2
    assert re.fullmatch(r"ross: --engine: expected a Dask scheduler at tcp://127\.0\.0\.1:1, got .*\n", done.stderr)
    assert time.monotonic() - began < 60


def test_a_scheduler_that_is_waited_for_is_told_before(monkeypatch):
    monkeypatch.setattr(dask_engine, "CONNECT_TIMEOUT", "1s")
    said = []
    engine = dask_engine.cluster("tcp://127.0.0.1:1", 1, dask_engine.Basis(dict, {}), said.append)
    with pytest.raises(ConfigError, match=r"expected a Dask scheduler at tcp://127\.0\.0\.1:1, got no answer"):
        next(engine(str, []))
    assert said == ["connecting to the Dask scheduler at tcp://127.0.0.1:1, for 1 s at most"]


def test_a_scheduler_on_a_host_that_nobody_knows_is_not_waited_for():
    engine = dask_engine.cluster("tcp://nowhere.invalid:8786", 1, dask_engine.Basis(dict, {}), print)
    with pytest.raises(ConfigError, match=r"at tcp://nowhere\.invalid:8786, got no such host"):
        next(engine(str, []))
