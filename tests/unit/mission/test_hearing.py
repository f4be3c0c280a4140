"""Nobody is said to be absent whom the microphones could not have given, and no voice clean that they have spoilt."""

from dataclasses import replace

import numpy as np
import pytest

from mission_bench import HOP, RATE, SETTINGS, OneGroupEach, ThreeTalkers, rig
from ross_payload.events import Answer, Checked, Finished, Outcome, Separated, State
from ross_payload.interfaces import AudioFlag, Quality
from ross_payload.mission.hearing import Hearing
from ross_payload.orders import Explore
from session_bench import Bench, make

SILENT, DEAD = np.array([[0], [0]], np.float32), np.array([[1], [1e-3]], np.float32)


def spoilt(factors, begin=0.0, end=1e9, *, every=None, flag=AudioFlag.NONE):
    """Multiply what both microphones give from one time to another [s], of ``every`` s the first 0.7 of them."""

    def on_hop(_, heard):
        time = heard.block.index / RATE
        if begin <= time < end and (every is None or time % every < 0.7 * every):
            return replace(heard, block=replace(heard.block, samples=heard.block.samples * factors, flags=flag))
        return heard

    return on_hop


@pytest.mark.parametrize(
    ("factors", "why"),
    [(SILENT, "no audio came for 100 % of the time"), (DEAD, "microphone 2 was dead for 100 % of the time")],
)
@pytest.mark.parametrize("explorer", [ThreeTalkers(azimuths=()), ThreeTalkers()])
def test_who_was_not_heard_is_not_said_to_be_absent(factors, why, explorer):
    result = rig(likes=7, explorer=explorer).run(spoilt(factors))
    assert result.outcome is Outcome.FAULT
    assert result.reason == f"cannot tell whether the target is there: {why}"


def test_microphones_that_were_pulled_out_before_the_end_are_no_finding_either():
    patient = replace(SETTINGS, unit=3.5)
    whole = rig(likes=7, settings=patient)
    assert whole.run().outcome is Outcome.NO_TARGET
    end = whole.hops * HOP / RATE
    result = rig(likes=7, settings=patient).run(spoilt(SILENT, end - 2.2))
    assert result.outcome is Outcome.FAULT
    assert result.reason == "cannot tell whether the target is there: no audio came for the last 2 s"


def test_gaps_and_knocks_are_no_reason_to_doubt():
    assert rig(likes=7).run(spoilt(SILENT, 1.0, 1.5)).outcome is Outcome.NO_TARGET
    assert rig(likes=7).run(spoilt(DEAD, 1.0, 1.5)).outcome is Outcome.NO_TARGET


@pytest.mark.parametrize("explorer", [ThreeTalkers(azimuths=()), ThreeTalkers()])
def test_a_noise_gate_between_words_does_not_hide_who_is_there_but_a_source_with_gaps_does(explorer):
    gated = rig(likes=7, explorer=explorer).run(spoilt(SILENT, every=1.0))
    assert gated.outcome is Outcome.NO_TARGET
    gaps = rig(likes=7, explorer=explorer).run(spoilt(SILENT, every=1.0, flag=AudioFlag.MISSING))
    assert gaps.outcome is Outcome.FAULT
    assert "no audio came for 7" in gaps.reason


def test_microphones_that_give_less_than_a_step_of_16_bits_are_not_dead():
    """Without dither the offset of each decides whether its noise shows at all."""
    hearing, generator = Hearing(), np.random.default_rng(4)
    noise = 0.1 * generator.standard_normal((2, 160 * 1000)) + np.array([[0.0], [0.5]])
    noise[:, -160 * 200 :] += 100 * generator.standard_normal(160 * 200)
    for hop in np.split((np.round(noise) / 2**15).astype(np.float32), 1000, axis=1):
        hearing.add(hop, 16000)
    assert hearing.fault() == ""


@pytest.mark.parametrize(("factors", "outcome"), [(DEAD, Outcome.FAULT), (DEAD * 0 + 1, Outcome.COMPLETED)])
def test_an_exploration_that_heard_nothing_does_not_say_that_nobody_is_there(factors, outcome):
    def make_deaf(config):
        kit = make(config)
        return replace(kit, tools=replace(kit.tools, explorer=ThreeTalkers(azimuths=())))

    bench = Bench(make=make_deaf)
    bench.factors = factors
    bench.hop(Explore(number=1))
    said = bench.over(1)
    assert said.answer is (Answer.FAILED if outcome is Outcome.FAULT else Answer.DONE)
    assert [event.outcome for event in bench.events if isinstance(event, Finished)] == [outcome]
    assert bench.state() is State.DONE, "nothing has to be re-armed"
    assert ("microphone 2 was dead" in said.reason) is (outcome is Outcome.FAULT)


class Expecting(OneGroupEach):
    """A separator that expects 9 dB of everybody."""

    def batch(self, spectrogram, scene):
        groups = super().batch(spectrogram, scene)
        return replace(groups, quality=(Quality(9.0, 7.0),) * len(groups.members))


@pytest.mark.parametrize(
    ("flag", "every", "told"),
    [
        (AudioFlag.CLIPPED, 5, None),
        (AudioFlag.CLIPPED, 20, 9.0),
        (AudioFlag.MISSING, 20, None),
        (AudioFlag.MISSING, 100, 9.0),
        (AudioFlag.INVALID, 20, None),
        (AudioFlag.INVALID, 100, 9.0),
        (AudioFlag.NONE, 1, 9.0),
    ],
)
def test_how_clean_a_voice_is_is_not_told_where_much_of_it_is_clipped_or_missing(flag, every, told):
    def on_hop(bench, heard):
        return replace(heard, block=replace(heard.block, flags=AudioFlag.NONE if bench.hops % every else flag))

    bench = rig(separator=Expecting())
    bench.run(on_hop)
    scores = bench.said(Separated)[-1].groups
    assert [score.si_sdr for score in scores] == [told] * len(scores)
    assert {score.si_sdr for event in bench.said(Checked) for score in event.groups} <= {told, None}


def test_hum_and_wind_at_one_microphone_do_not_kill_the_other():
    hearing, rate, generator = Hearing(), 16000, np.random.default_rng(2)
    noise = 1e-3 * generator.standard_normal((2, 160 * 300))
    noise[1] += 0.3 * np.sin(2 * np.pi * 50 / rate * np.arange(160 * 300)) + 0.2
    for hop in np.split(noise.astype(np.float32), 300, axis=1):
        hearing.add(hop, rate)
    assert hearing.fault() == ""


def heard_of_late(samples, flag=AudioFlag.NONE, seconds=1.0):
    hearing = Hearing()
    for hop in np.split(samples[:, : round(seconds * 16000)].astype(np.float32), round(100 * seconds), axis=1):
        hearing.add(hop, 16000, flag)
    return hearing.deaf


def talk():
    generator = np.random.default_rng(6)
    return 0.1 * generator.standard_normal((2, 16000)) * np.sin(np.arange(16000) / 600)


@pytest.mark.parametrize(
    ("factors", "flag"),
    [
        ((0, 1), AudioFlag.NONE),
        ((1, 0), AudioFlag.NONE),
        ((1, 1e-2), AudioFlag.NONE),
        ((20, 20), AudioFlag.CLIPPED),
        ((1, 50), AudioFlag.CLIPPED),
        ((0, 0), AudioFlag.MISSING),
    ],
)
def test_sound_of_which_a_microphone_gave_another_tells_of_no_direction(factors, flag):
    assert heard_of_late(np.clip(np.array(factors)[:, None] * talk(), -1, 1), flag)


def test_a_channel_that_stays_at_full_scale_tells_of_no_direction():
    stuck = talk()
    stuck[0] = 1 - 2**-23
    assert heard_of_late(stuck, AudioFlag.CLIPPED)


def test_a_dead_microphone_stays_dead_while_the_other_gives_nothing_either():
    """Behind a noise gate a pause is silence: then nothing is known of either."""
    sound = talk() * np.array([[1], [0]])
    sound[:, 8000:12800] = 0
    assert heard_of_late(sound, seconds=0.7)
    hearing = Hearing()
    for hop in np.split(np.tile(sound, 2).astype(np.float32), 200, axis=1):
        hearing.add(hop, 16000)
    assert hearing.dead_for(1.0) == 2


def test_a_microphone_whose_noise_gate_closes_first_is_not_dead_in_the_pause():
    """The pause would make a period one that tells of nobody."""
    sound = talk()
    sound[:, 8000:] = 0
    sound[1, 6400:] = 0
    assert not heard_of_late(sound, seconds=0.7)


@pytest.mark.parametrize("factor", [1, 0.1, -1])
def test_one_microphone_in_both_channels_tells_of_no_direction(factor):
    assert heard_of_late(np.array([[1], [factor]]) * talk()[:1])


@pytest.mark.parametrize(
    ("factors", "flag"),
    [((1, 0.3), AudioFlag.NONE), ((4, 4), AudioFlag.CLIPPED), ((1e-5, 1e-5), AudioFlag.NONE), ((0, 0), AudioFlag.NONE)],
)
def test_a_few_peaks_at_full_scale_a_soft_sound_and_a_noise_gate_are_heard(factors, flag):
    assert not heard_of_late(np.clip(np.array(factors)[:, None] * talk(), -1, 1), flag)


def test_a_microphone_that_works_again_is_heard_again():
    sound = talk()
    sound[1, :8000] = 0
    assert heard_of_late(sound, seconds=0.5)
    assert not heard_of_late(sound)
