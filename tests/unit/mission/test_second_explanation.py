"""An exploration that is in doubt about K: the mission looks for the target in the second-best explanation, too."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from mission_bench import RUN, SURE, Counting, Likes, OneGroupEach, ThreeTalkers, occasion, rig
from ross_payload.events import Checked, Estimate, OrientationHeard, Outcome, ScoreDropped, Separated, SourcesEstimated
from ross_payload.interfaces import Score
from ross_payload.mission.slip_detection import turned

BEST, SECOND = (170, 70), (170, -50, 70)  # [deg]; who is at -50 was missed


@dataclass
class InDoubt(ThreeTalkers):
    """An explorer that believes in two talkers, and thinks it possible that there are three."""

    azimuths: tuple[float, ...] = BEST

    def estimate(self, observations):
        best, second = (ThreeTalkers(azimuths=each).estimate(observations) for each in (self.azimuths, SECOND))
        return replace(best, certain=True, rival=second) if best.k else Estimate(())


class ByAzimuth(OneGroupEach):
    """A separator whose groups sound like who is there, whatever the sources are called."""

    def batch(self, spectrogram, scene):
        groups = super().batch(spectrogram, scene)
        order = {2: (0, 2), 3: (0, 1, 2)}[scene.n_sources]  # positions of the second explanation
        return replace(groups, signals=np.stack([spectrogram[0] * (place + 1) for place in order]))


def missions(likes, **told):
    return rig(explorer=InDoubt(), separator=ByAzimuth(), voiceprint=Likes(likes), **told)


def said(one):
    return [event.estimate.k for event in one.said(SourcesEstimated) if event.final]


def explorations(one):
    return len([event for event in one.said(OrientationHeard) if event.index == 0])


def test_a_target_that_the_best_explanation_misses_is_found_in_the_second():
    one = missions(likes=1)
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert said(one) == [2, 3]
    assert explorations(one) == 1
    heard = one.said(Separated)[-1]
    assert (heard.target, len(heard.groups)) == (1, 3)


def test_the_second_explanation_is_not_asked_when_the_best_one_holds_the_target():
    one = missions(likes=2)
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert said(one) == [2]
    assert one.said(Separated)[-1].target == 1


def test_only_who_is_not_in_the_best_explanation_is_visited_in_the_second():
    one = missions(likes=7)
    assert one.run().outcome is Outcome.NO_TARGET
    visited = [(len(event.groups), event.candidate.source) for event in one.said(Checked)]
    assert sorted(visited) == [(2, 0), (2, 1), (3, 1)]


def test_when_nobody_is_the_target_the_best_explanation_is_believed_in_the_end():
    one = missions(likes=7)
    assert one.run().reason == "none of the 2 voices is the target's"
    assert said(one) == [2, 3, 2, 2]  # and once more when all orientations were visited


def test_a_voice_that_turns_out_to_be_another_leads_to_the_second_explanation_before_a_new_exploration():
    class AtFirstEverybody(Likes):
        def score(self, voice, rate):
            long = occasion(voice) == RUN
            return super().score(voice, rate) if long or self.who(voice) == 1 else Score(0.8 * SURE, accepted=True)

    one = rig(explorer=InDoubt(), separator=ByAzimuth(), voiceprint=AtFirstEverybody(1))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert one.said(ScoreDropped)
    assert said(one)[-1] == 3
    assert explorations(one) == 1


def test_without_a_second_explanation_nobody_else_is_believed_in():
    one = rig(explorer=Counting(azimuths=BEST), separator=ByAzimuth(), voiceprint=Likes(1))
    assert one.run().outcome is Outcome.NO_TARGET
    assert said(one) == [2, 2]


def test_the_second_explanation_turns_with_the_frame():
    estimate = InDoubt().estimate(range(3))
    shifted = turned(estimate, np.deg2rad(20))
    assert [np.rad2deg(source.azimuth) for source in shifted.rival.sources] == pytest.approx([-170, -30, 90])
    assert turned(replace(estimate, rival=None), 0.1).rival is None
