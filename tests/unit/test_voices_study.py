"""The study of the voice print: which rooms it tells apart, and what its errors count."""

from dataclasses import replace

import numpy as np
import pytest
import soundfile

from examples import rows_in_soak
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Clip
from ross_payload.voiceprint import built_in_model, enrol
from ross_payload.voiceprint.features import RATE as VOICE_RATE
from ross_sim.study import calibration_voices, voiceprint_study
from ross_sim.study.room_settings import SETTINGS
from ross_sim.study.voiceprint_study import Trial, intervals, separated_voice, summary
from ross_sim.talkers.speech import TalkerVoice, load_folder
from speaker_network import vowel

RATE = 24000


def trial(room, talker, print_of, value, present=True):
    return Trial(room, 0, 3.0, True, talker, print_of, present, value)


def test_every_room_has_a_line_of_its_own_errors():
    found = [trial("S1", "a", "a", 1.0), trial("S1", "b", "a", -1.0), trial("S1", "b", "c", -1.0, present=False)]
    found += [trial("S2", "a", "a", -1.0), trial("S2", "b", "a", 1.0), trial("S2", "b", "c", 1.0, present=False)]
    rows = [line.split() for line in summary(found)[1:]]
    assert [row[0] for row in rows] == ["S1", "S2"]
    assert [row[4:8] for row in rows] == [["0.0", "(0-0)"] * 2, ["100.0", "(100-100)"] * 2]  # false rejects, accepts


def test_the_rooms_have_a_line_together_which_leaves_the_open_one_out(monkeypatch):
    monkeypatch.setattr(voiceprint_study, "REDRAWN", 100)
    found = []
    for room, value in (("S1", 9.0), ("S2", 1.0), ("S3", -1.0)):
        found += [trial(room, "a", "a", value), trial(room, "b", "a", -5.0), trial(room, "b", "c", -5.0, present=False)]
    lines = [line.split() for line in summary(found)[1:]]
    assert [line[0] for line in lines] == ["S1", "S2", "S3", "rooms"]
    assert lines[-1][4:6] == ["50.0", "(0-100)"]  # one of two, and whichever is drawn
    assert "(2 targets, 4 strangers)" in summary(found)[-1]
    assert lines[-1][10] == "100.0"  # each is compared with whom it shares a mixture


def test_an_interval_is_as_wide_as_mixtures_differ():
    alike = [
        Trial("S1", scene, 3.0, True, who, "a", True, value)
        for scene in range(9)
        for who, value in (("a", 1.0), ("b", -1.0))
    ]
    assert np.all(intervals(alike) == 0.0)
    one_fails = [replace(each, value=-2.0) if (each.scene, each.talker) == (0, "a") else each for each in alike]
    low, high = intervals(one_fails)
    assert low[0] == 0.0 < 1 / 9 < high[0] < 0.5


@pytest.mark.parametrize(("room", "least"), rows_in_soak(("S1", 0.8), ("S2", 0.5)))
def test_the_separated_voice_is_most_of_all_like_its_talker(room, least):
    rng = np.random.default_rng(0)
    t = np.arange(2 * RATE) / RATE
    envelopes = [np.sin(2 * np.pi * rate * t) > 0 for rate in (1.0, 1.7, 2.3)]
    voices = [envelope * rng.standard_normal(t.size) for envelope in envelopes]
    voice = separated_voice(voices, np.deg2rad([170.0, 70.0, -50.0]), 0, SETTINGS[room], rng).samples
    loudness = voice.reshape(-1, 1200).std(axis=1)
    alike = [np.corrcoef(loudness, other.reshape(-1, 1200).std(axis=1))[0, 1] for other in voices]
    assert alike[0] > least
    assert alike[0] > max(alike[1:])


def test_some_talkers_of_a_folder_are_read_and_the_others_left_alone(tmp_path):
    for name in ("ann", "bob"):
        soundfile.write(tmp_path / f"{name}.wav", np.random.default_rng(0).uniform(-0.1, 0.1, 6 * RATE), RATE)
    (tmp_path / "short.wav").write_bytes(b"no recording")
    assert [voice.name for voice in load_folder(tmp_path, RATE, ("bob", "cleo"))] == ["bob"]
    with pytest.raises(ConfigError, match="short"):
        load_folder(tmp_path, RATE)


@pytest.mark.soak
def test_every_separated_voice_is_scored_against_every_print(monkeypatch):
    """The scores are those of the prints themselves, though a voice is embedded once."""
    clips = {"ann": (220.0, 900.0), "bob": (110.0, 500.0), "cleo": (180.0, 1500.0)}
    voices = [
        TalkerVoice(name, vowel(*sound, seconds=2.0), vowel(*sound, seconds=3.0, seed=1), VOICE_RATE)
        for name, sound in clips.items()
    ]
    monkeypatch.setattr(voiceprint_study, "RATE", VOICE_RATE)
    heard = [(3.0, True, voices, voice.name, Clip(voice.speech)) for voice in voices]
    monkeypatch.setattr(voiceprint_study, "scenes", lambda *_: iter(heard))
    made = []
    monkeypatch.setattr(voiceprint_study, "enrol", lambda *told: made.append((told[0], enrol(*told))) or made[-1][1])
    found = list(voiceprint_study.trials(voices, built_in_model(), "S1", 1, 0))
    assert len(found) == 9
    prints = {voice.name: print_ for voice in voices for clip, print_ in made if clip is voice.enrolment}
    for each in found:
        voice = next(voice for voice in voices if voice.name == each.talker)
        assert each.value == pytest.approx(prints[each.print_of].score(voice.speech, VOICE_RATE).value)
    assert all(each.value > 0 for each in found if each.talker == each.print_of)


def test_the_built_in_model_is_calibrated_by_whole_voices(monkeypatch, tmp_path):
    voices = [TalkerVoice(name, vowel(220.0, 900.0, seconds=11.0), vowel(220.0, 900.0), RATE) for name in "abc"]
    monkeypatch.setattr(voiceprint_study, "dominant", lambda separated, *_: [Clip(voice[:9600]) for voice in separated])
    monkeypatch.setattr(calibration_voices, "ROOMS", ("S1",))
    monkeypatch.setattr(calibration_voices, "N_SCENES", {"others": 1})
    monkeypatch.setattr(voiceprint_study, "DURATIONS", (3.0,))
    calibration_voices.heard_in_rooms("others", [voices], tmp_path, 0)
    with np.load(next(tmp_path.rglob("others-S1-00.npz"))) as kept:
        assert {len(voice) for voice in kept.values()} == {3 * VOICE_RATE}
