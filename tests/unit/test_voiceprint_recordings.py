"""The voice print on people whom the background model has never heard."""

import os
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from ross_payload.voiceprint import enrol, shipped_background
from ross_payload.voiceprint.background import read_background
from ross_sim.study.train_voiceprint import main as train
from ross_sim.study.voice_augmentation import masked
from ross_sim.study.voiceprint_study import OUTSIDE, equal_error_rate
from ross_sim.talkers.speech import load_folder

pytestmark = pytest.mark.lockstep

SPEECH = Path(os.environ.get("ROSS_SPEECH", Path(__file__).parents[2] / ".." / "shared" / "speech"))
RATE = 16_000


@pytest.fixture(scope="module")
def people():
    if not SPEECH.is_dir():
        pytest.skip(f"no recordings in {SPEECH}; set ROSS_SPEECH")
    return {voice.name: voice for voice in load_folder(SPEECH, RATE) if voice.name in OUTSIDE}


@pytest.fixture(scope="module")
def prints(people):
    return {name: enrol(person.enrolment, RATE) for name, person in people.items()}


def clip(person, start, seconds):
    return person.speech[start * RATE : (start + seconds) * RATE].astype(float)


@pytest.mark.parametrize("start", [0, 30])
def test_ten_seconds_of_a_talker_score_highest_with_the_own_print(start, people, prints):
    for name, person in people.items():
        values = {other: model.score(clip(person, start, 10), RATE).value for other, model in prints.items()}
        assert max(values, key=values.get) == name
        assert values[name] > 0


@pytest.mark.soak
@pytest.mark.usefixtures("people")
def test_the_training_command_makes_the_shipped_model(tmp_path, monkeypatch):
    monkeypatch.setenv("ROSS_CACHE", str(tmp_path / "cache"))
    train(["--speech", str(SPEECH), "--seed", "0", str(tmp_path / "again.npz")])
    again, shipped = read_background((tmp_path / "again.npz").read_bytes(), "again.npz"), shipped_background()
    for field in fields(shipped):
        slack = 1 if field.name == "cohort" else 1e-3  # whole steps; another processor may round to the next
        np.testing.assert_allclose(getattr(again, field.name), getattr(shipped, field.name), rtol=1e-3, atol=slack)


def test_masked_voices_of_three_seconds_are_told_apart(people, prints):
    rng = np.random.default_rng(0)
    targets, strangers = [], []
    for name, person in people.items():
        others = [other.speech.astype(float) for key, other in people.items() if key != name]
        for start in (2, 12, 22, 32):
            voice = masked(clip(person, start, 3), others[:2], rng)
            for other, model in prints.items():
                (targets if other == name else strangers).append(model.score(voice, RATE).value)
    assert equal_error_rate(np.array(targets), np.array(strangers)) < 0.15
    assert np.mean(np.array(strangers) > 0) < 0.15
