"""The mission follows who moves while it listens: fed hop by hop, turning a little, separating piece by piece."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from mission_bench import RATE, SETTINGS, Likes, OneGroupEach, Rig, ThreeTalkers, rig
from ross_payload.dsp.stft import Stft
from ross_payload.events import (
    Checked,
    Doubted,
    Estimate,
    Outcome,
    Separated,
    SourceEstimate,
    SourcesEstimated,
    SourcesTracked,
    State,
    StateChanged,
    TurnStarted,
)
from ross_payload.interfaces import Attitude, AudioBlock, AudioFlag, Clip, Groups, Input
from ross_payload.localization import tracking
from ross_payload.mission.context import Context, Listening
from ross_payload.mission.heading_hold import LOOKING, REALIGNED, attend
from ross_payload.mission.mission_sequence import mission
from ross_payload.mission.moving_sources import recognise_moving
from ross_payload.mission.settings import Tools
from ross_payload.mission.source_tracking import SourceTracker
from ross_payload.mission.voice_evidence import Evidence
from ross_payload.mission_state import MissionState, reduce
from ross_payload.pointing import Pointing

FS, HOP = 16000, 160
SPACING, SPEED = 0.05, 343.0


def estimate(*degrees):
    return Estimate(
        tuple(SourceEstimate(math.radians(a), 0.01, 0.9, resolved=True) for a in degrees), certain=True, directness=1.0
    )


def noises(paths, seconds, heading, seed=0):
    """Noise from azimuths [deg] (functions of time) at an array that points to a heading [rad], (2, n).

    As with speech, every source is loud in few bands at a time, so that most bins belong to one of them.
    """
    rng, n = np.random.default_rng(seed), round(seconds * FS)
    heard = 1e-4 * rng.standard_normal((2, n))
    frame, hop = 512, 256
    window = np.sin(np.pi * np.arange(frame) / frame)
    frequencies = np.fft.rfftfreq(frame, 1 / FS)
    for path in paths:
        for index, first in enumerate(range(0, n - frame, hop)):
            if index % 6 == 0:
                loud = np.append(np.repeat(rng.random(16) < 0.25, 16), False)
            delay = SPACING / SPEED * math.cos(math.radians(path(first / FS)) - heading)
            spectrum = np.fft.rfft(rng.standard_normal(frame) * window) * loud
            heard[0, first : first + frame] += window * np.fft.irfft(spectrum)
            heard[1, first : first + frame] += window * np.fft.irfft(
                spectrum * np.exp(2j * np.pi * frequencies * delay)
            )
    return (0.05 * heard).astype(np.float32)


def feed(tracker, samples, heading):
    said = []
    for first in range(0, samples.shape[1], HOP):
        block = AudioBlock(samples[:, first : first + HOP], first, first / FS)
        pointing = Pointing(joint=heading)
        event = tracker.hear(Input(block, heading, pointing, True, Attitude(0.0)), (first + HOP) / FS)
        said += [event] if event is not None else []
    return said


def tracker_of(told, source=0):
    quiet = (0.05e-4 * np.random.default_rng(9).standard_normal((2, FS))).astype(np.float32)
    return SourceTracker(told, source, Stft(FS, 1024, 256), SPACING, SPEED, quiet, None)


def test_who_walks_is_told_and_who_stays_keeps_the_place_of_the_exploration():
    def walks(time):
        return 100.0 + 8.0 * max(time - 1.0, 0.0)

    tracker = tracker_of(estimate(-60, 100))
    said = feed(tracker, noises([lambda time: -60.0, walks], 7.0, 0.9), 0.9)
    assert [round(b.time - a.time, 2) for a, b in pairwise(said)] == pytest.approx([0.5] * (len(said) - 1), abs=0.05)
    assert tracker.moved == [False, True]
    last = said[-1]
    assert math.degrees(last.estimate.sources[1].azimuth) == pytest.approx(walks(last.time), abs=5.0)
    assert math.degrees(last.rates[1]) == pytest.approx(8.0, abs=3.0)
    assert last.estimate.sources[0].azimuth == pytest.approx(math.radians(-60))
    assert last.rates[0] == 0.0
    assert tracker.azimuths_at([1.0])[1, 0] == pytest.approx(math.radians(100), abs=0.05)


def test_who_has_gone_far_acts_sooner():
    """A delay that has changed by twice what echoes can do needs half of the corrections."""
    tracker = tracker_of(estimate(-60, 100))
    needed = []
    for shift in (8.0, 30.0):
        there = tracking.begin(estimate(-60, 100 + shift), SPACING, SPEED)
        tracker.tracks = replace(there, heading=0.9)
        tracker.moved, tracker._streak, count = [False, False], [0, 0], 0
        while not tracker.acts and count < 20:
            tracker.corrected(0.25 * count)
            count += 1
        needed.append(count)
    assert needed == [2, 1]
    assert tracker.moved == [False, True]


@pytest.mark.soak
def test_nobody_acts_while_everybody_stays():
    tracker = tracker_of(estimate(-20, 100, -150))
    said = feed(tracker, noises([lambda t: -20.0, lambda t: 100.0, lambda t: -150.0], 4.0, 0.9), 0.9)
    assert not tracker.acts
    assert not tracker.stirred
    assert tracker.heading_for(9.0, Pointing(joint=0.9), -9, 9, settled=True) is None
    assert [s.azimuth for s in said[-1].estimate.sources] == [s.azimuth for s in tracker.anchor.sources]


def test_when_everybody_has_moved_alike_the_array_has_slipped():
    tracker = tracker_of(estimate(-60, 100, -150))
    feed(tracker, noises([lambda t: -48.0, lambda t: 112.0, lambda t: -138.0], 5.0, 0.9), 0.9)
    assert not tracker.acts


class Moving(SourceTracker):
    """Says that source 0 has moved by 60 degrees, and where to turn; ``sure`` of it or not."""

    sure = True

    def hear(self, hop, time):
        self.moved = [True, *[False] * (self.anchor.k - 1)]
        self.asked = getattr(self, "asked", 0) + 1
        if self.asked % 50:
            return None
        return SourcesTracked(time, self.estimate, (0.1,) * self.anchor.k, (0.0,) * self.anchor.k)

    @property
    def lost(self):
        return not self.sure

    @property
    def azimuths(self):
        told = np.array([source.azimuth for source in self.anchor.sources])
        told[0] += math.radians(60)
        return told

    def heading_for(self, time, here, lower, upper, *, settled):
        return here.heading + 0.2 if self.asked == 30 else None


class Unsure(Moving):
    sure = False


class Looking(Moving):
    """Turns although nobody is known to have moved."""

    def hear(self, hop, time):
        super().hear(hop, time)
        self.moved = [False] * self.anchor.k


def mission_with(tracker, **changes):
    stft = Stft(RATE, 512, 128)
    tools = Tools(ThreeTalkers(), stft, OneGroupEach(), stft, Likes(1), tracker=tracker)
    return Rig(mission(replace(SETTINGS, track=True, **changes), tools))


def test_a_small_turn_is_made_while_it_listens_and_the_period_goes_on():
    one = mission_with(Moving)
    assert one.run().outcome is Outcome.TARGET_FOUND
    (turn,) = [event for event in one.said(TurnStarted) if event.reason == REALIGNED]
    (period,) = one.said(Separated)
    assert turn.joint in [output.goal for output in one.outputs]
    assert turn.time > period.start / RATE
    assert period.voices.shape[1] == round(SETTINGS.run * RATE)
    assert "pieces" in period.why
    assert len(one.said(SourcesTracked)) == 3
    assert one.joint == pytest.approx(turn.joint)


def attended(samples, told):
    """What a mission says that listens to the first source at 0.9 rad for as long as there are samples."""
    settings = replace(SETTINGS, rate=FS, spacing=SPACING, speed_of_sound=SPEED, track=True)
    stft = Stft(FS, 512, 128)
    context = Context(settings, Tools(ThreeTalkers(), stft, OneGroupEach(), stft, Likes(1)))
    context.lead_in = (0.05e-4 * np.random.default_rng(9).standard_normal((2, FS))).astype(np.float32)
    pointing = Pointing(joint=0.9)
    context.last = Input(AudioBlock(samples[:, :0], 0, 0.0), 0.9, pointing, True, Attitude(0.0))
    context.track(told, 0)
    step, said = attend(context, samples.shape[1] / FS), []
    output = next(step)
    for first in range(0, samples.shape[1], HOP):
        said += output.events
        block = samples[:, first : first + HOP]
        flags = AudioFlag.CLIPPED if np.abs(block).max() >= 1 - 2**-15 else AudioFlag.NONE
        hop = Input(AudioBlock(block, first, first / FS, flags=flags), 0.9, pointing, True, Attitude(0.0))
        try:
            output = step.send(hop)
        except StopIteration as end:
            return said, end.value
    raise AssertionError("it goes on listening")


@pytest.mark.parametrize(("microphone", "noise", "offset"), [(0, 0, 0), (1, 0, 0), (0, 3e-5, 0), (1, 0, 1)])
def test_a_microphone_that_dies_is_no_reason_to_turn(microphone, noise, offset):
    samples = noises([lambda _, a=a: a for a in (-60.0, 30.0, 120.0)], 14.0, 0.9)
    samples[microphone, 4 * FS :] = offset + noise * np.random.default_rng(1).standard_normal(10 * FS)
    said, listening = attended(samples, estimate(-60, 30, 120))
    assert [event.reason for event in said if isinstance(event, TurnStarted)] == []
    assert listening.deaf
    assert any(isinstance(event, SourcesTracked) and event.time > 13 for event in said), "telemetry goes on"


@pytest.mark.parametrize("factor", [1, 0.1])
def test_a_microphone_that_comes_in_both_channels_is_no_reason_to_turn(factor):
    """All seem to be at broadside at once, as where a sound server makes one channel of two."""
    samples = noises([lambda _, a=a: a for a in (-60.0, 30.0, 120.0)], 10.0, 0.9)
    begin = 4 * FS + 700
    samples[1, begin:] = factor * samples[0, begin:]
    said, listening = attended(samples, estimate(-60, 30, 120))
    assert [event.reason for event in said if isinstance(event, TurnStarted)] == []
    assert listening.deaf


def test_who_walks_while_a_microphone_is_dead_is_found_when_it_works_again():
    def walks(time):
        return 100.0 + 8.0 * min(max(time - 2.0, 0.0), 4.0)

    samples = noises([lambda _: -60.0, walks], 11.0, 0.9)
    samples[1, 2 * FS : 6 * FS] = 0
    said, _ = attended(samples, estimate(-60, 100))
    last = next(event for event in reversed(said) if isinstance(event, SourcesTracked))
    assert math.degrees(last.estimate.sources[1].azimuth) == pytest.approx(132, abs=6)
    assert last.estimate.sources[0].azimuth == pytest.approx(math.radians(-60))


def test_a_look_is_not_said_to_be_a_move():
    one = mission_with(Looking)
    one.run()
    small = [event.reason for event in one.said(TurnStarted) if event.time > one.said(Checked)[-1].time]
    assert small == [LOOKING]


def test_a_tracker_knows_for_how_long_the_sources_have_rested():
    told = []

    class Notes(Moving):
        def __post_init__(self):
            super().__post_init__()
            told.append(self.rested)

    one = mission_with(Notes)
    one.run()
    assert told == [pytest.approx(SETTINGS.unit * (1 + one.said(SourcesEstimated)[-1].rotations))]


def test_it_explores_again_when_the_track_is_lost():
    one = mission_with(Unsure)
    one.run()
    assert one.said(Doubted)[0].reason == "the target's track was lost"
    assert len([event for event in one.said(SourcesEstimated) if event.final]) > 1


def test_nothing_is_tracked_where_it_is_not_wanted():
    one = rig()
    one.run()
    assert one.said(SourcesTracked) == []
    assert [event for event in one.said(StateChanged) if event.state is State.RUN]


def test_the_state_of_the_mission_has_the_azimuths_of_the_track():
    told = estimate(10, 20)
    after = reduce(MissionState(estimate=estimate(0, 20), target=0), SourcesTracked(1.0, told, (0.1, 0.0), (0.0, 0.0)))
    assert (after.estimate, after.target) == (told, 0)


def test_who_rests_does_not_move_where_the_explorer_hears_in_long_frames():
    stft, told = Stft(FS, 512, 128), estimate(-60, 100)
    settings = replace(SETTINGS, rate=FS, spacing=SPACING, speed_of_sound=SPEED, track=True)
    context = Context(settings, Tools(ThreeTalkers(), Stft(FS, 8192, 2048), OneGroupEach(), stft, Likes(1)))
    context.track(told, 0)
    said = feed(context.tracker, noises([lambda _: -60.0, lambda _: 100.0], 4.0, 0.9), 0.9)
    assert said
    assert not context.tracker.anybody
    assert context.tracker.stft == Stft(FS, 512, 128)


def test_a_period_is_separated_piece_by_piece_with_the_delays_of_each():
    heard = []

    class Notes:
        name = "notes"

        def batch(self, spectrogram, scene):
            heard.append(np.asarray(scene.tau))
            signals = np.stack([spectrogram[0] * (k + 1) for k in range(scene.n_sources)])
            return Groups(signals, tuple((k,) for k in range(scene.n_sources)), self.name)

    stft = Stft(RATE, 512, 128)
    context = Context(SETTINGS, Tools(ThreeTalkers(), stft, Notes(), stft, Likes(1)))
    told = estimate(0, 90)
    context.tracker = SourceTracker(told, 0, stft, SPACING, SPEED, None, None)
    context.tracker.moved = [False, True]
    context.tracker.places = [(t, np.radians([0.0, 90.0 + 20.0 * t])) for t in np.arange(0.0, 4.01, 0.25)]
    samples = np.full((2, 4 * RATE), 0.1, np.float32)
    found = recognise_moving(context, told, 0, Listening(0.0, samples))
    assert len(heard) > 3
    unit = SPACING / SPEED
    assert all(tau[0] == pytest.approx(unit) for tau in heard)
    assert heard[0][1] > heard[-1][1]
    assert np.allclose(found.voices[1], 0.2, atol=0.01)  # faded into one another without a dip
    assert found.groups.why == f"in {len(heard)} pieces"
    assert [score.members for score in found.scores] == [(0,), (1,)]


def test_every_reason_is_told_of_a_period_that_is_separated_for_different_ones():
    reasons = iter(["a gap", "a gap", "noise", *["a gap", ""] * 99])

    class Reasons:
        name = "reasons"

        def batch(self, spectrogram, scene):
            return Groups(np.stack([spectrogram[0]] * 2), ((0,), (1,)), self.name, next(reasons))

    stft, told = Stft(RATE, 512, 128), estimate(0, 90)
    context = Context(SETTINGS, Tools(ThreeTalkers(), stft, Reasons(), stft, Likes(1)))
    context.tracker = SourceTracker(told, 0, stft, SPACING, SPEED, None, None)
    context.tracker.moved = [False, True]
    context.tracker.places = [(t, np.radians([0.0, 90.0 + 20.0 * t])) for t in np.arange(0.0, 4.01, 0.25)]
    found = recognise_moving(context, told, 0, Listening(0.0, np.full((2, 4 * RATE), 0.1, np.float32)))
    assert found.groups.why.startswith("a gap; noise, in ")


def test_a_separator_that_does_not_know_who_is_in_its_groups_ends_nothing_when_somebody_moves():
    class Knows:
        name = "knows"

        def batch(self, spectrogram, scene):
            return Groups(np.stack([spectrogram[0]] * 2), ((0,), ()), self.name)

    stft, told = Stft(RATE, 512, 128), estimate(0, 90)
    context = Context(SETTINGS, Tools(ThreeTalkers(), stft, Knows(), stft, Likes(1)))
    context.tracker = SourceTracker(told, 0, stft, SPACING, SPEED, None, None)
    context.tracker.moved = [False, True]
    context.tracker.places = [(t, np.radians([0.0, 90.0 + 20.0 * t])) for t in np.arange(0.0, 4.01, 0.25)]
    found = recognise_moving(context, told, 0, Listening(0.0, np.full((2, 4 * RATE), 0.1, np.float32)))
    assert [score.members for score in found.scores] == [(0,), (1,)]
    assert not found.voices[1].any()


def test_where_everybody_was_is_forgotten_also_while_nobody_moves():
    stft, told = Stft(RATE, 512, 128), estimate(0, 90)
    context = Context(SETTINGS, Tools(ThreeTalkers(), stft, OneGroupEach(), stft, Likes(1)))
    context.tracker = SourceTracker(told, 0, stft, SPACING, SPEED, None, None)
    context.tracker.places = [(t, np.radians([0.0, 90.0])) for t in np.arange(0.0, 4.01, 0.25)]
    recognise_moving(context, told, 0, Listening(0.0, np.full((2, 3 * RATE), 0.1, np.float32)))
    assert [time for time, _ in context.tracker.places] == [2.75, 3.0, 3.25, 3.5, 3.75, 4.0]


def test_a_part_of_what_was_heard_has_the_rotor_speeds_of_its_own_hops():
    speeds = np.arange(100.0, 110.0)[:, None]
    heard = Listening(0.0, np.zeros((2, 1000), np.float32), rotor_speeds=speeds)
    assert heard.speeds(0, 1000).ravel().tolist() == speeds.ravel().tolist()
    assert heard.speeds(300, 500).ravel().tolist() == [103, 104]
    assert heard.speeds(310, 320).ravel().tolist() == [103]
    assert heard.speeds(-200, 1100).ravel().tolist() == [100, 100, *range(100, 110), 109]
    assert replace(heard, rotor_speeds=None).speeds(0, 100) is None


def test_a_period_in_which_the_array_has_turned_is_cut_also_when_nobody_has_moved():
    heard = []

    class Notes:
        name = "notes"

        def batch(self, spectrogram, scene):
            heard.append(np.asarray(scene.tau))
            return Groups(np.stack([spectrogram[0]] * 2), ((0,), (1,)), self.name)

    stft, told = Stft(RATE, 512, 128), estimate(60, 150)
    context = Context(SETTINGS, Tools(ThreeTalkers(), stft, Notes(), stft, Likes(1)))
    context.tracker = SourceTracker(told, 0, stft, SPACING, SPEED, None, None)
    headings = np.radians(np.repeat([0.0, 30.0], 200))
    samples = np.full((2, 4 * RATE), 0.1, np.float32)
    for turned, pieces in ((-1.0, 1), (2.0, 2)):
        heard.clear()
        context.tracker.turned = turned
        evidence = Evidence(RATE, context.tools.voiceprint)
        evidence.hear(1, Clip(samples[0][: round(0.7 * RATE)]), seconds=0.7)
        recognise_moving(context, told, 0, Listening(math.radians(15), samples, 0.3, headings), evidence)
        assert len(heard) == pieces
        assert evidence.seconds(1) == pytest.approx(4.7)  # what was heard before counts, too
    unit = SPACING / SPEED
    assert heard[0] == pytest.approx(unit * np.cos(np.radians([60, 150])))
    assert heard[1] == pytest.approx(unit * np.cos(np.radians([30, 120])))
