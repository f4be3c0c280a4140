import ctypes
import errno
import io
import json
import os
import re
import signal
import subprocess
import sys
from contextlib import suppress

import click
import pytest

from nobody import nobody
from processes import ROSS
from ross_payload import cli
from ross_payload.notify import on_signal


def test_help_lists_every_command_and_exit_code(run):
    code, out, _ = run("--help")
    assert code == 0
    for word in ("sitl", "config", "enroll", "actuators", "3 no target"):
        assert word in out


HEAVY = """
import sys
sys.argv = ["ross", "--help"]
from ross_payload.cli import main
try:
    main()
except SystemExit:
    heavy = {"numpy", "scipy", "pydantic", "matplotlib", "pymavlink", "sounddevice", "rich"}
    assert not heavy & set(sys.modules), heavy & set(sys.modules)
"""


def test_help_imports_nothing_heavy():
    done = subprocess.run([sys.executable, "-c", HEAVY], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "sitl" in done.stdout


A_PAYLOAD = """
import sys
import ross_payload.service.live
from ross_payload.config import Config
from ross_payload.service.assemble import tools_of
tools_of(Config(), None)
heavy = {"scipy.optimize", "scipy.signal", "scipy.stats", "sklearn", "matplotlib", "pyroomacoustics"}
heavy |= {"sounddevice", "rich", "aiohttp", "http.server"}
assert not heavy & set(sys.modules), heavy & set(sys.modules)
"""


def test_a_payload_loads_nothing_that_it_can_do_without():
    done = subprocess.run([sys.executable, "-c", A_PAYLOAD], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_good_configuration_is_good(run, tmp_path):
    path = tmp_path / "a.toml"
    path.write_text("[actuator]\nkind = 'ideal'\noptions = { port = 'ideal:tcp:127.0.0.1:7001' }\n")
    assert run("config", "check", path)[0] == 0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[actuator]\nkind = 'hamster'", "'hamster' is unknown; there are: "),
        ("[actuator]\nkind = 'tb6600'\n[actuator.options]\nmicrostep = 16", "unknown key 'microstep'"),
        ("[explore]\nmethod = 'guess'", "'guess' is unknown; there are: joint"),
        ("[explore.options]\ncolour = 'red'", "explore.options of 'joint': unknown key 'colour'"),
        ("[explore]\nmethod = 'markov'\n[explore.options]\nshare = 2", "explore.options of 'markov': share"),
        ("[exploit]\nseparator = 'magic'", "'magic' is unknown"),
        ("[informed]\nazimuths_deg = []", "informed.azimuths_deg"),
        ("[informed]\nazimuths_deg = [nan]", "informed.azimuths_deg"),
        ("[informed]\nazimuths_deg = [0, 50, 100, 150, 200, 250, 300]", "at most 6"),
        ("[informed]\nazimuths_deg = [0, 50]\ntarget = 2", "target: expected a number below 2"),
        ("[informed]\nazimuths_deg = [0, 50]\ntarget = -1", "informed.target"),
        (
            "[informed]\nazimuths_deg = [-180, 50, 180]",
            "azimuths_deg 0 and 2: expected at least 1 deg between them, got 0",
        ),
        (
            "[informed]\nazimuths_deg = [0, 50]\nelevations_deg = [-30]",
            "elevations_deg: expected 2, one for each of azimuths_deg, got 1",
        ),
        ("[informed]\nsigma_deg = 1", "informed.azimuths_deg"),
        ("[array]\nspacing_m = -1", "array.spacing_m"),
        ("[service]\ntarget = 'nobody'", "is enrolled; enrolled: none; `ross enroll nobody FILE.wav` enrols it"),
    ],
)
def test_a_bad_configuration_gets_one_line_and_exit_code_2(run, tmp_path, text, words):
    path = tmp_path / "a.toml"
    path.write_text(text)
    code, out, err = run("config", "check", path)
    assert code == 2
    assert words in err
    assert err.count("\n") == 1
    assert not out


def test_actuators_are_listed_for_people_and_machines(run):
    assert "tb6600" in run("actuators")[1]
    rows = json.loads(run("actuators", "--json")[1])
    assert {"ideal", "tb6600"} <= {row["name"] for row in rows if row["usable"]}


LACKING = """
import importlib.metadata, sys
sys.modules["pyroomacoustics"] = None  # as if the extra were not installed

def version(name, known=importlib.metadata.version):
    if name == "pyroomacoustics":
        raise importlib.metadata.PackageNotFoundError(name)
    return known(name)

importlib.metadata.version = version
from ross_payload.cli import main
for command in ("sitl", "world"):
    sys.argv = ["ross", command]
    try:
        main()
    except SystemExit as ended:
        print(ended.code)
"""


def test_a_command_without_its_extra_says_what_to_install(tmp_path):
    ended = subprocess.run([sys.executable, "-c", LACKING], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ended.stdout.split() == ["2", "2"]
    lines = ended.stderr.splitlines()
    assert len(lines) == 2
    for line in lines:
        assert "needs the package pyroomacoustics: " in line
        assert "pip install " in line
    assert not any(tmp_path.iterdir())


ELSEWHERE = """
import signal, sys
sys.modules |= dict.fromkeys(["fcntl", "grp", "pwd", "resource", "termios", "tty"])
del signal.SIGHUP
from ross_payload import cli
sys.argv = ["ross", *sys.argv[1:]]
cli.main()
"""


@pytest.mark.parametrize(("arguments", "code"), [(["--help"], 0), (["sitl", "--list"], 2), (["run", "x.toml"], 2)])
def test_a_system_that_is_not_unix_gets_the_help_or_one_line(arguments, code):
    command = [sys.executable, "-c", ELSEWHERE, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == code, done.stderr
    needs = r"ross: this command needs Linux: Python has no module \w+ on linux\n"
    assert re.fullmatch(needs if code else "", done.stderr), done.stderr


@pytest.mark.parametrize("arguments", [(), ("config",)])
def test_a_command_that_is_missing_is_answered_with_the_help(run, arguments):
    code, out, err = run(*arguments)
    assert code == 2
    assert not out
    assert err.startswith("Usage: ")
    assert "\\n" not in err
    assert len(err.splitlines()) > 5


def test_an_unknown_command_or_option_is_exit_code_2(run):
    assert run("sing")[0] == 2
    assert run("sitl", "--loudly")[0] == 2


@pytest.mark.parametrize("arguments", [("sitl", "--speed", "fast"), ("sitl", "--seed", "-1"), ("enroll", "anna")])
def test_a_bad_value_is_exit_code_2(run, arguments):
    code, _, err = run(*arguments)
    assert code == 2
    assert "Traceback" not in err


def test_a_user_without_a_home_is_told_what_to_set(run, monkeypatch):
    """As in a container that runs as a number."""
    for name in ("HOME", "XDG_DATA_HOME", "STATE_DIRECTORY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("pwd.getpwuid", {}.__getitem__)
    what = "ross: this user has no home folder: set HOME, or "
    assert run("enroll", "anna", "--forget") == (2, "", f"{what}XDG_DATA_HOME\n")
    assert run("sessions") == (2, "", f"{what}STATE_DIRECTORY\n")
    assert run("health") == (2, "", f"{what}service.state_dir or STATE_DIRECTORY\n")


@pytest.fixture
def own_handlers():
    """What handles a signal to end stays what it was."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def test_an_interruption_stays_one_whatever_a_library_makes_of_it(run, monkeypatch, own_handlers):
    """pydantic raises its own error where a signal comes while it makes a model."""

    @click.command("make")
    def make():
        try:
            signal.raise_signal(signal.SIGTERM)
        except KeyboardInterrupt as error:
            raise ValueError("Error building a validator") from error

    monkeypatch.setitem(cli.ross.commands, "make", make)
    assert run("make") == (130, "", "ross: interrupted\n")


def test_what_asks_python_to_exit_does_not_end_a_command_with_its_own_exit_code(run, monkeypatch):
    """As a plug-in may: 0 would mean that the target was found."""
    leaving = click.Command("leave", callback=lambda: sys.exit(0))
    monkeypatch.setitem(cli.ross.commands, "leave", leaving)
    assert run("leave") == (1, "", "ross: ended by a plug-in or a library, which asked Python to exit with 0\n")


@pytest.mark.parametrize("asked", [["sitl", "--list"], ["--help"]])
def test_a_reader_who_has_gone_is_no_fault(asked):
    """As `ross sitl --list | head -1`: click ends the program then, as a plug-in might."""
    reader, writer = os.pipe()
    os.close(reader)
    command = [*ROSS, *asked]
    with os.fdopen(writer, "wb") as output:
        done = subprocess.run(command, stdout=output, stderr=subprocess.PIPE, text=True, check=False, timeout=60)
    assert (done.returncode, done.stderr) == (1, "")


@pytest.mark.parametrize(("said", "told"), [("Unable to allocate 4 MiB", ": Unable to allocate 4 MiB"), ("", "")])
def test_too_little_memory_is_one_line(run, monkeypatch, said, told):
    def grow():
        raise MemoryError(said)

    monkeypatch.setitem(cli.ross.commands, "grow", click.Command("grow", callback=grow))
    assert run("grow") == (1, "", f"ross: out of memory{told}\n")


def test_too_few_threads_are_one_line(run, monkeypatch):
    def start():
        raise RuntimeError("can't start new thread")

    monkeypatch.setitem(cli.ross.commands, "start", click.Command("start", callback=start))
    assert run("start") == (1, "", "ross: the system refuses another thread: can't start new thread\n")


def test_a_signal_that_interrupted_nobody_is_heard_by_who_listens_for_signals(run, monkeypatch, own_handlers):
    """As one that comes while a weak reference's callback runs: Python ignores what that raises."""
    heard = []

    @click.command("start")
    def start():
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        with on_signal(heard.append):
            heard.append("runs")

    monkeypatch.setitem(cli.ross.commands, "start", start)
    assert run("start")[0] == 0
    assert heard == ["SIGTERM", "runs"]


CLOSED = {  # of a file, and what is said of it, in a folder that may not be entered
    "inner": (("sitl", "--speech", "inner"), "used"),
    "inner/a.wav": (("listen", "rtp://127.0.0.1:5004", "--out", "inner/a.wav"), "used"),
    "inner ": (("ground", "--flights", "inner"), "used"),
    "ross/voice-models": (("voice-model", "list"), "read"),
}


@pytest.mark.parametrize("path", CLOSED)
def test_what_lies_in_a_folder_that_may_not_be_entered_is_told_in_one_line(run, monkeypatch, closed, path):
    arguments, verb = CLOSED[path]
    run(*(closed / "none" / each if each.startswith("inner") else each for each in arguments))  # imports what it needs
    monkeypatch.setenv("XDG_DATA_HOME", str(closed))
    with nobody():
        said = run(*(closed / each if each.startswith("inner") else each for each in arguments))
    assert said == (2, "", f"ross: {closed / path.strip()}: cannot be {verb}: Permission denied\n")


def test_sessions_of_a_folder_that_is_not_there_are_refused(run, tmp_path):
    (tmp_path / "empty").mkdir()
    assert run("sessions", "--folder", tmp_path / "empty") == (0, f"no sessions in {tmp_path}/empty\n", "")
    expected = f"ross: --folder {tmp_path}/nosuch: cannot be read: No such file or directory\n"
    assert run("sessions", "--folder", tmp_path / "nosuch") == (2, "", expected)


def test_output_that_cannot_be_written_is_one_line_and_a_fault(run, monkeypatch):
    class OnAFullDisk(io.StringIO):
        def write(self, text):
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(sys, "stdout", OnAFullDisk())
    code, _, err = run("actuators")
    assert (code, err) == (1, "ross: the output cannot be written: No space left on device\n")


LATE = """
import ctypes
from ross_payload import cli
libc = ctypes.CDLL(None)
libc.on_exit(getattr(libc, "raise"), None)  # is called with the exit code: 15, which is SIGTERM
cli.ross.main = lambda **settings: 15
cli.main()
"""


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "on_exit"), reason="needs on_exit of glibc")
def test_a_signal_after_the_end_of_python_changes_no_exit_code():
    """As one that a script passes on: 143 in its place."""
    shell = ["sh", "-c", 'exec "$0" -c "$1"', sys.executable, LATE]
    done = subprocess.run(shell, capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stderr) == (15, "")


def test_nothing_is_said_of_a_reader_who_has_gone():
    """As a pager that is left before the end: click asks Python to exit, with the code of an error."""
    read, write = os.pipe()
    os.close(read)
    command = [*ROSS, "--help"]
    with os.fdopen(write, "wb") as gone:
        done = subprocess.run(command, stdout=gone, stderr=subprocess.PIPE, text=True, check=False, timeout=60)
    assert (done.returncode, done.stderr) == (1, "")


WITHOUT_STREAMS = """
import os, sys
from ross_payload import cli
sys.argv = ["ross", "actuators"]
try:
    cli.main()
except SystemExit as end:
    with open("kept", "w") as kept:
        print(end.code, kept.fileno() > 2, repr(sys.stdin.read()), file=kept)
"""


def test_a_command_whose_streams_are_closed_ends_as_usual_and_opens_no_file_in_their_place(tmp_path):
    shell = ["sh", "-c", 'exec "$0" -c "$1" <&- >&- 2>&-', sys.executable, WITHOUT_STREAMS]
    subprocess.run(shell, cwd=tmp_path, check=False)
    assert (tmp_path / "kept").read_text() == "0 True ''\n"
