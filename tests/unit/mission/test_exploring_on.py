"""Nobody is recognised after an exploration that ended early: what it has left out is visited before that is said."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from mission_bench import SETTINGS, Likes, ThreeTalkers, rig
from ross_payload.events import Checked, OrientationHeard, Outcome, SourcesEstimated

FIRST, ALL = (170, 70), (170, 70, -50)  # [deg]; who is at -50 is found late
AT_LEAST = 3  # orientations of an exploration here, of five


@dataclass
class Late(ThreeTalkers):
    """An explorer that is soon certain of two talkers, and hears a third after so many orientations."""

    after: int = 4
    then: tuple[float, ...] = ALL

    def estimate(self, observations):
        azimuths = self.then if len(observations) >= self.after else FIRST
        return ThreeTalkers(azimuths=azimuths).estimate(observations)


def mission(likes, after=4, settings=SETTINGS, then=ALL, **told):
    return rig(explorer=Late(after=after, then=then), voiceprint=Likes(likes), settings=settings, **told)


def orientations(one):
    return [event.index for event in one.said(OrientationHeard)]


@pytest.mark.parametrize("after", [4, 5])
def test_a_target_who_is_heard_late_is_found_without_a_new_exploration(after):
    one = mission(likes=2, after=after)
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert orientations(one) == list(range(after))
    assert [event.candidate.source for event in one.said(Checked)][-1] == 2


def test_who_has_been_heard_is_not_visited_again():
    one = mission(likes=7)
    assert one.run().outcome is Outcome.NO_TARGET
    assert sorted(event.candidate.source for event in one.said(Checked)) == [0, 1, 2]


def test_where_nobody_else_is_found_all_orientations_are_visited():
    one = mission(likes=7, after=99)
    assert one.run().reason == "none of the 2 voices is the target's"
    assert orientations(one) == list(range(SETTINGS.max_rotations + 1))
    assert [event.final for event in one.said(SourcesEstimated)] == [False, False, True, False, True]


def test_what_is_believed_after_the_last_orientation_counts():
    one = mission(likes=7, after=5, then=FIRST[:1])
    assert one.run().reason == "none of the 1 voices is the target's"


def test_a_target_who_is_recognised_at_once_ends_the_exploration_as_before():
    one = mission(likes=1)
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert orientations(one) == list(range(AT_LEAST))


def test_after_told_azimuths_alone_nothing_was_left_out():
    told = ThreeTalkers(azimuths=FIRST, patience=0).estimate([])
    one = mission(likes=1, informed=told)
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert orientations(one) == []


def test_a_pipelined_mission_explores_nothing_after_it_has_checked_everybody():
    one = mission(likes=7, after=99, settings=replace(SETTINGS, pipelined=True))
    assert one.run().outcome is Outcome.NO_TARGET
    told = [type(event) for event in one.events if isinstance(event, Checked | OrientationHeard)]
    assert OrientationHeard not in told[told.index(Checked) :]
    assert len(orientations(one)) < SETTINGS.max_rotations + 1


def test_the_headings_left_out_are_those_of_the_schedule():
    one = mission(likes=7, after=99)
    one.run()
    headings = sorted(event.heading for event in one.said(OrientationHeard))
    assert np.diff(headings) == pytest.approx(SETTINGS.rotation)
