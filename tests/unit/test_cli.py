import errno
import io
import json
import os
import signal
import subprocess
import sys
from contextlib import suppress
from functools import partial

import click
import numpy as np
import pytest
import soundfile

from command_line import called
from nobody import nobody
from ross_payload import cli
from ross_payload.audio.audio_files import BLOCK, read_mono
from ross_payload.notify import on_signal
from ross_payload.voiceprint import speaker_model
from speaker_network import vowel


@pytest.fixture
def run(monkeypatch, capsys, tmp_path):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return partial(called, monkeypatch, capsys)


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


def test_enrolling_silence_is_refused_and_nothing_is_kept(run, tmp_path):
    path = tmp_path / "silence.wav"
    soundfile.write(path, np.zeros(48000), 16000)
    code, _, err = run("enroll", "anna", path)
    assert code == 2
    assert err.count("\n") == 1
    assert not list((tmp_path / "data").rglob("*anna*"))


@pytest.mark.parametrize(("scale", "rate"), [(1.0, 1_999_999_999), (1e30, 16000)], ids=["rate", "peak"])
def test_a_recording_of_no_sound_is_one_line(run, tmp_path, scale, rate):
    path = tmp_path / "odd.wav"
    soundfile.write(path, scale * vowel(), rate, subtype="DOUBLE")
    code, out, err = run("enroll", "ann", path)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert f"{path}: expected " in err
    assert not (tmp_path / "data").exists()


def test_of_a_long_recording_the_beginning_is_used_and_it_says_so(run, tmp_path, monkeypatch):
    monkeypatch.setattr(speaker_model, "LONGEST", 4.0)
    voice, long, short = vowel(), tmp_path / "long.wav", tmp_path / "short.wav"
    soundfile.write(short, voice, 16000)
    soundfile.write(long, np.concatenate([voice, np.full(16000, 0.5)]), 16000)
    assert run("enroll", "ann", short)[2] == ""
    assert run("enroll", "bob", long)[2] == f"{long}: the first 4 s are used, the rest is left out\n"
    ann, bob = (tmp_path / "data" / "ross" / "voices" / f"{name}.json" for name in ("ann", "bob"))
    assert ann.read_bytes() == bob.read_bytes()


@pytest.mark.parametrize("form", ["wav", "flac"])
def test_a_recording_is_read_as_the_mean_of_its_channels(tmp_path, form):
    path = tmp_path / f"three.{form}"
    soundfile.write(path, np.random.default_rng(0).uniform(-0.5, 0.5, (BLOCK + 1000, 3)), 16000)
    samples, rate, goes_on = read_mono(path)
    np.testing.assert_array_equal(samples, soundfile.read(path)[0].mean(axis=1))
    assert (rate, goes_on) == (16000, False)
    first, _, goes_on = read_mono(path, 0.5)
    np.testing.assert_array_equal(first, samples[:8000])
    assert goes_on


def test_forgetting_somebody_unknown_says_so(run):
    code, _, err = run("enroll", "nobody", "--forget")
    assert code == 2
    assert "nobody" in err


def test_forgetting_and_enrolling_at_once_is_refused_and_nothing_is_deleted(run, tmp_path):
    (tmp_path / "data" / "ross" / "voices").mkdir(parents=True)
    kept = tmp_path / "data" / "ross" / "voices" / "anna.json"
    kept.write_text("{}")
    assert run("enroll", "anna", "a.flac", "--forget") == (
        2,
        "",
        "ross: AUDIO: expected none with --forget, got a.flac\n",
    )
    assert kept.exists()


def test_a_folder_is_no_audio_and_no_network(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    expected = f"ross: {tmp_path}: expected an audio file, got a folder\n"
    assert run("enroll", "anna", tmp_path) == (2, "", expected)
    os.mkfifo(tmp_path / "pipe")
    assert run("enroll", "anna", "pipe") == (2, "", "ross: pipe: expected an audio file, got a named pipe\n")
    assert run("voice-model", "add", ".")[2].endswith("as the name of a file, got '.'\n")


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


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (["sitll"], "sitl"),
        (["config", "chek", "a.toml"], "check"),
        (["sitl", "--scenario", "drone-yaww"], "drone-yaw"),
        (["world", "dmo"], "demo"),
        (["study", "papr", "--out", "out"], "paper"),
        (["study", "--separators", "auxva", "--out", "out"], "auxiva"),
        (["enroll", "--forget", "annn"], "ann"),
    ],
)
def test_a_slip_of_the_pen_is_told_what_may_be_meant(run, tmp_path, monkeypatch, words, meant):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "data" / "ross" / "voices").mkdir(parents=True)
    (tmp_path / "data" / "ross" / "voices" / "ann.json").write_text("{}")
    code, out, err = run(*words)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert f"id you mean '{meant}'?" in err


def usages(command, path=("ross",)):
    """Every usage line."""
    context = click.Context(command, info_name=path[-1])
    yield command.collect_usage_pieces(context)
    for name in command.list_commands(context) if isinstance(command, click.Group) else ():
        yield from usages(command.get_command(context, name), (*path, name))


def test_every_argument_is_named_after_what_it_is():
    pieces = [piece for usage in usages(cli.ross) for piece in usage if piece.isupper()]
    assert "MIXTURE" in pieces
    assert not [piece for piece in pieces if len(piece.strip("[]. ")) < 3]


def commands(command, path=("ross",)):
    """Every command that is no group, and how it is called."""
    if not isinstance(command, click.Group):
        yield " ".join(path), command
        return
    context = click.Context(command, info_name=path[-1])
    for name in command.list_commands(context):
        yield from commands(command.get_command(context, name), (*path, name))


NUMBERS = [
    pytest.param(option, id=f"{called} {option.opts[0]}")
    for called, command in commands(cli.ross)
    for option in command.params
    if isinstance(option.type, click.types.FloatParamType)
]


def test_the_options_that_are_numbers_are_found():
    assert {"ross calibrate --turn", "ross world --quiet", "ross monitor --wait"} <= {each.id for each in NUMBERS}


@pytest.mark.parametrize("option", NUMBERS)
def test_no_number_may_be_nan(option):
    with pytest.raises(click.BadParameter, match=r"expected a (finite )?number, got nan"):
        option.type_cast_value(click.Context(cli.ross), ("nan",) if option.multiple else "nan")


def test_infinity_is_a_number_where_something_may_never_end():
    taken = set()
    for each in NUMBERS:
        (option,) = each.values
        try:
            option.type_cast_value(click.Context(cli.ross), ("inf",) if option.multiple else "inf")
        except click.BadParameter:
            continue
        taken.add(each.id)
    assert taken == {"ross listen --duration", "ross monitor --wait"}


@pytest.mark.parametrize("option", ["--turn", "--listen", "--elevation"])
def test_a_turn_by_nan_is_one_line_before_anything_is_opened(run, tmp_path, option):
    code, out, err = run("calibrate", tmp_path / "absent.toml", option, "nan")
    assert (code, out) == (2, "")
    assert err == f"ross: Invalid value for '{option}': expected a finite number, got nan\n"


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
