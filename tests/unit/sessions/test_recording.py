"""A session on disk: what was heard comes back as it was, whatever happens to the disk or the process."""

import json
import math
import stat
import time
import wave
import weakref
from dataclasses import dataclass, replace

import numpy as np
import pytest
import soundfile
from hypothesis import given
from hypothesis import strategies as st

from recording_bench import HOP, beginning, block_of, configured, equal, input_of, only, record, recording
from ross_payload.audio.channel_map import ChannelMap
from ross_payload.config import Config
from ross_payload.events import Estimate, Event, Separated, SourceEstimate, State, StateChanged
from ross_payload.health import RecordingState
from ross_payload.interfaces import Attitude, AudioBlock, AudioFlag, Input, Output, Score, VoiceBlock, VoicePrint
from ross_payload.orders import Informed, ListenTo, Set, Stop
from ross_payload.pointing import Pointing
from ross_payload.sessions import input_log
from ross_payload.sessions.divergence import Divergence, Replayed, replay
from ross_payload.sessions.npz_memory import packed, unpacked
from ross_payload.sessions.recorder import Recorder, in_background
from ross_payload.sessions.replay_results import latest
from ross_payload.sessions.session_store import SessionStore

ORDERS = (Set(name="RUN_S", value=0.1 + 0.2, number=7), ListenTo(2), Informed((0.1, -math.pi), 1), Stop())


def test_every_input_comes_back_exactly(tmp_path):
    rare = replace(block_of(2), lost=320, flags=AudioFlag.CLIPPED | AudioFlag.MISSING)
    inputs = [input_of(0), input_of(1, fault="it smokes: 3 °C", orders=ORDERS), input_of(2, block=rare, settled=False)]
    inputs += [input_of(k, attitude=Attitude(1 / k, 0.1, -0.2, 1e-300, math.inf, known=False)) for k in range(3, 150)]
    record(tmp_path, inputs)
    found = list(only(tmp_path).inputs(Config().audio))
    assert len(found) == 150
    assert all(equal(one, other) for one, other in zip(inputs, found, strict=True))


@given(st.tuples(*[st.floats(-5e307, 5e307)] * 10))  # also the sum of three angles is a float
def test_every_float_comes_back_as_it_was(values):
    start, joint, now, base, offset, rate, *attitude = values
    pointing = Pointing(now, joint, base, offset, earth=True, base_rate=rate)
    heard = Input(replace(block_of(0), time=now), start, pointing, True, Attitude(*attitude))
    found = input_log.input_of(input_log.parsed(input_log.line(heard).encode()), heard.block.samples, None)
    assert equal(found, heard)


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


def test_what_corrections_made_of_any_samples_comes_back(tmp_path):
    wrong = {"gain_db": [7.3, -2.1], "invert": [True, False], "roll_off_hz": [20, 55]}
    audio = Config.model_validate({"audio": wrong}).audio
    device = np.random.default_rng(4).normal(0, 0.3, (60, 2, HOP)).astype(np.float32)  # finer than 24 bits, and clipped
    correction = ChannelMap.of(audio).correction(16000)
    wired = [correction.apply(samples) for samples in device]
    blocks = [AudioBlock(one.samples, k * HOP, 0.0, flags=one.flags, raw=one.raw) for k, one in enumerate(wired)]
    record(tmp_path, [input_of(k, block=block) for k, block in enumerate(blocks)])
    found = list(only(tmp_path).inputs(audio))
    assert all(np.array_equal(one.block.samples, was.samples) for one, was in zip(found, wired, strict=True))
    assert only(tmp_path).contents().notes == ()


def test_corrections_come_back_where_a_session_begins_in_mid_stream_or_a_block_never_came(tmp_path):
    audio = Config.model_validate({"audio": {"roll_off_hz": [20, 55]}}).audio
    correction, rng = ChannelMap.of(audio).correction(16000), np.random.default_rng(4)
    device = rng.normal(0.2, 0.1, (20, 2, HOP)).astype(np.float32)
    wired = [correction.apply(samples) for samples in device]
    blocks = [
        AudioBlock(one.samples, k * HOP, 0.0, flags=one.flags, raw=one.raw, carried=one.carried)
        for k, one in enumerate(wired)
    ]
    blocks[12] = AudioBlock(np.zeros((2, HOP), np.float32), 12 * HOP, 0.0, flags=AudioFlag.MISSING)
    record(tmp_path, [input_of(k, block=block) for k, block in enumerate(blocks) if k >= 5])
    found = list(only(tmp_path).inputs(audio))
    assert len(found) == 15
    assert all(np.array_equal(one.block.samples, was.samples) for one, was in zip(found, blocks[5:], strict=True))
    other = Config.model_validate({"audio": {"roll_off_hz": [20, 90]}}).audio
    anew = ChannelMap.of(other).correction(16000)
    for one, was in zip(only(tmp_path).inputs(other, wire_everywhere=True), blocks[5:], strict=True):
        raw = was.samples if was.raw is None else was.raw
        assert np.array_equal(one.block.samples, anew.apply(raw).samples)


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


def test_a_voice_that_begins_late_holds_up_nothing_and_has_its_place(tmp_path):
    rate = Config().audio.rate_hz
    late, voice = 60 * rate, np.linspace(0.1, 0.2, 50 * HOP).astype(np.float32)
    with recording(tmp_path) as recorder:
        recorder.on_input(input_of(0))
        for first in range(0, len(voice), HOP):
            recorder.on_voice("source-0", VoiceBlock(voice[first : first + HOP], late + first, 60.0))
            recorder.drain()
            if not first:
                (path,) = tmp_path.glob("*/source-0.flac")
                assert soundfile.info(path).frames <= 2 * rate, "hours of silence take their time"
    heard, _ = soundfile.read(path, dtype="float32")
    assert len(heard) == late + len(voice)
    assert not heard[:late].any()
    assert heard[late:] == pytest.approx(voice, abs=1e-6)


def test_what_never_came_is_told_with_a_recording(tmp_path):
    def with_flags(index, flags):
        return input_of(index, block=replace(block_of(index), flags=flags))

    record(tmp_path, [with_flags(k, AudioFlag.MISSING if 10 <= k < 40 else AudioFlag.CLIPPED) for k in range(100)])
    assert (only(tmp_path).contents().missing, only(tmp_path).contents().lost) == (0.3, 0)


def test_only_the_owner_can_read_it(tmp_path):
    record(tmp_path / "all", [input_of(k) for k in range(3)], said=[Event(0.0)])
    folder = only(tmp_path / "all").path
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert {stat.S_IMODE(file.stat().st_mode) for file in folder.iterdir()} == {0o600}


def test_events_that_answer_what_was_not_recorded_are_left_out(tmp_path):
    with recording(tmp_path) as recorder:
        for index in range(3):
            recorder.on_input(input_of(index))
            recorder.on_event(StateChanged(float(index), State.RUN), input_of(index))
    assert [json.loads(line)["time"] for line in only(tmp_path).events()] == [1.0, 2.0]


class Voice(VoicePrint):
    def score(self, voice, rate):
        return Score(0.1 + 0.2, accepted=True)


def test_what_the_voice_print_says_is_kept_and_the_print_is_not(tmp_path):
    with recording(tmp_path) as recorder:
        voice = recorder.noting(Voice())
        voice.score(np.zeros(10), 16000)
        recorder.on_input(input_of(0))
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


def test_nothing_is_written_unless_asked(tmp_path):
    record(tmp_path / "all", [input_of(k) for k in range(60)], always=False)
    assert not (tmp_path / "all").exists()


def test_what_is_too_old_is_deleted_also_while_nothing_is_recorded(tmp_path):
    """As by a service that lives for months."""
    record(tmp_path, [input_of(k) for k in range(60)])
    (tmp_path / "0001").rename(tmp_path / "0001-20261001T120000Z")
    today = ["20261020T120000Z"]
    limits = configured(max_days=30).recording
    with Recorder(SessionStore(tmp_path), limits, beginning, lambda: today[0]) as recorder:
        for index in (0, 360_000):  # an hour
            recorder.on_input(input_of(index))
            recorder.drain()
            assert (tmp_path / "0001-20261001T120000Z").exists()
        today[0] = "20261101T120000Z"
        for index in (360_001, 719_000):
            recorder.on_input(input_of(index))
            recorder.drain()
            assert (tmp_path / "0001-20261001T120000Z").exists()
        recorder.on_input(input_of(720_001))
        recorder.drain()
        assert not (tmp_path / "0001-20261001T120000Z").exists()
        assert recorder.status().state is RecordingState.OFF


def test_a_date_that_is_not_sure_names_sessions_and_deletes_none(tmp_path):
    record(tmp_path, [input_of(k) for k in range(60)])
    (tmp_path / "0001").rename(tmp_path / "0001-20261001T120000Z")
    limits = configured(max_days=30, always=True).recording
    with Recorder(SessionStore(tmp_path), limits, beginning, lambda: "20371001T120000Z", lambda: "") as recorder:
        for index in range(60):
            recorder.on_input(input_of(index))
        recorder.drain()
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["0001-20261001T120000Z", "0002-20371001T120000Z"]


def test_a_session_that_a_date_named_which_nobody_confirmed_has_its_days_from_when_one_is_sure(tmp_path):
    """An autopilot without GPS has its date from a ground station, which may be years behind."""
    today = [""]
    with Recorder(
        SessionStore(tmp_path),
        configured(max_days=30, always=True, min_free_gb=0).recording,
        beginning,
        lambda: "20210101T120000Z",
        lambda: today[0],
    ) as recorder:
        recorder.on_input(input_of(0))
        recorder.drain()
    (session,) = tmp_path.iterdir()
    assert (session.name, (session / "dated").read_text()) == ("0001-20210101T120000Z", "")
    for today[0], there in (("20261101T120000Z", True), ("20261201T110000Z", True), ("20261201T130000Z", False)):
        with Recorder(SessionStore(tmp_path), configured(max_days=30).recording, beginning, today=lambda: today[0]):
            assert session.exists() is there


def test_what_is_too_old_is_deleted_within_a_minute_of_knowing_the_date(tmp_path):
    """At the start nobody has told it yet, and a drone is hardly switched on for an hour without a recording."""
    record(tmp_path, [input_of(k) for k in range(60)])
    old = (tmp_path / "0001").rename(tmp_path / "0001-20261001T120000Z")
    today = [""]
    with Recorder(SessionStore(tmp_path), configured(max_days=30).recording, beginning, today=lambda: today[0]) as one:
        for index, date in ((0, ""), (6_001, ""), (6_002, "20261101T120000Z"), (12_000, "20261101T120000Z")):
            today[0] = date
            one.on_input(input_of(index))
            one.drain()
            assert old.exists()
        one.on_input(input_of(12_002))
        one.drain()
        assert not old.exists()


def test_the_log_says_once_that_what_looks_too_old_stays(tmp_path, caplog):
    record(tmp_path, [input_of(k) for k in range(60)])
    (tmp_path / "0001").rename(tmp_path / "0001-20200101T120000Z")
    limits = configured(max_days=30).recording
    with Recorder(SessionStore(tmp_path), limits, beginning, today=lambda: "") as recorder:
        for index in (0, 360_001):
            recorder.on_input(input_of(index))
            recorder.drain()
    assert len(caplog.messages) == 1
    assert "1 sessions look older than recording.max_days = 30 by the clock of this computer, and stay" in caplog.text


def test_a_folder_that_could_not_be_read_for_a_while_is_told_until_it_can(tmp_path):
    folder = tmp_path / "all"
    limits = configured(always=False).recording
    with Recorder(SessionStore(folder), limits, beginning) as recorder:
        for index, broken in ((0, False), (360_001, True), (720_002, True), (1_080_003, False)):
            folder.unlink(missing_ok=True)
            if broken:
                folder.symlink_to(folder)
            recorder.on_input(input_of(index))
            recorder.drain()
            told = recorder.status()
            assert told.state is (RecordingState.BROKEN if broken else RecordingState.OFF)
            assert bool(told.reason) is broken


def test_what_is_told_of_a_recording_that_failed_outlives_a_folder_that_could_not_be_read_for_a_while(tmp_path):
    folder, aside = tmp_path / "all", tmp_path / "aside"
    with recording(folder, min_free_gb=9999) as recorder:
        recorder.on_input(input_of(0))
        recorder.drain()
        told = recorder.status()
        assert told.state is RecordingState.FULL
        for index, broken in ((1, False), (360_002, True), (720_003, True), (1_080_004, False)):
            if broken and not aside.exists():
                folder.rename(aside)
                folder.symlink_to(folder)
            elif not broken and aside.exists():
                folder.unlink()
                aside.rename(folder)
            recorder.on_input(input_of(index))
            recorder.drain()
            assert recorder.status().state is (RecordingState.BROKEN if broken else RecordingState.FULL)
        assert recorder.status() == told


def test_what_is_told_of_a_recording_that_failed_stays(tmp_path):
    with recording(tmp_path / "all", min_free_gb=9999) as recorder:
        for index in (0, 1, 360_002):
            recorder.on_input(input_of(index))
            recorder.drain()
            assert recorder.status().state is RecordingState.FULL
            assert "min_free_gb" in recorder.status().reason


def test_a_recording_begins_and_ends_with_the_next_input(tmp_path):
    with recording(tmp_path, always=False) as recorder:
        for index in range(30):
            if index in (10, 20):
                assert recorder.record(index == 10) == ""
            recorder.on_input(input_of(index))
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
        recorder.on_input(input_of(0))
        busy[0] = beginning()
        assert recorder.record(True) == ""
        busy[0] = None  # a task is quicker than the next hop
        recorder.on_input(input_of(1))
        busy[0] = beginning()
        recorder.on_input(input_of(2))
        busy[0] = None
        assert recorder.record(True) == ""  # it is on already
        recorder.on_input(input_of(3))
    assert [heard.block.index for heard in only(tmp_path).inputs(Config().audio)] == [2 * HOP, 3 * HOP]


def test_the_status_tells_what_is_being_recorded(tmp_path):
    with recording(tmp_path) as recorder:
        for index in range(200):
            recorder.on_input(input_of(index))
        recorder.drain()
        status = recorder.status()
        assert (status.state, status.name) == (RecordingState.ON, "0001")
        assert status.seconds == pytest.approx(2.0)
        assert status.free_gb > 0


def test_a_thread_of_its_own_writes_while_the_mission_goes_on(tmp_path):
    with recording(tmp_path) as recorder, in_background(recorder):
        for index in range(100):
            recorder.on_input(input_of(index))
        deadline = time.monotonic() + 20
        while recorder.status().seconds < 1.0 and time.monotonic() < deadline:
            time.sleep(0.05)
        assert recorder.status().seconds == pytest.approx(1.0)
    assert only(tmp_path).contents().inputs == 100


def test_a_session_of_an_older_version_tells_where_the_array_pointed(tmp_path):
    """Its lines have the heading, the joint angle and the yaw of the base, which turns at 0.2 rad/s here."""
    base = [0.3 + 0.002 * k for k in range(40)]
    old = [
        {"index": k * HOP, "n": HOP, "time": k * 0.01, "heading": [yaw, yaw + 0.5], "joint": 0.4, "settled": True}
        | {"attitude": [yaw, 0.0, 0.0, 0.0, 0.0, True]}
        for k, yaw in enumerate(base)
    ]
    found = [
        input_log.input_of(values, block_of(0).samples, None).pointing for values in input_log.completed(old, 16000)
    ]
    assert [each.heading for each in found] == pytest.approx([yaw + 0.5 for yaw in base], abs=1e-12)
    assert [each.zero for each in found] == pytest.approx([yaw + 0.1 for yaw in base], abs=1e-12)
    assert found[0].base_rate == 0.0
    assert [each.base_rate for each in found[1:]] == pytest.approx([0.2] * 39)
    assert all(each.earth for each in found)
    assert found[-1].time == pytest.approx(0.4)


def test_a_replay_of_hours_keeps_the_last_voices_alone():
    kept = []

    def mission():
        while True:
            voices = np.zeros((2, 10), np.float32)
            kept.append(weakref.ref(voices))
            yield Output(events=(Separated(0.0, 0, 0.0, voices, (), 0, "auxiva", ""),))

    told = Replayed()
    replay(mission(), map(input_of, range(20)), Divergence([], 0.005), 16000, told)
    assert len(told.lines) == 19
    assert [ref() is not None for ref in kept].count(True) == 1
    assert latest(told, Separated).voices.shape == (2, 10)
