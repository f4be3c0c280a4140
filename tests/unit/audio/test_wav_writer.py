"""A WAV file that is put in place when it is whole."""

import errno
import os
from pathlib import Path

import numpy as np
import pytest
import soundfile

from full_disk import fill
from ross_payload.audio.audio_files import BUFFER, WavWriter, write_wav
from ross_payload.errors import OutputError

RATE = 16_000
GOOD, LATER = np.full(RATE, 0.25), np.full((1, 4 * BUFFER), 0.5)


def test_a_file_that_the_disk_does_not_take_leaves_the_earlier_one(tmp_path):
    path = tmp_path / "target.wav"
    write_wav(path, GOOD, RATE)
    with pytest.raises(OutputError, match=r"^target\.wav: cannot be written"), WavWriter(path, RATE, 1) as writer:
        writer.write(LATER)
        (part,) = set(tmp_path.iterdir()) - {path}
        fill(part)
        for _ in range(100):
            writer.write(LATER)
    assert list(tmp_path.iterdir()) == [path]
    assert np.array_equal(soundfile.read(path)[0], GOOD)


def test_a_file_that_cannot_be_deleted_either_is_told_in_one_line(tmp_path, monkeypatch):
    """As on a card that fails: the system writes to none of its files from then on."""

    def refused(path, missing_ok=False):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    with (
        pytest.raises(OutputError, match=r"^target\.wav: cannot be written: Read-only file system$"),
        WavWriter(tmp_path / "target.wav", RATE, 1) as writer,
    ):
        fill(next(tmp_path.iterdir()))
        monkeypatch.setattr(Path, "unlink", refused)
        writer.write(LATER)
    assert [path.name for path in tmp_path.iterdir() if ".part" not in path.name] == []


def test_what_was_heard_before_something_else_went_wrong_is_kept(tmp_path):
    path = tmp_path / "mixture.wav"
    with pytest.raises(ValueError), WavWriter(path, RATE, 1) as writer:
        writer.write(LATER)
        raise ValueError
    assert soundfile.info(path).frames == LATER.shape[1]


def test_a_file_that_cannot_be_begun_is_told_by_its_own_name(tmp_path, monkeypatch):
    def full(*args, **options):
        raise soundfile.LibsndfileError(2, prefix=f"Error opening {args[0]!r}: ")

    monkeypatch.setattr("ross_payload.audio.audio_files.soundfile.SoundFile", full)
    with pytest.raises(OutputError) as caught:
        WavWriter(tmp_path / "target.wav", RATE, 1)
    assert str(caught.value) == "target.wav: cannot be written: is the disk full? (System error.)"
    assert list(tmp_path.iterdir()) == []
