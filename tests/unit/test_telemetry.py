"""The reporter: a ground station that hears only what is sent knows what the mission knows."""

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from ross_payload.config import Config
from ross_payload.events import (
    AlignmentCandidate,
    AlignmentPlanned,
    Checked,
    Estimate,
    Event,
    Finished,
    GroupScore,
    NoiseMeasured,
    OrientationHeard,
    Outcome,
    ScoreDropped,
    Separated,
    SourceEstimate,
    SourcesEstimated,
    State,
    StateChanged,
    TurnStarted,
)
from ross_payload.telemetry.outlets import periods
from ross_payload.telemetry.report import Reporter
from ross_payload.telemetry.standing import Snapshot
from ross_payload.telemetry.streams import Board, Stream
from ross_protocols.values import (
    CURVE_POINTS,
    Alignment,
    CandidateState,
    Density,
    Health,
    Heartbeat,
    Isolation,
    Phase,
    Rule,
    Separation,
    Source,
    Status,
    Value,
)

REST = Snapshot(
    earth=True, heading=0.2, present=True, joint=0.2, joint_rate=0.0, settled=True, homed=True, rotation_max=12,
    criterion=1.0,
)  # fmt: skip
EMPTY = np.zeros(0)


class Ground:
    """A ground station on a link without limits; it holds the clock."""

    def __init__(self) -> None:
        self.now = 0.0
        self.snapshot = REST
        self.heard: list[tuple[float, Value]] = []
        self._board = Board()
        self._stream = Stream(periods(Config().telemetry), lambda value: 0)
        self.reporter = Reporter(self._board, lambda severity, text: None)

    def wait(self, seconds: float, step: float = 0.01) -> None:
        for _ in range(round(seconds / step)):
            self.reporter.observe(self._present())
            self._listen()
            self.now += step

    def _present(self) -> Snapshot:
        return replace(self.snapshot, time_usec=round(self.now * 1e6))

    def _listen(self) -> None:
        self.heard += [(self.now, value) for value in self._stream.due(self._board, self.now, math.inf)]

    def say(self, *events: Event) -> None:
        for event in events:
            self.reporter.handle(event, self._present())
            self._listen()

    def all(self, kind: type) -> list:
        return [value for _, value in self.heard if type(value) is kind]

    def latest(self, kind: type):
        return self.all(kind)[-1]

    def forget(self) -> None:
        self.heard.clear()


def source(azimuth: float, resolved: bool = True) -> SourceEstimate:
    return SourceEstimate(azimuth, sigma=0.02, confidence=0.9, resolved=resolved, weight=0.5)


def orientation(index: int, heading: float) -> OrientationHeard:
    return OrientationHeard(0.0, index, heading, heading, EMPTY, EMPTY, ())


def candidate(who: int, joint: float, others: tuple[int, ...] = ()) -> AlignmentCandidate:
    return AlignmentCandidate(who, joint, joint, 210e-6, "bisector", others)


def checked(tried: AlignmentCandidate, accepted: int | None, *groups: GroupScore) -> Checked:
    return Checked(0.0, tried, groups, accepted, "gaussian", "the TDOAs are known")


def separated(target: int, *groups: GroupScore) -> Separated:
    return Separated(0.0, 0, 0.3, np.zeros((len(groups), 4)), groups, target, "gaussian", "")


THREE = SourcesEstimated(0.0, Estimate((source(-1.4), source(0.7), source(2.7)), certain=True), 12, final=True)
FIRST, SECOND = candidate(0, 0.5, (2, 1)), candidate(1, 1.5, (0, 2))
PLANNED = AlignmentPlanned(0.0, (FIRST, SECOND), EMPTY, EMPTY)
ALIGN = StateChanged(0.0, State.ALIGN_TURN)


# ---------------------------------------------------------------------------------------------------- what is periodic


def test_what_is_periodic_keeps_its_rate() -> None:
    ground = Ground()
    ground.wait(20.0)
    counts = Counter(type(value) for _, value in ground.heard)
    assert counts == {Heartbeat: 20, Status: 80}


def test_a_loop_that_was_held_up_does_not_catch_up() -> None:
    ground = Ground()
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
def test_the_heartbeat_tells_state_and_health(state: State, health: Health) -> None:
    ground = Ground()
    ground.wait(0.01)
    assert ground.latest(Heartbeat) == Heartbeat(Health.BOOT, State.IDLE)
    ground.say(StateChanged(0.0, state))
    ground.wait(1.0)
    assert ground.latest(Heartbeat) == Heartbeat(health, state)


def test_the_last_heartbeat_of_a_mission_says_that_it_is_over() -> None:
    """Nobody ticks any more when the mission has ended."""
    ground = Ground()
    ground.say(StateChanged(0.0, State.RUN), StateChanged(0.0, State.DONE), Finished(0.0, Outcome.NO_TARGET, "nobody"))
    assert ground.latest(Heartbeat) == Heartbeat(Health.STANDBY, State.DONE)


def test_what_was_found_out_is_repeated_with_its_own_time() -> None:
    ground = Ground()
    ground.now = 3.0
    ground.say(THREE)
    ground.forget()
    ground.wait(20.0)
    again = [(when, value.source) for when, value in ground.heard if isinstance(value, Source)]
    assert [who for _, who in again] == [0, 1, 2] * 3
    assert all(value.time_usec == 3_000_000 for value in ground.all(Source))


# ---------------------------------------------------------------------------------------------------- status


def test_status_is_how_things_stand() -> None:
    ground = Ground()
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


def test_every_event_shows_in_status_at_once() -> None:
    ground = Ground()
    ground.wait(0.01)
    for event in (StateChanged(0.0, State.EXPLORE_LISTEN), NoiseMeasured(0.0, -60.0, 2.0), orientation(3, 0.5), THREE):
        ground.say(event)
    status = ground.latest(Status)
    assert (status.state, status.noise_measured, status.rotation, status.k, status.certain) == (3, True, 3, 3, True)
    assert len(ground.all(Status)) == 5


def test_the_goal_shows_until_the_array_has_settled() -> None:
    ground = Ground()
    ground.snapshot = Snapshot(earth=True, heading=0.0, present=True, settled=False)
    ground.say(TurnStarted(0.0, 0.5, 0.5, "rotation 1"))
    ground.wait(1.0)
    assert ground.latest(Status).heading_goal == pytest.approx(0.5)
    ground.snapshot = REST
    ground.wait(1.0)
    assert ground.latest(Status).heading_goal is None


@pytest.mark.parametrize("outcome", Outcome)
def test_the_outcome_is_told(outcome: Outcome) -> None:
    ground = Ground()
    ground.say(Finished(0.0, outcome, "for a reason"))
    assert ground.latest(Status).outcome == outcome
    assert ground.latest(Status).target_found is (outcome is Outcome.TARGET_FOUND)


# ---------------------------------------------------------------------------------------------------- sources


def test_each_source_is_a_message() -> None:
    ground = Ground()
    ground.say(THREE)
    found = ground.all(Source)
    assert [(s.source, s.count, s.estimate, s.final) for s in found] == [(i, 3, 1, True) for i in range(3)]
    assert [s.azimuth for s in found] == pytest.approx([-1.4, 0.7, 2.7])
    assert all(s.mirror is None for s in found)


def test_a_new_estimate_has_a_new_number() -> None:
    ground = Ground()
    ground.say(THREE, THREE)
    assert [s.estimate for s in ground.all(Source)] == [1, 1, 1, 2, 2, 2]


def test_no_source_at_all_is_an_estimate_too() -> None:
    ground = Ground()
    ground.say(SourcesEstimated(0.0, Estimate(()), 4, final=True))
    assert ground.latest(Status).k == 0
    assert ground.all(Source) == []


def test_a_source_heard_at_one_axis_may_be_its_mirror_image() -> None:
    """Axis along 30 deg: what is at 80 deg sounds like what is at -20 deg."""
    ground = Ground()
    unresolved = Estimate((source(math.radians(80), resolved=False),))
    ground.say(orientation(0, math.radians(30)), SourcesEstimated(0.0, unresolved, 0, final=False))
    assert ground.latest(Source).mirror == pytest.approx(math.radians(-20))
    assert not ground.latest(Source).resolved


def test_heard_at_two_axes_there_is_no_one_mirror_image() -> None:
    ground = Ground()
    unresolved = Estimate((source(1.0, resolved=False),))
    ground.say(orientation(0, 0.0), orientation(1, 0.3), SourcesEstimated(0.0, unresolved, 1, final=False))
    assert ground.latest(Source).mirror is None


def test_a_new_exploration_forgets_the_headings_of_the_old_one() -> None:
    ground = Ground()
    ground.say(orientation(0, 0.0), orientation(1, 0.3), orientation(0, 0.5))
    ground.say(SourcesEstimated(0.0, Estimate((source(1.0, resolved=False),)), 0, final=False))
    assert ground.latest(Source).mirror == pytest.approx(0.0)


# ---------------------------------------------------------------------------------------------------- alignment


def test_each_candidate_is_a_message() -> None:
    ground = Ground()
    ground.say(THREE, PLANNED)
    first, second = ground.all(Alignment)
    assert (first.candidate, first.source, first.aliased, first.rule) == (0, 0, (1, 2), Rule.BISECTOR)
    assert (second.candidate, second.count, second.plan, second.state) == (1, 2, 1, CandidateState.PLANNED)
    assert first.isolation == pytest.approx(210e-6)


def test_a_candidate_is_turned_to_and_rejected_or_accepted() -> None:
    ground = Ground()
    ground.say(THREE, PLANNED, ALIGN, TurnStarted(0.0, FIRST.joint, FIRST.heading, ""))
    assert [(a.candidate, a.state) for a in ground.all(Alignment)[2:]] == [(0, CandidateState.TURNING)]
    ground.say(checked(FIRST, None, GroupScore((0,), -9.0, False), GroupScore((1, 2), -5.0, False)))
    assert ground.latest(Alignment) == ground.all(Alignment)[-1]
    assert (ground.latest(Alignment).candidate, ground.latest(Alignment).state) == (0, CandidateState.REJECTED)
    ground.say(TurnStarted(0.0, SECOND.joint, SECOND.heading, ""))
    ground.say(checked(SECOND, 0, GroupScore((1,), 4.0, True), GroupScore((0, 2), -5.0, False)))
    assert (ground.latest(Alignment).candidate, ground.latest(Alignment).state) == (1, CandidateState.ACCEPTED)


def test_a_rule_of_the_future_is_unknown_not_an_error() -> None:
    ground = Ground()
    ground.say(AlignmentPlanned(0.0, (AlignmentCandidate(0, 0.1, 0.1, 1e-4, "oracle"),), EMPTY, EMPTY))
    assert ground.latest(Alignment).rule is Rule.UNKNOWN


# ---------------------------------------------------------------------------------------------------- separation


def test_a_check_that_finds_the_target_tells_group_source_and_score() -> None:
    ground = Ground()
    ground.say(THREE, PLANNED, checked(SECOND, 1, GroupScore((0, 2), -5.0, False), GroupScore((1,), 4.0, True)))
    other, target = ground.all(Separation)
    assert (other.members, other.accepted, other.target) == ((0, 2), False, False)
    assert (target.members, target.accepted, target.target, target.phase) == ((1,), True, True, Phase.CHECK)
    assert (target.method, target.score, target.criterion, target.si_sdr) == ("gaussian", 4.0, 1.0, None)
    status = ground.latest(Status)
    assert (status.target, status.target_found, status.score) == (1, True, 4.0)
    assert [(s.source, s.target, s.score) for s in ground.all(Source)[3:]] == [(1, True, 4.0)], "only what is new"


def test_a_check_without_the_target_says_so_with_its_best_score() -> None:
    ground = Ground()
    ground.say(THREE, checked(FIRST, None, GroupScore((0,), -9.0, False), GroupScore((1, 2), -5.0, False)))
    status = ground.latest(Status)
    assert (status.target, status.target_found, status.score) == (None, False, -5.0)
    assert not any(group.target for group in ground.all(Separation))


def test_a_target_among_several_is_nobody_yet() -> None:
    ground = Ground()
    ground.say(THREE, PLANNED, checked(FIRST, 1, GroupScore((0,), -9.0, False), GroupScore((1, 2), 3.0, True)))
    status = ground.latest(Status)
    assert (status.target, status.target_found) == (None, True)
    assert ground.latest(Alignment).state is CandidateState.REJECTED, "the voice is not the one it isolates"


def test_a_run_tells_the_score_of_the_running_target() -> None:
    ground = Ground()
    ground.say(THREE, separated(0, GroupScore((1,), 2.0, True), GroupScore((0, 2), 9.0, True)))
    assert ground.latest(Status).score == 2.0
    assert [group.phase for group in ground.all(Separation)] == [Phase.RUN, Phase.RUN]
    assert [group.target for group in ground.all(Separation)] == [True, False]


def test_a_dropped_score_takes_the_target_back() -> None:
    ground = Ground()
    ground.say(THREE, separated(0, GroupScore((1,), 2.0, True)))
    ground.say(separated(0, GroupScore((1,), -2.0, False)), ScoreDropped(0.0, -2.0, 1.0))
    status = ground.latest(Status)
    assert (status.target, status.target_found, status.score) == (None, False, -2.0)
    assert not ground.latest(Source).target


def test_a_new_estimate_takes_back_what_was_said_of_the_old_sources() -> None:
    ground = Ground()
    ground.say(THREE, PLANNED, checked(SECOND, 0, GroupScore((1,), 4.0, True)), THREE)
    ground.forget()
    ground.wait(6.0)
    assert ground.all(Alignment) == ground.all(Separation) == []
    assert ground.latest(Status).target is None
    assert all(s.score is None and not s.target for s in ground.all(Source))


# ---------------------------------------------------------------------------------------------------- curves


def test_what_each_orientation_heard_is_a_curve() -> None:
    ground = Ground()
    grid = np.linspace(-2e-4, 2e-4, 161)
    density = np.exp(-((grid - 1e-4) ** 2) / (2 * 1e-5**2))
    ground.say(OrientationHeard(0.0, 0, 0.5, 0.5, grid, density, (1e-4,)))
    (curve,) = ground.all(Density)
    assert (curve.rotation, curve.heading, curve.first, curve.last) == (0, 0.5, -2e-4, 2e-4)
    loudest = np.linspace(curve.first, curve.last, CURVE_POINTS)[int(np.argmax(curve.density))]
    assert loudest == pytest.approx(1e-4, abs=3e-6)
    assert max(curve.density) == pytest.approx(1.0, abs=0.1)


def test_a_new_exploration_takes_the_curves_of_the_old_one_away() -> None:
    ground = Ground()
    heard = [OrientationHeard(0.0, index, 0.1, 0.1, np.arange(3.0), np.ones(3), ()) for index in (0, 1, 0)]
    ground.say(*heard)
    ground.forget()
    ground.wait(10.0)
    assert {(curve.exploration, curve.rotation) for curve in ground.all(Density)} == {(2, 0)}


def test_the_isolation_of_every_source_is_a_curve_over_half_a_turn() -> None:
    ground = Ground()
    headings = np.linspace(0, 3.1, 63)
    isolation = np.array([np.sin(headings) * 2e-4, np.sin(headings) * 1e-4])
    ground.say(THREE, AlignmentPlanned(0.0, (FIRST,), headings, isolation))
    first, second = ground.all(Isolation)
    assert (first.source, second.source, first.plan) == (0, 1, 1)
    assert (first.first, first.last) == (0.0, 3.1)
    assert max(first.isolation) * first.maximum == pytest.approx(2e-4, rel=0.01)
    assert max(second.isolation) * second.maximum == pytest.approx(1e-4, rel=0.01)


def test_silence_has_no_curve() -> None:
    ground = Ground()
    ground.say(OrientationHeard(0.0, 0, 0.5, 0.5, np.arange(3.0), np.zeros(3), ()), THREE, PLANNED)
    assert ground.all(Density) == ground.all(Isolation) == []


# ---------------------------------------------------------------------------------------------------- task after task


def test_the_outcome_of_one_task_is_forgotten_when_the_next_begins() -> None:
    ground = Ground()
    ground.say(StateChanged(0.0, State.RUN), StateChanged(0.0, State.DONE), Finished(0.0, Outcome.COMPLETED, "done"))
    ground.say(StateChanged(0.0, State.IDLE))
    assert ground.latest(Status).outcome == Outcome.COMPLETED
    ground.say(StateChanged(0.0, State.TURN))
    assert ground.latest(Status).outcome is None
    ground.say(Finished(0.0, Outcome.STOPPED, "cancelled"), StateChanged(0.0, State.STOPPED))
    assert ground.latest(Status).outcome == Outcome.STOPPED
    assert ground.latest(Heartbeat) == Heartbeat(Health.STANDBY, State.STOPPED)


def test_what_an_earlier_task_found_out_is_told_while_the_next_one_turns() -> None:
    ground = Ground()
    ground.say(THREE, Finished(0.0, Outcome.COMPLETED, "3 sources"), StateChanged(0.0, State.IDLE))
    ground.say(StateChanged(0.0, State.TURN))
    ground.forget()
    ground.wait(6.0)
    assert {value.source for value in ground.all(Source)} == {0, 1, 2}
    assert ground.latest(Status).k == 3
