"""Simulated time at the pace of the wall: it goes on from where it is, and nobody who computes holds it up."""

import math
import threading
from types import SimpleNamespace

import pytest

from clocks import FakeClock
from ross_payload.streams import Selection, StreamStatus
from ross_sim.clock import QUANTUM, SimClock
from ross_sim.paced_clock import Pacer, RealTimeClock
from ross_sim.sitl.pace import ListenedSpeed
from ross_sim.sitl.serve import MissionProgress
from waiting import wait_for

FAST = 50.0


def status(*, on):
    return StreamStatus(0, "rtp", Selection(), on=on, rate=16000)


def test_time_goes_on_from_where_it_is_when_the_speed_changes():
    wall, speed = FakeClock(100.0), [4.0]
    pacer = Pacer(lambda: speed[0], wall, begin=10.0)
    assert pacer.delay(12.0) == pytest.approx(0.5)
    wall.time += 0.5
    speed[0] = 1.0
    assert pacer.delay(12.0) == pytest.approx(0.0)
    assert pacer.delay(12.5) == pytest.approx(0.5)
    wall.time += 0.25
    assert pacer.now() == pytest.approx(12.25)


def test_what_is_late_is_made_up_for_and_not_left_out():
    wall = FakeClock()
    pacer = Pacer(lambda: 1.0, wall)
    wall.time = 3.0
    assert pacer.delay(1.0) == pytest.approx(-2.0)
    assert pacer.delay(4.0) == pytest.approx(1.0)


def test_as_fast_as_can_be_nothing_is_waited_for_until_somebody_listens():
    wall, speed = FakeClock(), ListenedSpeed(None)
    pacer = Pacer(speed, wall)
    assert pacer.delay(1000.0) <= 0
    assert pacer.now() == 1000.0
    speed.streams = lambda: (status(on=True),)
    assert pacer.delay(1000.01) == pytest.approx(0.0)
    assert pacer.delay(1001.01) == pytest.approx(1.0)


def test_while_a_stream_is_on_the_speed_is_that_of_real_time():
    speed, streams = ListenedSpeed(4.0), [status(on=False)]
    speed.streams = lambda: tuple(streams)
    assert (speed(), speed.listened) == (4.0, False)
    streams.append(status(on=True))
    assert (speed(), speed.listened) == (1.0, True)
    assert ListenedSpeed(None)() == math.inf


def test_in_lock_step_a_file_is_written_as_fast_as_can_be():
    kept = StreamStatus(0, "file", Selection(), on=True, rate=16000, keeps=True)
    for asked, expected in ((None, math.inf), (4.0, 1.0)):
        speed = ListenedSpeed(asked)
        speed.streams = lambda: (kept,)
        assert speed() == expected


def test_time_moves_on_while_everybody_else_stands_still():
    simulated, beats = SimClock(), []
    with RealTimeClock(simulated, lambda: FAST) as clock:
        cancel = clock.every(0.1, lambda: beats.append((simulated.now(), threading.current_thread().name)))
        wait_for(lambda: len(beats) >= 5)
        cancel()
        heard = len(beats)
        clock.sleep(1.0)
    assert [time for time, _ in beats[:5]] == pytest.approx([beats[0][0] + 0.1 * index for index in range(5)])
    assert {name for _, name in beats} == {"pump"}
    assert len(beats) == heard


def test_who_sleeps_wakes_when_the_simulated_time_has_come():
    with RealTimeClock(SimClock(), lambda: FAST) as clock:
        begin = clock.now()
        clock.sleep(0.5)
        assert clock.now() >= begin + 0.5 - QUANTUM / 2


def test_it_waits_for_who_must_not_miss_anything():
    simulated = SimClock()
    with RealTimeClock(simulated, lambda: 1000.0, ahead=0.5) as clock:
        clock.on_progress(clock.now())
        progress = clock._progress
        most = progress + 0.5 + 1.5 * QUANTUM
        wait_for(lambda: clock.now() > progress + 0.5 - QUANTUM / 2)
        clock._over.wait(0.05)  # fifty seconds of simulated time, if it went on
        assert clock.now() < most
        clock.on_progress(clock.now())
        wait_for(lambda: clock.now() > most)


def test_it_goes_on_when_nobody_hears_any_more():
    clock = RealTimeClock(SimClock(), lambda: FAST, ahead=0.5)
    mission = MissionProgress(clock)
    mission.on_input(SimpleNamespace(block=SimpleNamespace(time=-1.0)))  # late before it begins
    with clock:
        with mission:
            clock._over.wait(0.05)  # seconds of simulated time, if it went on
            assert clock.now() == 0.0
        clock.sleep(1.0)


def test_what_fails_on_the_pump_comes_out_where_somebody_waits():
    def fail():
        raise ValueError("broken")

    with RealTimeClock(SimClock(), lambda: FAST) as clock:
        clock.every(0.1, fail)
        with pytest.raises(RuntimeError, match="a periodic call failed: ValueError"):
            clock.sleep(10.0)


def test_nobody_waits_for_a_time_that_has_ended():
    with RealTimeClock(SimClock(), lambda: FAST) as clock:
        pass
    with pytest.raises(RuntimeError, match="has ended"):
        clock.sleep(1.0)


def test_who_registers_a_call_has_a_turn_while_time_is_made_up_for():
    called = []
    with RealTimeClock(SimClock(), lambda: 1e6) as clock:
        for _ in range(20):
            clock.every(0.01, lambda: called.append(clock.now()))()
        cancel = clock.every(0.01, lambda: called.append(clock.now()))
        wait_for(lambda: called)
        cancel()
