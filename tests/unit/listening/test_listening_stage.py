"""Who is heard of a mission and when: the mixture, a source, the target, and what is separated at which heading."""

import numpy as np
import pytest

from listening_bench import AZIMUTHS, MIXTURE, NOISE, RATE, TARGET, Bench, azimuth, estimate, noise, source
from ross_payload.events import (
    AlignmentCandidate,
    Checked,
    GroupScore,
    SourcesTracked,
    State,
    StateChanged,
)
from ross_payload.interfaces import AudioBlock, AudioFlag
from ross_payload.pointing import Pointing


def test_the_mixture_comes_out_sample_by_sample_where_it_was():
    bench = Bench({0: MIXTURE}, noise)
    bench.hear(1.0)
    bench.stage.finish()
    kept = bench.kept[0]
    assert kept.first == 0
    assert len(kept.samples) == RATE
    assert np.abs(kept.samples - NOISE[:RATE]).max() < 2**-22
    for one, other in zip(kept.blocks, kept.blocks[1:], strict=False):
        assert other.index == one.index + len(one.samples)
        assert other.time == pytest.approx(5.0 + other.index / RATE)


def test_an_offset_of_the_microphones_is_not_listened_to():
    bench = Bench({0: MIXTURE, 1: source(0)}, lambda index: noise(index) + 0.3)
    bench.know()
    bench.hear(4.0)
    for kept in bench.kept.values():
        assert abs(kept.samples[-RATE:].mean()) < 2e-3


def test_the_offset_is_known_after_a_gap():
    bench = Bench({0: MIXTURE}, lambda index: noise(index) + 0.3)
    bench.hear(4.0)
    for time in range(3):
        zeros = np.zeros((2, RATE), np.float32)
        block = AudioBlock(zeros, bench.index, 9.0 + time, flags=AudioFlag.MISSING)
        bench.stage.hear(block, Pointing(), settled=True)
        bench.index += RATE
    bench.hear(1.0)
    assert abs(bench.kept[0].samples[4 * RATE : 7 * RATE].mean()) < 2e-3
    assert abs(bench.kept[0].samples[7 * RATE :].mean()) < 2e-3


def test_the_offset_is_not_heard_at_the_edges_of_a_gap():
    bench = Bench({0: MIXTURE}, lambda index: noise(index) + 0.3)
    bench.hear(4.0)
    samples = np.full((2, 160), 0.3, np.float32)
    samples[:, :40] = 0.0  # never came
    bench.stage.hear(AudioBlock(samples, bench.index, 9.0, flags=AudioFlag.MISSING), Pointing(), settled=True)
    bench.index += 160
    bench.hear(1.0)
    assert np.abs(bench.kept[0].samples[4 * RATE : 4 * RATE + 160]).max() < 5e-3


def test_a_voice_has_the_index_that_it_has_in_the_mixture():
    bench = Bench({0: source(0)}, noise)
    bench.know()
    bench.hear(2.0)
    kept, begin = bench.kept[0], RATE // 2
    part = kept.samples[begin : begin + RATE]
    expected = 2 * NOISE[kept.first + begin : kept.first + begin + RATE]
    assert np.abs(part - expected).max() < 1e-5


@pytest.mark.parametrize("latency_ms", [45, 100, 200])
def test_what_is_heard_is_as_late_as_is_configured_and_no_more(latency_ms):
    bench = Bench({0: MIXTURE}, noise, latency_ms=latency_ms)
    bench.hear(3.0)
    end = bench.kept[0].blocks[-1].index + len(bench.kept[0].blocks[-1].samples)
    assert bench.stage.latency <= 1e-3 * latency_ms
    assert bench.index - end <= bench.stage.latency * RATE


def test_nobody_who_wants_a_stream_costs_nothing():
    bench = Bench({})
    bench.know()
    bench.hear(1.0)
    assert (bench.kept, bench.separator.starts) == ({}, [])


def test_a_stream_that_is_off_opens_no_sink_and_is_told_of():
    bench = Bench({0: MIXTURE})
    bench.want(0, on=False)
    bench.hear(0.5)
    assert bench.kept == {}
    assert [(status.number, status.on) for status in bench.stage.streams] == [(0, False)]


def test_who_only_hears_the_mixture_has_nothing_separated():
    bench = Bench({0: MIXTURE})
    bench.know()
    bench.hear(1.0)
    assert bench.separator.starts == []
    assert bench.factor(0) == 1


@pytest.mark.parametrize(("selection", "factor"), [(source(0), 2), (source(2), 6), (azimuth(75), 4), (azimuth(-45), 6)])
def test_a_source_and_an_azimuth_are_heard_without_a_target(selection, factor):
    bench = Bench({0: selection})
    bench.know()
    bench.hear(1.0)
    assert bench.factor(0) == factor
    status = bench.status(0)
    assert (status.separated, status.source, status.group) == (True, factor // 2 - 1, factor // 2 - 1)
    assert status.azimuth == pytest.approx(np.deg2rad(AZIMUTHS[factor // 2 - 1]))


def test_the_target_is_whom_the_mission_checks_and_then_whom_it_has_found():
    bench = Bench({0: TARGET})
    bench.know()
    bench.hear(0.5)
    assert (bench.factor(0), bench.status(0).detail) == (1, "there is no target yet")
    bench.listen_to(1)
    bench.hear(0.5)
    assert bench.factor(0) == 4
    groups = (GroupScore((2,), 5.0, True), GroupScore((0, 1), -3.0, False))
    bench.say(Checked(0.0, AlignmentCandidate(1, 0.1, 0.1, 1e-5, "gain"), groups, 0, "gaussian", ""))
    bench.hear(0.5)
    assert bench.factor(0) == 6
    bench.say(StateChanged(0.0, State.DONE))
    bench.hear(0.5)
    assert bench.factor(0) == 6  # the task is over, and he talks on


@pytest.mark.parametrize(("otherwise", "factor"), [("mixture", 1), ("silence", 0)])
@pytest.mark.parametrize(
    ("state", "settled", "detail"),
    [(State.EXPLORE_LISTEN, True, "exploring"), (State.RUN, False, "turning"), (State.LEAD_IN, True, "exploring")],
)
def test_where_no_voice_can_be_separated_there_is_the_mixture_or_silence(otherwise, factor, state, settled, detail):
    bench = Bench({0: source(0), 1: MIXTURE}, otherwise=otherwise)
    bench.know()
    bench.say(StateChanged(0.0, state))
    for _ in range(50):
        bench.heading += 0.0 if settled else 0.05
        bench.hear(0.01, settled=settled)
    assert bench.factor(0) == factor
    assert bench.factor(1) == 1
    status = bench.status(0)
    assert (status.separated, status.source, status.detail) == (False, None, detail)


@pytest.mark.parametrize(("otherwise", "factor"), [("mixture", 1), ("silence", 0)])
def test_where_a_microphone_is_dead_no_voice_is_said_to_be_separated(otherwise, factor):
    bench = Bench({0: source(0)}, otherwise=otherwise, sound=noise)
    bench.know()
    bench.hear(0.5)
    bench.gains = np.array([[1], [0]], np.float32)
    bench.hear(0.5)
    assert bench.status(0).separated, "a knock is no death"
    bench.hear(1.0)
    assert bench.factor(0) == factor
    status = bench.status(0)
    assert (status.separated, status.detail) == (False, "microphone 2 is dead")
    bench.gains = np.ones((2, 1), np.float32)
    bench.hear(0.5)
    status = bench.status(0)
    assert (bench.factor(0), status.separated, status.detail) == (2, True, "")


def test_nobody_known_nobody_there_and_no_such_source_are_told():
    bench = Bench({0: source(3), 1: azimuth(110), 2: TARGET})
    bench.hear(0.3)
    assert {status.detail for status in bench.stage.streams} == {"nobody is known"}
    bench.know()
    bench.hear(0.3)
    details = [status.detail for status in bench.stage.streams]
    assert details == ["there is no source 3", "nobody at this azimuth", "there is no target yet"]


def test_a_separator_begins_again_at_another_heading_and_not_while_it_follows_one():
    bench = Bench({0: source(0)})
    bench.know()
    bench.hear(0.5)
    bench.heading = np.deg2rad(4.0)
    bench.hear(0.5, settled=False)  # the array follows its heading
    assert len(bench.separator.starts) == 1
    for degrees in range(5, 31):  # 50 deg/s
        bench.heading = np.deg2rad(degrees)
        bench.hear(0.02, settled=False)
    assert (bench.factor(0, last=0.05), len(bench.separator.starts)) == (2, 1)
    bench.hear(0.5)
    assert (bench.factor(0), len(bench.separator.starts)) == (2, 2)
    expected = 0.05 / 343.0 * np.cos(np.deg2rad(np.array(AZIMUTHS) - 30.0))
    assert bench.separator.starts[1].tau == pytest.approx(expected)


def test_a_fast_turn_is_not_followed():
    bench = Bench({0: source(0)})
    bench.know()
    bench.hear(0.5)
    for degrees in range(0, 90, 2):  # 200 deg/s
        bench.heading = np.deg2rad(degrees)
        bench.hear(0.01, settled=False)
    assert (bench.factor(0, last=0.05), bench.status(0).detail) == (1, "turning")


def test_a_joint_that_holds_a_heading_on_a_base_that_yaws_is_at_rest_enough():
    bench = Bench({0: source(0)})
    bench.know()
    for hop in range(200):
        bench.heading = np.deg2rad(10.0 + 1.5 * np.sin(hop / 15))
        bench.hear(0.01, settled=False)
    assert (bench.factor(0), len(bench.separator.starts)) == (2, 1)


def test_who_moves_is_followed_without_beginning_again():
    bench = Bench({0: azimuth(40)})
    bench.know()
    bench.hear(0.5)
    assert bench.factor(0) == 1
    moved = estimate((170, 50, -50))
    bench.say(SourcesTracked(0.0, moved, (0.0, -0.1, 0.0), (0.0, 0.0, 0.0)))
    bench.hear(0.5)
    assert (bench.factor(0), len(bench.separator.starts)) == (4, 1)
    bench.know((10, 100))
    bench.hear(0.5)
    assert [scene.n_sources for scene in bench.separator.starts] == [3, 2]


def test_what_was_learnt_at_this_heading_is_learnt_on_and_taken_over():
    bench = Bench({0: source(0)}, window_s=2.0, learn_s=0.25)
    bench.know()
    bench.hear(4.0)
    sizes, before = zip(*bench.separator.lessons, strict=True)
    assert sizes[0] == pytest.approx(0.5 / 0.016, abs=17)
    assert np.diff(sizes[:6]) == pytest.approx(16, abs=1)
    assert max(sizes) == 125
    assert before == (None, *range(1, len(before)))
    assert bench.separator.renewals == list(range(1, len(bench.separator.renewals) + 1))
    bench.heading = 1.0
    bench.hear(1.0)
    assert bench.separator.lessons[len(before)][1] is None  # at another heading nothing is known


def test_after_two_seconds_at_a_heading_it_is_learnt_half_as_often():
    bench = Bench({0: source(0)}, learn_s=0.25)
    bench.know()
    bench.hear(2.0)
    early = len(bench.separator.lessons)
    bench.hear(4.0)
    assert early == pytest.approx(6, abs=1)  # the first one after half a second
    assert len(bench.separator.lessons) - early == pytest.approx(8, abs=1)
