"""Sources are confirmed, dropped or added by what is heard after the exploration; the rig is that of mission_bench."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

import mission_bench as base
from ross_payload.angles import wrap
from ross_payload.dsp.stft import Stft
from ross_payload.events import (
    Checked,
    Estimate,
    OrientationHeard,
    Outcome,
    ScoreDropped,
    Separated,
    SourceEstimate,
    SourcesEstimated,
    SourcesReconsidered,
    State,
    StateChanged,
    TurnStarted,
)
from ross_payload.interfaces import Score, VoicePrint
from ross_payload.mission.context import Context, Listening
from ross_payload.mission.reconsideration import DROPPED, MOST, doubtful, keep, reassessed, takes
from ross_payload.mission.settings import Tools

AZIMUTHS = base.ThreeTalkers.azimuths


@dataclass
class Again(base.ThreeTalkers):
    """An explorer that has these confidences [%] in the sources at its azimuths when it is asked again."""

    sure: tuple[int, ...] = (97, 98, 99)
    more: tuple[tuple[int, int], ...] = ()  # azimuth and confidence [%] of others in its second explanation
    asked: list = field(default_factory=list)

    def reconsider(self, observations, believed):
        self.asked.append((len(observations), believed.k))
        pairs = [(a + 3, s) for a, s in zip(self.azimuths, self.sure, strict=True) if s >= 0]
        if believed.k == len(pairs) + len(self.more):
            return told(*pairs, *self.more)
        rival = told(*reversed(pairs), *self.more) if self.more else None
        return replace(told(*pairs), rival=rival)


def told(*pairs):
    return Estimate(tuple(SourceEstimate(wrap(np.deg2rad(a)), 0.01, sure / 100, True) for a, sure in pairs))


class LouderIsLikelier(VoicePrint):
    """Of the groups of `mission_bench.OneGroupEach` the last one sounds most like the target, whatever its number."""

    def score(self, voice, rate):
        return Score(base.SURE * float(np.abs(voice).max()), accepted=True)


def flown(again, **others):
    one = base.rig(again=again, **others)
    return one, one.run()


def azimuths(estimate):
    return np.rad2deg([source.azimuth for source in estimate.sources]).round().tolist()


def test_what_is_heard_at_the_alignments_renews_every_confidence_and_moves_nothing():
    one, _ = flown(Again())
    plain, _ = flown(None)
    last = one.said(SourcesReconsidered)[-1]
    assert [source.confidence for source in last.estimate.sources] == [0.97, 0.98, 0.99]
    assert azimuths(last.estimate) == list(AZIMUTHS)
    assert not last.dropped
    assert len(one.said(SourcesEstimated)) == len(plain.said(SourcesEstimated))
    assert [turn.joint for turn in one.said(TurnStarted)] == [turn.joint for turn in plain.said(TurnStarted)]


def test_the_explorer_is_asked_after_ever_longer_times_and_no_heading_outweighs_the_exploration():
    again = Again()
    one, _ = flown(again, settings=replace(base.SETTINGS, run=5.25, runs=10))
    assert set(again.asked) == {(3 + MOST, 3)}  # of T_check and 70 T_unit at one heading four count
    times = np.diff([event.time for event in one.said(SourcesReconsidered)])
    assert (times / 5.25).round().astype(int).tolist() == [2, 2, 4]


def test_a_source_that_is_most_probably_nobody_is_dropped_and_the_others_stay():
    one, result = flown(Again(sure=(97, 98, 10)), likes=1)
    assert result.outcome is Outcome.TARGET_FOUND
    assert one.said(SourcesReconsidered)[0].dropped == (2,)
    last = one.said(SourcesEstimated)[-1]
    assert (azimuths(last.estimate), last.final) == (list(AZIMUTHS[:2]), True)
    assert len(one.said(Separated)[-1].groups) == 2


def with_a_dead_microphone(again, *states):
    """A mission in which microphone 2 gives nothing in some states."""

    def on_hop(bench, heard):
        now = next((each.state for each in reversed(bench.said(StateChanged))), None)
        factors = np.array([[1], [0 if now in states else 1]], np.float32)
        return replace(heard, block=replace(heard.block, samples=heard.block.samples * factors))

    one = base.rig(again=again, likes=1)
    return one, one.run(on_hop)


def test_nobody_is_dropped_by_what_a_dead_microphone_gave():
    one, result = with_a_dead_microphone(Again(sure=(97, 98, 10)), State.CHECK, State.RUN)
    assert result.outcome is Outcome.TARGET_FOUND
    assert one.said(SourcesReconsidered) == []
    assert len(one.said(Separated)[-1].groups) == 3


@pytest.mark.parametrize("deaf", [False, True])
def test_what_a_dead_microphone_gave_is_not_kept_for_the_explorer(deaf):
    explorer, stft = Again(), Stft(base.RATE, 512, 128)
    tools = Tools(explorer, stft, base.OneGroupEach(), stft, base.Likes(1), reconsidering=explorer)
    context = Context(base.SETTINGS, tools, observations=[explorer.observe(None, None, 0.0, None)])
    keep(context, Listening(0.0, np.full((2, base.RATE), 0.1, np.float32), deaf=deaf))
    assert len(context.heard_since) == (0 if deaf else 1)


def test_a_source_that_no_explanation_of_as_many_holds_any_more_is_dropped():
    one, _ = flown(Again(sure=(97, 98, -1)), likes=1)
    assert azimuths(one.said(SourcesEstimated)[-1].estimate) == list(AZIMUTHS[:2])


def test_who_is_somebody_beyond_doubt_in_the_second_explanation_is_added_after_the_others():
    again = Again(more=((-110, 95),))
    one, result = flown(again, likes=1, settings=replace(base.SETTINGS, run=5.25, runs=4))
    assert result.outcome is Outcome.TARGET_FOUND
    last = one.said(SourcesEstimated)[-1]
    assert (azimuths(last.estimate), last.final) == ([*AZIMUTHS, -110], True)
    assert last.estimate.rival is None
    groups = [len(event.groups) for event in one.said(Separated)]
    assert groups == [4] * len(groups)
    assert [event.target for event in one.said(Separated)] == [1] * len(groups)


@dataclass
class Refuted(VoicePrint):
    """Some voices sound like the target at first, and others after T_run."""

    at_first: set[int]
    after_run: set[int]

    def score(self, voice, rate):
        accepted = base.Likes.who(voice) in (self.after_run if base.occasion(voice) == base.RUN else self.at_first)
        return Score(base.SURE if accepted else -base.SURE, accepted)


@pytest.mark.parametrize(
    ("at_first", "target", "visited"),
    [({1, 3}, 3, [1, 3]), ({0, 1, 2}, 2, [0, 2, 1, 2]), ({0, 1, 2, 3}, 3, [0, 1, 3])],  # who is left as before, too
)
def test_who_was_added_or_left_is_visited_when_the_voice_that_was_listened_to_is_another(at_first, target, visited):
    one, result = flown(Again(more=((-110, 95),)), voiceprint=Refuted(at_first, {target}))
    assert (result.outcome, result.reason) == (Outcome.TARGET_FOUND, f"source {target} is the target")
    assert [event.candidate.source for event in one.said(Checked)] == visited
    assert len([event for event in one.said(OrientationHeard) if event.index == 0]) == 1  # not explored again
    assert one.said(SourcesEstimated)[-1].estimate.k == 4


@pytest.mark.parametrize("more", [((-110, 89),), ((-110, 95), (130, 89)), ((98, 95),)])
def test_nobody_is_added_who_is_doubtful_or_near_somebody_who_is_known(more):
    one, _ = flown(Again(more=more), likes=1)
    assert azimuths(one.said(SourcesEstimated)[-1].estimate) == list(AZIMUTHS)


def test_nobody_is_added_where_somebody_is_dropped():
    one, _ = flown(Again(sure=(97, 98, 10), more=((-110, 95),)), likes=1)
    assert azimuths(one.said(SourcesEstimated)[-1].estimate) == list(AZIMUTHS[:2])


def test_who_sounds_like_the_target_is_never_dropped_and_goes_by_the_new_name():
    one, result = flown(Again(sure=(10, 98, 10)), voiceprint=LouderIsLikelier())
    assert one.said(Checked)[-1].accepted == 2
    assert result.reason == "source 1 is the target"
    assert azimuths(one.said(SourcesEstimated)[-1].estimate) == list(AZIMUTHS[1:])
    assert one.said(Separated)[-1].target == 1


def test_the_array_turns_again_where_the_target_stands_clearly_better_apart_from_who_is_left():
    one, _ = flown(Again(sure=(97, 98, 10)), likes=1)
    turns = [turn for turn in one.said(TurnStarted) if turn.time > one.said(SourcesReconsidered)[0].time]
    assert [turn.reason for turn in turns] in ([], ["alignment for source 1"])
    assert one.said(Separated)[-1].heading == (turns[-1].heading if turns else one.said(Checked)[-1].candidate.heading)


def test_without_the_target_the_last_estimate_is_that_of_everything_heard():
    one, result = flown(Again(sure=(97, 98, 10)), likes=7)
    assert result.outcome is Outcome.NO_TARGET
    assert result.reason == "none of the 2 voices is the target's"
    assert one.said(SourcesEstimated)[-1].estimate.k == 2


def test_told_azimuths_are_not_reconsidered():
    again = Again()
    one, _ = flown(again, informed=again.estimate([None] * 3))
    assert not again.asked
    assert not one.said(SourcesReconsidered)


@pytest.mark.parametrize("sure", [(0.0, 0.1, 0.2), (0.9, DROPPED, 0.5)])
def test_nobody_is_dropped_where_all_are_doubtful_or_none_is(sure):
    sources = tuple(SourceEstimate(a, 0.01, c, True) for a, c in zip((0.0, 2.0, -2.0), sure, strict=True))
    assert doubtful(Estimate(sources), None) == ()


def test_an_explanation_that_cannot_be_had_changes_nothing():
    assert reassessed(Estimate((SourceEstimate(0.0, 0.01, 0.9, True),)), None) is None


def test_a_period_in_which_the_array_turned_is_taken_where_it_rested():
    headings = np.concatenate([np.full(300, 0.5), np.linspace(0.5, 0.9, 50), np.full(650, 0.9)])
    samples = np.arange(2 * 10000, dtype=np.float32).reshape(2, 10000)
    heard = Listening(0.77, samples, 0.3, headings)
    found = [(take.heading, int(take.samples[0, 0]), take.samples.shape[1]) for take in takes(heard, 3000)]
    assert [(round(heading, 2), length) for heading, _, length in found] == [
        (0.5, 3000),
        (0.89, 3000),
        (0.89, 3000),
    ]
    assert found[0][1] == 0
    assert found[1][1] >= 3400
    assert [len(list(takes(Listening(0.5, samples[:, :n]), 3000))) for n in (1400, 1600, 3000, 9100)] == [0, 1, 1, 3]


@pytest.mark.parametrize(("sure", "others"), [((97, 98, 99), [0]), ((97, 10, 99), [])])
def test_nobody_else_comes_next_where_a_source_was_dropped_meanwhile(sure, others):
    """What the sources were called when the others were left is not what they are called now."""
    one, result = flown(Again(sure=sure), voiceprint=LouderIsLikelier())
    assert result.outcome is Outcome.TARGET_FOUND
    assert [event.other for event in one.said(ScoreDropped)] == others
