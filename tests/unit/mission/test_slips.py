"""The array slips on its shaft: everybody seems to turn together, and the mission knows that it was the array."""

import math
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from mission_bench import RATE, RUN, SETTINGS, Likes, OneGroupEach, Rig, ThreeTalkers, rig
from ross_payload.dsp.stft import Stft
from ross_payload.events import Doubted, Estimate, OrientationHeard, Outcome, Slipped, SourceEstimate, SourcesEstimated
from ross_payload.interfaces import Observation
from ross_payload.localization.rotation_estimate import common_shift, common_turn
from ross_payload.localization.sectors import sectors_of, shifted, together
from ross_payload.mission.context import Context, Listening, hop
from ross_payload.mission.settings import Tools
from ross_payload.mission.slip_detection import survey, suspicion

AZIMUTHS = (170, 70, -50)


def estimate(*degrees):
    return Estimate(tuple(SourceEstimate(math.radians(a), 0.01, 0.9, resolved=True) for a in degrees), certain=True)


@dataclass
class Turned(ThreeTalkers):
    """An explorer that finds everybody turned from its second exploration on."""

    shifts: tuple = (0, 12, 12)  # one per exploration [deg], or one per talker in each
    explorations: int = 0
    seen: list = field(default_factory=list)

    def estimate(self, observations):
        self.explorations += len(observations) == 1
        shift = self.shifts[min(self.explorations, len(self.shifts)) - 1]
        each = shift if isinstance(shift, tuple) else (shift,) * len(AZIMUTHS)
        self.azimuths = tuple(a + s for a, s in zip(AZIMUTHS, each, strict=True))
        return super().estimate(observations)


def drops_once(explorer):
    """A mission whose target is lost once it is listened to, until it is explored again."""
    return rig(explorer=explorer, voiceprint=Likes(1, {RUN: lambda _: 1.0 if explorer.explorations > 1 else -1.0}))


def put_right(one):
    """What the Outputs have asked to be put right [deg]."""
    return [round(math.degrees(output.slipped), 6) for output in one.outputs if output.slipped is not None]


def last_azimuths(one):
    return [math.degrees(source.azimuth) for source in one.said(SourcesEstimated)[-1].estimate.sources]


@pytest.mark.parametrize("shift", [-44, -12, 4, 30])
def test_a_shift_of_everybody_is_found_whatever_their_order(shift):
    after = estimate(*[a + shift for a in (70, -50, 170)])
    assert math.degrees(common_shift(estimate(*AZIMUTHS), after)) == pytest.approx(shift)


def test_the_shift_is_the_mean_of_everybody_s():
    after = estimate(170 + 12, 70 + 13.5, -50 + 12)
    assert math.degrees(common_shift(estimate(*AZIMUTHS), after)) == pytest.approx(12.5)


def test_a_shift_across_the_back_is_one_like_any_other():
    assert math.degrees(common_shift(estimate(175, 20), estimate(-170, 35))) == pytest.approx(15)


@pytest.mark.parametrize(
    "after",
    [
        AZIMUTHS,
        (171, 69, -48),  # talkers sway
        (170, 70, -30),  # one has moved
        (182, 82, -50),  # two have
        (182, 70 - 12, -38),  # each by its own
        (182, 82),  # one has left
        (170 + 60, 70 + 60, -50 + 60),  # too far to be believed
    ],
)
def test_anything_else_is_no_shift_of_everybody(after):
    assert common_shift(estimate(*AZIMUTHS), estimate(*after)) is None


def test_one_talker_alone_tells_nothing():
    assert common_shift(estimate(10), estimate(22)) is None


@pytest.mark.soak
def test_other_people_seldom_stand_where_a_shift_would_put_them():
    chance = np.random.default_rng(0)
    for talkers, seldom in ((2, 0.02), (3, 0.003)):
        drawn = chance.uniform(-180, 180, (2000, 2, talkers))
        taken = sum(common_shift(estimate(*before), estimate(*after)) is not None for before, after in drawn)
        assert taken / len(drawn) < seldom


def test_the_mission_says_so_and_goes_on_with_the_azimuths_it_knew():
    one = drops_once(Turned())
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert [round(math.degrees(event.shift)) for event in one.said(Slipped)] == [12]
    assert put_right(one) == [12.0]
    assert last_azimuths(one) == pytest.approx(AZIMUTHS)
    *_, explored, corrected = one.said(SourcesEstimated)
    assert corrected.rotations == explored.rotations == 2


def test_what_was_heard_is_remembered_with_headings_put_right():
    stft = Stft(RATE, 512, 128)
    context = Context(SETTINGS, Tools(Turned(shifts=(12,)), stft, OneGroupEach(), stft, Likes(1)))
    context.surveyed = estimate(*AZIMUTHS), False

    def brain():
        yield from hop(context)
        return (yield from survey(context))

    found, _ = Rig(brain()).run()
    assert [math.degrees(source.azimuth) for source in found.sources] == pytest.approx(AZIMUTHS)
    for heard in (context.explored, context.observations):
        assert [round(math.degrees(each.heading)) for each in heard] == [-12, 3, 18]
    assert [math.degrees(source.azimuth) for source in context.beliefs[-1].sources] == pytest.approx(AZIMUTHS)


def test_headings_that_an_explorer_keeps_are_put_right_with_that_of_the_observation():
    parts = [Observation(heading, np.zeros(1), np.ones(1), 1.0, features=heading) for heading in (0.1, 0.2, 0.3)]
    right = shifted(together(parts), -0.1)
    assert right.heading == pytest.approx(0.1)
    assert sectors_of(right).headings == pytest.approx([0.0, 0.1, 0.2])
    assert sectors_of(right).histograms == (0.1, 0.2, 0.3)


def test_after_a_slip_the_alignment_is_that_of_the_azimuths_put_right():
    slipped, other = (drops_once(Turned(shifts=shifts)) for shifts in ((0, 12), (0, 0)))
    slipped.run()
    other.run()
    goals = [[output.goal for output in one.outputs if output.goal is not None][-1] for one in (slipped, other)]
    assert goals[0] == pytest.approx(goals[1])


def test_a_talker_who_walks_is_no_slip():
    one = drops_once(Turned(shifts=(0, (0, 0, 12))))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert one.said(Slipped) == [] == put_right(one)


@dataclass
class Homing(Rig):
    """A turntable that goes and looks for its switch when it is told of a slip."""

    def _obey(self, output):
        super()._obey(output)
        if output.slipped is not None:
            self.goal, self.moving = 0.0, 40


def test_the_mission_waits_until_the_zero_is_found():
    one = drops_once(Turned())
    homing = Homing(one.brain)
    assert homing.run().outcome is Outcome.TARGET_FOUND
    place = next(n for n, output in enumerate(homing.outputs) if output.slipped is not None)
    following = homing.outputs[place + 1 : place + 40]
    assert [output.goal for output in following] == [None] * 39
    assert not any(isinstance(event, SourcesEstimated) for output in following for event in output.events)


GRID = np.linspace(-1.2, 1.2, 241) * 0.05 / 343
HEADING = math.radians(30)


def heard(*degrees, width=0.03):
    """What is heard at 30 deg of talkers at these azimuths [deg]."""
    unit = 0.05 / 343
    peaks = (np.exp(-(((GRID / unit - math.cos(math.radians(a) - HEADING)) / width) ** 2)) for a in degrees)
    return Observation(HEADING, GRID, sum(peaks), 1.0)


def test_one_orientation_tells_by_how_much_everybody_has_turned():
    turn, gain = common_turn(heard(40 + 8, 155 + 8, -80 + 8), estimate(40, 155, -80), 0.05, 343.0)
    assert abs(math.degrees(turn)) == pytest.approx(8, abs=1.01)
    assert gain > 2


@pytest.mark.parametrize("now", [(40, 155, -80), (41, 154, -81), (40, 155), (40, -80), (155, -80), (40, 155, -100)])
def test_talkers_who_stay_pause_or_walk_alone_are_no_turn_of_everybody(now):
    _, gain = common_turn(heard(*now), estimate(40, 155, -80), 0.05, 343.0)
    assert gain < 2


@pytest.mark.parametrize(
    ("now", "suspicious"),
    [
        ((40 + 8, 155 + 8, -80 + 8), True),
        ((40 + 2, 155 + 2, -80 + 2), False),  # likelier than none, but nothing to turn for
        ((40, 155, -100), False),  # a turn of everybody is a little likelier than none, but not by enough
    ],
)
def test_a_suspicion_needs_a_turn_that_is_large_and_likely(now, suspicious):
    class Hears(ThreeTalkers):
        def observe(self, *_, frame_period=None):
            return heard(*now, width=0.008 if max(now) == 157 else 0.03)

    stft = Stft(RATE, 512, 128)
    context = Context(SETTINGS, Tools(Hears(), stft, OneGroupEach(), stft, Likes(1)))
    silence = Listening(HEADING, np.zeros((2, RATE), np.float32))
    turn, gain = common_turn(Hears().observe(), estimate(40, 155, -80), 0.05, 343.0)
    assert (gain > 2) or (abs(turn) > math.radians(3))  # one of both would do
    assert bool(suspicion(context, estimate(40, 155, -80), silence)) is suspicious
    assert not suspicion(context, estimate(40, 155, -80), replace(silence, deaf=True)), "a microphone was dead"


@dataclass
class Listener(ThreeTalkers):
    """An explorer that hears everybody turned by 10 deg in one period of the run, and finds it so afterwards."""

    explored: int = 0
    turned_in: int = 1  # period of the run
    runs: int = 0

    def observe(self, spectrogram, frequencies, heading, noise_psd, *, frame_period=None):
        run = spectrogram.shape[-1] > 1.4 * RATE / 128
        self.runs += run
        shift = 10 if run and self.runs == self.turned_in else 0
        return replace(heard(*(a + shift - math.degrees(heading) + 30 for a in self.azimuths)), heading=heading)

    def estimate(self, observations):
        self.explored += len(observations) == 1
        shift = 10 if self.explored > 1 else 0
        turned = replace(self, azimuths=tuple(a + shift for a in self.azimuths))
        return ThreeTalkers.estimate(turned, observations)


def test_a_run_in_which_everybody_seems_to_have_turned_is_followed_by_an_exploration():
    one = rig(explorer=Listener(), settings=replace(SETTINGS, runs=2))
    assert one.run().outcome is Outcome.TARGET_FOUND
    (doubt,) = one.said(Doubted)
    assert "together by 10 deg" in doubt.reason
    assert put_right(one) == [10.0]
    assert last_azimuths(one) == pytest.approx(AZIMUTHS)


def test_on_the_last_attempt_nothing_is_doubted_that_still_sounds_like_the_target():
    one = rig(explorer=Listener(), settings=replace(SETTINGS, max_restarts=0))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert one.said(Doubted) == []
    assert len([event for event in one.said(OrientationHeard) if event.index == 0]) == 1
