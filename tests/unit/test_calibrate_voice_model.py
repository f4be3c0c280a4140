"""From what a network says to ratios: what is compared, and how it is weighed."""

from types import SimpleNamespace

import numpy as np
import pytest

from ross_payload.alignment.plan import isolation
from ross_sim.study import calibrate_voice_model
from ross_sim.study.calibrate_voice_model import Comparison, Crowd, comparisons, fitted, headings_for
from ross_sim.study.mixtures import RATE, layouts
from ross_sim.study.room_settings import SETTINGS, SPACING, SPEED_OF_SOUND
from ross_sim.study.voiceprint_study import best_heading
from ross_sim.talkers.speech import TalkerVoice

NAMES = ("ann", "bob", "eve", "joe", "sue")


@pytest.fixture
def crowd():
    """Everybody says a number of their own, and is known by it."""
    voices = [TalkerVoice(name, np.full(12 * RATE, 1.0 + n), np.ones(RATE), RATE) for n, name in enumerate(NAMES)]
    model = SimpleNamespace(
        embed=lambda clip: np.eye(len(NAMES))[round(float(np.median(clip))) - 1],
        similarity=lambda enrolled, heard: 2 * float(enrolled @ heard),
    )
    return Crowd(model, voices, dict(zip(NAMES, np.eye(len(NAMES)), strict=True)))


def test_every_voice_is_heard_from_one_heading_for_3_s_and_from_three_for_10_and_compared_with_everybody(
    crowd, monkeypatch
):
    heard = []

    def separated(heading, parts, azimuths, target, **_):
        heard.append((len(parts), len(parts[target]) / RATE))
        return parts[target]

    monkeypatch.setattr(calibrate_voice_model, "separated_at", separated)
    found = list(comparisons(crowd, "S1", 4, draws=2, seed=0))
    assert [round(seconds, 1) for _, seconds in heard[:4]] == [3.0, 3.3, 3.3, 3.3]
    assert len(found) == 2 * 4 * 2 * len(NAMES)
    assert all((each.similarity == pytest.approx(2.0)) == each.own for each in found)
    assert sum(each.own for each in found) == 2 * 4 * 2


def test_a_voice_of_which_nothing_can_be_compared_tells_nothing(crowd, monkeypatch):
    monkeypatch.setattr(calibrate_voice_model, "separated_at", lambda *_, **__: np.zeros(0))
    monkeypatch.setattr(crowd.model, "embed", lambda clip: np.zeros(len(NAMES) + len(clip)))
    assert list(comparisons(crowd, "S1", 4, draws=1, seed=0)) == []


def test_headings_are_the_best_one_and_others_that_isolate_by_half_as_much(crowd):
    rng = np.random.default_rng(0)
    for azimuths in layouts(4, 5, rng)[1:]:
        for target in range(4):
            best, *others = headings_for(azimuths, target, SETTINGS["A0.45"], rng)
            assert best == best_heading(azimuths, target, SETTINGS["A0.45"])
            curve = isolation(azimuths, np.pi * np.arange(180) / 180, SPACING, SPEED_OF_SOUND)[target]
            assert np.all(isolation(azimuths, others, SPACING, SPEED_OF_SOUND)[target] >= 0.5 * curve.max() - 1e-12)


def test_rooms_count_alike_however_many_voices_were_heard_in_them():
    rng = np.random.default_rng(0)

    def part(n, shift):
        targets = [Comparison(3.0, float(value), own=True) for value in rng.normal(0.5 + shift, 0.1, n)]
        return targets + [Comparison(3.0, float(value), own=False) for value in rng.normal(0.1 + shift, 0.1, 4 * n)]

    small, large = part(200, 0.0), part(200, 0.2)
    slope, threshold = fitted([small, large])
    again = fitted([small * 3, large])
    assert again == pytest.approx((slope, threshold), abs=0.02)
    assert 0.3 < threshold - 1 / slope < 0.5  # between those of the rooms, 0.3 and 0.5
