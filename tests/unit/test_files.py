import os
from pathlib import Path

import numpy as np
import pytest
import soundfile

from ross_payload.audio.files import WavWriter, read_mono, write_wav
from ross_payload.errors import AudioError, OutputError


def test_written_samples_come_back_on_the_24_bit_grid(tmp_path):
    samples = np.random.default_rng(1).uniform(-1, 1, (2, 1000))
    write_wav(tmp_path / "a.wav", samples, 16000)
    back, rate = soundfile.read(tmp_path / "a.wav", always_2d=True)
    assert rate == 16000
    np.testing.assert_allclose(back.T, samples, atol=2.0**-23)


def test_same_samples_make_the_same_bytes(tmp_path):
    samples = np.random.default_rng(2).uniform(-1, 1, 500)
    write_wav(tmp_path / "a.wav", samples, 16000)
    write_wav(tmp_path / "b.wav", samples, 16000)
    assert (tmp_path / "a.wav").read_bytes() == (tmp_path / "b.wav").read_bytes()


def test_a_file_appears_only_when_closed(tmp_path):
    path = tmp_path / "a.wav"
    path.write_bytes(b"the good old one")
    writer = WavWriter(path, 16000, 1)
    writer.write(np.zeros((1, 10)))
    assert path.read_bytes() == b"the good old one"
    writer.close()
    assert soundfile.info(path).frames == 10


def test_channels_are_averaged(tmp_path):
    write_wav(tmp_path / "a.wav", np.array([[0.5, 0.5], [0.0, -0.5]]), 8000)
    voice, rate = read_mono(tmp_path / "a.wav")
    assert rate == 8000
    np.testing.assert_allclose(voice, [0.25, 0.0], atol=1e-6)


def make_text(path):
    path.write_text("not audio")


def make_empty(path):
    soundfile.write(path, np.zeros(0), 16000)


def make_nan(path):
    soundfile.write(path, np.array([0.0, np.nan]), 16000, subtype="FLOAT")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda path: None, "no such file"),
        (make_text, "not audio"),
        (make_empty, "0 s"),
        (make_nan, "not finite"),
    ],
)
def test_bad_files_are_refused_in_one_line(tmp_path, make, words):
    path = tmp_path / "bad.wav"
    make(path)
    with pytest.raises(AudioError, match=words) as caught:
        read_mono(path)
    assert "\n" not in str(caught.value)
    assert "bad.wav" in str(caught.value)


def test_a_disk_that_fills_up_leaves_the_good_old_file(tmp_path):
    path = tmp_path / "a.wav"
    path.write_bytes(b"the good old one")
    writer = WavWriter(path, 16000, 1)
    with Path("/dev/full").open("wb") as full:
        os.dup2(full.fileno(), int(next(iter(descriptors(tmp_path / "a.wav.part")))))
    writer.write(np.zeros((1, 20)))
    with pytest.raises(OutputError, match=r"a\.wav: cannot be written"):
        writer.close()
    assert path.read_bytes() == b"the good old one"


def descriptors(path):
    for entry in Path("/proc/self/fd").iterdir():
        if entry.is_symlink() and entry.readlink() == path:
            yield entry.name
