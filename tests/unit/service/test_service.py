"""The runner between a mission and the things that hear and turn."""

import math
import threading
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from ross_payload.actuators.registry import open_actuator
from ross_payload.computing import computing, on_threads
from ross_payload.config import Config
from ross_payload.events import Event, Outcome
from ross_payload.interfaces import AudioBlock, Output, Result, Services
from ross_payload.mount import FixedMount
from ross_payload.orders import Cancel, Shutdown, Stop
from ross_payload.service.runner import Runner
from ross_sim.clock import SimClock
from ross_sim.devices.far_end import far_end_of

CONFIG = Config.model_validate({"actuator": {"kind": "ideal"}, "array": {"offset_deg": 10}})


class Microphones:
    """Zeros, read in lock-step with the clock."""

    rate = 16000

    def __init__(self, clock):
        self.clock = clock
        self.index = 0

    def read(self, n):
        time = self.clock.now()
        self.clock.sleep(n / self.rate)
        self.index += n
        return AudioBlock(np.zeros((2, n), np.float32), self.index - n, time)


class LateMicrophones(Microphones):
    """What they hear comes two seconds later, as to a mission that computes."""

    def __init__(self, clock):
        super().__init__(clock)
        self.waiting = deque()

    def read(self, n):
        while not self.waiting or self.clock.now() - self.waiting[0].time < 2.0:
            self.waiting.append(super().read(n))
        return self.waiting.popleft()


class Recorder:
    def __init__(self):
        self.inputs = []
        self.events = []

    def on_input(self, heard):
        self.inputs.append(heard)

    def on_event(self, event, heard):
        self.events.append(event)


@pytest.fixture
def bench():
    clock = SimClock()
    far_end = far_end_of(CONFIG)
    clock.before_calls(far_end.advance)
    with open_actuator(CONFIG, Services(clock, lambda url: far_end.port)) as actuator:

        def make(mission, mount=None, microphones=Microphones):
            mount = mount or FixedMount(None)
            runner = Runner(mission, microphones(clock), actuator, mount, config=CONFIG, clock=clock)
            clock.every(0.01, runner.poll)
            clock.sleep(0.05)
            recorder = Recorder()
            runner.observers = [recorder]
            return runner, recorder, far_end

        yield make


def turns_once(goal):
    heard = yield Output((Event(0.0),))
    heard = yield Output(goal=goal)
    while not heard.settled:
        heard = yield Output()
    yield Output(stop=True)
    return Result(Outcome.TARGET_FOUND, "there")


def obeys_stop(goal):
    heard = yield Output(goal=goal)
    while not heard.orders and not heard.fault:
        heard = yield Output()
    yield Output(stop=True)
    return Result(Outcome.FAULT if heard.fault else Outcome.STOPPED, heard.fault)


def test_a_goal_is_reached_and_the_headings_tell_the_way(bench):
    runner, recorder, far_end = bench(turns_once(0.5))
    assert runner.run().outcome is Outcome.TARGET_FOUND
    assert far_end.angle() == pytest.approx(0.5, abs=1e-6)
    headings = [one.pointing.heading for one in recorder.inputs]
    assert headings[0] == pytest.approx(math.radians(10))
    assert headings[-1] == pytest.approx(0.5 + math.radians(10), abs=1e-6)
    for before, after in zip(recorder.inputs, recorder.inputs[1:], strict=False):
        assert before.pointing.heading == pytest.approx(after.heading_start, abs=1e-9)
    assert len(recorder.events) == 1


def test_a_hop_in_which_a_goal_was_given_is_not_settled(bench):
    runner, recorder, _ = bench(turns_once(0.5))
    runner.run()
    assert recorder.inputs[0].settled
    assert not recorder.inputs[1].settled


def test_a_mission_that_is_late_does_not_take_a_turn_for_over_before_it_begins(bench):
    runner, recorder, _ = bench(turns_once(0.5), microphones=LateMicrophones)
    assert runner.run().outcome is Outcome.TARGET_FOUND
    settled = [one for one in recorder.inputs[1:] if one.settled]
    assert [one.pointing.joint for one in settled] == pytest.approx([0.5] * len(settled), abs=1e-6)


def test_a_command_reaches_the_mission_with_the_next_hop_and_the_motor_comes_to_rest(bench):
    runner, recorder, far_end = bench(obeys_stop(3.0))

    class Press(Recorder):
        def on_input(self, heard):
            super().on_input(heard)
            if len(self.inputs) == 60:
                runner.order(Stop())

    press = Press()
    runner.observers.append(press)
    assert runner.run().outcome is Outcome.STOPPED
    assert press.inputs[60].orders == (Stop(),)
    speed = (press.inputs[60].pointing.joint - press.inputs[59].pointing.joint) / 0.01
    braking = speed**2 / (2 * math.radians(112.5))
    assert far_end.angle() - press.inputs[60].pointing.joint <= braking + speed * 0.1
    assert recorder.inputs[-1].pointing.joint == pytest.approx(far_end.angle(), abs=1e-3)


def computes(goal, then):
    """A mission that is busy for three seconds and looks at no order, then turns elsewhere."""
    yield Output(goal=goal)
    for _ in range(300):
        yield Output()
    heard = yield Output(goal=then)
    for _ in range(300):
        heard = yield Output()
    return Result(Outcome.FAULT if heard.fault else Outcome.COMPLETED, heard.fault)


class Presses(Recorder):
    """Orders something in the middle of a turn."""

    def __init__(self, runner, order):
        super().__init__()
        self.runner, self.order = runner, order

    def on_input(self, heard):
        super().on_input(heard)
        if len(self.inputs) == 60:
            self.runner.order(self.order)


@pytest.mark.parametrize(("order", "latches"), [(Stop(), True), (Shutdown(), True), (Cancel(), False)])
def test_what_ends_a_turn_decelerates_though_the_mission_computes(bench, order, latches):
    runner, recorder, far_end = bench(computes(3.0, then=0.2))
    runner.observers.append(Presses(runner, order))
    result = runner.run()
    assert recorder.inputs[299].pointing.joint < 1.0
    assert (result.outcome is Outcome.FAULT) == latches
    assert (far_end.angle() == pytest.approx(0.2, abs=1e-3)) == (not latches)


def test_a_mission_computes_on_two_threads_whatever_thread_it_runs_on(bench, monkeypatch):
    monkeypatch.setattr("ross_payload.computing.cores", lambda: 2)
    meet, names = threading.Barrier(2, timeout=10), set[str]()

    def compute(_):
        meet.wait()
        names.add(threading.current_thread().name)

    def separates():
        yield Output()
        on_threads(compute, range(2))
        return Result(Outcome.COMPLETED, "")

    runner, _, _ = bench(separates())
    with computing(), ThreadPoolExecutor(1, thread_name_prefix="mission") as mission:  # as ross run does
        assert mission.submit(runner.run).result().outcome is Outcome.COMPLETED
    assert len(names) == 2


def test_a_goal_outside_the_limits_is_a_fault_and_no_motion(bench):
    runner, _, far_end = bench(obeys_stop(100.0))
    result = runner.run()
    assert result.outcome is Outcome.FAULT
    assert "expected -200.00 to 200.00 deg" in result.reason
    assert far_end.angle() == 0.0


def test_an_exception_stops_the_motor(bench):
    def breaks():
        yield Output(goal=2.0)
        for _ in range(40):
            yield Output()
        raise RuntimeError("a defect")

    runner, _, far_end = bench(breaks())
    with pytest.raises(RuntimeError, match="a defect"):
        runner.run()
    assert far_end.angle() < 2.0
    with pytest.raises(Exception, match="stop"):
        runner._actuator.command(1.0)


def test_a_goal_that_meets_a_stop_is_no_fault(bench):
    """The stop takes effect at once, on its own thread; the mission that had just chosen a goal hears of it next."""

    def chooses_late(goal):
        yield Output()
        runner.order(Stop())
        heard = yield Output(goal=goal)
        assert heard.orders == (Stop(),)
        yield Output(stop=True)
        return Result(Outcome.FAULT if heard.fault else Outcome.STOPPED, heard.fault)

    runner, _, far_end = bench(chooses_late(1.0))
    assert runner.run().outcome is Outcome.STOPPED
    assert far_end.angle() == 0.0


class SlowBrakes:
    """What is between the stop and the queue, as brakes that take their time would be."""

    def __init__(self):
        self.pressed, self.goes_on = threading.Event(), threading.Event()

    def ordered(self, order):
        self.pressed.set()
        assert self.goes_on.wait(10)


def test_a_goal_that_meets_a_stop_which_is_not_queued_yet_is_no_fault(bench):
    brakes = SlowBrakes()

    def chooses_late(goal):
        yield Output()
        operator = threading.Thread(target=runner.order, args=(Stop(),))
        operator.start()
        assert brakes.pressed.wait(10)
        heard = yield Output(goal=goal)
        assert (heard.orders, heard.fault) == ((), "")
        brakes.goes_on.set()
        operator.join()
        heard = yield Output()
        assert (heard.orders, heard.fault) == ((Stop(),), "")
        heard = yield Output(goal=goal)  # a mission that takes no notice
        yield Output(stop=True)
        return Result(Outcome.FAULT if heard.fault else Outcome.STOPPED, heard.fault)

    runner, _, far_end = bench(chooses_late(1.0))
    runner._latch = brakes
    assert runner.run().reason == "stopped: re-arm first"
    assert far_end.angle() == 0.0


def test_what_a_stop_on_its_way_has_kept_the_array_from_is_not_reached(bench):
    brakes = SlowBrakes()

    def turns(goal):
        yield Output()
        operator = threading.Thread(target=runner.order, args=(Stop(),))
        operator.start()
        assert brakes.pressed.wait(10)
        heard = yield Output(goal=goal)
        for _ in range(20):
            heard = yield Output()
            assert not heard.settled
        brakes.goes_on.set()
        operator.join()
        heard = yield Output()
        assert heard.orders == (Stop(),)
        heard = yield Output()
        yield Output(stop=True)
        return Result(Outcome.STOPPED, f"{heard.settled}")

    runner, _, far_end = bench(turns(1.0))
    runner._latch = brakes
    assert runner.run().reason == "True"
    assert far_end.angle() == 0.0


def test_where_a_cancel_on_its_way_has_halted_the_array_is_not_its_goal(bench):
    brakes = SlowBrakes()

    def turns(goal):
        yield Output(goal=goal)
        for _ in range(50):
            yield Output()
        operator = threading.Thread(target=runner.order, args=(Cancel(),))
        operator.start()
        assert brakes.pressed.wait(10)
        for _ in range(200):
            heard = yield Output()
            assert not heard.settled
        brakes.goes_on.set()
        operator.join()
        heard = yield Output()
        assert heard.orders == (Cancel(),)
        heard = yield Output()
        yield Output(stop=True)
        return Result(Outcome.STOPPED, f"{heard.settled}")

    runner, _, far_end = bench(turns(3.0))
    runner._latch = brakes
    assert runner.run().reason == "True"
    assert 0.0 < far_end.angle() < 2.5


def test_a_stop_that_cannot_be_saved_is_heard_of_all_the_same(bench):
    class Full:
        def ordered(self, order):
            raise RuntimeError("can't start new thread")

    def hears():
        yield Output()
        with pytest.raises(RuntimeError):
            runner.order(Stop())
        heard = yield Output()
        yield Output(stop=True)
        return Result(Outcome.STOPPED, f"{heard.orders == (Stop(),)}")

    runner, _, _ = bench(hears())
    runner._latch = Full()
    assert runner.run().reason == "True"


def slips(angle):
    heard = yield Output()
    heard = yield Output(slipped=angle)
    while not heard.settled:
        heard = yield Output()
    yield Output(stop=True)
    return Result(Outcome.COMPLETED, "put right")


def test_headings_are_corrected_by_a_slip_where_no_zero_can_be_found(bench):
    runner, recorder, far_end = bench(slips(0.1))
    runner.run()
    assert recorder.inputs[0].pointing.heading == pytest.approx(math.radians(10))
    assert recorder.inputs[-1].pointing.heading == pytest.approx(math.radians(10) - 0.1)
    assert recorder.inputs[-1].pointing.joint == far_end.angle() == 0.0


class FindsItsZero:
    """A turntable with a switch: `home` turns it there."""

    def __init__(self, guard):
        self._guard = guard
        self.capabilities = replace(guard.capabilities, finds_zero=True)
        self.homed = 0

    def home(self):
        self.homed += 1
        self._guard.command(0.3)

    def __getattr__(self, name):
        return getattr(self._guard, name)


def test_a_zero_that_can_be_found_is_looked_for_after_a_slip(bench):
    runner, recorder, far_end = bench(slips(0.1))
    runner._actuator = switch = FindsItsZero(runner._actuator)
    runner.run()
    assert switch.homed == 1
    assert recorder.inputs[-1].pointing.heading == pytest.approx(0.3 + math.radians(10), abs=1e-6)
    assert far_end.angle() == pytest.approx(0.3, abs=1e-6)


class SlowDisk:
    """Remembers orders; knows whether the brakes were on when it was asked to."""

    def __init__(self):
        self.asked, self.actuator = [], None

    def ordered(self, order):
        self.asked.append((type(order), self.actuator.stopped))


def test_the_brakes_are_on_before_a_disk_hears_of_a_stop():
    clock, far_end, disk = SimClock(), far_end_of(CONFIG), SlowDisk()
    clock.before_calls(far_end.advance)
    with open_actuator(CONFIG, Services(clock, lambda url: far_end.port)) as actuator:
        disk.actuator = actuator
        mission = turns_once(0.5)
        runner = Runner(mission, Microphones(clock), actuator, FixedMount(None), config=CONFIG, clock=clock, latch=disk)
        runner.order(Stop())
    assert disk.asked == [(Stop, True)]


def test_where_the_array_points_can_be_asked_before_the_mission_hears_of_it(bench):
    asked = []

    class Asks:
        def on_input(self, hop):
            end = hop.block.time + hop.block.samples.shape[1] / 16000
            asked.append((runner.located(hop.block.time, end), hop))

        def on_event(self, event, hop):
            pass

    runner, _, _ = bench(turns_once(0.5), FixedMount(0.2))
    runner.observers.append(Asks())
    runner.run()
    for (pointing, settled), hop in asked:
        assert replace(hop.pointing, base_rate=0.0) == pointing
        assert settled or not hop.settled
    assert {settled for (_, settled), _ in asked} == {True, False}
