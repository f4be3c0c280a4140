"""What the explorer's regressions are fitted to where the noise of a vehicle is learnt."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from ross_payload.localization.joint import Joint
from ross_payload.localization.talker_evidence import FEATURES, IN_NOISE
from ross_sim.study import fit_evidence_in_noise
from ross_sim.study.fit_evidence_in_noise import N_TALKERS, descents, noisy_scenes, played
from ross_sim.study.scenes.mixtures import RATE
from rotor_scenes import SPACING, SPEED_OF_SOUND, observations


def test_propellers_are_never_heard_as_they_were_recorded():
    clip = np.arange(1000, dtype=np.float32)
    assert [round(each.size / clip.size, 1) for each in played([clip])] == [1.2, 0.8]
    assert all(each[100] > each[-100] for each in played([clip]))


def test_scenes_follow_from_their_numbers(monkeypatch):
    asked = []
    monkeypatch.setattr(fit_evidence_in_noise, "scene", lambda *args, **named: asked.append((args[:3], named["key"])))
    for _ in range(2):
        list(noisy_scenes([np.zeros(RATE, np.float32)], (), 10, 7))
    assert asked[:10] == asked[10:]
    assert {args[2] for args, _ in asked} == {"recorded", "drifting", "synthetic", "wind"}
    assert {args[0] for args, _ in asked} <= set(N_TALKERS)


@pytest.mark.soak
def test_sources_among_rotors_have_as_many_numbers_as_weights(monkeypatch):
    monkeypatch.setattr(fit_evidence_in_noise, "ROTATIONS", (5,))
    heard = SimpleNamespace(name="made-1-0-1", azimuths=np.array([1.6]))
    (found,) = descents(heard, observations([1.6]), Joint(SPACING, SPEED_OF_SOUND))
    assert found.talkers == 1
    assert {row.features.shape[1] for row in found.rows} == {len(FEATURES) + len(IN_NOISE)}
    assert found.rows[-1].somebody.tolist() == [True]
