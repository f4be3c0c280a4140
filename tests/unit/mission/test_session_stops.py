"""Stops, cancels, faults and arming again, whenever they come in a session."""

import pytest

from ross_payload.config import Config
from ross_payload.errors import ConfigError
from ross_payload.events import (
    Answer,
    Answered,
    Separated,
    State,
    StateChanged,
    TurnStarted,
)
from ross_payload.mission.tasks import Memory
from ross_payload.orders import (
    Cancel,
    Explore,
    Home,
    ListenTo,
    Park,
    Rearm,
    Set,
    Stop,
    TurnTo,
)
from session_bench import HOP, RATE, Bench, estimate, make


@pytest.fixture
def bench():
    return Bench()


def hops(bench, n):
    for _ in range(n):
        bench.hop()


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


def test_an_actuator_that_is_late_at_the_start_is_no_fault_once_it_is_there(bench):
    bench.fault = "no heartbeat received from an autopilot"
    bench.hop()
    bench.hop()
    bench.hop()
    assert bench.state() is State.FAULT
    bench.fault = ""
    bench.hop()
    bench.hop()
    assert bench.state() is State.IDLE
    bench.hop(Park(number=1))
    assert bench.over(1).answer is Answer.DONE


def test_an_actuator_that_is_late_does_not_undo_a_stop(bench):
    bench.fault = "waiting for a node id"
    bench.hop(Stop())
    bench.hop()
    bench.hop()
    bench.fault = ""
    bench.hop()
    bench.hop()
    assert bench.state() is State.STOPPED
    bench.hop(Park(number=1))
    assert bench.over(1).answer is Answer.REFUSED


@pytest.mark.parametrize("first", [(), (Home(number=1),)], ids=["it was well before", "it was homed before"])
def test_a_fault_while_nothing_turned_is_over_a_second_after_its_cause(bench, first):
    bench.fault = "waiting for a node id" if first else ""
    bench.hop()
    bench.hop(*first)
    if first:
        bench.over(1)
    bench.fault = "no report for 0.5 s"
    hops(bench, 4)
    assert bench.state() is State.FAULT
    bench.fault = ""
    hops(bench, 90)
    assert bench.state() is State.FAULT
    hops(bench, 20)
    assert bench.state() is State.IDLE
    bench.hop(Park(number=2))
    assert bench.over(2).answer is Answer.DONE


def test_a_fault_that_lasts_is_told_once_and_another_one_again(bench):
    """An idle actuator that was unplugged was told with every hop, a hundred times in a second."""
    bench.hop()
    for hop in range(50, 90):
        bench.fault = f"no report for {hop / 100:.2f} s"
        bench.hop()
    for bench.fault in ("node 5: fault 0x2310", "node 5: fault 0x3210"):
        hops(bench, 3)
    told = [e.detail for e in bench.events if isinstance(e, StateChanged) and e.state is State.FAULT]
    assert told == ["no report for 0.50 s", "node 5: fault 0x2310", "node 5: fault 0x3210"]


def test_a_fault_that_comes_and_goes_is_not_over_between(bench):
    for _ in range(6):
        bench.fault = "no report for 0.5 s"
        hops(bench, 2)
        bench.fault = ""
        hops(bench, 50)
    assert {e.state for e in bench.events if isinstance(e, StateChanged)} == {State.IDLE, State.FAULT}
    assert bench.state() is State.FAULT


def test_a_fault_while_nothing_turned_does_not_undo_a_stop(bench):
    bench.hop(Stop())
    bench.fault = "no report for 0.5 s"
    hops(bench, 4)
    bench.fault = ""
    hops(bench, 120)
    assert bench.state() is State.STOPPED


def test_a_fault_that_is_not_of_the_start_waits_for_rearm(bench):
    """It has ended a task."""
    bench.hop(TurnTo(1.0, number=1))
    bench.hop()
    bench.fault = "does not follow"
    assert bench.over(1).answer is Answer.FAILED
    bench.fault = ""
    hops(bench, 300)
    assert bench.state() is State.FAULT
    bench.hop(Rearm(number=2))
    hops(bench, 2)
    assert bench.answers(2) == [Answer.ACCEPTED]
    assert bench.state() is State.IDLE


@pytest.mark.parametrize("late", [5, 800])
def test_the_task_to_begin_with_begins_when_the_actuator_is_ready(late):
    bench = Bench(first=Explore())
    bench.fault = "waiting for a node id"
    hops(bench, late)
    assert not bench.goals
    assert bench.session.memory.pending
    bench.fault = ""
    bench.hops_until(TurnStarted)
    assert not bench.session.memory.pending
    assert bench.over(0).answer is Answer.DONE


@pytest.mark.parametrize("order", [Stop(number=1), Cancel(number=1), Home(number=1), Rearm(number=1)], ids=repr)
def test_the_task_to_begin_with_does_not_begin_when_something_else_was_ordered(order):
    bench = Bench(first=Explore())
    bench.fault = "waiting for a node id"
    hops(bench, 5)
    bench.hop(order)
    hops(bench, 5)
    bench.fault = ""
    hops(bench, 300)
    assert not any(isinstance(event, TurnStarted) for event in bench.events)
    assert bench.answers(0) == [Answer.REFUSED]


def test_the_task_to_begin_with_does_not_begin_while_a_stop_is_latched():
    bench = Bench(memory=Memory(stopped=True, starting=True), first=Explore())
    bench.fault = "waiting for a node id"
    hops(bench, 5)
    bench.fault = ""
    hops(bench, 300)
    assert bench.goals == []
    assert "re-arm" in bench.reason(0)


def test_a_setting_does_not_keep_the_task_to_begin_with_from_beginning():
    bench = Bench(first=Explore())
    bench.fault = "waiting for a node id"
    bench.hop(Set("XPL_RUN", 1.5, number=1))
    hops(bench, 5)
    assert bench.answers(1) == [Answer.ACCEPTED], bench.reason(1)
    bench.fault = ""
    assert bench.over(0).answer is Answer.DONE


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


def test_a_fault_that_begins_while_the_zero_is_found_and_lasts_ends_it_soon(bench):
    bench.fault = "no data from the gimbal"
    bench.hop()
    bench.hop(Home(number=1))
    hops(bench, 2)
    bench.lasting, begun = "the gimbal does not follow", bench.hops
    assert bench.over(1).answer is Answer.FAILED
    assert "does not follow" in bench.reason(1)
    assert (bench.hops - begun) * HOP / RATE == pytest.approx(2.0, abs=0.1)


def test_faults_that_pass_while_the_zero_is_found_do_not_end_it(bench):
    bench.hop(Home(number=1))
    bench.hop()
    for _ in range(3):
        bench.lasting = "reports are late"
        hops(bench, 150)
        bench.lasting, bench.moving = "", 3
        bench.hop()
    assert bench.over(1).answer is Answer.DONE


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


@pytest.mark.parametrize("going_on", [True, False])
def test_arming_that_was_ordered_right_behind_a_task_does_not_undo_a_later_stop(going_on):
    bench = Bench(memory=Memory(estimate()))
    if going_on:
        bench.hop(ListenTo(1, number=1))
        bench.hops_until(lambda event: isinstance(event, StateChanged) and event.state is State.RUN)
    bench.hop(ListenTo(0, number=2), Rearm(number=3))
    bench.hops_until(TurnStarted)
    bench.hop(Stop(number=4))
    hops(bench, 20)
    assert bench.answers(3) == [Answer.REFUSED]
    assert (bench.state(), bench.stopped) == (State.STOPPED, True)


def test_arming_that_was_ordered_right_behind_a_task_that_is_refused_is_obeyed(bench):
    bench.hop(Stop(number=1))
    bench.hop(Park(number=2), Rearm(number=3))
    hops(bench, 3)
    assert (bench.answers(2), bench.answers(3)) == ([Answer.REFUSED], [Answer.ACCEPTED])


def test_a_task_that_cannot_be_prepared_is_refused_and_the_payload_goes_on():
    wrong = []

    def prepared(config):
        if wrong:
            raise ConfigError("two voice models: which one?")
        return make(config)

    bench = Bench(make=prepared)
    bench.hop()
    wrong.append(True)
    bench.hop(Explore(number=1))
    bench.over(1)
    assert (bench.answers(1), bench.reason(1)) == ([Answer.REFUSED], "two voice models: which one?")
    bench.hop(Park(number=2))  # needs none of them
    bench.over(2)
    assert bench.answers(2) == [Answer.ACCEPTED, Answer.DONE]
    wrong.clear()
    bench.hop(Explore(number=3))
    bench.over(3)
    assert bench.answers(3)[-1] is Answer.DONE


def test_a_stop_that_comes_with_a_task_in_place_of_another_is_obeyed():
    bench = Bench(memory=Memory(estimate()))
    bench.hop(ListenTo(0, number=1))
    bench.hops_until(lambda e: isinstance(e, StateChanged) and e.state is State.RUN)
    bench.hop(TurnTo(1.0, number=2), Stop(number=3))
    bench.hops_until(lambda e: isinstance(e, Answered) and e.order == 3)
    assert bench.answers(1)[-1] is Answer.CANCELLED
    assert bench.answers(2) == [Answer.REFUSED]
    assert bench.state() is State.STOPPED
