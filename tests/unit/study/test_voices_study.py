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
from ross_sim.study import voiceprint_study
from ross_sim.study.rows import voice_print_rows
from ross_sim.study.rows.voice_print_rows import (
    NEAR,
    VoicePrintRow,
    equal_error_rate,
    errors,
    intervals,
    split,
    voice_prints,
)
from ross_sim.study.scenes.room_settings import SETTINGS
from ross_sim.study.training import calibration_voices
from ross_sim.study.voiceprint_study import separated_voice
from ross_sim.talkers.speech import TalkerVoice, load_folder
from speaker_network import vowel

RATE = 24000


def row(room, targets, near, mixture=0, **changes):
    return replace(VoicePrintRow("built-in", room, 0, mixture, 3.0, targets, 4, near), **changes)


def lines(rows):
    return {line[0]: line[1:] for line in voice_prints(rows).rows}


def test_every_room_has_a_line_of_its_own_errors():
    assert lines([row("S1", (1.0, 2.0), (0.4,)), row("S2", (-1.0, 0.0), (0.6, 0.7, 0.8, 0.9))]) == {
        "S1, 3 s": ("2, 4", "0.0 (0-0)", "0.0 (0-0)", "0.0 (0-0)"),
        "S2, 3 s": ("2, 4", "100.0 (100-100)", "100.0 (100-100)", "100.0 (100-100)"),
    }


def test_the_rooms_have_lines_together_and_by_seed_which_leave_the_open_one_out(monkeypatch):
    monkeypatch.setattr(voice_print_rows, "REDRAWN", 100)
    found = [row("S1", (-9.0,), ()), row("S2", (1.0,), ()), row("S3", (-1.0,), (0.6, 0.1))]
    made = lines(found)
    assert list(made) == ["S1, 3 s", "S2, 3 s", "S3, 3 s", "rooms together, 3 s"]
    assert made["rooms together, 3 s"][0] == "2, 8"
    assert made["rooms together, 3 s"][2:] == ("50.0 (50-50)", "12.5 (12-12)")  # the mixture of both rooms is one
    made = lines([*found, row("S2", (2.0, 3.0), (), seed=1)])
    assert made["rooms together, 3 s"][2] == "25.0 (0-50)"
    assert made["rooms together, seed 1, 3 s"] == ("2, 4", "0.0 (0-0)", "0.0 (0-0)", "0.0 (0-0)")


def test_models_have_lines_of_their_own():
    assert list(lines([row("S1", (1.0,), ()), row("S1", (1.0,), (), model="net")])) == [
        "built-in, S1, 3 s", "net, S1, 3 s"
    ]  # fmt: skip


def test_an_interval_is_as_wide_as_mixtures_differ():
    alike = [row("S1", (1.0,), (), mixture) for mixture in range(9)]
    assert np.all(intervals(alike) == 0.0)
    low, high = intervals([row("S1", (-2.0,), ()), *alike[1:]])
    assert low[1] == 0.0 < 1 / 9 < high[1] < 0.5


def test_the_equal_error_rate_needs_no_more_of_strangers_than_that_they_are_far():
    rng = np.random.default_rng(0)
    targets, strangers = rng.normal(4.0, 3.0, 50), rng.normal(-4.0, 3.0, 2000)
    values, same = np.concatenate([targets, strangers]), np.arange(2050) < 50
    found = VoicePrintRow("built-in", "S1", 0, 0, 3.0, *split(values, same))
    assert (len(found.targets), found.strangers) == (50, 2000)
    assert len(found.near) == np.sum(np.round(strangers, 2) > NEAR) < 600
    assert errors([found])[0] == equal_error_rate(np.round(targets, 2), np.round(strangers, 2))


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
    monkeypatch.setattr(voiceprint_study, "DURATIONS", (3.0,))
    made = []
    monkeypatch.setattr(voiceprint_study, "enrol", lambda *told: made.append((told[0], enrol(*told))) or made[-1][1])
    (found,) = voiceprint_study.measured(voices, {"built-in": built_in_model()}, "S1", 1, 0)
    prints = {voice.name: print_ for voice in voices for clip, print_ in made if clip is voice.enrolment}
    own = [prints[voice.name].score(voice.speech, VOICE_RATE).value for voice in voices]
    assert found.targets == pytest.approx(own, abs=0.006)
    others = [
        prints[name].score(voice.speech, VOICE_RATE).value for voice in voices for name in prints if name != voice.name
    ]
    assert found.strangers == 6
    assert found.near == pytest.approx([value for value in others if round(value, 2) > NEAR], abs=0.006)
    assert all(value > 0 for value in found.targets)


def test_the_built_in_model_is_calibrated_by_whole_voices(monkeypatch, tmp_path):
    voices = [TalkerVoice(name, vowel(220.0, 900.0, seconds=11.0), vowel(220.0, 900.0), RATE) for name in "abc"]
    monkeypatch.setattr(voiceprint_study, "dominant", lambda separated, *_: [Clip(voice[:9600]) for voice in separated])
    monkeypatch.setattr(calibration_voices, "ROOMS", ("S1",))
    monkeypatch.setattr(calibration_voices, "N_SCENES", {"others": 1})
    monkeypatch.setattr(voiceprint_study, "DURATIONS", (3.0,))
    calibration_voices.heard_in_rooms("others", [voices], tmp_path, 0)
    with np.load(next(tmp_path.rglob("others-S1-00.npz"))) as kept:
        assert {len(voice) for voice in kept.values()} == {3 * VOICE_RATE}
