"""Which voice is the target: what is recalled, who is visited first, what a check and a T_run decide."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from mission_bench import (
    CHECKED,
    HOP,
    RATE,
    RECALLED,
    RUN,
    SETTINGS,
    SURE,
    Likes,
    OneGroupEach,
    ThreeTalkers,
    occasion,
    rig,
)
from ross_payload.events import (
    AlignmentPlanned,
    Checked,
    OrientationHeard,
    Outcome,
    ScoreDropped,
    Separated,
    State,
    StateChanged,
)
from ross_payload.interfaces import Groups, Score
from ross_payload.mission.identify_target import CERTAIN


def test_a_target_that_pauses_during_the_check_gets_a_second_hearing():
    one = rig(voiceprint=Likes(1, {RECALLED: -0.7, CHECKED: -0.7}))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert len(one.said(Checked)) == 4
    assert one.said(Checked)[-1].candidate.source == 1


@pytest.mark.parametrize("doubtful", [-0.1, 0.1])
def test_where_the_check_leaves_a_doubt_the_array_goes_on_listening(doubtful):
    one = rig(voiceprint=Likes(1, {RECALLED: -0.1, CHECKED: doubtful}))
    assert one.run().outcome is Outcome.TARGET_FOUND
    first, second = one.said(Checked)
    assert first.candidate == second.candidate
    assert second.time - first.time == pytest.approx(SETTINGS.run)  # no turn between them


class CountingFrames(OneGroupEach):
    """Notes how long everything is that it separates."""

    def __init__(self):
        self.frames = []

    def batch(self, spectrogram, scene):
        self.frames.append(spectrogram.shape[-1])
        return super().batch(spectrogram, scene)


@pytest.mark.parametrize(
    ("azimuths", "separated"), [((0, 90, 180), 1), ((30, 60, 90, 120), 1), ((170, 70, -50), 2), ((100, 40, -20), 3)]
)
def test_no_more_orientations_are_separated_than_tell_of_everybody(azimuths, separated):
    """Those at 0, 90 and 180 degrees stand well apart at heading 0; of the last no heading tells of two."""
    separator = CountingFrames()
    explorer = ThreeTalkers(azimuths=azimuths, certain=False)
    one = rig(explorer=explorer, separator=separator, voiceprint=Likes(1, {CHECKED: 9.0}))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert separator.frames.count(separator.frames[0]) == separated  # as long as T_unit


@pytest.mark.parametrize(("target", "sounds", "separated"), [(2, 3.9, 3), (2, 4.1, 2), (0, 4.1, 1), (1, 4.1, 3)])
def test_nobody_else_is_recalled_once_somebody_sounds_like_the_target_beyond_doubt(target, sounds, separated):
    """No heading tells of two sources; 0, 2 and 1 are recalled. The target is ``sounds`` over the criterion [nat]."""
    separator = CountingFrames()
    voiceprint = Likes(target, {RECALLED: (SETTINGS.criterion + sounds) / SURE})
    one = rig(explorer=ThreeTalkers(azimuths=(100, 40, -20), certain=False), separator=separator, voiceprint=voiceprint)
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert one.said(Checked)[0].candidate.source == target
    assert separator.frames.count(separator.frames[0]) == separated


def test_a_doubtful_score_has_more_of_the_exploration_separated_each_orientation_once():
    explored = []
    for score in (1.0, 0.1):
        separator = CountingFrames()
        one = rig(
            explorer=ThreeTalkers(certain=False),
            separator=separator,
            voiceprint=Likes(1, {RECALLED: 0.5, CHECKED: score}),
        )
        assert one.run().outcome is Outcome.TARGET_FOUND
        explored.append(separator.frames.count(separator.frames[0]))  # as long as T_unit
    assert explored[0] <= 3  # the best orientation of everybody
    assert explored[0] < explored[1] <= SETTINGS.max_rotations + 1


def test_all_that_was_heard_of_a_voice_is_compared_together():
    voiceprint = Likes(1, {RECALLED: 0.5})
    lengths, score = [], voiceprint.score
    voiceprint.score = lambda voice, rate: (lengths.append(len(voice) / rate), score(voice, rate))[1]
    rig(voiceprint=voiceprint).run()
    recalled = (max(lengths) - SETTINGS.check - SETTINGS.run) / SETTINGS.unit
    assert recalled == pytest.approx(round(recalled))  # whole periods of the exploration
    assert recalled >= 1


def test_of_voices_that_are_alike_the_nearer_one_is_visited_and_a_likelier_one_before_them():
    alike = rig(likes=7)
    alike.run()
    planned = alike.said(AlignmentPlanned)[-1].candidates
    visited = [event.candidate.source for event in alike.said(Checked)]
    assert visited[0] == planned[0].source
    far = planned[-1].source
    likelier = rig(voiceprint=Likes(far, {RECALLED: 0.0}))
    likelier.run()
    assert likelier.said(Checked)[0].candidate.source == far


def test_a_voice_that_the_exploration_has_recognised_is_visited_first():
    for number in range(3):
        one = rig(likes=number)
        one.run()
        assert [event.candidate.source for event in one.said(Checked)] == [number]


@pytest.mark.parametrize(("sounds", "checks"), [(CERTAIN, 0), (CERTAIN - 0.1, 1)])
def test_whom_the_exploration_leaves_no_doubt_of_is_listened_to_without_a_check(sounds, checks):
    one = rig(voiceprint=Likes(1, {RECALLED: (SETTINGS.criterion + sounds) / SURE}))
    assert one.run().outcome is Outcome.TARGET_FOUND
    states = [event.state for event in one.said(StateChanged)]
    assert states.count(State.CHECK) == checks
    (checked,), (separated,) = one.said(Checked), one.said(Separated)
    assert checked.time + SETTINGS.run == pytest.approx(separated.time, abs=2 * HOP / RATE)
    assert (checked.candidate.source, checked.groups[checked.accepted].members) == (1, (1,))
    assert checked.method == "numbered"
    assert (checked.why == "by what was heard before") == (checks == 0)


def test_who_was_told_from_outside_is_checked_however_sure_the_voice():
    one = rig(informed=ThreeTalkers().estimate([None] * 3), likes=1)
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert State.CHECK in [event.state for event in one.said(StateChanged)]


def test_who_is_listened_to_without_a_check_is_judged_by_t_run():
    one = rig(voiceprint=Likes(1, {RUN: -1.0}), settings=replace(SETTINGS, max_restarts=0))
    assert one.run().outcome is Outcome.NO_TARGET
    assert one.said(ScoreDropped)


def test_a_voice_recognised_from_another_alignment_is_confirmed_at_its_own():
    one = rig(explorer=ThreeTalkers(azimuths=(0, 60, 120)), voiceprint=Likes(1, {RECALLED: -1.0}))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert [event.candidate.source for event in one.said(Checked)] == [2, 1]


class PosingAsOne(OneGroupEach):
    """Sources 0 and 1 always arrive together."""

    def batch(self, spectrogram, scene):
        signals = np.stack([spectrogram[0], spectrogram[0] * 3])
        return Groups(signals, ((0, 1), (2,)), self.name)


def test_sources_that_pose_as_one_are_never_taken_for_the_target():
    one = rig(likes=0, separator=PosingAsOne())
    assert one.run().outcome is Outcome.NO_TARGET
    assert any(group.accepted for event in one.said(Checked) for group in event.groups)


def test_when_a_voice_turns_out_to_be_another_the_others_are_heard_before_it_is_explored_again():
    """Everybody sounds like the target at first, and after T_run one of them does."""

    class Everybody(Likes):
        def score(self, voice, rate):
            long = occasion(voice) == RUN
            return super().score(voice, rate) if long else Score(SURE, accepted=True)

    one = rig(voiceprint=Everybody(2))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert one.said(ScoreDropped)
    assert [event.target for event in one.said(Separated)][-1] == 2
    assert len([event for event in one.said(OrientationHeard) if event.index == 0]) == 1


@dataclass
class TwoAlike(Likes):
    """Sources 0 and 1 sound like the target when they are recalled; source 0 the less the longer it is heard."""

    after_run: float = 0.2  # score of source 0 then, of `SURE`
    other: float = 1.0  # and of source 1 when it was visited

    def score(self, voice, rate):
        number, when = self.who(voice), occasion(voice)
        if number == 2:
            return Score(-SURE, accepted=False)
        if number == 1:
            return self.told(0.6 if when == RECALLED else self.other)
        return self.told(self.after_run if when == RUN else 1.0)

    def told(self, times):
        return Score(SURE * times, times > 0)


def running(one):
    return [event.target for event in one.said(Separated)]


def test_after_it_was_heard_longer_the_likeliest_voice_wins_and_not_the_one_that_is_listened_to():
    one = rig(voiceprint=TwoAlike(0))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert running(one) == [0, 1]
    (dropped,) = one.said(ScoreDropped)
    assert (dropped.value, dropped.criterion, dropped.other) == pytest.approx((0.2 * SURE, 0.6 * SURE, 1))
    assert len([event for event in one.said(OrientationHeard) if event.index == 0]) == 1


def test_the_first_voice_is_gone_back_to_where_the_likelier_one_is_not_the_target_after_all():
    one = rig(voiceprint=TwoAlike(0, other=-1.0))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert running(one) == [0, 0]
    assert [event.candidate.source for event in one.said(Checked)] == [0, 1, 0]
    assert len(one.said(ScoreDropped)) == 1


@pytest.mark.parametrize(("other", "wins"), [(0.65, 0), (0.75, 1)])
def test_a_voice_that_is_nearly_as_likely_is_visited_and_the_likelier_one_wins(other, wins):
    one = rig(voiceprint=TwoAlike(0, after_run=0.7, other=other))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert running(one) == [0, wins]
    assert [event.other for event in one.said(ScoreDropped)] == [1]


def test_a_voice_that_stays_by_far_the_likeliest_is_listened_to():
    one = rig(voiceprint=TwoAlike(0, after_run=1.1))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert running(one) == [0]
    assert not one.said(ScoreDropped)
