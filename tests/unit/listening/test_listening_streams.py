"""How a stream sounds: changes without a click, gain, limits, indices, faults, and what is said of it."""

from dataclasses import replace

import numpy as np
import pytest

from listening_bench import HOP, MIXTURE, NOISE, RATE, Bench, azimuth, noise, source
from ross_payload.events import State, StateChanged
from ross_payload.listening.limiter import CEILING

SWITCHED_S = 0.5  # within which another selection is heard


def click(samples, low=1.0):
    """The largest second difference of a signal, relative to what a tone of 440 Hz of amplitude 1 has."""
    return np.abs(np.diff(samples, 2)).max() / (low * (2 * np.pi * 440 / RATE) ** 2)


def test_another_selection_is_heard_within_half_a_second_and_without_a_click():
    bench = Bench({0: MIXTURE})
    bench.know()
    bench.hear(1.0)
    for selection, factor in ((source(1), 4), (source(0), 2), (MIXTURE, 1), (azimuth(-50), 6)):
        bench.want(0, selection=selection)
        before = bench.index
        bench.hear(SWITCHED_S)
        kept = bench.kept[0]
        assert bench.factor(0, last=0.05) == factor
        assert kept.blocks[-1].index + len(kept.blocks[-1].samples) - before > 0.4 * RATE
    assert click(bench.kept[0].samples[RATE // 4 :], low=0.1) < 6 * 1.5  # six times as loud, and hardly anything more


def test_the_test_finds_a_click():
    tone = np.sin(2 * np.pi * 440 / RATE * np.arange(RATE))
    assert click(tone) < 1.001
    assert click(np.where(np.arange(RATE) < 8010, tone, 2 * tone)) > 9


def test_gain_and_mute_take_effect_at_once_and_the_level_tells():
    bench = Bench({0: MIXTURE})
    bench.hear(1.5)
    assert bench.status(0).level_db == pytest.approx(-23.0, abs=0.3)
    bench.want(0, gain_db=-20.0)
    bench.hear(1.5)
    assert bench.factor(0) == 0.1
    assert bench.status(0).level_db == pytest.approx(-43.0, abs=0.3)
    bench.want(0, muted=True)
    bench.hear(1.5)
    assert not bench.kept[0].samples[-RATE // 2 :].any()
    assert (bench.status(0).muted, bench.status(0).level_db) == (True, -120)
    bench.want(0, muted=False, gain_db=0.0)
    bench.hear(0.5)
    assert bench.factor(0) == 1


def test_what_is_too_loud_is_limited():
    bench = Bench({0: MIXTURE})
    bench.want(0, gain_db=40.0)
    bench.hear(0.5)
    assert np.abs(bench.kept[0].samples).max() <= CEILING * 1.0001


def test_streams_have_nothing_to_do_with_each_other():
    bench = Bench({0: MIXTURE, 1: source(0), 2: source(2)})
    bench.know()
    bench.hear(1.0)
    assert [bench.factor(number) for number in range(3)] == [1, 2, 6]
    bench.want(1, on=False)
    bench.hear(0.5)
    assert bench.kept[1].closed
    assert not bench.kept[2].closed
    assert bench.status(1).on is False
    first = bench.kept[1]
    bench.want(1, on=True)
    bench.hear(0.5)
    assert bench.kept[1] is not first
    assert bench.kept[1].first >= first.blocks[-1].index


def test_a_stream_that_starts_late_tells_the_index_of_its_first_sample():
    bench = Bench({0: MIXTURE, 1: MIXTURE}, noise)
    bench.want(1, on=False)
    bench.hear(1.0)
    bench.want(1, on=True)
    bench.hear(1.0)
    late, kept = bench.kept[1], bench.kept[0]
    assert late.first > RATE // 2
    skipped = RATE // 10  # it fades in
    index = late.first + skipped
    assert np.array_equal(late.samples[skipped:], kept.samples[index:])


def test_audio_that_was_left_out_is_left_out_of_the_indices():
    bench = Bench({0: MIXTURE}, noise)
    bench.hear(0.5)
    bench.index += RATE
    bench.hear(0.5)
    bench.stage.finish()
    found = np.zeros(2 * RATE)
    for block in bench.kept[0].blocks:
        found[block.index : block.index + len(block.samples)] = block.samples
    assert np.abs(found[-RATE // 2 :] - NOISE[bench.index - RATE // 2 : bench.index]).max() < 1e-5


def test_a_separator_that_fails_is_one_line_and_the_mixture_goes_on(caplog):
    bench = Bench({0: source(0)})
    bench.know()
    bench.hear(0.5)
    bench.separator.fault = "separator 'theirs': step: expected Groups, got NoneType"
    bench.hear(0.5)
    assert bench.factor(0) == 1
    assert bench.status(0).detail == bench.separator.fault
    assert caplog.messages.count(bench.separator.fault) == 1
    bench.separator.fault = ""
    bench.heading = 1.0
    bench.hear(0.5)
    assert bench.factor(0) == 2


def test_starts_and_stops_are_one_line_each(caplog):
    caplog.set_level("INFO")
    bench = Bench({0: source(2)})
    bench.hear(0.5)
    bench.want(0, on=False)
    bench.hear(0.5)
    assert caplog.messages == [
        "stream 0 (source 2 to memory) begins",
        "stream 0 (source 2 to memory) ends: ordered",
    ]


def test_the_noise_of_the_lead_in_is_told_to_the_separator():
    quiet = 0.001 * np.random.default_rng(1).standard_normal(10 * RATE)
    bench = Bench({0: source(0)}, lambda index: np.where(index < 2 * RATE, quiet[index], noise(index)))
    bench.say(StateChanged(0.0, State.LEAD_IN))
    bench.hear(2.0)
    bench.say(StateChanged(0.0, State.RUN))
    bench.know()
    bench.hear(4.0)
    scene = []
    step = bench.separator.step
    bench.separator.step = lambda state, frame, told: scene.append(told) or step(state, frame, told)
    bench.hear(0.1)
    expected = 1e-6 * np.sum(bench.transform.analysis_window**2)
    assert scene[-1].noise_psd.mean() == pytest.approx(expected, rel=0.1)


def test_the_same_hops_give_the_same_samples():
    def run():
        bench = Bench({0: source(1), 1: MIXTURE}, noise)
        bench.hear(0.5)
        bench.know()
        bench.hear(1.0)
        bench.want(0, selection=source(2))
        bench.hear(HOP * 33 / RATE)
        bench.stage.finish()
        return [bench.kept[number].samples for number in range(2)]

    for one, other in zip(run(), run(), strict=True):
        assert np.array_equal(one, other)


def test_settings_that_stay_leave_the_sink_alone():
    bench = Bench({0: MIXTURE})
    bench.hear(0.2)
    kept = bench.kept[0]
    bench.want(0, gain_db=3.0)
    bench.want(0, options={})
    bench.hear(0.2)
    assert bench.kept[0] is kept
    bench.wanted[0] = replace(bench.wanted[0], options={"port": 5})
    bench.stage.want(bench.wanted)
    bench.hear(0.2)
    assert bench.kept[0] is not kept
    assert kept.closed
