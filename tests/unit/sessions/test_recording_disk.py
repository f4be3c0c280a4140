"""A disk that is full, too small, slow or not there ends the recording and not the mission."""

import errno
import os
import subprocess
import sys

import pytest
import soundfile

from nobody import nobody
from recording_bench import HOP, SUPPORT, beginning, block_of, input_of, only, record, recording
from ross_payload.config import Config
from ross_payload.events import Event
from ross_payload.health import RecordingState
from ross_payload.interfaces import VoiceBlock
from ross_payload.sessions import recorder as recorder_module
from ross_payload.sessions.session_store import SessionStore


def test_a_full_disk_ends_the_recording_and_not_the_mission(tmp_path):
    script = f"""
import resource, sys
sys.path.insert(0, {SUPPORT!r})
import recording_bench as t
from pathlib import Path
resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))
with t.recording(Path({str(tmp_path)!r})) as recorder:
    for index in range(600):
        recorder.on_input(t.input_of(index))
        recorder.drain()
    status = recorder.status()
print(status.state, status.reason, sep="|")
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "full|" + os.strerror(errno.EFBIG)
    found = only(tmp_path).contents()
    assert 1.0 < found.seconds <= found.audio < 2.5
    assert len(list(only(tmp_path).inputs(Config().audio))) == found.inputs


def test_a_payload_that_records_where_another_does_says_so(tmp_path, caplog):
    with recording(tmp_path) as first, recording(tmp_path) as second:
        first.on_input(input_of(0))
        first.drain()
        assert caplog.messages == []
        second.on_input(input_of(0))
        second.drain()
        told = f"recording.folder: another payload records into {tmp_path}: max_gb and max_days hold for"
        assert [message.startswith(told) for message in caplog.messages] == [True]
    record(tmp_path, [input_of(0)])
    assert len(caplog.messages) == 1


def test_a_recording_that_cannot_be_closed_is_told_and_another_can_begin(tmp_path, monkeypatch):
    def broken(*_):
        raise ValueError("a bug")

    with recording(tmp_path) as recorder:
        recorder.on_input(input_of(0))
        recorder.drain()
        monkeypatch.setattr(recorder_module.SessionWriter, "write_event", broken)
        monkeypatch.setattr(recorder_module.SessionWriter, "flush", broken)
        recorder.on_input(input_of(1))
        recorder.on_event(Event(0.0), input_of(1))
        recorder.drain()
        assert recorder.status().state is RecordingState.BROKEN
        monkeypatch.undo()
        recorder.on_input(input_of(2))
        assert not recorder.record(on=True)
        recorder.on_input(input_of(3))
        recorder.drain()
        assert recorder.status().state is RecordingState.ON


def test_whatever_goes_wrong_the_recorder_says_so_and_goes_on(tmp_path, monkeypatch):
    def broken(*_):
        raise ValueError("a bug")

    with recording(tmp_path) as recorder:
        recorder.on_input(input_of(0))
        recorder.drain()
        monkeypatch.setattr(recorder_module.SessionStore, "tidy", broken)
        monkeypatch.setattr(recorder_module.SessionWriter, "write_input", broken)
        recorder.on_input(input_of(1))
        recorder.drain()
        assert recorder.status().state is RecordingState.BROKEN
        assert "a bug" in recorder.status().reason
        monkeypatch.undo()


@pytest.fixture
def tiny_disk(tmp_path):
    """A disk of 1 MB, where the system lets us have one."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=1m", "none", folder], capture_output=True, check=False
    )
    if mounted.returncode:
        pytest.skip("needs root and mount (apt install mount)")
    yield folder
    subprocess.run(["umount", "-l", folder], check=True)


def test_a_disk_that_fills_while_a_voice_is_written_ends_the_recording_alone(tiny_disk):
    with recording(tiny_disk) as recorder:
        for index in range(100):
            recorder.on_input(input_of(index))
            recorder.on_voice("target", VoiceBlock(block_of(index).samples[0], index * HOP, index / 100))
        recorder.drain()
        with (tiny_disk / "junk").open("wb") as junk, pytest.raises(OSError):
            junk.write(bytes(2**20))
        for index in range(100, 200):
            recorder.on_voice("target", VoiceBlock(block_of(index).samples[0], index * HOP, index / 100))
        recorder.drain()
        assert (recorder.status().state, recorder.status().reason) == (RecordingState.FULL, os.strerror(errno.ENOSPC))
    assert only(tiny_disk).contents().inputs == 100
    assert len(soundfile.read(only(tiny_disk).path / "target.flac")[0]) >= 50 * HOP


@pytest.mark.soak
def test_a_disk_that_runs_full_ends_the_recording_and_not_the_mission(tiny_disk):
    with recording(tiny_disk) as recorder:
        for index in range(2000):
            recorder.on_input(input_of(index))
            recorder.on_event(Event(index / 100), None)
            recorder.on_frame(index, b"telemetry")
            recorder.drain()
        status = recorder.status()
    assert (status.state, status.reason) == (RecordingState.FULL, os.strerror(errno.ENOSPC))
    found = only(tiny_disk)
    assert 5.0 < found.contents().seconds <= found.contents().audio < 11.0
    assert len(list(found.inputs(Config().audio))) == found.contents().inputs


@pytest.mark.parametrize("left", [0, 4096, 12288])
def test_a_disk_that_is_full_already_leaves_no_folder_behind(tiny_disk, left):
    with (tiny_disk / "junk").open("wb", buffering=0) as junk:
        junk.write(bytes(2**20 - left - 4096))
    recorder = record(tiny_disk, [input_of(k) for k in range(200)])
    assert recorder.status().state is RecordingState.FULL
    assert all(kept.path.name == "0001" for kept in SessionStore(tiny_disk).all())
    assert len(SessionStore(tiny_disk).all()) == len([path for path in tiny_disk.iterdir() if path.is_dir()])


def test_a_disk_that_has_too_little_left_ends_the_recording(tmp_path):
    recorder = record(tmp_path, [input_of(k) for k in range(100)], min_free_gb=9999)
    assert recorder.status().state is RecordingState.FULL
    assert "min_free_gb" in recorder.status().reason


def test_after_a_full_disk_one_can_try_again(tmp_path):
    with recording(tmp_path, min_free_gb=9999) as recorder:
        for index in range(60):
            recorder.on_input(input_of(index))
            recorder.drain()
        assert recorder.status().state is RecordingState.FULL
        before = len(SessionStore(tmp_path).all())
        recorder.on_input(input_of(61))
        recorder.drain()
        assert len(SessionStore(tmp_path).all()) == before
        recorder.record(True)
        recorder.on_input(input_of(62))
        recorder.drain()
        assert len(SessionStore(tmp_path).all()) == before + 1


def test_an_order_that_comes_before_the_mission_has_seen_the_failure_is_no_lost_one(tmp_path):
    begin = [beginning()]
    with recording(tmp_path, lambda: begin[0], min_free_gb=9999) as recorder:
        recorder.on_input(input_of(0))
        recorder.drain()
        assert recorder.status().state is RecordingState.FULL
        begin[0] = None  # a task runs
        assert recorder.record(True).startswith("a task is running")
        begin[0] = beginning()
        assert recorder.record(True) == ""
        recorder.on_input(input_of(1))
        recorder.drain()
        assert len(SessionStore(tmp_path).all()) == 2


def test_a_folder_that_cannot_be_made_is_said(tmp_path):
    (tmp_path / "file").write_text("")
    recorder = record(tmp_path / "file" / "all", [input_of(0)])
    assert recorder.status().state is RecordingState.BROKEN
    assert recorder.status().reason == f"recording.folder: {tmp_path}/file/all cannot be written: Not a directory"


def test_a_folder_that_may_not_be_read_is_said_and_ends_nothing(closed):
    with nobody(), recording(closed / "inner", always=False) as recorder:
        recorder.on_input(input_of(0))
        recorder.drain()
    assert recorder.status().state is RecordingState.BROKEN
    assert recorder.status().reason == f"recording.folder: {closed}/inner cannot be read: Permission denied"


def test_a_disk_that_stalls_for_too_long_ends_the_recording(tmp_path, monkeypatch):
    monkeypatch.setattr(recorder_module, "BACKLOG_S", 1.0)
    with recording(tmp_path) as recorder:
        for index in range(150):  # nobody drains
            recorder.on_input(input_of(index))
        assert recorder.status().state is RecordingState.BROKEN
        assert "slow" in recorder.status().reason
        recorder.drain()
        assert recorder.status().state is RecordingState.BROKEN
    assert only(tmp_path).contents().inputs == 101  # what had waited is there
