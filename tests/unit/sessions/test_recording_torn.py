"""Sessions that are cut off, damaged, of another version, or of a process that was killed."""

import errno
import fcntl
import json
import math
import os
import signal
import subprocess
import sys
import time
import wave

import numpy as np
import pytest

from recording_bench import HOP, SUPPORT, equal, input_of, only, record, recording
from ross_payload.config import Config
from ross_payload.errors import ConfigError
from ross_payload.events import Event
from ross_payload.interfaces import Attitude, Score
from ross_payload.mission.tasks import Memory
from ross_payload.sessions import npz_memory
from ross_payload.sessions.npz_memory import unpacked
from ross_payload.sessions.session_reader import RecordedSession
from ross_payload.sessions.session_store import SessionStore

# ------------------------------------------------------------------------------------------------ torn files


@pytest.fixture
def whole(tmp_path):
    record(tmp_path, [input_of(k) for k in range(100)], said=[Event(1.0)])
    return only(tmp_path)


@pytest.mark.parametrize("cut", [1, 7, 150, 5000])
def test_inputs_that_are_cut_off_are_read_up_to_the_cut(whole, cut):
    path = whole.path / "inputs.jsonl"
    content = path.read_bytes()
    path.write_bytes(content[:-cut])
    found = list(whole.inputs(Config().audio))
    assert len(found) == content[:-cut].count(b"\n") < 100
    assert whole.contents().notes


def test_a_short_audio_file_ends_the_inputs(whole):
    path = whole.path / "audio.wav"
    os.truncate(path, 44 + 6 * (50 * HOP + 3) + 2)
    assert len(list(whole.inputs(Config().audio))) == 50
    assert any("shorter" in note for note in whole.contents().notes)


def test_a_damaged_line_in_the_middle_is_said(whole):
    path = whole.path / "inputs.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    lines[40] = b'{"index": 3}\n'
    path.write_bytes(b"".join(lines))
    assert len(list(whole.inputs(Config().audio))) == 40
    assert any("line 41" in note for note in whole.contents().notes)


@pytest.mark.parametrize(
    "damage",
    [
        *(
            b'"orders":5,',
            b'"orders":[5],',
            b'"lost":"x",',
            b'"flags":null,',
            b'"n":true,',
            b'"n":99999999999999999999,',
        ),
        *(b'"settled":null,', b'"pointing":[],', b'"fault":5,'),
        *(b'"time":NaN,', b'"joint":1e999,', b'"joint":1' + 400 * b"0", b'"heading":[NaN,0],', b'"height":NaN,'),
        *(b'"pointing":[0,NaN,0,0],', b'"rotors":[NaN],', b'"attitude":[NaN,0,0,0,0,true],'),
        *(b'"attitude":[0,0,0,0,NaN,true],', b'"attitude":[],'),
    ],
)
def test_a_line_whose_values_cannot_be_is_damaged(whole, damage):
    path = whole.path / "inputs.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    lines[40] = lines[40].rstrip(b"}\n") + b"," + damage.rstrip(b",") + b"}\n"
    path.write_bytes(b"".join(lines))
    assert len(list(whole.inputs(Config().audio))) == 40
    assert any("line 41" in note for note in whole.contents().notes)


@pytest.mark.parametrize(
    "name", ["config.json", "audio.wav", "inputs.jsonl", "memory.npz", "voice.npz", "target.flac", "source-3.flac"]
)
def test_an_emptied_file_is_said(whole, name):
    assert not whole.contents().notes
    (whole.path / name).write_bytes(b"")  # as a power cut leaves it
    assert any(note.startswith(f"{name}: ") for note in whole.contents().notes)


def test_a_configuration_that_was_cut_off_is_said(whole):
    path = whole.path / "config.json"
    os.truncate(path, path.stat().st_size - 5)
    assert [note.split(":")[0] for note in whole.contents().notes] == ["config.json"]


@pytest.mark.parametrize("key", [b"settled", b"time", b"joint", b"attitude"])
def test_a_line_that_lacks_what_every_line_has_is_damaged(whole, key):
    path = whole.path / "inputs.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    lines[40] = lines[40].replace(b'"' + key, b'"\x5f' + key[1:])
    path.write_bytes(b"".join(lines))
    assert len(list(whole.inputs(Config().audio))) == 40
    assert any("line 41" in note for note in whole.contents().notes)


def test_events_are_read_up_to_the_first_that_is_damaged(tmp_path):
    record(tmp_path, [input_of(k) for k in range(5)], said=[Event(1.0)])
    whole = only(tmp_path)
    path = whole.path / "events.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(lines[0] + b"\x00\x00\xff\n" + lines[1] + lines[2][:9])
    assert whole.events() == [lines[0].decode()]
    assert any(note.startswith("events.jsonl: damaged at line 2") for note in whole.contents().notes)


@pytest.mark.parametrize(
    "damaged",
    [
        b'{"event":"TurnStarted","time":1}',
        b'{"event":"TurnStarted","time":1,"joint":"x"}',
        b'{"event":"TurnStarted","time":1,"joint":NaN}',
        b'{"event":"Event","time":NaN}',
        b'{"event":"Event","time":1' + 400 * b"0" + b"}",
        b'{"event":5,"time":1}',
    ],
)
def test_an_event_whose_values_cannot_be_is_damaged(whole, damaged):
    path = whole.path / "events.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join([lines[0], damaged + b"\n", *lines[1:]]))
    assert whole.events() == [lines[0].decode()]


@pytest.mark.parametrize("damaged", ['{"input":1e999,"value":1', '{"input":1,"value":1' + 400 * "0"])
def test_scores_are_read_up_to_the_first_that_is_damaged(whole, damaged):
    good = '{"input": 3, "value": 0.5, "accepted": true}\n'
    (whole.path / "scores.jsonl").write_text(f'{good}{damaged},"accepted":true}}\n{good}')
    assert whole.scores() == [(3, Score(0.5, accepted=True))]
    assert "scores.jsonl: damaged at line 2; 2 lines are not read" in whole.contents().notes


@pytest.mark.parametrize(
    "changes", [{"travel_rad": [math.nan, 1.0]}, {"travel_rad": ["-inf", None]}, {"informed_yaw_rad": math.nan}]
)
def test_angles_of_a_session_that_are_none_are_damage(whole, changes):
    path = whole.path / "session.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))
    with pytest.raises(ConfigError, match="damaged, or of another version"):
        RecordedSession.open(whole.path)


def test_what_an_attitude_that_never_came_is_told_by_is_no_damage(tmp_path):
    never = Attitude(0.0, age=math.inf, known=False)
    record(tmp_path, [input_of(k, attitude=never) for k in range(10)])
    assert [heard.attitude for heard in only(tmp_path).inputs(Config().audio)] == 10 * [never]


def test_what_is_checked_is_told_in_json_that_others_read(whole, run):
    assert whole.manifest.upper == math.inf
    code, said, _ = run("sessions", "check", whole.path, "--json")
    assert code == 0
    assert json.loads(said, parse_constant=pytest.fail)["manifest"]["upper"] is None


@pytest.mark.parametrize("samples", [np.zeros(3), np.full((2, 9), np.nan), np.array([b"x"])])
def test_arrays_that_cannot_be_are_damage(tmp_path, samples):
    path = tmp_path / "memory.npz"
    np.savez(path, **{"samples" if samples.ndim == 1 and samples.dtype.kind == "f" else "noise": samples})
    with pytest.raises(ConfigError, match=r"^memory\.npz: damaged"):
        unpacked(path, Memory)


def test_an_archive_that_is_far_larger_than_its_file_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(npz_memory, "LARGEST", 100_000)
    path = tmp_path / "memory.npz"
    np.savez_compressed(path, noise=np.zeros((2, 100_000), np.float32))
    assert path.stat().st_size < 10_000
    with pytest.raises(ConfigError, match="expected at most 100,000 bytes when unpacked"):
        unpacked(path, Memory)


@pytest.mark.parametrize("name", ["events.jsonl", "config.json", "audio.wav", "inputs.jsonl"])
def test_a_missing_file_is_said(whole, name):
    (whole.path / name).unlink()
    assert any(note.startswith(f"{name}: missing") for note in whole.contents().notes)


def test_a_session_of_a_newer_version_is_read_as_far_as_it_goes(whole):
    path = whole.path / "session.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"version": 2, "new": True}))
    found = RecordedSession.open(whole.path)
    assert found.contents().inputs == 100
    assert "expected version 1, got 2" in found.contents().notes[0]


@pytest.mark.parametrize("content", ["", "{", "[]", '{"format": "other"}', '{"format": "ross-session"}'])
def test_a_folder_that_is_no_session_is_refused_with_one_line(tmp_path, content):
    (tmp_path / "session.json").write_text(content)
    with pytest.raises(ConfigError) as refused:
        RecordedSession.open(tmp_path)
    assert "\n" not in str(refused.value)


def test_an_order_of_another_version_is_named(whole):
    path = whole.path / "inputs.jsonl"
    lines = path.read_text().splitlines(keepends=True)
    lines[3] = json.dumps(json.loads(lines[3]) | {"orders": [{"order": "Sing", "number": 1}]}) + "\n"
    path.write_text("".join(lines))
    with pytest.raises(ConfigError, match="Sing"):
        list(whole.inputs(Config().audio))


def test_a_session_that_is_being_recorded_is_not_called_cut_off(tmp_path, run):
    with recording(tmp_path) as recorder:
        for index in range(100):
            recorder.on_input(input_of(index))
        recorder.drain()
        assert only(tmp_path).contents().notes == ("being recorded: read as far as it has come",)
        code, said, _ = run("sessions", "check", only(tmp_path).path)
    assert code == 0
    assert said.startswith("mission, target voice ann, being recorded\n")
    assert only(tmp_path).contents().notes == ()


def test_a_session_that_says_its_end_is_over_also_where_no_file_can_be_locked(whole, run, monkeypatch):
    """As on a share of another computer."""

    def refused(handle, operation):
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", refused)
    code, said, _ = run("sessions", "check", whole.path)
    assert code == 0
    assert said.startswith("mission, target voice ann, the program ended\n")
    store = SessionStore(whole.path.parent)
    assert [kept.running for kept in store.all()] == [False]
    said_of_itself = whole.path / "session.json"
    said_of_itself.write_text(said_of_itself.read_text().replace('"the program ended"', "null"))
    assert [kept.running for kept in store.all()] == [True]


# ------------------------------------------------------------------------------------------------ kill -9

LIVE = f"""
import itertools, sys, time
sys.path.insert(0, {SUPPORT!r})
import recording_bench as t
from pathlib import Path
from ross_payload.events import Event
from ross_payload.sessions.recorder import in_background
recorder = t.recording(Path(sys.argv[1]))
with recorder, in_background(recorder):
    start = time.monotonic()
    for index in itertools.count():
        recorder.on_input(t.input_of(index))
        recorder.on_event(Event(index / 100), None)
        sys.stdout.write(f"{{index + 1}}\\n")
        sys.stdout.flush()
        time.sleep(max(start + index * 0.01 - time.monotonic(), 0))
"""


def killed(folder, after):
    """Record in real time, kill the process without warning; return how many Inputs it had heard."""
    with subprocess.Popen([sys.executable, "-c", LIVE, folder], stdout=subprocess.PIPE) as process:
        process.stdout.readline()
        time.sleep(after)
        process.send_signal(signal.SIGKILL)
        rest = process.stdout.read()
    return int(rest.splitlines()[-1])


def check_killed(folder, moments):
    for number, after in enumerate(moments):
        heard = killed(folder / str(number), after)
        if heard < 100 and not SessionStore(folder / str(number)).all():
            continue  # killed before the first write: the last second is all there was
        found = only(folder / str(number))
        inputs = list(found.inputs(Config().audio))
        assert heard - len(inputs) <= 100
        assert len(inputs) >= 50 or heard < 100
        assert all(equal(one, input_of(index)) for index, one in enumerate(inputs[-3:], len(inputs) - 3))
        with wave.open(str(found.path / "audio.wav")) as file:
            assert file.getnframes() >= len(inputs) * HOP
        assert found.manifest.end is None
        assert "cut off" in found.contents().notes[0]


def test_a_killed_recording_misses_at_most_the_last_second(tmp_path):
    check_killed(tmp_path, np.random.default_rng(1).uniform(1.0, 2.5, 3))


@pytest.mark.soak
def test_a_recording_killed_at_fifty_moments_misses_at_most_the_last_second(tmp_path):
    check_killed(tmp_path, np.random.default_rng(2).uniform(0.0, 6.0, 50))
