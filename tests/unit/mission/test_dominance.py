"""Of a voice that holds much of the others the parts are compared in which it dominates, of a clean one everything."""

from dataclasses import dataclass, field, replace
from functools import cache
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from mission_bench import Likes, OneGroupEach, rig
from ross_payload.events import Outcome, Separated
from ross_payload.interfaces import Clip, Groups, Quality, VoicePrint
from ross_payload.mission.identify_target import CERTAIN, beyond_doubt
from ross_payload.mission.voice_evidence import Evidence, lone_voices
from ross_payload.voiceprint import enrol
from ross_payload.voiceprint.dominance import GOOD, POOR, SOFT, dominant
from ross_sim.talkers.synthetic_voices import synthetic_voices

RATE = 16000  # [Hz]
LEAK = 10 ** (-15 / 20)  # of the others in a separated voice
SECONDS = 10
DRAWS = 3


def separated(levels_db: list[float], seed: int = 0) -> np.ndarray:
    """What a separator that is right to within `LEAK` gives of three voices, (3, n), float32."""
    voices, rng = list(synthetic_voices(RATE))[:3], np.random.default_rng(seed)
    n = SECONDS * RATE
    clips = []
    for voice, level in zip(voices, levels_db, strict=True):
        start = int(rng.integers(len(voice.speech) - n)) if len(voice.speech) > n else 0
        clip = np.resize(voice.speech[start:], n)
        clips.append(10 ** (level / 20) * clip / np.sqrt(np.mean(clip**2)))
    clean = np.stack(clips)
    return (clean + LEAK * (clean.sum(axis=0) - clean)).astype(np.float32)


@cache
def print_of(index: int) -> VoicePrint:
    return enrol(list(synthetic_voices(RATE))[index].enrolment, RATE)


def mean_scores(prints: list, clips: list[Clip]) -> np.ndarray:
    return np.mean([[each.score_clips([clip], RATE).value for each in prints] for clip in clips], axis=0)


def noise(*levels: float, n: int = RATE) -> np.ndarray:
    return np.array(levels)[:, None] * np.random.default_rng(0).standard_normal((len(levels), n))


def believed(*si_sdr: float) -> tuple[Quality, ...]:
    return tuple(Quality(value, 8.0) for value in si_sdr)


def test_voices_that_are_separated_well_are_compared_as_they_are() -> None:
    voices = noise(1, 0.1, 1)
    for voice, kept in zip(voices, dominant(voices, believed(15, GOOD, 9), RATE), strict=True):
        np.testing.assert_array_equal(kept.samples, voice)
        assert kept.poorness == 0.0


def test_where_the_separator_does_not_say_voices_are_compared_as_they_are() -> None:
    voices = noise(1, 0.1)
    for voice, kept in zip(voices, dominant(voices, (), RATE), strict=True):
        np.testing.assert_array_equal(kept.samples, voice)
        assert kept.poorness == 0.0


def test_a_lone_voice_is_kept() -> None:
    voices = noise(1e-3)
    np.testing.assert_array_equal(dominant(voices, believed(-5), RATE)[0].samples, voices[0])


def test_a_poor_voice_that_is_as_loud_as_the_others_is_kept_whole() -> None:
    voices = np.stack([noise(1)[0], -noise(1)[0], 0.9 * noise(1)[0]])
    kept = dominant(voices, believed(-1, -1, 12), RATE)
    for voice, whole in zip(kept, voices, strict=True):
        np.testing.assert_array_equal(voice.samples, whole)


def test_a_good_voice_beside_a_poor_one_is_kept_whole() -> None:
    voices = noise(1, 0.3)
    np.testing.assert_array_equal(dominant(voices, believed(12, -1), RATE)[0].samples, voices[0])


def test_of_a_poor_voice_the_pauses_of_the_others_are_left() -> None:
    loud, soft = noise(1, 0.1, n=2 * RATE)
    loud[RATE:] = 0
    kept = dominant(np.stack([loud, soft]), believed(15, POOR), RATE)[1]
    assert kept.poorness == 1.0
    assert 0.9 * RATE < len(kept.samples) <= RATE
    np.testing.assert_allclose(kept.samples[-RATE // 2 :], soft[-RATE // 2 :], rtol=1e-6)


def test_of_a_poor_voice_that_never_dominates_nothing_is_left() -> None:
    assert [len(kept.samples) for kept in dominant(noise(1, 0.1), believed(15, -3), RATE)] == [RATE, 0]


@pytest.mark.parametrize("what", ["expected SI-SDR", "level"])
def test_between_all_and_nothing_there_is_no_step(what) -> None:
    gains, poorness = [], []
    for part in np.linspace(0, 1, 81):
        level = 10 ** (-SOFT * (part if what == "level" else 1) / 20)
        voices = noise(1, level, n=8 * RATE)
        voices[0] *= np.sqrt(2 / 3) * (1 + np.sin(2 * np.pi * np.arange(8 * RATE) / RATE))  # pauses, and loud parts
        si_sdr = POOR if what == "level" else GOOD + part * (POOR - GOOD)
        kept = dominant(voices, believed(15, si_sdr), RATE)[1]
        gains.append(float(np.linalg.norm(kept.samples) / np.linalg.norm(voices[1])))
        poorness.append(kept.poorness)
    assert gains[0] == pytest.approx(1, abs=0.02)
    assert gains[-1] < 0.7
    assert all(0 < before - after < 0.05 for before, after in pairwise(gains))
    assert poorness == pytest.approx(np.linspace(0, 1, 81), abs=0.03)


@pytest.mark.parametrize("shape", [(0, 100), (1, 0), (2, 0), (2, 1), (3, 159), (3, 16001)])
@pytest.mark.parametrize("rate", [16000, 48000])
def test_any_shape_and_silence(shape, rate) -> None:
    kept = dominant(np.zeros(shape, np.float32), believed(*[-20.0] * shape[0]), rate)
    assert [clip.samples.shape for clip in kept] == [shape[1:]] * shape[0]
    assert all(clip.samples.dtype == np.float32 and np.isfinite(clip.samples).all() for clip in kept)


@pytest.mark.parametrize("soft", range(3))
def test_a_soft_voice_sounds_more_like_its_own_print_and_not_more_like_others(soft) -> None:
    levels, quality = [0.0] * 3, [15.0] * 3
    levels[soft], quality[soft] = -12.0, 0.0
    prints = [print_of(index) for index in (soft, *{0, 1, 2} - {soft})]  # its own first
    heard = [separated(levels, seed) for seed in range(DRAWS)]
    kept = [dominant(each, believed(*quality), RATE)[soft] for each in heard]
    as_it_is = mean_scores(prints, [Clip(each[soft]) for each in heard])
    parts = mean_scores(prints, [Clip(clip.samples) for clip in kept])
    as_poor = mean_scores(prints, kept)
    assert parts[0] > as_it_is[0] + 1
    assert (parts[1:] < as_it_is[1:] + 1).all()
    assert 2 < as_poor[0] < 0.9 * parts[0]  # less is certain
    assert (as_poor[0] - as_poor[1:] < parts[0] - parts[1:] - 1).all()


def test_who_is_never_heard_alone_is_undecided() -> None:
    groups = Groups(np.zeros((2, 1, 0), complex), ((0,), (1,)), "made up", quality=believed(15, -3))
    heard = lone_voices(groups, dominant(noise(1, 0.1).astype(np.float32), groups.quality, RATE))
    evidence = Evidence(RATE, print_of(0))
    assert evidence.hear(1, heard[1], seconds=1.0) == 0.0
    assert evidence.alone(heard[1]) == 0.0
    assert evidence.seconds(1) == 0.0
    assert evidence.listened == {1: 1.0}


@pytest.mark.parametrize(
    ("listened", "left", "sure"), [(3.0, 3.0, True), (3.0, 1.5, True), (3.0, 1.4, False), (1.6, 1.6, False)]
)
def test_who_was_heard_for_too_short_or_hardly_counts_is_not_beyond_doubt(listened, left, sure) -> None:
    context = SimpleNamespace(settings=SimpleNamespace(criterion=0.5, unit=3.0))
    clips = {0: [Clip(np.ones(round(left * RATE)))]}
    evidence = Evidence(RATE, Likes(0), {0: 0.5 + CERTAIN}, clips, {0: listened})
    assert beyond_doubt(context, evidence, 0) == sure


@dataclass
class Believing(OneGroupEach):
    """The same separator, which expects an SI-SDR [dB] of every voice."""

    si_sdr: float = 0.0

    def batch(self, spectrogram, scene):
        groups = super().batch(spectrogram, scene)
        return replace(groups, quality=(Quality(self.si_sdr, 5.0),) * len(groups.members))


@dataclass
class Loudness(Likes):
    """The same voice print, which remembers the peaks of what it was asked about, and how poor that was."""

    peaks: set = field(default_factory=set)
    poorness: set = field(default_factory=set)

    def score_clips(self, clips, rate):
        self.poorness |= {round(clip.poorness, 2) for clip in clips}
        return super().score_clips(clips, rate)

    def score(self, voice, rate):
        self.peaks.add(round(float(np.abs(voice).max()), 3))
        return super().score(voice, rate)


@pytest.mark.parametrize(
    ("si_sdr", "peaks", "poorness"), [(GOOD, {0.1, 0.2, 0.3}, {0.0}), (POOR, {0.007, 0.163, 0.3}, {0.0, 0.16, 1.0})]
)
def test_poor_voices_are_compared_by_their_shares_and_heard_as_they_are(si_sdr, peaks, poorness):
    print_ = Loudness(1)
    one = rig(voiceprint=print_, separator=Believing(si_sdr))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert print_.peaks == peaks
    assert print_.poorness == poorness
    assert np.abs(one.said(Separated)[-1].voices).max(axis=1) == pytest.approx([0.1, 0.2, 0.3], rel=1e-3)


def test_a_voice_that_is_scored_alone_is_as_poor_as_it_is():
    print_ = Loudness(0)
    Evidence(RATE, print_).alone(Clip(np.full(10, 0.1), 0.7))
    assert print_.poorness == {0.7}
