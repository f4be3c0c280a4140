"""Tests in forked workers end as they do in one process: every one once, and a failure is a failure with a name."""

import os
import re
import subprocess
import sys
from collections import Counter
from functools import partial
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest

from examples import rows_in_soak
from forked_workers import ForkedWorkers, Queue, Stage
from lanes import TESTS

RUN = """
import sys, pytest
from forked_workers import ForkedWorkers, Stage
stages = [Stage(("one",), 2, quiet=True), Stage(("two",), 2, spare=True), Stage(("rest",), 2)]
sys.exit(pytest.main(sys.argv[1:], plugins=[ForkedWorkers(stages, Stage(("rest",), 2), lambda stage: None)]))
"""
SETTINGS = """
[pytest]
markers =
    one: first
    two: then
    rest: whenever
addopts = -ra -p no:cacheprovider -p pytest_timeout
timeout = 60
junit_family = xunit1
"""
GOOD = """
import os, pytest, time

@pytest.fixture(scope="module")
def file(tmp_path_factory):
    with (tmp_path_factory.mktemp("shared", numbered=False) / "own").open("w") as file:
        yield file

pytestmark = pytest.mark.{lane}

@pytest.mark.parametrize("number", range(6))
def test_number(number, file, tmp_path, record_property):
    assert file.write(str(number))
    record_property("began", time.monotonic())
    time.sleep(0.02)
    record_property("folder", str(tmp_path.parent))
    record_property("output", os.fstat(1).st_ino)
"""
STOPPED = """
import os, signal, pytest

pytestmark = pytest.mark.one

@pytest.fixture(scope="module")
def kept():
    yield
    open("closed", "a").close()

@pytest.mark.parametrize("number", range(6))
def test_number(number, kept):
    if number == 0:
        os.kill(os.getppid(), signal.SIGINT)
"""
BAD = """
import os, signal, time, warnings, pytest

pytestmark = pytest.mark.one

def test_that_fails():
    print("said before")
    assert [1, 2] == [1, 3]

def test_that_ends_its_process():
    os._exit(0)

def test_whose_process_is_killed():
    os.kill(os.getpid(), signal.SIGKILL)

@pytest.mark.timeout(0.2)
def test_that_takes_too_long():
    time.sleep(60)

@pytest.fixture
def broken():
    yield
    raise ValueError("not closed")

def test_with_a_broken_fixture(broken):
    pass

def test_that_warns():
    warnings.warn("heard of")

def test_that_is_skipped():
    pytest.skip("not now")

def test_that_ends_well():
    pass
"""


def run_in(folder, files, *arguments):
    """Run these files in forked workers; return the process that has ended and what it reports of every test."""
    (folder / "pytest.ini").write_text(SETTINGS)
    for name, text in files.items():
        (folder / f"test_{name}.py").write_text(text)
    environment = os.environ | {"PYTHONPATH": str(TESTS / "support"), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    command = [sys.executable, "-c", RUN, "--junitxml=report.xml", *arguments]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=60)
    cases = list(ElementTree.parse(folder / "report.xml").iter("testcase"))  # noqa: S314 - written by pytest
    return done, cases


@pytest.fixture
def run(tmp_path):
    return partial(run_in, tmp_path)


@pytest.fixture(scope="module")
def stages(tmp_path_factory):
    """A run of all stages."""
    files = {lane: GOOD.format(lane=lane) for lane in ("rest", "two", "one")}
    return run_in(tmp_path_factory.mktemp("stages"), files)


def outcomes_of(cases):
    return Counter(
        (case.get("name"), *(child.tag for child in case if child.tag in {"failure", "error", "skipped"}))
        for case in cases
    )


def test_every_test_of_every_stage_runs_once_in_its_turn(stages):
    done, cases = stages
    assert (done.returncode, done.stderr) == (0, "")
    assert outcomes_of(cases) == {(f"test_number[{number}]",): 3 for number in range(6)}
    assert re.findall(r"\w+(?=: \d at a time)", done.stdout)[:2] == ["one", "two"]
    assert "18 passed" in done.stdout
    for own in ("folder", "output"):
        places = {(case.get("classname"), case.find(f".//property[@name='{own}']").get("value")) for case in cases}
        assert len({place for _, place in places}) >= 3  # one of every worker


def test_beside_a_quiet_stage_runs_nothing_else(stages):
    _, cases = stages
    began = {lane: [] for lane in ("one", "two", "rest")}
    for case in cases:
        lane = case.get("classname").rpartition("test_")[2]
        began[lane].append(float(case.find(".//property[@name='began']").get("value")))
    assert max(began["one"]) < min(began["rest"]) < max(began["two"])


def test_every_failure_fails_the_run_and_has_a_name(run):
    done, cases = run({"bad": BAD, "good": GOOD.format(lane="one")})
    assert done.returncode == 1
    outcomes = outcomes_of(cases)
    assert {outcome for outcome in outcomes if not outcome[0].startswith("test_number")} == {
        ("test_that_fails", "failure"),
        ("test_that_ends_its_process", "failure"),
        ("test_whose_process_is_killed", "failure"),
        ("test_that_takes_too_long", "failure"),
        ("test_with_a_broken_fixture", "error"),
        ("test_that_warns",),
        ("test_that_is_skipped", "skipped"),
        ("test_that_ends_well",),
    }
    assert set(outcomes.values()) == {1}
    for said in (
        "assert [1, 2] == [1, 3]", "said before", "not closed", "UserWarning: heard of", "Timeout (>0.2s)",
        "the process of this test ended with 0", "the process of this test was ended by SIGKILL",
        "4 failed, 9 passed, 1 skipped, 1 warning, 1 error",
    ):  # fmt: skip
        assert said in done.stdout, done.stdout


@pytest.mark.parametrize(
    ("files", "arguments", "code", "said"),
    [
        ({"good": "def test_of_no_lane():\n    pass"}, [], 4, "test_of_no_lane: no stage runs it"),
        *rows_in_soak(
            ({"good": "import nothing_of_that_name"}, [], 2, "No module named 'nothing_of_that_name'"),
            ({"good": GOOD.format(lane="one")}, ["-k", "nothing_of_that_name"], 5, "6 deselected"),
            ({"bad": BAD}, ["-x", "-k", "that_fails or ends_well"], 1, "stopping after 1 failures"),
        ),
    ],
)
def test_a_run_ends_as_one_of_pytest_does(run, files, arguments, code, said):
    done, _ = run(files, *arguments)
    assert done.returncode == code, done.stdout
    assert said in done.stdout + done.stderr


@pytest.mark.soak
def test_a_run_that_is_interrupted_closes_what_is_open(run, tmp_path):
    done, _ = run({"stopped": STOPPED})
    assert done.returncode == 2
    assert (tmp_path / "closed").exists()


@pytest.mark.parametrize("option", ["collectonly", "usepdb", "trace", "numprocesses"])
def test_pytest_has_its_own_loop_for_who_looks_into_tests_or_asks_for_other_workers(option):
    options = dict.fromkeys(("collectonly", "usepdb", "trace", "numprocesses"))
    plugins = SimpleNamespace(get_plugins=lambda: [ForkedWorkers((), Stage((), 1), print)])
    assert ForkedWorkers.runs(SimpleNamespace(pluginmanager=plugins, option=SimpleNamespace(**options)))
    options[option] = True
    assert not ForkedWorkers.runs(SimpleNamespace(pluginmanager=plugins, option=SimpleNamespace(**options)))


def test_who_finds_no_file_takes_half_of_what_another_has_left():
    queue = Queue(range(9), lambda number: "long" if number < 6 else "short")
    first, second = queue.take(), queue.take()
    assert (list(first), list(second)) == ([0, 1, 2, 3, 4, 5], [6, 7, 8])
    first.popleft()
    second.clear()
    third = queue.take()
    assert (list(first), list(third)) == ([1, 2], [3, 4, 5])
    queue.give_back([7])
    assert list(queue.take()) == [7]
    for own in (first, third):
        own.clear()
    queue.clear()
    assert not queue.take()
