"""From what a network says to ratios: what is compared, and how it is weighed."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from ross_payload.alignment.plan import isolation
from ross_payload.interfaces import Clip
from ross_payload.voiceprint.built_in import built_in_model
from ross_sim.study import calibrate_voice_model
from ross_sim.study.calibrate_voice_model import (
    BUILT_IN_MARGIN,
    BUILT_IN_POOR_MARGIN,
    MARGIN,
    POOR,
    POOR_MARGIN,
    SOFTER_DB,
    Comparison,
    Crowd,
    calibration,
    comparisons,
    fitted,
    headings_for,
)
from ross_sim.study.scenes.mixtures import RATE, layouts, record
from ross_sim.study.scenes.room_settings import SETTINGS, SPACING, SPEED_OF_SOUND
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
        return Clip(parts[target])

    monkeypatch.setattr(calibrate_voice_model, "separated_at", separated)
    found = list(comparisons(crowd, "S1", 4, draws=2, seed=0))
    assert [round(seconds, 1) for _, seconds in heard[:4]] == [3.0, 3.3, 3.3, 3.3]
    assert len(found) == 2 * 4 * 2 * len(NAMES)
    assert all((each.similarity == pytest.approx(2.0)) == each.own for each in found)
    assert sum(each.own for each in found) == 2 * 4 * 2


def test_a_voice_of_which_nothing_can_be_compared_tells_nothing(crowd, monkeypatch):
    monkeypatch.setattr(calibrate_voice_model, "separated_at", lambda *_, **__: Clip(np.zeros(0)))
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
    slope, threshold = fitted([small, large], MARGIN)
    again = fitted([small * 3, large], MARGIN)
    assert again == pytest.approx((slope, threshold), abs=0.02)
    assert 0.3 < threshold - 1 / slope < 0.5  # between those of the rooms, 0.3 and 0.5


def similarities(mean: float, poorness: float = 0.0) -> list[Comparison]:
    """Of 30 targets and 90 strangers, who are less alike."""
    rng = np.random.default_rng(0)
    targets = [Comparison(3.0, float(value), True, poorness) for value in rng.normal(mean, 0.1, 30)]
    return targets + [Comparison(3.0, float(value), False, poorness) for value in rng.normal(mean - 0.4, 0.1, 90)]


@pytest.mark.parametrize(
    ("model", "margins"),
    [
        (SimpleNamespace(fingerprint="of a network"), (MARGIN, POOR_MARGIN)),
        (built_in_model(), (BUILT_IN_MARGIN, BUILT_IN_POOR_MARGIN)),
    ],
)
@pytest.mark.parametrize("poorness", [POOR + 0.1, POOR - 0.1])
def test_poor_voices_are_read_by_themselves(monkeypatch, tmp_path, poorness, model, margins):
    asked = []

    def compared(crowd, room, talkers, draws, seed, *, softer_db):
        asked.append((room, talkers, softer_db))
        soft = similarities(0.1, poorness) if softer_db else []
        long = [replace(each, seconds=10.0) for each in similarities(0.5)]
        return [*similarities(0.5), *long, *soft]

    voices = [TalkerVoice(name, np.ones(12 * RATE), np.ones(RATE), RATE) for name in NAMES]
    monkeypatch.setattr(calibrate_voice_model, "comparisons", compared)
    monkeypatch.setattr(calibrate_voice_model, "load_folder", lambda *_: voices)
    monkeypatch.setattr(calibrate_voice_model, "enrol", lambda *_: SimpleNamespace(embedding=np.ones(1)))
    found = calibration(model, tmp_path, ("S1", "S2"), 2, 0)
    assert set(asked) == {(room, k, softer) for room in ("S1", "S2") for k in (3, 4) for softer in (0.0, SOFTER_DB)}
    slope, threshold = fitted([similarities(0.5)] * 4, margins[0])
    assert (found.slopes, found.thresholds) == ((slope, slope), (threshold, threshold))
    assert found.poor == (fitted([similarities(0.1)], margins[1]) if poorness > POOR else None)


def test_a_target_is_softer_than_the_others_by_so_much():
    rng = np.random.default_rng(0)
    voices = [rng.standard_normal(RATE) for _ in range(3)]
    azimuths = np.deg2rad([170.0, 70.0, -50.0])
    loud, soft = (
        record(voices, azimuths, 1, 0.0, SETTINGS["S1"], rng=np.random.default_rng(1), softer_db=softer)
        for softer in (0.0, 10.0)
    )
    level = 20 * np.log10(np.std(soft.images[:, 0], axis=1) / np.std(loud.images[:, 0], axis=1))
    assert level == pytest.approx([0.0, -10.0, 0.0], abs=1e-6)
