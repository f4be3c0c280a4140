"""Files of one voice: every sample at its place, and readable wherever they are cut off."""

import os
import stat
from contextlib import suppress

import numpy as np
import pytest
import soundfile

from full_disk import fill
from ross_payload.audio.sinks import SinkServices, checked_options, make_sink
from ross_payload.audio.track_files import FLAC_BLOCK, SUFFIXES, AlignedTrack
from ross_payload.clock import SystemClock
from ross_payload.errors import ConfigError

RATE = 16000
GRID = 2.0**-23
VOICE = (np.random.default_rng(0).integers(-(2**20), 2**20, 5 * RATE) * GRID).astype(np.float32)


@pytest.fixture(params=SUFFIXES)
def path(request, tmp_path):
    return tmp_path / f"voice{request.param}"


def read(path):
    samples, rate = soundfile.read(path, dtype="float32")
    assert rate == RATE
    return samples


def test_what_was_written_is_read_to_the_last_bit(path):
    track = AlignedTrack(path, RATE)
    for begin in range(0, len(VOICE), 256):
        track.write(begin, VOICE[begin : begin + 256])
    track.close()
    track.close()
    assert np.array_equal(read(path), VOICE)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_a_gap_is_silence_and_what_comes_twice_is_written_once(path):
    track = AlignedTrack(path, RATE)
    track.write(-100, VOICE[:300])  # the first hundred lie before the file
    track.write(150, VOICE[250:350])
    track.write(20_000, VOICE[:10])
    track.close()
    expected = np.zeros(20_010, np.float32)
    expected[:250], expected[20_000:] = VOICE[100:350], VOICE[:10]
    assert np.array_equal(read(path), expected)


@pytest.mark.parametrize("step", [256, 1000, 6000])
def test_a_killed_process_loses_less_than_a_third_of_a_second(path, step):
    child = os.fork()
    if not child:
        track = AlignedTrack(path, RATE)
        for begin in range(0, len(VOICE), step):
            track.write(begin, VOICE[begin : begin + step])
        os._exit(9)  # nothing is closed
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9
    found = read(path)
    assert len(VOICE) - FLAC_BLOCK - 1 <= len(found) <= len(VOICE)
    assert np.array_equal(found, VOICE[: len(found)])


def test_a_disk_that_fills_is_an_oserror_and_the_file_can_be_closed(path):
    track = AlignedTrack(path, RATE)
    track.write(0, VOICE[:RATE])
    fill(path)
    for _ in range(3):
        with pytest.raises(OSError):
            track.write(RATE, VOICE[RATE:])
    with suppress(OSError):
        track.close()
    track.close()
    assert path.stat().st_size


def test_a_file_that_is_there_is_left_alone(path):
    path.write_bytes(b"precious")
    with pytest.raises(FileExistsError):
        AlignedTrack(path, RATE)
    assert path.read_bytes() == b"precious"


def test_another_format_is_refused(tmp_path):
    with pytest.raises(ConfigError, match=r"expected a name that ends in \.flac or \.wav, got 'voice\.mp3'"):
        AlignedTrack(tmp_path / "voice.mp3", RATE)
    assert not list(tmp_path.iterdir())


def test_what_is_beyond_full_scale_is_clipped(path):
    track = AlignedTrack(path, RATE)
    track.write(0, np.array([2.0, -2.0, 0.5], np.float32))
    track.close()
    assert read(path).tolist() == [1 - GRID, -1.0, 0.5]


def test_a_process_that_is_killed_behind_a_whole_block_leaves_a_file_that_is_read(tmp_path):
    """libFLAC keeps the last block until one more sample has come: the header may not count it before."""
    path, blocks = tmp_path / "voice.flac", 4
    child = os.fork()
    if not child:
        AlignedTrack(path, RATE).write(0, VOICE[: blocks * FLAC_BLOCK])
        os._exit(9)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9
    found = read(path)
    assert len(found) in ((blocks - 1) * FLAC_BLOCK, blocks * FLAC_BLOCK)
    assert soundfile.info(path).frames == len(found)
    assert np.array_equal(found, VOICE[: len(found)])


@pytest.mark.parametrize(("named", "place"), [("./a.flac", "here"), ("new/a.flac", "here/new"), ("a.flac", "tapes")])
def test_a_sink_writes_where_it_is_told_in_folders_for_its_owner_alone(tmp_path, monkeypatch, named, place):
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    services = SinkServices(SystemClock(), RATE, 0, "target", tmp_path / "tapes")
    with make_sink("file", checked_options("file", {"path": named}, "options"), services):
        written = tmp_path / place / "a.flac"
        assert stat.S_IMODE(written.stat().st_mode) == 0o600
    assert place == "here" or stat.S_IMODE(written.parent.stat().st_mode) == 0o700
