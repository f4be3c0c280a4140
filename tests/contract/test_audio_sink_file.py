"""A voice in a file: on a full disk, beside others of its name, with its gaps, and for nobody else to read."""

from __future__ import annotations

import numpy as np
import pytest

from full_disk import fill
from ross_payload.audio.sinks import info_of
from ross_payload.errors import AudioError
from ross_payload.interfaces import VoiceBlock
from sink_bench import RATE, Rig, blocks, flac, services, voice

pytestmark = pytest.mark.process


def test_a_full_disk_is_a_fault_and_what_is_not_written_is_counted(tmp_path):
    rig = flac(tmp_path, None)
    with rig.make() as sink:
        for block in blocks(voice(1.0)):
            sink.write(block)
        fill(rig.path)
        for block in blocks(voice(2.0), RATE):
            sink.write(block)
        assert sink.fault == f"{rig.path}: cannot be written: No space left on device"
        assert sink.lost > RATE
    assert len(rig.received()) > RATE / 2


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
