import logging
import os

import numpy as np
import pytest
import soundfile

from ross_payload.errors import ConfigError
from ross_sim.talkers.speech import load_folder

RATE = 16000


def tone(seconds, rate=RATE, frequency=440.0):
    return 0.3 * np.sin(2 * np.pi * frequency * np.arange(round(seconds * rate)) / rate)


def write(path, samples, rate=RATE, **options):
    path.parent.mkdir(parents=True, exist_ok=True)
    soundfile.write(path, samples, rate, **options)


def test_sub_folders_and_files_are_talkers_sorted_by_name(tmp_path):
    write(tmp_path / "zoe" / "speech.wav", tone(6))
    write(tmp_path / "anna.flac", tone(6))
    (tmp_path / "README.txt").write_text("not a recording")
    assert [voice.name for voice in load_folder(tmp_path, RATE)] == ["anna", "zoe"]


def test_enrolment_clip_is_kept_apart_and_the_rest_joined_in_order(tmp_path):
    write(tmp_path / "anna" / "b.wav", tone(2, frequency=2000))
    write(tmp_path / "anna" / "a.wav", tone(3, frequency=500))
    write(tmp_path / "anna" / "Enrol-1.wav", tone(1.5))
    (voice,) = load_folder(tmp_path, RATE)
    assert voice.speech.size == 5 * RATE
    assert voice.enrolment.size == 1.5 * RATE
    assert np.abs(np.fft.rfft(voice.speech[:RATE])).argmax() == 500


def test_without_an_enrolment_clip_the_last_seconds_are_cut_off(tmp_path):
    whole = np.random.default_rng(1).uniform(-0.5, 0.5, 6 * RATE).astype(np.float32)
    write(tmp_path / "anna.wav", whole, subtype="FLOAT")
    (voice,) = load_folder(tmp_path, RATE)
    assert np.array_equal(np.concatenate([voice.speech, voice.enrolment]), whole)
    assert voice.enrolment.size == 4 * RATE


@pytest.mark.parametrize("original", [8000, 22050, 44100, 48000])
def test_any_rate_keeps_pitch_and_duration(tmp_path, original):
    write(tmp_path / "anna.wav", tone(8, original, 440.0), original)
    (voice,) = load_folder(tmp_path, RATE)
    assert voice.speech.size + voice.enrolment.size == pytest.approx(8 * RATE, abs=2)
    assert np.abs(np.fft.rfft(voice.speech[: 2 * RATE])).argmax() == 880


def test_channels_are_averaged(tmp_path):
    write(tmp_path / "anna.wav", np.stack([tone(6), np.zeros(6 * RATE)], axis=1))
    (voice,) = load_folder(tmp_path, RATE)
    assert np.abs(voice.speech).max() == pytest.approx(0.15, abs=0.001)


@pytest.mark.parametrize(
    ("samples", "message"),
    [
        (np.zeros(0), r"anna\.wav: is empty"),
        (np.zeros(6 * RATE), r"anna\.wav: is silent"),
        (np.full(6 * RATE, np.nan), r"anna\.wav: expected finite samples"),
        (1e30 * tone(6), r"anna\.wav: expected samples of at most 1e\+06 re full scale, got 3e\+29"),
        (tone(2), "talker 'anna': expected at least 5 s of speech without an enrolment clip, got 2.0 s"),
    ],
)
def test_useless_recording_is_refused_in_words(tmp_path, samples, message):
    write(tmp_path / "anna.wav", samples, subtype="FLOAT")
    with pytest.raises(ConfigError, match=message):
        load_folder(tmp_path, RATE)


def test_the_folder_of_one_talker_is_no_folder_of_talkers(tmp_path):
    write(tmp_path / "enrol.wav", tone(6))
    write(tmp_path / "speech.wav", tone(6))
    with pytest.raises(ConfigError, match=r"enrol\.wav: is an enrolment clip, without speech .* one sub-folder or"):
        load_folder(tmp_path, RATE)


def test_a_name_that_results_cannot_hold_is_refused_before_anything_is_done(tmp_path):
    """A file name of another encoding: before, the results of a mission and of a study ended in a traceback."""
    name = os.fsdecode(b"ren\xe9")
    write(tmp_path / "anna.wav", tone(6))
    write(tmp_path / "b.wav", tone(6))
    (tmp_path / "b.wav").rename(tmp_path / f"{name}.wav")
    with pytest.raises(ConfigError, match=f"talker '{name}': expected a name in UTF-8"):
        load_folder(tmp_path, RATE)
    assert [voice.name for voice in load_folder(tmp_path, RATE, only=["anna"])] == ["anna"]


def test_a_rate_that_no_recording_has_is_refused(tmp_path):
    soundfile.write(tmp_path / "anna.wav", tone(6), 1_999_999_999)
    with pytest.raises(ConfigError, match=r"anna\.wav: expected at most 192000 Hz, got 1999999999 Hz"):
        load_folder(tmp_path, RATE)


def test_file_that_is_no_recording_is_named(tmp_path):
    write(tmp_path / "anna.wav", tone(6))
    (tmp_path / "bert.wav").write_text("this is text")
    with pytest.raises(ConfigError, match=r"bert\.wav: not a recording that can be read: Format not recognised"):
        load_folder(tmp_path, RATE)


def test_missing_and_empty_folders_are_refused(tmp_path):
    with pytest.raises(ConfigError, match="no such folder"):
        load_folder(tmp_path / "nowhere", RATE)
    with pytest.raises(ConfigError, match="expected one sub-folder or one file"):
        load_folder(tmp_path, RATE)


def test_clipping_is_worth_a_warning_and_no_more(tmp_path, caplog):
    write(tmp_path / "anna.wav", np.clip(10 * tone(6), -1, 1))
    with caplog.at_level(logging.WARNING):
        assert len(load_folder(tmp_path, RATE)) == 1
    assert "anna.wav: is clipped" in caplog.text
