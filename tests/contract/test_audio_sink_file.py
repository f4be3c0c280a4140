"""A voice in a file: on a full disk, beside others of its name, with its gaps, and for nobody else to read."""

from __future__ import annotations

import errno
import os
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import soundfile

from clocks import FakeClock
from full_disk import fill
from ross_payload.audio.sinks import checked_options, info_of, make_sink
from ross_payload.errors import AudioError
from ross_payload.interfaces import VoiceBlock
from ross_payload.listening.sink_runner import DirectRunner
from sink_bench import HOP, RATE, Rig, blocks, file, flac, services, voice, wav

pytestmark = pytest.mark.process


def test_a_full_disk_is_a_fault_and_what_is_not_written_is_counted(tmp_path):
    rig = flac(tmp_path, None)
    with rig.make() as sink:
        for block in blocks(voice(1.0)):
            sink.write(block)
        fill(rig.path)
        with pytest.raises(AudioError, match=f"^{rig.path}: cannot be written: No space left on device$"):
            for block in blocks(voice(2.0), RATE):
                sink.write(block)
        assert sink.fault == f"{rig.path}: cannot be written: No space left on device"
    assert len(rig.received()) > RATE / 2


@pytest.mark.parametrize("suffix", [".flac", ".wav"])
def test_after_a_full_disk_it_goes_on_in_another_file_when_there_is_room(tmp_path, monkeypatch, caplog, suffix):
    caplog.set_level("INFO")
    rig, clock, free = file(tmp_path, None, suffix), FakeClock(), [2**40]
    monkeypatch.setattr(
        "ross_payload.audio.sinks.file_sink.os.statvfs",
        lambda path: SimpleNamespace(f_bavail=free[0], f_frsize=1),
    )
    runner, samples = DirectRunner("stream 0", rig.make, clock), voice(12.0)
    for block in blocks(samples):
        if block.index == 4 * RATE:
            fill(rig.path)
            free[0] = 1000
        free[0] = 2**40 if block.index > 8 * RATE else free[0]
        runner.write(block)
        clock.sleep(HOP / RATE)
    lost = runner.lost
    runner.close()
    second = rig.path.with_stem("voice-2")
    assert sorted(path.name for path in rig.path.parent.iterdir()) == sorted([rig.path.name, second.name])
    first, rest = rig.received(), soundfile.read(second, dtype="float32")[0]
    assert np.array_equal(rest, samples[-len(rest) :]), "its first sample is the first that there was room for"
    assert np.array_equal(first, samples[: len(first)])
    assert 3.5 * RATE < len(first) <= 4.3 * RATE
    assert 2 * RATE - HOP <= len(rest) <= 4 * RATE, "every 2 s it is tried again"
    waited = len(samples) - len(first) - len(rest) - lost  # to be encoded, when the disk was full
    assert 0 <= waited < 5000
    said = [each.getMessage() for each in caplog.records if each.getMessage().startswith("stream 0")]
    assert said[:2] == [
        f"stream 0: {rig.path}: cannot be {done}: No space left on device" for done in ("written", "made")
    ]
    assert re.fullmatch(rf"stream 0: works again after \d\.\d s; {lost} samples are missing", said[2])
    assert len(said) == 3


def test_what_must_stay_free_ends_the_file_before_the_disk_is_full(tmp_path, monkeypatch, caplog):
    caplog.set_level("INFO")
    rig, clock, free = wav(tmp_path, None), FakeClock(), [600_000_000]
    monkeypatch.setattr(
        "ross_payload.audio.sinks.file_sink.os.statvfs",
        lambda path: SimpleNamespace(f_bavail=free[0], f_frsize=1),
    )
    rig.services = replace(rig.services, min_free_gb=0.5)
    runner, samples = DirectRunner("stream 0", rig.make, clock), voice(12.0)
    for block in blocks(samples):
        if block.index == 4 * RATE:
            free[0] = 499_000_000
        if block.index == 6 * RATE:
            free[0] = 501_000_000  # enough, and not for a minute of sound more
        if block.index == 8 * RATE:
            free[0] = 503_000_000
        runner.write(block)
        assert not 5.1 < block.index / RATE < 8 or runner.fault.endswith(
            "below min_free_gb; [recording] keeps 0.5 GB of the disk free"
        )
        clock.sleep(HOP / RATE)
    lost = runner.lost
    runner.close()
    first, rest = rig.received(), soundfile.read(rig.path.with_stem("voice-2"), dtype="float32")[0]
    assert 4 * RATE <= len(first) <= 5.1 * RATE
    assert len(rest) >= RATE - HOP
    assert len(first) + lost + len(rest) == len(samples)
    said = [each.getMessage() for each in caplog.records if each.getMessage().startswith("stream 0")]
    assert said[:2] == [
        f"stream 0: {rig.path}: cannot be {done}: below min_free_gb; [recording] keeps 0.5 GB of the disk free"
        for done in ("written", "made")
    ]
    assert len(said) == 3


def test_a_disk_that_takes_nothing_at_all_is_not_filled_with_empty_files(tmp_path, monkeypatch):
    def write(track, samples):
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    rig = wav(tmp_path, None)
    monkeypatch.setattr("ross_payload.audio.track_files.WavTrack.write", write)
    with rig.make() as sink, pytest.raises(AudioError, match="Input/output error"):
        sink.write(next(blocks(voice(0.1))))
    assert not list(rig.path.parent.iterdir())


def test_a_file_is_told_as_it_was_named_not_where_it_lies(tmp_path):
    options = checked_options("file", {"path": "heard.flac"}, "options")
    for name in ("heard.flac", "heard-2.flac"):
        with make_sink("file", options, services(tmp_path)) as sink:
            assert info_of(sink).address == name
        assert (tmp_path / name).exists()


def test_a_folder_that_cannot_be_made_is_told_by_name(tmp_path):
    (tmp_path / "folder").write_text("in the way")
    with (
        pytest.raises(AudioError, match=r"folder/voice\.flac: cannot be made: File exists"),
        flac(tmp_path, None).make(),
    ):
        pass


def test_a_file_that_is_there_is_kept_and_another_name_taken(tmp_path):
    for number in range(3):
        with flac(tmp_path, None).make() as sink:
            sink.write(next(blocks(voice(0.1, number))))
            assert info_of(sink).address.endswith(("voice.flac", "voice-2.flac", "voice-3.flac")[number])
    assert len(list((tmp_path / "folder").iterdir())) == 3
    assert np.array_equal(flac(tmp_path, None).received(), next(blocks(voice(0.1, 0))).samples)


def test_a_file_that_is_named_without_a_folder_lies_with_the_recordings(tmp_path):
    rig = Rig("file", {"path": "take.wav"}, services(tmp_path / "recordings"), None)
    with rig.make():
        pass
    assert (tmp_path / "recordings" / "take.wav").stat().st_mode & 0o777 == 0o600


def test_a_gap_in_what_is_heard_is_a_gap_in_the_file(tmp_path):
    rig = flac(tmp_path, None)
    with rig.make() as sink:
        sink.write(VoiceBlock(np.full(10, 0.5, np.float32), 1000, 0.0))
        sink.write(VoiceBlock(np.full(10, 0.5, np.float32), 1100, 0.0))
    assert np.flatnonzero(rig.received()).tolist() == [*range(10), *range(100, 110)]
