"""Audio files of any name that the system allows, also where its bytes are no text in UTF-8."""

import os

import numpy as np
import pytest

from ross_payload.audio.audio_files import read_audio, read_mono, write_wav
from ross_payload.audio.channel_map import ChannelMap
from ross_payload.audio.file_source import FileSource
from ross_payload.clock import SystemClock
from ross_payload.config import Audio
from ross_payload.errors import AudioError
from ross_payload.ground.flights.sound import _rate, _tracks
from ross_sim.talkers import speech

RATE = 16000


@pytest.fixture
def path(tmp_path):
    folder = tmp_path / os.fsdecode(b"recordings of Zo\xeb")
    folder.mkdir()
    write_wav(folder / "voice.wav", np.random.default_rng(0).uniform(-0.1, 0.1, (2, RATE)), RATE)
    return folder / "voice.wav"


def test_a_file_is_written_and_read(path):
    samples, rate = read_audio(path)
    assert (samples.shape, rate) == ((RATE, 2), RATE)
    assert read_mono(path)[0].shape == (RATE,)
    assert speech.read(path, RATE).shape == (RATE,)
    assert [each.name for each in path.parent.iterdir()] == ["voice.wav"]


def test_a_file_is_a_source_of_the_payload(path):
    with FileSource(path, RATE, ChannelMap.of(Audio()), SystemClock()) as source:
        assert source.read(160).samples.shape == (2, 160)


def test_a_track_of_a_flight_is_found(path):
    assert _rate({"audio": path}) == RATE
    assert [track.rate for track in _tracks({"audio": path}, {"audio": 0.0})] == [RATE]


def test_what_is_no_audio_is_refused_in_one_line(path):
    path.write_bytes(b"text")
    with pytest.raises(AudioError, match="expected audio that libsndfile can read"):
        read_audio(path)
