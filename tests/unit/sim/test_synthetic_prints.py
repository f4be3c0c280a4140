"""Prints of synthetic talkers are kept; those of people are not."""

import importlib.util
from dataclasses import replace

import numpy as np
import pytest

from ross_payload.voiceprint import BuiltInModel, built_in_model, enrol
from ross_sim.scenario import load
from ross_sim.sitl.talker_selection import talkers_of
from ross_sim.talkers import synthetic_prints
from ross_sim.talkers.speech import TalkerVoice
from ross_sim.talkers.synthetic_prints import synthetic_print
from voice_folders import voice_folder

RATE = 16000


def buzz(pitch=120):
    """Two seconds that are voiced: the harmonics of a pitch [Hz]."""
    time = np.arange(2 * RATE) / RATE
    said = sum(np.sin(2 * np.pi * pitch * k * time) / k for k in range(1, 20)) * (1 + 0.5 * np.sin(8 * time))
    return TalkerVoice("buzz", np.zeros(0, np.float32), np.asarray(0.05 * said, np.float32), RATE)


def kept(folder):
    return sorted((folder / "prints").iterdir())


def test_a_print_is_that_of_enrolling_to_the_last_bit_and_is_made_once(tmp_path, monkeypatch):
    made = enrol(buzz().enrolment, RATE)
    synthetic_print(buzz(), built_in_model(), tmp_path)
    monkeypatch.setattr(synthetic_prints, "enrol", None)
    again = synthetic_print(buzz(), built_in_model(), tmp_path)
    assert np.array_equal(again.embedding, made.embedding)
    assert replace(again, embedding=0) == replace(made, embedding=0)


@pytest.mark.soak
def test_another_voice_model_or_code_makes_a_print_of_its_own(tmp_path, monkeypatch):
    model = built_in_model()
    other = BuiltInModel(replace(model.parameters, centre=model.parameters.centre + 0.01))
    synthetic_print(buzz(), model, tmp_path)
    synthetic_print(buzz(121), model, tmp_path)
    changed = synthetic_print(buzz(), other, tmp_path)
    assert changed.fingerprint == other.fingerprint != model.fingerprint
    assert len(kept(tmp_path)) == 3
    monkeypatch.setattr(synthetic_prints, "_code", lambda: "another")
    synthetic_print(buzz(), model, tmp_path)
    assert len(kept(tmp_path)) == 4


@pytest.mark.skipif(importlib.util.find_spec("espeakng_loader") is None, reason="needs the package espeakng-loader")
def test_a_print_of_a_recording_is_never_kept(tmp_path, monkeypatch):
    (tmp_path / "speech").mkdir()
    voice_folder(tmp_path / "speech", (0,), 6)
    monkeypatch.setenv("ROSS_CACHE", str(tmp_path / "cache"))
    assert talkers_of(load("one-talker"), tmp_path / "speech", None).synthetic is None
    assert not (tmp_path / "cache").exists()
