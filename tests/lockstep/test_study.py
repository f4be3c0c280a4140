"""`ross study` from the outside: any number of workers, any kind of end, and the same rows."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from examples import in_soak
from mission_fixtures import without_figures
from processes import ROSS
from ross_sim.study.rows.result_rows import decode
from ross_sim.study.runs.study_case import perform
from ross_sim.study.runs.study_design import chosen, tasks
from ross_sim.study.runs.talker_placement import Source
from voice_folders import SMALL_STUDY, voice_folder

pytestmark = pytest.mark.process

TASKS = 2 + 2 * 2


@pytest.fixture(scope="module")
def speech(tmp_path_factory):
    return voice_folder(tmp_path_factory.mktemp("voices"), (0, 1, 3), 12)


@pytest.fixture
def asked(tmp_path, speech):
    (tmp_path / "tiny.toml").write_text(SMALL_STUDY)
    return ["study", str(tmp_path / "tiny.toml"), "--speech", str(speech)]


def journal(out):
    path = out / "journal.jsonl"
    return path.read_bytes().count(b"\n") if path.exists() else 0


def start(asked, out, workers):
    arguments = [*ROSS, *asked, "--out", str(out), "--workers", str(workers)]
    return subprocess.Popen(
        arguments,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )


def wait_for(running, out, n):
    deadline = time.monotonic() + 120
    while journal(out) < n:
        assert running.poll() is None, running.stdout.read()
        assert time.monotonic() < deadline
        time.sleep(0.02)


def alive(group):
    """Processes of a group that still run."""
    listed = subprocess.run(["ps", "-eo", "pgid=,stat=,args="], capture_output=True, text=True, check=True).stdout
    lines = [line.split(maxsplit=2) for line in listed.splitlines()]
    return [line for line in lines if line[0] == str(group) and not line[1].startswith("Z")]


def test_a_study_outlives_the_reader_of_its_lines(asked, tmp_path):
    command = [*ROSS, *asked, "--out", tmp_path / "out"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
        running.stdout.close()
        assert running.stderr.read() == "ross: nobody reads the output any more; the study goes on for what it writes\n"
    assert running.returncode == 0
    assert journal(tmp_path / "out") == TASKS
    assert (tmp_path / "out" / "tables.md").exists()


@pytest.mark.soak  # of one that a full disk ends: below
@pytest.mark.parametrize("workers", [1, 2])
def test_a_study_that_was_killed_goes_on_and_ends_with_the_same_rows(run, asked, tmp_path, workers):
    alone, killed = tmp_path / "alone", tmp_path / "killed"
    with without_figures():
        code, said, err = run(*asked, "--workers", "1", "--out", alone)
    assert (code, err) == (0, "")
    assert "Mean SI-SDRi" in said
    assert journal(alone) == TASKS

    running = start(asked, killed, workers)
    wait_for(running, killed, 1)
    running.kill()
    running.communicate()
    before = (killed / "journal.jsonl").read_bytes()
    before = before[: before.rfind(b"\n") + 1]
    kept = before.count(b"\n")
    assert 1 <= kept < TASKS

    code, said, _ = run(*asked, "--workers", "1", "--out", killed)
    assert code == 0
    assert f"{kept} of {TASKS} tasks were done before" in said
    assert (killed / "journal.jsonl").read_bytes().startswith(before)
    assert journal(killed) == TASKS
    for name in ("separations.csv", "explorations.csv", "gains.csv", "ends.csv", "sigmas.csv", "tables.md"):
        assert (killed / name).read_bytes() == (alone / name).read_bytes(), name
    for name in ("aoa", "methods", "orientation-duet"):  # the same of the same rows: test_study_figures
        assert (killed / f"{name}.pdf").read_bytes().startswith(b"%PDF")

    rows = list(csv.DictReader((alone / "separations.csv").read_text().splitlines()))
    aligned, unaligned, estimated = (
        sum(row["how"] == how for row in rows) for how in ("aligned", "unaligned", "estimated")
    )
    assert (aligned, unaligned, estimated) == (2, 2 * 2, 2 * 2)
    assert len(list(csv.DictReader((alone / "explorations.csv").read_text().splitlines()))) == 2 * 3


def rows_here(asked, task, **changes):
    """The rows of one task as this process measures it."""
    study = chosen(asked[1], changes, False)
    source = Source(Path(asked[3]), study.talkers, study.rate_hz)
    result = perform(next(each for each in tasks(study) if each.id == task), study, source)
    return result.separations, result.explorations


@pytest.mark.parametrize("workers", [1, *in_soak(2)])  # what a signal does to a pool: the tests below
def test_ctrl_c_ends_at_once_with_everything_done_kept(asked, tmp_path, workers):
    out = tmp_path / "out"
    running = start([*asked, "--layouts", "40"], out, workers)  # more than it can do before the signal
    wait_for(running, out, 1)
    os.killpg(running.pid, signal.SIGINT)  # as a terminal does: to the workers also
    said, _ = running.communicate(timeout=20)
    assert running.returncode == 130
    assert "the same command goes on" in said
    assert "Traceback" not in said
    kept = decode(json.loads((out / "journal.jsonl").read_text().splitlines()[0]))
    assert (kept.separations, kept.explorations) == rows_here(asked, kept.task, layouts=40)
    deadline = time.monotonic() + 10
    while alive(running.pid) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert alive(running.pid) == []


CUT_SHORT = """
import os, signal, sys, time
from concurrent.futures import process
from contextlib import closing
from ross_sim.study.runs.task_engine import processes

WINDOW = float(sys.argv[1])  # [s] between the look whether the pipe is open and the writing, at the exit

def wakeup(self):
    if not self._closed:
        time.sleep(WINDOW)
        self._writer.send_bytes(b"")

if __name__ == "__main__":
    with closing(processes(2)(abs, range(200))) as results:
        try:
            next(results)
            if WINDOW:
                process._ThreadWakeup.wakeup = wakeup
            os.kill(os.getpid(), signal.SIGINT)
            for result in results:
                time.sleep(0.01)
        except KeyboardInterrupt:
            print("interrupted", flush=True)
"""


def cut_short(folder, window):
    """Stop a pool of processes by Ctrl-C; what is said on standard error."""
    program = folder / "cut_short.py"
    program.write_text(CUT_SHORT)
    command = [sys.executable, program, str(window)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout) == (0, "interrupted\n")
    return done.stderr


def test_the_end_of_a_pool_does_not_race_with_the_exit_of_the_interpreter(tmp_path):
    assert cut_short(tmp_path, window=0.15) == ""


STARTING = """
import multiprocessing, os, signal, sys, time
from contextlib import closing
from pathlib import Path
from ross_sim.study.runs.task_engine import processes

HERE = Path(__file__).parent

if __name__ == "__mp_main__":  # a worker that is still being loaded
    (HERE / str(os.getpid())).touch()
    while not (HERE / "signalled").exists():
        time.sleep(0.01)

def interrupt():
    workers = [str(process.pid) for process in multiprocessing.active_children()]
    while not workers or not all((HERE / worker).exists() for worker in workers):
        time.sleep(0.01)
        workers = [str(process.pid) for process in multiprocessing.active_children()]
    for worker in workers:
        os.kill(int(worker), signal.SIGINT)
    (HERE / "signalled").touch()

class Tasks(list):
    def __iter__(self):
        yield from (1, 2)
        if "submitting" in sys.argv:
            os.kill(os.getpid(), signal.SIGINT)
        yield from (3, 4)
        interrupt()

if __name__ == "__main__":
    try:
        with closing(processes(2)(abs, Tasks([1, 2, 3, 4]))) as results:
            print(sorted(results))
    except KeyboardInterrupt:
        print("interrupted", len(multiprocessing.active_children()))
"""


@pytest.mark.parametrize(("when", "said"), [("starting", "[1, 2, 3, 4]\n"), ("submitting", "interrupted 0\n")])
def test_ctrl_c_while_workers_are_started_ends_none_of_them_with_a_traceback(tmp_path, when, said):
    program = tmp_path / "starting.py"
    program.write_text(STARTING)
    command = [sys.executable, program, when]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, said, "")


@pytest.mark.soak
@pytest.mark.parametrize("window", [0, 0.15])
def test_100_pools_that_are_cut_short_end_without_a_word(tmp_path, window):
    assert [cut_short(tmp_path, window) for _ in range(100)] == [""] * 100


@pytest.mark.soak
@pytest.mark.parametrize("count", range(100))
def test_100_studies_that_are_stopped_end_without_a_traceback(asked, tmp_path, count):
    test_ctrl_c_ends_at_once_with_everything_done_kept(asked, tmp_path, 2)


BAD = {
    "preset": ["study", "party"],
    "S9": ["study", "--settings", "S1,S9"],
    "fancy": ["study", "--separators", "fancy"],
    "plain": ["study", "--explorers", "plain"],
    "missing.toml": ["study", "missing.toml"],
    "half": ["study", "--rotations", "half"],
    "talkers for K": ["study", "--k", "4"],
    "of speech": ["study", "--k", "3", "paper"],
}


@pytest.mark.parametrize("words", BAD)
def test_bad_input_is_one_line_and_exit_code_2(run, speech, tmp_path, words):
    code, out, err = run(*BAD[words], "--speech", speech, "--out", tmp_path / "out")
    assert (code, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_an_empty_folder_of_voices_is_refused(run, tmp_path):
    (tmp_path / "empty").mkdir()
    code, _, err = run("study", "--speech", tmp_path / "empty", "--out", tmp_path / "out")
    assert code == 2
    assert "expected one sub-folder or one file" in err


FULL = "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (6000, 6000)); " + (
    "sys.argv[0] = 'ross'; from ross_payload.cli import main; main()"
)


def test_a_full_disk_is_one_line_and_the_same_command_goes_on_to_the_same_rows(run, asked, tmp_path):
    out = tmp_path / "out"
    command = [sys.executable, "-c", FULL, *asked, "--out", str(out), "--workers", "1"]
    full = subprocess.run(command, capture_output=True, text=True, check=False)
    assert full.returncode == 1, full.stderr
    assert "journal.jsonl: cannot be written" in full.stderr
    assert full.stderr.count("\n") == 1
    kept = journal(out)
    assert 0 < kept < TASKS
    code, said, _ = run(*asked, "--out", out, "--workers", "1", "--seed", "5")
    assert code == 2
    with without_figures():
        code, said, _ = run(*asked, "--out", out, "--workers", "1")
        assert code == 0
        assert f"{kept} of {TASKS} tasks were done before" in said
        whole = tmp_path / "whole"
        assert run(*asked, "--out", whole, "--workers", "1")[0] == 0
    for name in ("separations.csv", "explorations.csv", "gains.csv", "ends.csv", "sigmas.csv", "tables.md"):
        assert (out / name).read_bytes() == (whole / name).read_bytes(), name
