"""The pipelined and the informed mission, by the Outputs for given Inputs; the rig is that of mission_bench."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

import mission_bench as base
from examples import in_soak
from ross_payload.alignment.plan import isolation
from ross_payload.dsp.steering import tdoa
from ross_payload.events import (
    AlignmentPlanned,
    Checked,
    Doubted,
    Estimate,
    OrientationHeard,
    Outcome,
    ScoreDropped,
    Separated,
    SourceEstimate,
    SourcesEstimated,
    State,
    StateChanged,
    TurnStarted,
)
from ross_payload.mission.orientation_scan import agree, steady
from ross_payload.orders import Cancel, Stop

PIPELINED = replace(base.SETTINGS, pipelined=True, check=0.5, unit=0.5, max_rotations=6)
AZIMUTHS = (170, 70, -50)


def estimate(*degrees, sigma=0.01, confidence=0.9, resolved=True, certain=False, nominal=None):
    sources = (
        SourceEstimate(float(np.deg2rad(a)), sigma, confidence, resolved, nominal_sigma=nominal) for a in degrees
    )
    return Estimate(tuple(sources), certain)


@dataclass
class Script(base.ThreeTalkers):
    """An explorer that believes what is written for the n-th time it is asked, and then the last of it."""

    beliefs: tuple = ()
    asked: int = 0

    def estimate(self, observations):
        self.asked = 1 if len(observations) == 1 else self.asked + 1
        return self.beliefs[min(self.asked, len(self.beliefs)) - 1]


SOON = (Estimate(()), estimate(*AZIMUTHS), estimate(*AZIMUTHS))  # steady after three orientations, never certain


def pipelined(*beliefs, settings=PIPELINED, **others):
    return base.rig(settings=settings, explorer=Script(beliefs=beliefs or SOON), **others)


def visits(one):
    return [event for event in one.said(StateChanged) if event.state is State.CHECK]


# ------------------------------------------------------------------------------------------------ pipelined


def test_a_steady_belief_is_visited_before_the_schedule_ends():
    one = pipelined()
    assert one.run().outcome is Outcome.TARGET_FOUND
    headings = [event.heading for event in one.said(OrientationHeard)]
    assert np.rad2deg(headings[:3]).round().tolist() == [0, 15, 30]
    assert len(headings) == 4  # the visit, and no step after it
    assert headings[3] == one.said(Checked)[-1].candidate.heading


def test_the_same_mission_takes_longer_step_by_step():
    plain = base.rig(settings=replace(PIPELINED, pipelined=False), explorer=Script(beliefs=SOON))
    one = pipelined()
    assert plain.run().outcome is one.run().outcome is Outcome.TARGET_FOUND
    assert one.said(Separated)[0].start < plain.said(Separated)[0].start


def test_what_is_heard_at_an_alignment_serves_explorer_and_voice_print():
    one = pipelined()
    one.run()
    check, heard, checked = visits(one)[0], one.said(OrientationHeard)[-1], one.said(Checked)[-1]
    assert check.time < heard.time == checked.time
    assert heard.time - check.time == pytest.approx(PIPELINED.unit)


def test_a_visit_is_as_long_as_the_longer_of_unit_and_check():
    one = pipelined(settings=replace(PIPELINED, check=1.0), voiceprint=base.Likes(1, {base.CHECKED: -1.0}))
    one.run()
    assert one.said(Checked)[0].time - visits(one)[0].time == pytest.approx(1.0)


@pytest.mark.parametrize(
    "belief",
    [
        estimate(*AZIMUTHS, sigma=0.2),
        estimate(*AZIMUTHS, confidence=0.5),
        estimate(*AZIMUTHS, resolved=False),
        Estimate(()),
    ],
)
def test_a_doubtful_belief_is_not_visited(belief):
    one = pipelined(belief)
    one.run()
    headings = np.rad2deg([event.heading for event in one.said(OrientationHeard)]).round().tolist()
    assert headings == [0, 15, 30, 45, 60, 75, 90]


def test_a_belief_that_moves_is_not_steady():
    assert steady([estimate(*AZIMUTHS), estimate(*AZIMUTHS)])
    assert steady([estimate(*AZIMUTHS), estimate(-50, 170, 72)])
    assert not steady([estimate(*AZIMUTHS)])
    assert not steady([estimate(170, 70, -50, -120), estimate(*AZIMUTHS)])
    assert not steady([estimate(170, 70, -30), estimate(*AZIMUTHS)])


def test_a_belief_is_sharp_by_how_much_was_heard_whatever_the_room():
    before, wide = estimate(*AZIMUTHS), np.deg2rad(5.0)
    assert steady([before, estimate(*AZIMUTHS, sigma=wide, nominal=0.01)])
    assert not steady([before, estimate(*AZIMUTHS, sigma=wide)])


def test_order_and_wrapping_do_not_matter_to_agreement():
    assert agree(estimate(179, 70), estimate(70, -178))
    assert not agree(estimate(70, 70), estimate(70, 0))


def test_a_belief_that_falls_at_its_alignment_is_explored_further():
    four = estimate(*AZIMUTHS, -120)
    one = pipelined(Estimate(()), estimate(*AZIMUTHS), estimate(*AZIMUTHS), four, replace(four, certain=True))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert len(one.said(OrientationHeard)) >= 5
    assert one.said(SourcesEstimated)[3].final is False
    assert len(one.said(Separated)[-1].groups) == 4


def test_a_rejected_source_is_not_visited_twice_and_the_schedule_goes_on_from_there():
    one = pipelined(voiceprint=base.Likes(7))
    assert one.run().outcome is Outcome.NO_TARGET
    end = next(n for n, event in enumerate(one.events) if isinstance(event, SourcesEstimated) and event.final)
    exploration = one.events[:end]
    assert sorted(event.candidate.source for event in exploration if isinstance(event, Checked)) == [0, 1, 2]
    turns = [event for event in exploration if isinstance(event, TurnStarted)]
    after = max(n for n, event in enumerate(turns) if "alignment" in event.reason)
    there = turns[after].joint
    steps = np.array([event.joint for event in turns[after + 1 :]])
    assert len(steps) >= 2
    np.testing.assert_allclose(np.rad2deg(steps) / 15, np.round(np.rad2deg(steps) / 15), atol=1e-9)
    assert abs(steps[0] - there) <= np.abs(steps - there).min() + 1e-9  # in order of travel


def test_an_alignment_near_an_orientation_of_the_schedule_takes_its_place():
    one = pipelined(voiceprint=base.Likes(7))
    one.run()
    reasons = {round(event.heading, 9): event.reason for event in one.said(TurnStarted)}
    heard = [
        (event.heading, "alignment" in reasons.get(round(event.heading, 9), "")) for event in one.said(OrientationHeard)
    ]
    assert any(visited for _, visited in heard)
    for n, (heading, visited) in enumerate(heard):
        later = [other for other, also in heard[n + 1 :] if not also]
        apart = [abs((heading - other + np.pi / 2) % np.pi - np.pi / 2) for other in later]
        assert not visited or min(apart, default=np.pi) >= PIPELINED.rotation / 2


def test_a_wrong_k_is_noticed_while_it_runs_and_mended():
    four = estimate(*AZIMUTHS, -120)
    one = pipelined(*SOON, estimate(*AZIMUTHS), four)
    assert one.run().outcome is Outcome.TARGET_FOUND
    last = one.said(Separated)[-1]
    assert len(last.groups) == 4
    assert one.said(SourcesEstimated)[-1].estimate == four


def test_one_take_out_of_three_does_not_change_k():
    four = estimate(*AZIMUTHS, -120)
    one = pipelined(*SOON, estimate(*AZIMUTHS), four, estimate(*AZIMUTHS))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert len(one.said(Separated)[-1].groups) == 3


def test_a_mended_belief_that_asks_for_another_heading_gets_it():
    one = pipelined(*SOON, estimate(*AZIMUTHS), estimate(*AZIMUTHS, 90))
    assert one.run().outcome is Outcome.TARGET_FOUND
    own = next(c for c in one.said(AlignmentPlanned)[-1].candidates if c.source == 1)
    assert one.said(Separated)[-1].heading == pytest.approx(own.heading)
    assert abs(own.heading - one.said(Checked)[-1].candidate.heading) > np.deg2rad(5)
    assert len(one.said(Separated)) == 1  # the period before the turn does not count


def test_two_sources_are_not_visited_early():
    assert not steady([estimate(170, 70), estimate(170, 70)])


# ------------------------------------------------------------------------------------------------- informed

TOLD = estimate(*AZIMUTHS, certain=True)


def test_told_azimuths_skip_the_exploration():
    one = base.rig(informed=TOLD)
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert not one.said(OrientationHeard)
    assert [(event.informed, event.final, event.rotations) for event in one.said(SourcesEstimated)] == [(True, True, 0)]


@pytest.mark.parametrize("first", [0, 1, 2])
def test_the_source_told_to_be_the_target_is_visited_first(first):
    one = base.rig(likes=1, informed=TOLD, target=first)
    one.run()
    assert one.said(Checked)[0].candidate.source == first


def test_without_the_target_among_the_told_it_explores_and_says_so():
    one = base.rig(likes=2, informed=estimate(170, 70, certain=True))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert len(one.said(Doubted)) == 1
    assert one.said(OrientationHeard)
    assert not one.said(SourcesEstimated)[-1].informed


def test_a_dropped_score_of_an_informed_mission_starts_a_real_exploration():
    explorer = base.Counting()
    mood = {base.RUN: lambda _: 1.0 if explorer.explorations else -1.0}
    one = base.rig(explorer=explorer, voiceprint=base.Likes(1, mood), informed=TOLD)
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert len(one.said(ScoreDropped)) == len(one.said(Doubted)) == 1
    assert one.said(ScoreDropped)[0].time < one.said(OrientationHeard)[0].time


def test_without_restarts_what_is_told_is_the_last_word():
    one = base.rig(likes=7, informed=TOLD, settings=replace(base.SETTINGS, max_restarts=0))
    result = one.run()
    assert result.outcome is Outcome.NO_TARGET
    assert "none of the 3 voices" in result.reason
    assert not one.said(Doubted)


# ------------------------------------------------------------------------------------------------ elevation


class Taus(base.OneGroupEach):
    """Keeps the TDOAs that it is told."""

    def __init__(self):
        self.told = []

    def batch(self, spectrogram, scene):
        self.told.append(scene.tau)
        return super().batch(spectrogram, scene)


def test_separators_are_told_tdoas_that_know_the_elevation():
    down = np.deg2rad(-60)
    high = Estimate(tuple(replace(s, elevation=down) for s in TOLD.sources), certain=True)
    one = base.rig(separator=Taus(), informed=high)
    separator = one.brain.gi_frame.f_locals["tools"].separator
    one.run()
    heading = one.said(Separated)[-1].heading
    azimuths = np.deg2rad(AZIMUTHS)
    expected = tdoa(azimuths, heading, 0.05, 343.0) / 2  # cos(60 deg)
    np.testing.assert_allclose(separator.told[-1], expected, atol=1e-12)


def test_a_source_above_is_recalled_where_its_own_tdoa_stands_apart():
    """A talker at the zenith has no delay anywhere, so it is apart where the other one has its longest delay."""
    zenith = replace(estimate(90).sources[0], elevation=np.pi / 2)
    level = estimate(0).sources[0]
    one = base.rig(likes=7, explorer=Script(beliefs=(Estimate((level, zenith)),)), separator=(separator := Taus()))
    one.run()
    recalled = separator.told[0]
    np.testing.assert_allclose(recalled, [0.05 / 343.0, 0.0], atol=1e-12)


@pytest.mark.parametrize("elevation", [0.0, np.deg2rad(-60)])
def test_what_a_visit_says_of_its_heading_knows_the_elevation(elevation):
    """All of one elevation eps: every isolation is cos(eps) times the one at 0."""
    level = estimate(*AZIMUTHS)
    down = replace(level, sources=tuple(replace(source, elevation=elevation) for source in level.sources))
    one = pipelined(Estimate(()), down, down)
    one.run()
    reached = one.said(Checked)[0].candidate
    flat = isolation(np.deg2rad(AZIMUTHS), [reached.heading], 0.05, 343.0)[reached.source, 0]
    assert reached.isolation == pytest.approx(np.cos(elevation) * flat)


# -------------------------------------------------------------------------------------------- both, always


@pytest.mark.parametrize("order", [Stop(), *in_soak(Cancel())])
@pytest.mark.parametrize(
    "make",
    [pipelined, lambda: base.rig(informed=TOLD), lambda: base.rig(likes=2, informed=estimate(170, 70, certain=True))],
)
def test_a_stop_is_obeyed_within_one_hop_anywhere(make, order):
    probe = make()
    probe.run()
    for at in range(0, probe.hops, 29):
        one = make()

        def press(self, heard, at=at):
            return replace(heard, orders=(order,)) if self.hops == at + 1 else None

        assert one.run(press).outcome is Outcome.STOPPED
        assert one.hops <= at + 2
        assert one.outputs[-1].stop


@pytest.mark.parametrize("make", [pipelined, lambda: base.rig(informed=TOLD)])
def test_the_same_inputs_give_the_same_outputs(make):
    one, other = make(), make()
    one.run()
    other.run()
    assert [type(event) for event in one.events] == [type(event) for event in other.events]
    assert [output.goal for output in one.outputs] == [output.goal for output in other.outputs]


@pytest.mark.parametrize(
    "make", [pipelined, lambda: pipelined(voiceprint=base.Likes(7)), lambda: base.rig(informed=TOLD)]
)
def test_every_goal_lies_inside_the_travel(make):
    one = make()
    one.run()
    goals = [output.goal for output in one.outputs if output.goal is not None]
    assert goals
    assert all(base.SETTINGS.lower <= goal <= base.SETTINGS.upper for goal in goals)
