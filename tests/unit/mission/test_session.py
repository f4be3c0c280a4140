"""The live mission: orders come with the hops, tasks follow each other, nothing turns unasked."""

from dataclasses import replace

import numpy as np
import pytest

from ross_payload.errors import ConfigError, PluginError
from ross_payload.events import (
    Answer,
    Finished,
    Outcome,
    Separated,
    SourcesEstimated,
    State,
    StateChanged,
    TurnStarted,
)
from ross_payload.mission.live_session import Kit
from ross_payload.mission.tasks import Memory
from ross_payload.orders import (
    Cancel,
    Enrol,
    Explore,
    Home,
    Informed,
    ListenAt,
    ListenTo,
    MeasureNoise,
    Park,
    Point,
    Seek,
    Set,
    Shutdown,
    Stop,
    TurnTo,
)
from ross_payload.plugin_results import MOST_SOURCES
from session_bench import AZIMUTHS, HOP, RATE, Bench, Numbered, estimate, make, nobody


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


def test_the_sources_that_orders_count_are_told_again_when_an_exploration_does_not_end(bench):
    bench.hop(Explore(number=1))
    bench.over(1)
    bench.hop(Explore(number=2))
    assert bench.hops_until(SourcesEstimated).estimate.k == 0  # so far
    bench.hop(Cancel(number=3))
    bench.over(2)
    told = [event for event in bench.events if isinstance(event, SourcesEstimated)][-1]
    assert told.final
    assert told.estimate == bench.session.memory.estimate == estimate()
    count = len(bench.events)
    bench.hop(ListenTo(2, number=4))
    assert bench.over(4).answer is Answer.DONE
    assert not [event for event in bench.events[count:] if isinstance(event, SourcesEstimated)]


def test_they_are_told_again_when_the_frame_of_their_azimuths_is_back(bench):
    bench.hop(Explore(number=1))
    bench.over(1)
    bench.known = True
    bench.hop(Explore(number=2))
    bench.hops_until(SourcesEstimated)
    bench.hop(Cancel(number=3))
    bench.over(2)
    bench.hop()
    assert not [event for event in bench.events if isinstance(event, SourcesEstimated)][-1].final
    bench.known = False
    assert bench.hops_until(SourcesEstimated, limit=3).final
    for _ in range(10):
        bench.hop()
    assert [event.final for event in bench.events if isinstance(event, SourcesEstimated)][-2:] == [False, True]


def test_an_exploration_that_does_not_end_leaves_what_it_told_where_nothing_else_is_known(bench):
    bench.hop(Explore(number=1))
    bench.hops_until(SourcesEstimated)
    bench.hop(Cancel(number=2))
    bench.over(1)
    told = [event for event in bench.events if isinstance(event, SourcesEstimated)]
    assert [event.final for event in told] == [False]
    bench.hop(ListenTo(0, number=3))
    assert bench.over(3).answer is Answer.REFUSED


def test_azimuths_that_were_heard_stay_so_when_a_voice_is_sought_among_them(bench):
    """What is told by somebody does not show that the array has slipped."""
    bench.hop(Explore(number=1))
    bench.over(1)
    bench.hop(Seek(number=2))
    bench.over(2)
    assert bench.session.memory.explored
    bench.hop(Informed(tuple(np.deg2rad(AZIMUTHS)), number=3))
    bench.over(3)
    assert not bench.session.memory.explored


def test_an_estimate_is_known_when_a_plug_in_fails_right_after_it():
    class Broken(Numbered):
        def batch(self, spectrogram, scene):
            raise PluginError("separator 'broken': no")

    def broken(config):
        kit = make(config)
        return Kit(kit.settings, replace(kit.tools, separator=Broken()))

    bench = Bench(make=broken)
    bench.hop(Seek(number=1))
    assert bench.over(1).answer is Answer.FAILED
    assert [event for event in bench.events if isinstance(event, SourcesEstimated)][-1].final
    assert bench.session.memory.estimate == estimate()


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


def test_nobody_sounds_like_the_target_when_nobody_is_enrolled_whatever_the_criterion():
    def kind(config):
        kit = nobody(config)
        return Kit(replace(kit.settings, criterion=-1.0), kit.tools)

    bench = Bench(make=kind, memory=Memory(estimate()))
    bench.hop(ListenTo(1, number=1))
    assert bench.over(1).answer is Answer.DONE
    heard = [group for event in bench.events if isinstance(event, Separated) for group in event.groups]
    assert heard
    assert not any(group.accepted for group in heard)


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


def test_a_slow_rate_from_beyond_a_limit_asks_for_no_angle_outside(bench):
    """The joint stands beyond its limits where the switch is by which it finds its zero."""
    bench.joint = bench.goal = 4.0
    bench.hop(Point(rate=-0.05))
    for _ in range(50):
        bench.hop()
    assert bench.goals
    assert max(bench.goals) <= 3.5


@pytest.mark.parametrize(
    "kind", [ListenAt, lambda azimuth, number: Enrol(azimuth=azimuth, consent=True, number=number)]
)
def test_azimuths_are_told_until_as_many_sources_are_known_as_can_be_planned_for(kind, bench):
    """Each that is told is one more source; the bit masks of the dialect end at 32."""
    for number in range(1, MOST_SOURCES + 1):
        bench.hop(ListenAt(np.deg2rad(22 * number), number=number))
        bench.over(number)
    assert bench.session.memory.estimate.k == MOST_SOURCES
    bench.hop(kind(np.deg2rad(11), number=50))
    assert bench.over(50).answer is Answer.REFUSED
    assert "16 sources are known" in bench.reason(50)
    bench.hop(ListenAt(np.deg2rad(23), number=51))
    assert bench.answers(51) != [Answer.REFUSED]
    bench.over(51)
    bench.hop(Explore(number=52))
    bench.over(52)
    bench.hop(ListenAt(np.deg2rad(11), number=53))
    assert bench.over(53).answer is not Answer.REFUSED


class Coarse(Bench):
    """A turntable that is settled 7 degrees from its goal, as a vehicle may be in wind."""

    def hop(self, *orders):
        if self.moving == 1:
            self.goal -= np.deg2rad(7)
        super().hop(*orders)


def test_a_heading_is_reached_where_the_actuator_says_that_it_is_there():
    bench = Coarse()
    bench.hop(TurnTo(1.2, number=1))
    assert bench.over(1).answer is Answer.DONE
    assert bench.joint == pytest.approx(1.2 - np.deg2rad(7))


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


def test_a_task_that_cannot_be_begun_does_not_end_the_present_one():
    """A plug-in was changed meanwhile."""
    broken = []

    def checked(config):
        if broken:
            raise ConfigError("separator 'numbered' is unknown")
        return make(config)

    bench = Bench(make=checked, memory=Memory(estimate()))
    bench.hop(ListenTo(1, number=1))
    bench.hops_until(lambda event: isinstance(event, StateChanged) and event.state is State.RUN)
    broken.append(True)
    bench.hop(Seek(number=2))
    assert bench.over(2).answer is Answer.REFUSED
    assert bench.reason(2) == "separator 'numbered' is unknown"
    assert bench.answers(1) == [Answer.ACCEPTED]
    broken.clear()
    assert bench.over(1).answer is Answer.DONE


@pytest.mark.parametrize(
    "task", [Park(number=2), Home(number=2), TurnTo(0.1, number=2), MeasureNoise(0.5, number=2), Point(0.1, number=2)]
)
@pytest.mark.parametrize("listening", [True, False])
def test_what_needs_no_plug_in_is_done_also_when_one_cannot_be_used(task, listening):
    """It was changed meanwhile, as its package can be."""
    broken = []

    def checked(config):
        if broken:
            raise ConfigError("explorer 'believer' is unknown")
        return make(config)

    bench = Bench(make=checked, memory=Memory(estimate()))
    if listening:
        bench.hop(ListenTo(1, number=1))
        bench.hops_until(lambda event: isinstance(event, StateChanged) and event.state is State.RUN)
    broken.append(True)
    bench.hop(task)
    assert bench.over(2).answer is Answer.DONE


def test_a_setting_holds_from_the_next_task_on(bench):
    bench.hop(Explore(number=1))
    bench.hop(Set("EXP_UNIT", 9.0, number=2))
    bench.over(1)
    first = bench.hops
    bench.hop(Explore(number=3))
    bench.over(3)
    assert bench.answers(2) == [Answer.ACCEPTED]
    assert bench.hops - first > 2 * first


@pytest.mark.parametrize("together", [True, False])
def test_a_setting_holds_for_a_task_that_takes_the_place_of_the_present_one(together):
    bench = Bench(memory=Memory(estimate()))
    bench.hop(ListenTo(1, number=1))
    bench.hops_until(lambda event: isinstance(event, StateChanged) and event.state is State.RUN)
    orders = Set("EXP_UNIT", 9.0, number=2), Explore(number=3)
    for each in [orders] if together else [(order,) for order in orders]:
        bench.hop(*each)
    first = bench.hops
    bench.over(3)
    assert bench.answers(2) == [Answer.ACCEPTED]
    assert bench.hops - first > 3 * 0.9 * RATE / HOP


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
