"""`ross enroll`: what is taken for a recording, what is kept, what is deleted; each refusal is one line."""

import errno
import os

import numpy as np
import pytest
import soundfile

from ross_payload.audio.audio_files import BLOCK, read_mono
from ross_payload.voiceprint import speaker_model
from speaker_network import vowel


def test_enrolling_silence_is_refused_and_nothing_is_kept(run, tmp_path):
    path = tmp_path / "silence.wav"
    soundfile.write(path, np.zeros(48000), 16000)
    code, _, err = run("enroll", "anna", path)
    assert code == 2
    assert err.count("\n") == 1
    assert not list((tmp_path / "data").rglob("*anna*"))


@pytest.mark.parametrize(("scale", "rate"), [(1.0, 1_999_999_999), (1e30, 16000)], ids=["rate", "peak"])
def test_a_recording_of_no_sound_is_one_line(run, tmp_path, scale, rate):
    path = tmp_path / "odd.wav"
    soundfile.write(path, scale * vowel(), rate, subtype="DOUBLE")
    code, out, err = run("enroll", "ann", path)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert f"{path}: expected " in err
    assert not (tmp_path / "data").exists()


def test_of_a_long_recording_the_beginning_is_used_and_it_says_so(run, tmp_path, monkeypatch):
    monkeypatch.setattr(speaker_model, "LONGEST", 4.0)
    voice, long, short = vowel(), tmp_path / "long.wav", tmp_path / "short.wav"
    soundfile.write(short, voice, 16000)
    soundfile.write(long, np.concatenate([voice, np.full(16000, 0.5)]), 16000)
    assert run("enroll", "ann", short)[2] == ""
    assert run("enroll", "bob", long)[2] == f"{long}: the first 4 s are used, the rest is left out\n"
    ann, bob = (tmp_path / "data" / "ross" / "voices" / f"{name}.json" for name in ("ann", "bob"))
    assert ann.read_bytes() == bob.read_bytes()


def test_a_voice_that_finds_a_full_disk_is_no_bad_input_and_the_old_print_stays(run, tmp_path, monkeypatch):
    path, kept = tmp_path / "voice.wav", tmp_path / "data" / "ross" / "voices" / "ann.json"
    soundfile.write(path, vowel(), 16000)
    assert run("enroll", "ann", path)[0] == 0
    before = kept.read_bytes()

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    assert run("enroll", "ann", path) == (
        1,
        "",
        f"ross: {kept}: the voice print cannot be written: No space left on device\n",
    )
    assert kept.read_bytes() == before
    assert [each.name for each in kept.parent.iterdir()] == ["ann.json"]


@pytest.mark.parametrize("form", ["wav", "flac"])
def test_a_recording_is_read_as_the_mean_of_its_channels(tmp_path, form):
    path = tmp_path / f"three.{form}"
    soundfile.write(path, np.random.default_rng(0).uniform(-0.5, 0.5, (BLOCK + 1000, 3)), 16000)
    samples, rate, goes_on = read_mono(path)
    np.testing.assert_array_equal(samples, soundfile.read(path)[0].mean(axis=1))
    assert (rate, goes_on) == (16000, False)
    first, _, goes_on = read_mono(path, 0.5)
    np.testing.assert_array_equal(first, samples[:8000])
    assert goes_on


def test_channels_of_opposite_polarity_are_named_and_not_taken_for_clipping(run, tmp_path):
    """As from a balanced cable in a stereo jack: half a step is left of what cancels."""
    path, voice = tmp_path / "opposite.wav", vowel()
    soundfile.write(path, np.stack([voice, -voice], axis=1), 16000)
    assert run("enroll", "ann", path) == (
        2,
        "",
        f"ross: {path}: expected channels to add up, got some that cancel the others: invert these\n",
    )
    soundfile.write(path, np.stack([voice, np.zeros_like(voice)], axis=1), 16000)
    assert run("enroll", "ann", path)[0] == 0


def test_forgetting_somebody_unknown_says_so(run):
    code, _, err = run("enroll", "nobody", "--forget")
    assert code == 2
    assert "nobody" in err


def test_forgetting_and_enrolling_at_once_is_refused_and_nothing_is_deleted(run, tmp_path):
    (tmp_path / "data" / "ross" / "voices").mkdir(parents=True)
    kept = tmp_path / "data" / "ross" / "voices" / "anna.json"
    kept.write_text("{}")
    assert run("enroll", "anna", "a.flac", "--forget") == (
        2,
        "",
        "ross: AUDIO: expected none with --forget, got a.flac\n",
    )
    assert kept.exists()


def test_a_folder_is_no_audio_and_no_network(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    expected = f"ross: {tmp_path}: expected an audio file, got a folder\n"
    assert run("enroll", "anna", tmp_path) == (2, "", expected)
    os.mkfifo(tmp_path / "pipe")
    assert run("enroll", "anna", "pipe") == (2, "", "ross: pipe: expected an audio file, got a named pipe\n")
    assert run("voice-model", "add", ".")[2].endswith("as the name of a file, got '.'\n")
