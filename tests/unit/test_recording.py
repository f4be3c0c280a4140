"""A session on disk: what was heard comes back as it was, whatever happens to the disk or the process."""

import errno
import json
import math
import os
import signal
import stat
import subprocess
import sys
import time
import wave
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_payload.audio.wiring import Wiring
from ross_payload.config import Config
from ross_payload.errors import ConfigError
from ross_payload.events import Estimate, Event, SourceEstimate, State, StateChanged
from ross_payload.health import RecordingState
from ross_payload.interfaces import Attitude, AudioBlock, AudioFlag, Input, Score
from ross_payload.orders import Informed, ListenTo, Set, Stop
from ross_payload.recording import journal
from ross_payload.recording import recorder as recorder_module
from ross_payload.recording.manifest import Beginning
from ross_payload.recording.memory import packed, unpacked
from ross_payload.recording.recorder import Recorder, in_background
from ross_payload.recording.session import Session
from ross_payload.recording.shelf import Shelf

HOP = 160
GRID = 2.0**-23


def block_of(index, raw=None):
    generator = np.random.default_rng(index)
    samples = generator.integers(-(2**23), 2**23, (2, HOP)).astype(np.float32) * np.float32(GRID)
    return AudioBlock(samples, index * HOP, 0.1 + index * 0.01, raw=raw)


def input_of(index, **changes):
    heading = math.sin(index / 7)
    return replace(Input(block_of(index), heading, heading + 1e-9, heading / 3, True, Attitude(0.1)), **changes)


def configured(**recording):
    return Config.model_validate({"recording": recording})


def beginning(config=None, **changes):
    return replace(Beginning("mission", config or Config(), -3.0, math.inf, "ann"), **changes)


def recording(folder, begin=beginning, **limits):
    limits = {"always": True, "min_free_gb": 0} | limits
    return Recorder(Shelf(folder), configured(**limits).recording, begin)


def record(folder, inputs, said=(), **limits):
    with recording(folder, **limits) as recorder:
        for index, heard in enumerate(inputs):
            recorder.heard(heard)
            for event in said:
                recorder.said(event, heard)
            if index % 50 == 49:
                recorder.drain()
    return recorder


def only(folder):
    (kept,) = Shelf(folder).all()
    return Session.open(kept.path)


def equal(one, other):
    assert np.array_equal(one.block.samples, other.block.samples)
    return replace(one, block=None) == replace(other, block=None) and (
        one.block.index, one.block.time, one.block.lost, one.block.flags
    ) == (other.block.index, other.block.time, other.block.lost, other.block.flags)  # fmt: skip


ORDERS = (Set(name="RUN_S", value=0.1 + 0.2, number=7), ListenTo(2), Informed((0.1, -math.pi), 1), Stop())


def test_every_input_comes_back_exactly(tmp_path):
    rare = replace(block_of(2), lost=320, flags=AudioFlag.CLIPPED | AudioFlag.MISSING)
    inputs = [input_of(0), input_of(1, fault="it smokes: 3 °C", orders=ORDERS), input_of(2, block=rare, settled=False)]
    inputs += [input_of(k, attitude=Attitude(1 / k, 0.1, -0.2, 1e-300, math.inf, known=False)) for k in range(3, 150)]
    record(tmp_path, inputs)
    found = list(only(tmp_path).inputs(Config().audio))
    assert len(found) == 150
    assert all(equal(one, other) for one, other in zip(inputs, found, strict=True))


@given(st.tuples(*[st.floats(allow_nan=False)] * 8))
def test_every_float_comes_back_as_it_was(values):
    start, end, joint, now, *attitude = values
    heard = Input(replace(block_of(0), time=now), start, end, joint, True, Attitude(*attitude[:4]))
    found = journal.input_of(journal.parsed(journal.line(heard).encode()), heard.block.samples, None)
    assert found == heard


def test_the_audio_is_what_the_microphones_gave_before_gain(tmp_path):
    raw = block_of(5).samples
    record(tmp_path, [input_of(k, block=replace(block_of(k), samples=raw / 2, raw=raw)) for k in range(60)])
    with wave.open(str(only(tmp_path).path / "audio.wav")) as file:
        assert (file.getnchannels(), file.getsampwidth(), file.getframerate()) == (2, 3, 16000)
        assert file.getnframes() == 60 * HOP
    audio = Config.model_validate({"audio": {"invert": [True, False]}}).audio
    found = list(only(tmp_path).inputs(audio))
    assert np.array_equal(found[7].block.raw, raw)
    assert np.array_equal(found[7].block.samples, raw * np.array([[-1], [1]], np.float32))


def test_what_a_gain_made_of_any_samples_comes_back(tmp_path):
    audio = Config.model_validate({"audio": {"gain_db": [7.3, -2.1], "invert": [True, False]}}).audio
    device = np.random.default_rng(4).normal(0, 0.3, (60, 2, HOP)).astype(np.float32)  # finer than 24 bits, and clipped
    wired = [Wiring.of(audio).apply(samples) for samples in device]
    blocks = [AudioBlock(one.samples, k * HOP, 0.0, flags=one.flags, raw=one.raw) for k, one in enumerate(wired)]
    record(tmp_path, [input_of(k, block=block) for k, block in enumerate(blocks)])
    found = list(only(tmp_path).inputs(audio))
    assert all(np.array_equal(one.block.samples, was.samples) for one, was in zip(found, wired, strict=True))
    assert only(tmp_path).contents().notes == ()


def test_samples_that_24_bits_do_not_hold_are_said(tmp_path):
    odd = replace(block_of(1), samples=np.full((2, HOP), np.pi / 7, np.float32))
    record(tmp_path, [input_of(0), input_of(1, block=odd)])
    assert any("24 bits" in note for note in only(tmp_path).contents().notes)


def test_a_session_that_ended_well_has_nothing_to_complain_of(tmp_path):
    record(tmp_path, [input_of(k) for k in range(120)])
    found = only(tmp_path)
    assert found.contents().notes == ()
    assert (found.contents().inputs, found.contents().seconds) == (120, 1.2)
    assert (found.manifest.lower, found.manifest.upper, found.manifest.voice) == (-3.0, math.inf, "ann")
    assert found.configuration() == Config()


def test_only_the_owner_can_read_it(tmp_path):
    record(tmp_path / "all", [input_of(k) for k in range(3)], said=[Event(0.0)])
    folder = only(tmp_path / "all").path
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert {stat.S_IMODE(file.stat().st_mode) for file in folder.iterdir()} == {0o600}


def test_events_that_answer_what_was_not_recorded_are_left_out(tmp_path):
    with recording(tmp_path) as recorder:
        for index in range(3):
            recorder.heard(input_of(index))
            recorder.said(StateChanged(float(index), State.RUN), input_of(index))
    assert [json.loads(line)["time"] for line in only(tmp_path).events()] == [1.0, 2.0]


class Voice:
    def score(self, voice, rate):
        return Score(0.1 + 0.2, accepted=True)


def test_what_the_voice_print_says_is_kept_and_the_print_is_not(tmp_path):
    with recording(tmp_path) as recorder:
        voice = recorder.noting(Voice())
        voice.score(np.zeros(10), 16000)
        recorder.heard(input_of(0))
        assert voice.score(np.zeros(10), 16000) == Score(0.1 + 0.2, accepted=True)
    assert only(tmp_path).scores() == [(1, Score(0.1 + 0.2, accepted=True))]


@dataclass(frozen=True, slots=True)
class Memory:
    estimate: Estimate | None = None
    earth: bool = False
    noise: np.ndarray | None = None


def test_what_the_mission_knew_comes_back(tmp_path):
    source = SourceEstimate(0.1 + 0.2, 1e-3, 0.9, True, elevation=None)
    memory = Memory(Estimate((source, source), certain=True), earth=True, noise=block_of(1).samples)
    (tmp_path / "memory.npz").write_bytes(packed(memory))
    found = unpacked(tmp_path / "memory.npz", Memory)
    assert found.estimate == memory.estimate
    assert found.earth
    assert np.array_equal(found.noise, memory.noise)


# ------------------------------------------------------------------------------------------------ on and off


def test_nothing_is_written_unless_asked(tmp_path):
    record(tmp_path / "all", [input_of(k) for k in range(60)], always=False)
    assert not (tmp_path / "all").exists()


def test_a_recording_begins_and_ends_with_the_next_input(tmp_path):
    with recording(tmp_path, always=False) as recorder:
        for index in range(30):
            if index in (10, 20):
                assert recorder.record(index == 10) == ""
            recorder.heard(input_of(index))
            recorder.drain()
            assert recorder.status().state is (RecordingState.ON if 10 <= index < 20 else RecordingState.OFF)
    assert [heard.block.index for heard in only(tmp_path).inputs(Config().audio)] == [
        HOP * index for index in range(10, 20)
    ]
    assert only(tmp_path).manifest.end == "ended by order"


def test_a_recording_does_not_begin_in_the_middle_of_a_task(tmp_path):
    busy = [beginning()]
    with recording(tmp_path, begin=lambda: busy[0], always=False) as recorder:
        busy[0] = None
        assert "task" in recorder.record(True)
        recorder.heard(input_of(0))
        busy[0] = beginning()
        assert recorder.record(True) == ""
        busy[0] = None  # a task is quicker than the next hop
        recorder.heard(input_of(1))
        busy[0] = beginning()
        recorder.heard(input_of(2))
        busy[0] = None
        assert recorder.record(True) == ""  # it is on already
        recorder.heard(input_of(3))
    assert [heard.block.index for heard in only(tmp_path).inputs(Config().audio)] == [2 * HOP, 3 * HOP]


def test_the_status_tells_what_is_being_recorded(tmp_path):
    with recording(tmp_path) as recorder:
        for index in range(200):
            recorder.heard(input_of(index))
        recorder.drain()
        status = recorder.status()
        assert (status.state, status.name) == (RecordingState.ON, "0001")
        assert status.seconds == pytest.approx(2.0)
        assert status.free_gb > 0


def test_a_thread_of_its_own_writes_while_the_mission_goes_on(tmp_path):
    with recording(tmp_path) as recorder, in_background(recorder):
        for index in range(100):
            recorder.heard(input_of(index))
        deadline = time.monotonic() + 20
        while recorder.status().seconds < 1.0 and time.monotonic() < deadline:
            time.sleep(0.05)
        assert recorder.status().seconds == pytest.approx(1.0)
    assert only(tmp_path).contents().inputs == 100


# ------------------------------------------------------------------------------------------------ bad disks


def test_a_full_disk_ends_the_recording_and_not_the_mission(tmp_path):
    script = f"""
import resource, sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
import test_recording as t
from pathlib import Path
resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))
with t.recording(Path({str(tmp_path)!r})) as recorder:
    for index in range(600):
        recorder.heard(t.input_of(index))
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


def test_a_disk_that_runs_full_ends_the_recording_and_not_the_mission(tiny_disk):
    with recording(tiny_disk) as recorder:
        for index in range(2000):
            recorder.heard(input_of(index))
            recorder.said(Event(index / 100), None)
            recorder.sent(index, b"telemetry")
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
    assert all(kept.path.name == "0001" for kept in Shelf(tiny_disk).all())
    assert len(Shelf(tiny_disk).all()) == len([path for path in tiny_disk.iterdir() if path.is_dir()])


def test_a_disk_that_has_too_little_left_ends_the_recording(tmp_path):
    recorder = record(tmp_path, [input_of(k) for k in range(100)], min_free_gb=9999)
    assert recorder.status().state is RecordingState.FULL
    assert "min_free_gb" in recorder.status().reason


def test_after_a_full_disk_one_can_try_again(tmp_path):
    with recording(tmp_path, min_free_gb=9999) as recorder:
        for index in range(60):
            recorder.heard(input_of(index))
            recorder.drain()
        assert recorder.status().state is RecordingState.FULL
        before = len(Shelf(tmp_path).all())
        recorder.heard(input_of(61))
        recorder.drain()
        assert len(Shelf(tmp_path).all()) == before
        recorder.record(True)
        recorder.heard(input_of(62))
        recorder.drain()
        assert len(Shelf(tmp_path).all()) == before + 1


def test_a_folder_that_cannot_be_made_is_said(tmp_path):
    (tmp_path / "file").write_text("")
    recorder = record(tmp_path / "file" / "all", [input_of(0)])
    assert recorder.status().state is RecordingState.BROKEN
    assert recorder.status().reason


def test_a_disk_that_stalls_for_too_long_ends_the_recording(tmp_path, monkeypatch):
    monkeypatch.setattr(recorder_module, "BACKLOG", 1.0)
    with recording(tmp_path) as recorder:
        for index in range(150):  # nobody drains
            recorder.heard(input_of(index))
        assert recorder.status().state is RecordingState.BROKEN
        assert "slow" in recorder.status().reason
        recorder.drain()
        assert recorder.status().state is RecordingState.BROKEN
    assert only(tmp_path).contents().inputs == 101  # what had waited is there


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


def test_events_are_read_up_to_the_first_that_is_damaged(tmp_path):
    record(tmp_path, [input_of(k) for k in range(5)], said=[Event(1.0)])
    whole = only(tmp_path)
    path = whole.path / "events.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(lines[0] + b"\x00\x00\xff\n" + lines[1] + lines[2][:9])
    assert whole.events() == [lines[0].decode()]
    assert any(note.startswith("events.jsonl: damaged at line 2") for note in whole.contents().notes)


@pytest.mark.parametrize("name", ["events.jsonl", "config.json", "audio.wav", "inputs.jsonl"])
def test_a_missing_file_is_said(whole, name):
    (whole.path / name).unlink()
    assert any(note.startswith(f"{name}: missing") for note in whole.contents().notes)


def test_a_session_of_a_newer_version_is_read_as_far_as_it_goes(whole):
    path = whole.path / "session.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"version": 2, "new": True}))
    found = Session.open(whole.path)
    assert found.contents().inputs == 100
    assert "version 2, wanted 1" in found.contents().notes[0]


@pytest.mark.parametrize("content", ["", "{", "[]", '{"format": "other"}', '{"format": "ross-session"}'])
def test_a_folder_that_is_no_session_is_refused_with_one_line(tmp_path, content):
    (tmp_path / "session.json").write_text(content)
    with pytest.raises(ConfigError) as refused:
        Session.open(tmp_path)
    assert "\n" not in str(refused.value)


def test_an_order_of_another_version_is_named(whole):
    path = whole.path / "inputs.jsonl"
    lines = path.read_text().splitlines(keepends=True)
    lines[3] = json.dumps(json.loads(lines[3]) | {"orders": [{"order": "Sing", "number": 1}]}) + "\n"
    path.write_text("".join(lines))
    with pytest.raises(ConfigError, match="Sing"):
        list(whole.inputs(Config().audio))


# ------------------------------------------------------------------------------------------------ kill -9

LIVE = f"""
import itertools, sys, time
sys.path.insert(0, {str(Path(__file__).parent)!r})
import test_recording as t
from pathlib import Path
recorder = t.recording(Path(sys.argv[1]))
with recorder, t.in_background(recorder):
    start = time.monotonic()
    for index in itertools.count():
        recorder.heard(t.input_of(index))
        recorder.said(t.Event(index / 100), None)
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
        if heard < 100 and not Shelf(folder / str(number)).all():
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
    check_killed(tmp_path, np.random.default_rng(1).uniform(1.0, 2.5, 5))


@pytest.mark.soak
def test_a_recording_killed_at_fifty_moments_misses_at_most_the_last_second(tmp_path):
    check_killed(tmp_path, np.random.default_rng(2).uniform(0.0, 6.0, 50))
