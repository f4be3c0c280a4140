"""The mission is a coroutine: these tests send it Inputs and read its Outputs; nothing else moves."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from mission_bench import (
    HOP,
    RATE,
    RUN,
    SETTINGS,
    Counting,
    Likes,
    OneGroupEach,
    Rig,
    ThreeTalkers,
    rig,
)
from ross_payload.alignment.paper_rules import paper_plan
from ross_payload.dsp.stft import Stft
from ross_payload.events import (
    AlignmentPlanned,
    Checked,
    Finished,
    OrientationHeard,
    Outcome,
    ScoreDropped,
    Separated,
    SourcesEstimated,
    State,
    StateChanged,
    TurnStarted,
)
from ross_payload.mission.calibration_turn import calibration_turn
from ross_payload.mission.settings import Tools
from ross_payload.orders import Cancel, Stop


def test_target_is_found_at_its_own_alignment():
    one = rig(likes=1, planner=paper_plan)
    result = one.run()
    assert result.outcome is Outcome.TARGET_FOUND
    heading = one.said(Checked)[-1].candidate.heading
    assert np.cos(np.deg2rad(170) - heading) == pytest.approx(np.cos(np.deg2rad(-50) - heading), abs=1e-9)
    assert one.said(Separated)[-1].target == 1


def test_exploration_stops_when_certain_and_not_before_the_minimum():
    one = rig()
    one.run()
    heard = one.said(OrientationHeard)
    assert [round(np.rad2deg(event.heading)) for event in heard] == [0, 15, 30]
    assert [event.final for event in one.said(SourcesEstimated)] == [False, False, True]


@dataclass
class OneFewer(ThreeTalkers):
    """An explorer that misses the last talker at some orientations, and is certain."""

    misses: tuple[int, ...] = (3,)  # how many orientations it has heard then
    patience: int = 2

    def estimate(self, observations):
        missed = len(observations) in self.misses
        azimuths = self.azimuths[:2] if missed else self.azimuths
        return ThreeTalkers(azimuths=azimuths, certain=missed, patience=self.patience).estimate(observations)


@pytest.mark.parametrize(("misses", "heard", "k"), [((3,), 5, 3), ((3, 4), 4, 2), ((2, 3, 4), 3, 2)])
def test_an_explorer_that_believed_in_more_talkers_right_before_is_not_taken_to_be_certain(misses, heard, k):
    one = rig(explorer=OneFewer(misses=misses))
    one.run()
    assert len(one.said(OrientationHeard)) == heard
    assert next(event.estimate.k for event in one.said(SourcesEstimated) if event.final) == k


def test_the_explorer_is_told_how_far_its_frames_are_apart():
    periods = set()

    class Timed(ThreeTalkers):
        def observe(self, *heard, frame_period=None):
            periods.add(frame_period)
            return super().observe(*heard)

    rig(explorer=Timed()).run()
    assert periods == {128 / RATE}


def test_exploration_ends_at_the_maximum_when_never_certain():
    one = rig(explorer=ThreeTalkers(certain=False))
    one.run()
    assert len(one.said(OrientationHeard)) == SETTINGS.max_rotations + 1


def test_exploration_turns_the_other_way_where_the_travel_ends():
    one = rig(explorer=ThreeTalkers(certain=False), settings=replace(SETTINGS, upper=np.deg2rad(31), lower=-3.5))
    one.run()
    degrees = [round(np.rad2deg(event.joint)) for event in one.said(OrientationHeard)]
    assert degrees == [0, -15, -30, -45, -60]


def test_exploration_uses_both_sides_of_a_narrow_travel():
    narrow = replace(SETTINGS, lower=np.deg2rad(-31), upper=np.deg2rad(31))
    one = rig(explorer=ThreeTalkers(certain=False), settings=narrow)
    one.run()
    degrees = [round(np.rad2deg(event.joint)) for event in one.said(OrientationHeard)]
    assert degrees == [0, 15, 30, -15, -30]


@pytest.mark.parametrize(
    ("joint", "lower", "upper", "heard"),
    [(0, 17, 106, [17, 32, 47, 62, 77]), (0, 40, 70, [40, 55, 70]), (120, -50, 90, [90, 75, 60, 45, 30])],
)
def test_a_joint_that_stands_beyond_a_limit_turns_to_it_first(joint, lower, upper, heard):
    """So it stands once it has found its zero at a switch beyond the limits."""
    settings = replace(SETTINGS, lower=np.deg2rad(lower), upper=np.deg2rad(upper))
    one = rig(explorer=ThreeTalkers(certain=False), settings=settings)
    one.joint = one.goal = np.deg2rad(joint)
    one.run()
    assert [round(np.rad2deg(event.joint)) for event in one.said(OrientationHeard)] == heard
    goals = [output.goal for output in one.outputs if output.goal is not None]
    assert all(settings.lower <= goal <= settings.upper for goal in goals)


def test_a_calibration_turns_within_the_limits_wherever_it_begins():
    settings, stft = replace(SETTINGS, lower=np.deg2rad(-50), upper=np.deg2rad(90)), Stft(RATE, 512, 128)
    tools = Tools(ThreeTalkers(), stft, OneGroupEach(), stft, None)
    one = Rig(calibration_turn(settings, tools, 0.5, []), joint=np.deg2rad(120), goal=np.deg2rad(120))
    assert one.run().outcome is Outcome.COMPLETED
    goals = [round(np.rad2deg(output.goal)) for output in one.outputs if output.goal is not None]
    assert goals == [90, 75, 60, 45, 30, 90]


def test_every_goal_lies_inside_the_travel():
    tight = replace(SETTINGS, lower=np.deg2rad(-20), upper=np.deg2rad(50))
    one = rig(settings=tight)
    one.run()
    goals = [output.goal for output in one.outputs if output.goal is not None]
    assert goals
    assert all(tight.lower <= goal <= tight.upper for goal in goals)


def test_nobody_talking_is_an_answer():
    result = rig(explorer=ThreeTalkers(azimuths=())).run()
    assert result.outcome is Outcome.NO_TARGET


def test_limits_under_which_nobody_stands_apart_are_told_as_the_reason():
    narrow = replace(SETTINGS, lower=-0.005, upper=0.005)
    one = rig(settings=narrow, explorer=ThreeTalkers(azimuths=(30, -30), patience=1))
    result = one.run()
    assert result.outcome is Outcome.NO_TARGET
    assert "no heading within the limits" in result.reason
    assert not one.said(Checked)


def test_the_last_estimate_is_final_where_the_travel_ends_the_exploration():
    one = rig(explorer=ThreeTalkers(certain=False), settings=replace(SETTINGS, lower=-0.3, upper=0.3))
    one.run()
    assert [event.final for event in one.said(SourcesEstimated)] == [False, False, True]


def test_no_target_here_is_an_answer_and_not_a_wrong_pick():
    one = rig(likes=7)
    result = one.run()
    assert result.outcome is Outcome.NO_TARGET
    assert not one.said(Separated)
    planned = one.said(AlignmentPlanned)[-1]
    assert len(one.said(Checked)) == len(planned.candidates)  # everyone once: nobody comes near


def test_a_dropped_score_starts_the_mission_again():
    explorer = Counting()
    one = rig(explorer=explorer, voiceprint=Likes(1, {RUN: lambda _: 1.0 if explorer.explorations > 1 else -1.0}))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert len(one.said(ScoreDropped)) == 1
    assert len([event for event in one.said(OrientationHeard) if event.index == 0]) == 2


def test_restarts_are_bounded():
    result = rig(voiceprint=Likes(1, {RUN: -1.0})).run()
    assert result.outcome is Outcome.NO_TARGET
    assert result.reason == "gave up after 2 attempts: the target's score dropped"


@pytest.mark.parametrize("order", [Stop(), Cancel()])
def test_a_stop_is_obeyed_within_one_hop_anywhere(order):
    probe = rig()
    probe.run()
    for at in range(0, probe.hops, 13):
        one = rig()

        def press(self, heard, at=at):
            return replace(heard, orders=(order,)) if self.hops == at + 1 else None

        result = one.run(press)
        assert result.outcome is Outcome.STOPPED
        assert one.hops <= at + 2  # the stop goes out with the very next Output
        assert one.outputs[-1].stop


def test_a_fault_ends_the_mission_and_is_named():
    one = rig()
    result = one.run(lambda self, heard: replace(heard, fault="motor stalled") if self.hops == 30 else None)
    assert (result.outcome, result.reason) == (Outcome.FAULT, "motor stalled")
    assert one.outputs[-1].stop
    assert State.FAULT in [event.state for event in one.said(StateChanged)]


def test_nothing_is_listened_to_while_turning():
    one = rig()
    one.run()
    turns = one.said(TurnStarted)
    listens = [event for event in one.said(StateChanged) if event.state is State.EXPLORE_LISTEN]
    for turned, listened in zip(turns[:2], listens[1:3], strict=True):
        assert listened.time - turned.time > 3.5 * HOP / RATE  # three hops of travel and one settled


def test_cancelled_mission_says_finished_last():
    one = rig()
    one.run(lambda self, heard: replace(heard, orders=(Cancel(),)) if self.hops == 5 else None)
    assert isinstance(one.outputs[-1].events[-1], Finished)
