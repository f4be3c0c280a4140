"""No file in the state folder stops or hangs a start: it is named, set aside and never deleted."""

import json
import os
import shutil
import subprocess
import time
import tomllib

import numpy as np
import pytest
import soundfile

from command_line import called
from processes import ROSS
from ross_payload.bounded_files import set_aside
from ross_payload.config import Config
from ross_payload.config.parameter_store import Parameters
from ross_payload.events import State, StateChanged
from ross_payload.orders import Rearm
from ross_payload.service.live import live
from ross_payload.service.stop_latch import StopLatch
from ross_payload.transport.signing import SigningTime
from ross_payload.voiceprint import VoiceStore, enrol
from ross_protocols.mavlink.signing import timestamp_of
from state_fuzz import NAMED, PRINT, RUINED, SESSION, drawn, spoil

RATE = 16000
SOON = 5.0  # [s]


def buzz():
    """Four seconds that are voiced: the harmonics of 120 Hz."""
    t = np.arange(4 * RATE) / RATE
    return 0.05 * sum(np.sin(2 * np.pi * 120 * k * t) / k for k in range(1, 20)) * (1 + 0.5 * np.sin(8 * t))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The folder of a payload after a short flight, everything in its state folder used once."""
    folder = tmp_path_factory.mktemp("whole")
    noise = np.random.default_rng(0).normal(0, 0.1, (4 * RATE, 2))
    soundfile.write(folder / "n.wav", noise[: RATE // 20], RATE, subtype="PCM_24")
    (folder / "key").write_bytes(bytes(range(32)))
    (folder / "key").chmod(0o600)
    VoiceStore((folder / PRINT).parent).save("ann", enrol(buzz(), RATE))
    with pytest.MonkeyPatch.context() as patch:
        config = settled(folder, patch)
        live(config)
        with Parameters(config, folder / "state" / "params.toml") as parameters:
            parameters.set("EXP_UNIT", 2.0)
    return folder


def settled(folder, patch):
    """The configuration of a folder; its user's voice prints are there, too."""
    patch.setenv("XDG_DATA_HOME", str(folder / "data"))
    values = {
        "audio": {"source": f"file:{folder / 'n.wav'}"},
        "service": {"state_dir": str(folder / "state"), "target": "ann"},
        "recording": {"always": True, "min_free_gb": 0},
        "links": [{"url": "udpout:127.0.0.1:9", "key_file": str(folder / "key")}],
        "dronecan": {"port": "can:virtual:state"},
    }
    return Config.model_validate(values)


def started(config, capsys):
    """Start the payload and let its audio end; the log, and how long that took."""
    began = time.monotonic()
    code = live(config)
    took = time.monotonic() - began
    assert code == 0
    said = capsys.readouterr().err
    assert "Traceback" not in said
    assert all(line.isprintable() for line in said.splitlines())
    return said, took


@pytest.fixture
def one_round(whole, tmp_path, monkeypatch, capsys):
    """Spoil one thing, start, and look at what became of it."""

    def play(name, kind, seed=0):
        folder = shutil.copytree(whole, tmp_path / "flown")
        if seed % 3 == 1:
            (folder / "state" / "stopped").touch()
        path = spoil(folder, name, kind, np.random.default_rng(seed))
        spoilt, latched = path.lstat().st_ino, os.path.lexists(folder / "state" / "stopped")
        said, took = started(settled(folder, monkeypatch), capsys)
        assert took < SOON
        assert ("mission: stopped" in said) == latched
        if name in NAMED and kind in RUINED:
            assert name in said
            assert f"{path.name}.unreadable" in said
            assert spoilt in {each.lstat().st_ino for each in folder.rglob("*")}
        called(monkeypatch, capsys, "sessions", "--folder", folder / "state" / "recordings")

    return play


PIPE = "named pipe"  # which hangs who reads it
WORST = ("nested lists", "nested tables", "5,000 digits", "folder")
OTHERS = [(name, kind) for index, name in enumerate(NAMED) for kind in WORST if kind != WORST[index % len(WORST)]]
SHORT = [
    *((name, PIPE) for name in NAMED),
    *((name, WORST[index % len(WORST)]) for index, name in enumerate(NAMED)),
    *(pytest.param(*pair, marks=pytest.mark.soak) for pair in OTHERS),
    *(("state/stopped", kind) for kind in (PIPE, "folder", "loop", "link to nothing", "noise")),
    *((f"{SESSION}/{name}", PIPE) for name in ("inputs.jsonl", "audio.wav", "events.jsonl")),
    ("state/recordings", PIPE),
    ("state/recordings/0002", PIPE),
    ("state/params.toml", "escapes"),
]


@pytest.mark.parametrize(("name", "kind"), SHORT)
def test_a_spoilt_file_does_not_stop_a_start_and_is_named_and_kept(one_round, name, kind):
    one_round(name, kind)


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(200))
def test_a_state_folder_spoilt_at_random_starts(one_round, seed):
    one_round(*drawn(np.random.default_rng(seed)), seed)


def test_a_parameter_that_the_explorer_cannot_follow_does_not_stop_a_start(tmp_path, monkeypatch, capsys):
    """It was set in flight with another explorer, or kept by a version that did not refuse it."""
    soundfile.write(tmp_path / "n.wav", np.random.default_rng(0).normal(0, 0.1, (RATE // 20, 2)), RATE)
    plain = settled(tmp_path, monkeypatch)
    service = plain.service.model_copy(update={"target": ""})
    explore = plain.explore.model_copy(update={"method": "markov"})
    config = plain.model_copy(update={"service": service, "explore": explore, "links": ()})
    with Parameters(config, tmp_path / "state" / "params.toml") as parameters:
        parameters.set("EXP_CONTINUOUS", 1.0)
    said, _ = started(config, capsys)
    assert "EXP_CONTINUOUS: explore.continuous: expected an explorer that hears while turning, got 'markov'" in said


def test_the_whole_service_starts_beside_a_named_pipe_and_nested_json(whole, tmp_path):
    folder, rng = tmp_path / "flown", np.random.default_rng(0)
    shutil.copytree(whole, folder)
    spoil(folder, f"{SESSION}/inputs.jsonl", "named pipe", rng)
    spoil(folder, f"{SESSION}/session.json", "nested lists", rng)
    spoil(folder, "state/params.toml", "5,000 digits", rng)
    (folder / "ross.toml").write_text(
        '[audio]\nsource = "file:n.wav"\n[service]\nstate_dir = "state"\n[recording]\nalways = true\n'
    )
    command = [*ROSS, "run", "ross.toml"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    assert "session.json.unreadable" in done.stderr
    assert "params.toml.unreadable" in done.stderr


def test_a_stop_latch_that_is_a_folder_goes_when_the_payload_is_armed_again(tmp_path):
    (tmp_path / "stopped" / "something").mkdir(parents=True)
    latch = StopLatch(tmp_path / "stopped")
    assert latch.closed
    latch.ordered(Rearm())
    latch.on_event(StateChanged(0.0, State.IDLE), None)
    latch.close()
    assert not latch.closed
    assert (tmp_path / "stopped.unreadable" / "something").is_dir()


def test_what_was_signed_before_a_signing_time_was_lost_is_not_believed(tmp_path):
    (tmp_path / "signing-time").write_text("not a number")
    now = 1_700_000_000.0
    time = SigningTime(tmp_path, lambda: now, 0.0)
    assert time.floor >= timestamp_of(now)
    assert (tmp_path / "signing-time.unreadable").read_text() == "not a number"


def test_a_lost_signing_time_is_bounded_by_the_file_where_no_clock_is_set(tmp_path):
    path = tmp_path / "signing-time"
    path.write_text("9" * 5000)
    SigningTime(tmp_path, lambda: 0.0, 0.0).close()
    assert int(path.read_text()) > timestamp_of((tmp_path / "signing-time.unreadable").stat().st_mtime)
    assert path.stat().st_mode & 0o777 == 0o600


def test_a_spoilt_file_on_a_disk_that_cannot_be_written_is_named_where_it_is(tmp_path):
    target = tmp_path / ("x" * 250)  # its name cannot be longer, so it cannot be renamed
    target.write_text("spoilt")
    assert "cannot be renamed" in set_aside(target, "unreadable")
    assert target.read_text() == "spoilt"


ESCAPES = "\x1b[2J\x9b31m\u202e\x07"


def test_what_a_session_says_of_itself_does_not_reach_the_terminal_raw(whole, tmp_path, monkeypatch, capsys):
    path = shutil.copytree(whole, tmp_path / "flown") / SESSION / "session.json"
    values = json.loads(path.read_text())
    path.write_text(json.dumps(values | {"end": ESCAPES, "kind": ESCAPES, "voice": ESCAPES, "versions": {}}))
    for words in (("sessions", "--folder", path.parents[1]), ("sessions", "check", path.parent)):
        code, out, err = called(monkeypatch, capsys, *words)
        assert (code, err) == (0, "")
        assert all(line.isprintable() for line in out.splitlines())


def test_a_configuration_is_shown_as_toml_that_a_terminal_does_not_obey(tmp_path, monkeypatch, capsys):
    path = tmp_path / "a.toml"
    path.write_text('[actuator.options]\n"\\u001b[2J" = "\\u009b31m\\u202e\\u0007"\n')
    code, out, _ = called(monkeypatch, capsys, "config", "show", path)
    assert code == 0
    assert all(line.isprintable() for line in out.splitlines())
    assert tomllib.loads(out)["actuator"]["options"] == {"\x1b[2J": "\x9b31m\u202e\x07"}
