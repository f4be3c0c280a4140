"""The reporter: a ground station that hears only what is sent knows what the mission knows."""

import math
from collections import Counter

import numpy as np
import pytest

from ross_payload.events import (
    Estimate,
    Finished,
    NoiseMeasured,
    OrientationHeard,
    Outcome,
    SourceEstimate,
    SourcesEstimated,
    State,
    StateChanged,
    TurnStarted,
)
from ross_payload.telemetry.snapshot import Snapshot
from ross_protocols.mavlink.values import Health, Heartbeat, Source, Status

EMPTY = np.zeros(0)


def source(azimuth: float, resolved: bool = True) -> SourceEstimate:
    return SourceEstimate(azimuth, sigma=0.02, confidence=0.9, resolved=resolved, weight=0.5)


def orientation(index: int, heading: float) -> OrientationHeard:
    return OrientationHeard(0.0, index, heading, heading, EMPTY, EMPTY, ())


THREE = SourcesEstimated(0.0, Estimate((source(-1.4), source(0.7), source(2.7)), certain=True), 12, final=True)


# ---------------------------------------------------------------------------------------------------- what is periodic


def test_what_is_periodic_keeps_its_rate(ground) -> None:
    ground.wait(20.0)
    counts = Counter(type(value) for _, value in ground.heard)
    assert counts == {Heartbeat: 20, Status: 80}


def test_a_loop_that_was_held_up_does_not_catch_up(ground) -> None:
    ground.wait(1.0)
    ground.forget()
    ground.now += 60.0
    ground.wait(0.01)
    assert Counter(type(value) for _, value in ground.heard) == {Heartbeat: 1, Status: 1}


@pytest.mark.parametrize(
    ("state", "health"),
    [
        (State.IDLE, Health.STANDBY),
        (State.LEAD_IN, Health.CALIBRATING),
        (State.EXPLORE_TURN, Health.ACTIVE),
        (State.EXPLORE_LISTEN, Health.ACTIVE),
        (State.ALIGN_TURN, Health.ACTIVE),
        (State.CHECK, Health.ACTIVE),
        (State.RUN, Health.ACTIVE),
        (State.DONE, Health.STANDBY),
        (State.STOPPED, Health.STANDBY),
        (State.FAULT, Health.CRITICAL),
    ],
)
def test_the_heartbeat_tells_state_and_health(ground, state: State, health: Health) -> None:
    ground.wait(0.01)
    assert ground.latest(Heartbeat) == Heartbeat(Health.BOOT, State.IDLE)
    ground.say(StateChanged(0.0, state))
    ground.wait(1.0)
    assert ground.latest(Heartbeat) == Heartbeat(health, state)


def test_the_last_heartbeat_of_a_mission_says_that_it_is_over(ground) -> None:
    """Nobody ticks any more when the mission has ended."""
    ground.say(StateChanged(0.0, State.RUN), StateChanged(0.0, State.DONE), Finished(0.0, Outcome.NO_TARGET, "nobody"))
    assert ground.latest(Heartbeat) == Heartbeat(Health.STANDBY, State.DONE)


def test_what_was_found_out_is_repeated_with_its_own_time(ground) -> None:
    ground.now = 3.0
    ground.say(THREE)
    ground.forget()
    ground.wait(20.0)
    again = [(when, value.source) for when, value in ground.heard if isinstance(value, Source)]
    assert [who for _, who in again] == [0, 1, 2] * 3
    assert all(value.time_usec == 3_000_000 for value in ground.all(Source))


# ---------------------------------------------------------------------------------------------------- status


def test_status_is_how_things_stand(ground) -> None:
    ground.snapshot = Snapshot(
        mission_time=12.345, earth=True, heading=-0.5, mount_yaw=1.0, present=True, joint=-1.5, joint_rate=0.25,
        homed=True, open_loop=True, rotation_max=12, criterion=1.0,
    )  # fmt: skip
    ground.wait(0.01)
    status = ground.latest(Status)
    assert (status.heading, status.mount_yaw, status.joint, status.joint_rate) == pytest.approx((-0.5, 1.0, -1.5, 0.25))
    assert (status.mission_time, status.earth, status.rotation_max, status.criterion) == (12.345, True, 12, 1.0)
    assert (status.actuator_present, status.settled, status.homed, status.fault, status.open_loop) == (
        True, False, True, False, True,
    )  # fmt: skip
    assert (status.k, status.target, status.outcome, status.score) == (None, None, None, None)


def test_every_event_shows_in_status_at_once(ground) -> None:
    ground.wait(0.01)
    for event in (StateChanged(0.0, State.EXPLORE_LISTEN), NoiseMeasured(0.0, -60.0, 2.0), orientation(3, 0.5), THREE):
        ground.say(event)
    status = ground.latest(Status)
    assert (status.state, status.noise_measured, status.rotation, status.k, status.certain) == (3, True, 3, 3, True)
    assert len(ground.all(Status)) == 5


def test_the_goal_shows_until_the_array_has_settled(ground) -> None:
    ground.snapshot = Snapshot(earth=True, heading=0.0, present=True, settled=False)
    ground.say(TurnStarted(0.0, 0.5, 0.5, "rotation 1"))
    ground.wait(1.0)
    assert ground.latest(Status).heading_goal == pytest.approx(0.5)
    ground.snapshot = ground.rest
    ground.wait(1.0)
    assert ground.latest(Status).heading_goal is None


@pytest.mark.parametrize("outcome", Outcome)
def test_the_outcome_is_told(ground, outcome: Outcome) -> None:
    ground.say(Finished(0.0, outcome, "for a reason"))
    assert ground.latest(Status).outcome == outcome
    assert ground.latest(Status).target_found is (outcome is Outcome.TARGET_FOUND)


# ---------------------------------------------------------------------------------------------------- sources


def test_each_source_is_a_message(ground) -> None:
    ground.say(THREE)
    found = ground.all(Source)
    assert [(s.source, s.count, s.estimate, s.final) for s in found] == [(i, 3, 1, True) for i in range(3)]
    assert [s.azimuth for s in found] == pytest.approx([-1.4, 0.7, 2.7])
    assert all(s.mirror is None for s in found)


def test_a_new_estimate_has_a_new_number(ground) -> None:
    ground.say(THREE, THREE)
    assert [s.estimate for s in ground.all(Source)] == [1, 1, 1, 2, 2, 2]


def test_no_source_at_all_is_an_estimate_too(ground) -> None:
    ground.say(SourcesEstimated(0.0, Estimate(()), 4, final=True))
    assert ground.latest(Status).k == 0
    assert ground.all(Source) == []


def test_a_source_heard_at_one_axis_may_be_its_mirror_image(ground) -> None:
    """Axis along 30 deg: what is at 80 deg sounds like what is at -20 deg."""
    unresolved = Estimate((source(math.radians(80), resolved=False),))
    ground.say(orientation(0, math.radians(30)), SourcesEstimated(0.0, unresolved, 0, final=False))
    assert ground.latest(Source).mirror == pytest.approx(math.radians(-20))
    assert not ground.latest(Source).resolved


def test_heard_at_two_axes_there_is_no_one_mirror_image(ground) -> None:
    unresolved = Estimate((source(1.0, resolved=False),))
    ground.say(orientation(0, 0.0), orientation(1, 0.3), SourcesEstimated(0.0, unresolved, 1, final=False))
    assert ground.latest(Source).mirror is None


def test_a_new_exploration_forgets_the_headings_of_the_old_one(ground) -> None:
    ground.say(orientation(0, 0.0), orientation(1, 0.3), orientation(0, 0.5))
    ground.say(SourcesEstimated(0.0, Estimate((source(1.0, resolved=False),)), 0, final=False))
    assert ground.latest(Source).mirror == pytest.approx(0.0)


# ---------------------------------------------------------------------------------------------------- task after task


def test_the_outcome_of_one_task_is_forgotten_when_the_next_begins(ground) -> None:
    ground.say(StateChanged(0.0, State.RUN), StateChanged(0.0, State.DONE), Finished(0.0, Outcome.COMPLETED, "done"))
    ground.say(StateChanged(0.0, State.IDLE))
    assert ground.latest(Status).outcome == Outcome.COMPLETED
    ground.say(StateChanged(0.0, State.TURN))
    assert ground.latest(Status).outcome is None
    ground.say(Finished(0.0, Outcome.STOPPED, "cancelled"), StateChanged(0.0, State.STOPPED))
    assert ground.latest(Status).outcome == Outcome.STOPPED
    assert ground.latest(Heartbeat) == Heartbeat(Health.STANDBY, State.STOPPED)


def test_what_an_earlier_task_found_out_is_told_while_the_next_one_turns(ground) -> None:
    ground.say(THREE, Finished(0.0, Outcome.COMPLETED, "3 sources"), StateChanged(0.0, State.IDLE))
    ground.say(StateChanged(0.0, State.TURN))
    ground.forget()
    ground.wait(6.0)
    assert {value.source for value in ground.all(Source)} == {0, 1, 2}
    assert ground.latest(Status).k == 3
