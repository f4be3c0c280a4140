"""What a stream carries when the mission changes its mind, and what is told of it."""

import numpy as np
import pytest

from clocks import FakeClock
from listening_bench import TARGET, Bench, estimate, source
from ross_payload.events import SourcesEstimated, State, StateChanged, TurnStarted


def test_azimuths_of_another_frame_are_separated_by_nobody():
    bench = Bench({0: source(1)})
    bench.stage.on_event(SourcesEstimated(0.0, estimate(), rotations=3, final=True), earth=True)
    bench.hear(0.5)  # the array tells its heading from its mount
    assert (bench.factor(0), bench.status(0).detail) == (1, "azimuths: frame changed")
    bench.know()
    bench.hear(0.5)
    assert bench.factor(0) == 4


def test_who_was_checked_and_is_not_the_target_is_not_heard_as_the_target():
    bench = Bench({0: TARGET})
    bench.know()
    bench.listen_to(1)
    bench.hear(0.5)
    assert bench.factor(0) == 4
    bench.say(StateChanged(0.0, State.ALIGN_TURN), TurnStarted(0.0, 0.2, 0.2, "alignment"))
    bench.hear(0.5)
    assert (bench.factor(0), bench.status(0).detail) == (1, "there is no target yet")
    bench.say(StateChanged(0.0, State.DONE))
    bench.hear(0.5)
    assert bench.factor(0) == 1


def test_while_separation_begins_the_mixture_is_heard_and_no_silence():
    bench = Bench({0: source(0)}, lambda index: np.where(index % 32 < 16, 0.1, -0.1))  # never soft, and no offset
    bench.hear(0.5)
    bench.know()
    bench.hear(0.5)
    assert bench.factor(0, last=0.1) == 2
    assert np.abs(bench.kept[0].samples).min() > 0.09


def test_a_stream_that_is_wanted_now_and_then_is_open_only_then():
    wanted = [False]
    bench = Bench({0: TARGET})
    bench.want(0, wanted=lambda: wanted[0])
    bench.hear(0.3)
    assert bench.kept == {}
    wanted[0] = True
    bench.hear(0.3)
    first = bench.kept[0]
    assert (bench.status(0).on, first.closed) == (True, False)
    wanted[0] = False
    bench.hear(0.3)
    assert (bench.status(0).on, first.closed) == (False, True)


def test_when_all_is_over_every_stream_is_told_to_be_off():
    bench = Bench({0: TARGET, 1: source(2)})
    bench.hear(0.3)
    assert [status.on for status in bench.stage.streams] == [True, True]
    bench.stage.finish()
    assert [(status.number, status.on) for status in bench.stage.streams] == [(0, False), (1, False)]


def test_the_delay_is_told_from_the_microphone_on():
    bench, clock = Bench({0: TARGET}), FakeClock()
    bench.stage._clock = clock
    clock.sleep(5.0 + 3.0 - clock.now())  # the first sample was heard at 5 s
    bench.hear(1.0)
    newest = bench.kept[0].blocks[-1]
    assert bench.status(0).delay == pytest.approx(8.0 - newest.time, abs=0.12)  # told ten times a second
