"""A program that is forked from the server behaves as one that is started."""

import os
import signal
import subprocess
import sys

import pytest

from forked_programs import _program, _server, begin

pytestmark = pytest.mark.process

CODE = "import ross_payload, sys\n"


def ran(code, *arguments, **options):
    """Run a program that is given by -c; `subprocess` forks it."""
    command = [sys.executable, "-c", CODE + code, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=60, **options)


@pytest.mark.parametrize(
    ("words", "asked"),
    [
        (["-m", "ross_payload.cli", "sitl", "-u"], {"module": "ross_payload.cli", "arguments": ["sitl", "-u"]}),
        (["-u", "-m", "ross_sim"], {"module": "ross_sim", "arguments": [], "unbuffered": True}),
        (["-c", "import ross_sim", "a"], {"code": "import ross_sim", "arguments": ["a"]}),
        (["-c", "import ross_sim, sys; sys.modules.clear()"], None),
        (["-c", "print()"], None),
        (["-m", "pytest"], None),
        (["-W", "error", "-m", "ross_payload.cli"], None),
        (["-c"], None),
        ([], None),
    ],
)
def test_programs_of_this_project_are_forked_and_no_others(words, asked):
    expected = None if asked is None else {"unbuffered": False} | asked
    assert _program([sys.executable, *words]) == expected
    assert _program(["/usr/bin/another", *words]) is None


def test_arguments_folder_and_environment_are_those_that_are_asked_for(tmp_path):
    told = "import os; print(sys.argv, os.getcwd(), os.environ['WHERE'])"
    done = ran(told, "one", "-x", cwd=tmp_path, env=os.environ | {"WHERE": "here"})
    assert (done.stdout, done.stderr) == (f"['-c', 'one', '-x'] {tmp_path} here\n", "")


def test_modules_are_found_where_the_environment_says(tmp_path):
    (tmp_path / "mine.py").write_text("NUMBER = 7\n")
    told = "import mine; print(mine.NUMBER)"
    assert ran(told, env=os.environ | {"PYTHONPATH": str(tmp_path)}).stdout == "7\n"
    assert "No module named 'mine'" in ran(told).stderr


@pytest.mark.parametrize(("code", "status"), [("", 0), ("sys.exit(3)", 3), ("sys.exit('no')", 1), ("1 / 0", 1)])
def test_it_ends_with_its_own_code(code, status):
    assert ran(code).returncode == status


def test_it_can_be_waited_for_looked_at_and_signalled():
    command = [sys.executable, "-c", CODE + "print('here', flush=True); import time; time.sleep(60)"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
        assert (program.stdout.readline(), program.poll()) == ("here\n", None)
        with pytest.raises(subprocess.TimeoutExpired):
            program.wait(0.01)
        program.kill()
        assert (program.wait(60), program.poll()) == (-signal.SIGKILL, -signal.SIGKILL)


def test_processes_that_are_forked_from_each_other_share_a_server():
    begin()
    server = _server()
    reading, writing = os.pipe()
    if (child := os.fork()) == 0:
        try:
            os.write(writing, ran("import os; print(os.getppid())").stdout.encode())
        finally:
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as told:
        assert told.read() == f"{server._process.pid}\n"
    assert os.waitpid(child, 0)[1] == 0
    assert ran("print('still here')").stdout == "still here\n"
