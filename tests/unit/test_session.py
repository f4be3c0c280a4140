"""The live mission: orders come with the hops, tasks follow each other, nothing turns unasked."""

from dataclasses import replace

import numpy as np
import pytest

from ross_payload.config import Config
from ross_payload.dsp.stft import Stft
from ross_payload.events import (
    Answer,
    Answered,
    Estimate,
    Finished,
    Outcome,
    Separated,
    SourceEstimate,
    SourcesEstimated,
    State,
    StateChanged,
    TurnStarted,
)
from ross_payload.interfaces import Attitude, AudioBlock, Groups, Input, Observation, Score
from ross_payload.mission.context import Settings, Tools
from ross_payload.mission.session import Kit, Session
from ross_payload.mission.tasks import Memory
from ross_payload.orders import (
    Cancel,
    Explore,
    Home,
    Informed,
    ListenAt,
    ListenTo,
    MeasureNoise,
    Park,
    Rearm,
    Seek,
    Set,
    Shutdown,
    Stop,
    TurnTo,
)

RATE, HOP = 8000, 80
AZIMUTHS = (170, 70, -50)


def estimate():
    return Estimate(tuple(SourceEstimate(float(np.deg2rad(a)), 0.01, 0.9, True) for a in AZIMUTHS), certain=True)


class Believer:
    """An explorer that knows after three orientations."""

    name = "believer"

    def observe(self, spectrogram, frequencies, heading, noise_psd, *, frame_period=None):
        return Observation(heading, np.zeros(1), np.ones(1), 1.0)

    def estimate(self, observations):
        return estimate() if len(observations) > 2 else Estimate(())


class Numbered:
    """A separator whose group k is the mixture times k + 1."""

    name = "numbered"

    def batch(self, spectrogram, scene):
        signals = np.stack([spectrogram[0] * (k + 1) for k in range(scene.n_sources)])
        return Groups(signals, tuple((k,) for k in range(scene.n_sources)), self.name)


class Likes:
    """A voice print that accepts one group."""

    def __init__(self, number):
        self.number = number

    def score(self, voice, rate):
        value = 1.0 if round(float(np.abs(voice).max() / 0.1)) - 1 == self.number else -1.0
        return Score(value, value > 0)


def make(config):
    explore, exploit = config.explore, config.exploit
    settings = Settings(
        rate=RATE, spacing=0.05, speed_of_sound=343.0, lead_in=0.1, unit=explore.unit_s / 10, rotation=np.deg2rad(15),
        min_rotations=2, max_rotations=4, pipelined=False, check=0.2, run=0.4, runs=exploit.runs, criterion=0.0,
        max_restarts=1, lower=-3.5, upper=3.5, seed=0, park=0.3,
    )  # fmt: skip
    stft = Stft(RATE, 256, 64)
    return Kit(settings, Tools(Believer(), stft, Numbered(), stft, Likes(1)))


def nobody(config):
    kit = make(config)
    return Kit(kit.settings, replace(kit.tools, voiceprint=None))


class Bench:
    """A turntable that needs three hops for any turn, a guard that latches stops, and an operator with a list."""

    def __init__(self, config=None, make=make, memory=None, first=None):
        self.session = Session(config or Config(), make, memory)
        self.brain = self.session.mission(first)
        self.joint = self.goal = 0.0
        self.moving = self.hops = 0
        self.stopped = self.homed = False
        self.fault = ""
        self.known = False
        self.events, self.goals = [], []
        self.output = next(self.brain)
        self.result = None

    def obey(self, output):
        self.events += output.events
        if output.stop or output.halt:
            self.goal, self.moving, self.stopped = self.joint, 0, self.stopped or output.stop
        if output.rearm:
            self.stopped = False
            if self.homed:
                self.fault = ""
        if output.home:
            self.homed, self.moving = True, 3
        if output.goal is not None:
            assert not self.stopped
            self.goals.append(output.goal)
            self.goal, self.moving = output.goal, 3

    def hop(self, *orders):
        self.obey(self.output)
        begin, self.moving = self.joint, max(self.moving - 1, 0)
        if not self.moving:
            self.joint = self.goal
        samples = np.full((2, HOP), 0.1, np.float32)
        block = AudioBlock(samples, self.hops * HOP, self.hops * HOP / RATE)
        self.hops += 1
        heard = Input(
            block,
            begin,
            self.joint,
            self.joint,
            self.moving == 0 and not self.fault,
            Attitude(0.0, known=self.known),
            self.fault,
            orders,
        )
        try:
            self.output = self.brain.send(heard)
        except StopIteration as end:
            self.result = end.value

    def hops_until(self, wanted, limit=3000):
        """Hop until an event of this kind (or for which the function is true) is said."""
        true = (lambda event: isinstance(event, wanted)) if isinstance(wanted, type) else wanted
        for _ in range(limit):
            before = len(self.events)
            self.hop()
            found = [event for event in self.events[before:] if true(event)]
            if found:
                return found[0]
        raise AssertionError("it never came")

    def answers(self, number):
        return [e.answer for e in self.events if isinstance(e, Answered) and e.order == number]

    def reason(self, number):
        return [e.reason for e in self.events if isinstance(e, Answered) and e.order == number][-1]

    def state(self):
        return [e.state for e in self.events if isinstance(e, StateChanged)][-1]

    def over(self, number):
        ends = (Answer.DONE, Answer.FAILED, Answer.CANCELLED, Answer.REFUSED)
        return self.hops_until(lambda e: isinstance(e, Answered) and e.order == number and e.answer in ends)


@pytest.fixture
def bench():
    return Bench()


def test_nothing_turns_before_it_is_ordered(bench):
    for _ in range(500):
        bench.hop()
    assert bench.goals == []
    assert bench.state() is State.IDLE


def test_an_exploration_ends_with_its_sources_and_waits(bench):
    bench.hop(Explore(number=7))
    bench.over(7)
    assert bench.answers(7)[0] is Answer.ACCEPTED
    assert bench.answers(7)[-1] is Answer.DONE
    assert Answer.PROGRESS in bench.answers(7)
    assert bench.state() is State.DONE
    turned = len(bench.goals)
    for _ in range(300):
        bench.hop()
    assert len(bench.goals) == turned


def test_a_source_of_the_exploration_is_listened_to(bench):
    bench.hop(Explore(number=1))
    bench.over(1)
    bench.hop(ListenTo(2, number=2))
    assert bench.over(2).answer is Answer.DONE
    delivered = next(e for e in bench.events if isinstance(e, Separated))
    assert delivered.groups[delivered.target].members == (2,)


def test_a_source_cannot_be_listened_to_before_it_is_known(bench):
    bench.hop(ListenTo(0, number=1))
    assert bench.over(1).answer is Answer.REFUSED
    assert "explore first" in bench.reason(1)
    assert bench.goals == []


def test_a_source_that_does_not_exist_is_refused():
    bench = Bench(memory=Memory(estimate()))
    bench.hop(ListenTo(3, number=1))
    assert bench.over(1).answer is Answer.REFUSED


def test_what_is_known_in_another_frame_is_not_known():
    bench = Bench(memory=Memory(estimate(), earth=True))
    bench.hop(ListenTo(0, number=1))
    assert bench.over(1).answer is Answer.REFUSED


def test_the_enrolled_voice_is_found_and_kept(bench):
    bench.hop(Seek(number=1))
    assert bench.over(1).answer is Answer.DONE
    assert next(e for e in bench.events if isinstance(e, Finished)).outcome is Outcome.TARGET_FOUND


def test_nobody_is_sought_when_nobody_is_enrolled():
    bench = Bench(make=nobody)
    bench.hop(Seek(number=1))
    assert bench.over(1).answer is Answer.REFUSED
    bench.hop(Explore(number=2))
    assert bench.over(2).answer is Answer.DONE


def test_told_azimuths_are_searched_without_exploring(bench):
    bench.hop(Informed(tuple(np.deg2rad(AZIMUTHS)), first=1, number=1))
    assert bench.over(1).answer is Answer.DONE
    assert not [e for e in bench.events if isinstance(e, StateChanged) and e.state is State.EXPLORE_LISTEN]


@pytest.mark.parametrize(("degrees", "k", "source"), [(72, 3, 1), (120, 4, 3)])
def test_who_is_near_an_azimuth_is_a_known_source_and_else_a_new_one(degrees, k, source):
    bench = Bench(memory=Memory(estimate()))
    bench.hop(ListenAt(np.deg2rad(degrees), number=1))
    assert bench.over(1).answer is Answer.DONE
    delivered = next(e for e in bench.events if isinstance(e, Separated))
    assert len(delivered.groups) == k
    assert delivered.groups[delivered.target].members == (source,)


def test_a_heading_is_turned_to(bench):
    bench.hop(TurnTo(1.2, number=1))
    assert bench.over(1).answer is Answer.DONE
    assert bench.joint == pytest.approx(1.2)
    bench.hop(TurnTo(-3.1, number=2))
    bench.over(2)
    assert bench.joint == pytest.approx(-3.1 + 2 * np.pi, abs=1e-9)


def test_a_heading_outside_the_limits_is_refused_and_nothing_moves():
    def narrow(config):
        kit = make(config)
        return Kit(replace(kit.settings, lower=-1.0, upper=1.0), kit.tools)

    bench = Bench(make=narrow)
    bench.hop(TurnTo(2.0, number=1))
    assert bench.over(1).answer is Answer.REFUSED
    assert bench.goals == []


def test_parking_goes_to_the_configured_place(bench):
    bench.hop(Park(number=1))
    bench.over(1)
    assert bench.joint == pytest.approx(0.3)


def test_measured_noise_takes_the_place_of_the_lead_in(bench):
    bench.hop(MeasureNoise(0.5, number=1))
    assert bench.over(1).answer is Answer.DONE
    bench.hop(Explore(number=2))
    bench.over(2)
    states = [e.state for e in bench.events if isinstance(e, StateChanged)]
    assert State.NOISE in states
    assert State.LEAD_IN not in states


def test_a_stop_ends_the_task_and_nothing_moves_until_armed_again(bench):
    bench.hop(Explore(number=1))
    bench.hops_until(TurnStarted)
    bench.hop(Stop(number=2))
    assert bench.over(1).answer is Answer.CANCELLED
    bench.hop()
    assert (bench.state(), bench.stopped) == (State.STOPPED, True)
    bench.hop(Park(number=3))
    assert bench.over(3).answer is Answer.REFUSED
    assert "re-arm" in bench.reason(3)
    bench.hop(Rearm(number=4))
    bench.hop()
    bench.hop()
    assert bench.answers(4) == [Answer.ACCEPTED]
    bench.hop(Park(number=5))
    assert bench.over(5).answer is Answer.DONE


def test_a_cancel_ends_the_task_and_the_next_one_is_welcome(bench):
    bench.hop(Explore(number=1))
    bench.hops_until(TurnStarted)
    bench.hop(Cancel(number=2))
    assert bench.over(1).answer is Answer.CANCELLED
    bench.hop(Park(number=3))
    assert bench.over(3).answer is Answer.DONE


def test_a_stop_while_idle_latches(bench):
    bench.hop(Stop(number=1))
    bench.hop(Park(number=2))
    assert bench.over(2).answer is Answer.REFUSED


def test_a_task_and_a_stop_in_one_hop_is_a_stop(bench):
    bench.hop(Park(number=1), Stop(number=2))
    assert bench.over(1).answer is Answer.REFUSED
    bench.hop()
    assert bench.goals == []
    assert bench.state() is State.STOPPED


def test_a_second_task_is_refused_while_one_is_busy(bench):
    bench.hop(Explore(number=1))
    bench.hop(Park(number=2))
    assert bench.over(2).answer is Answer.REFUSED
    assert bench.over(1).answer is Answer.DONE


def test_of_two_tasks_in_one_hop_the_first_is_performed(bench):
    bench.hop(Park(number=1), TurnTo(1.0, number=2))
    assert bench.over(2).answer is Answer.REFUSED
    assert bench.over(1).answer is Answer.DONE


def test_while_listening_another_task_takes_over():
    bench = Bench(Config.model_validate({"exploit": {"runs": 0}}), memory=Memory(estimate()))
    bench.hop(ListenTo(0, number=1))
    bench.hops_until(Separated)
    bench.hop(ListenTo(1, number=2))
    assert bench.over(1).answer is Answer.CANCELLED
    delivered = bench.hops_until(Separated)
    assert delivered.groups[delivered.target].members == (1,)


def test_a_fault_ends_the_task_and_forbids_the_next(bench):
    bench.hop(Explore(number=1))
    bench.hops_until(TurnStarted)
    bench.fault = "motor stalled"
    assert bench.over(1).answer is Answer.FAILED
    bench.hop(Park(number=2))
    assert bench.over(2).answer is Answer.REFUSED
    assert "motor stalled" in bench.reason(2)
    assert bench.state() is State.FAULT


def test_arming_fails_while_the_fault_is_there_and_finding_the_zero_clears_it(bench):
    bench.fault = "position lost"
    bench.hop()
    bench.hop(Rearm(number=1))
    bench.hop()
    bench.hop()
    assert bench.answers(1) == [Answer.REFUSED]
    begun = bench.hops
    bench.hop(Home(number=2))
    assert bench.over(2).answer is Answer.DONE
    assert bench.hops < begun + 20, "what is not armed never settles"
    bench.hop(Park(number=3))
    assert bench.over(3).answer is Answer.DONE


def test_a_stop_after_a_fault_does_not_keep_the_zero_from_being_found(bench):
    bench.fault = "position lost"
    bench.hop()
    bench.hop(Stop(number=1))
    bench.hop(Rearm(number=2))
    bench.hop()
    bench.hop()
    assert bench.answers(2) == [Answer.REFUSED]
    assert bench.state() is State.FAULT
    bench.hop(Home(number=3))
    assert bench.over(3).answer is Answer.DONE
    bench.hop(Rearm(number=4))
    bench.hop()
    bench.hop()
    assert bench.answers(4) == [Answer.ACCEPTED]


@pytest.mark.parametrize("hops", range(6))
def test_a_stop_while_the_zero_is_looked_for_is_obeyed_whenever_it_comes(bench, hops):
    bench.hop(Home(number=1))
    for _ in range(hops):
        bench.hop()
    bench.hop(Stop(number=2))
    bench.hop()
    bench.hop()
    bench.hop()
    assert bench.answers(2) == [Answer.ACCEPTED]
    assert bench.stopped
    assert bench.state() is State.STOPPED


def test_a_setting_holds_from_the_next_task_on(bench):
    bench.hop(Explore(number=1))
    bench.hop(Set("EXP_UNIT", 9.0, number=2))
    bench.over(1)
    first = bench.hops
    bench.hop(Explore(number=3))
    bench.over(3)
    assert bench.answers(2) == [Answer.ACCEPTED]
    assert bench.hops - first > 2 * first


def test_a_setting_that_is_wrong_is_refused(bench):
    bench.hop(Set("NO_SUCH", 1.0, number=1))
    bench.hop()
    assert bench.answers(1) == [Answer.REFUSED]


def test_the_shutdown_ends_everything_with_a_stop(bench):
    bench.hop(Explore(number=1))
    bench.hops_until(TurnStarted)
    bench.hop(Shutdown())
    for _ in range(5):
        if bench.result is None:
            bench.hop()
    assert bench.result.outcome is Outcome.STOPPED
    assert bench.stopped


def test_a_first_task_begins_by_itself():
    bench = Bench(first=Explore())
    assert bench.hops_until(SourcesEstimated)


def test_what_a_session_knows_can_be_taken_on_by_another(bench):
    bench.hop(Explore(number=1))
    bench.hop()
    assert bench.session.busy
    bench.over(1)
    bench.hop(Stop(number=2))
    bench.hop()
    assert not bench.session.busy
    memory = bench.session.memory
    assert memory.estimate == estimate()
    assert memory.samples == bench.hops * HOP
    after = Bench(memory=memory)
    after.hop(Park(number=3))
    assert after.over(3).answer is Answer.REFUSED  # still stopped
    assert after.events[0].time == memory.samples / RATE


def test_a_stop_outlives_a_fault(bench):
    bench.hop(Stop())
    bench.fault = "unplugged"
    bench.hop()
    bench.fault = ""
    bench.hop()
    bench.hop(Park(number=1))
    assert bench.over(1).answer is Answer.REFUSED
    assert "re-arm" in bench.reason(1)


def test_what_comes_with_the_order_that_ends_a_task_is_obeyed_after_it(bench):
    bench.hop(TurnTo(1.0, number=1))
    bench.hop()
    bench.hop(Stop(number=2), Rearm(number=3))
    bench.over(1)
    bench.hops_until(lambda e: isinstance(e, Answered) and e.order == 3)
    assert bench.answers(1)[-1] is Answer.CANCELLED
    assert bench.answers(2) == bench.answers(3) == [Answer.ACCEPTED]
    assert bench.state() is State.IDLE


def test_a_stop_that_comes_with_a_task_in_place_of_another_is_obeyed():
    bench = Bench(memory=Memory(estimate()))
    bench.hop(ListenTo(0, number=1))
    bench.hops_until(lambda e: isinstance(e, StateChanged) and e.state is State.RUN)
    bench.hop(TurnTo(1.0, number=2), Stop(number=3))
    bench.hops_until(lambda e: isinstance(e, Answered) and e.order == 3)
    assert bench.answers(1)[-1] is Answer.CANCELLED
    assert bench.answers(2) == [Answer.REFUSED]
    assert bench.state() is State.STOPPED
