"""The reporter: headings to try, what was separated there, and the curves behind both."""

import numpy as np
import pytest

from ross_payload.events import (
    AlignmentCandidate,
    AlignmentPlanned,
    Checked,
    Enrolled,
    Estimate,
    Finished,
    GroupScore,
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
from ross_payload.telemetry.reporter import Reporter
from ross_protocols.mavlink.values import (
    CURVE_POINTS,
    Alignment,
    CandidateState,
    Density,
    Isolation,
    Phase,
    Rule,
    Separation,
    Source,
    Status,
)

EMPTY = np.zeros(0)


def source(azimuth: float, resolved: bool = True) -> SourceEstimate:
    return SourceEstimate(azimuth, sigma=0.02, confidence=0.9, resolved=resolved, weight=0.5)


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


# ---------------------------------------------------------------------------------------------------- alignment


def test_each_candidate_is_a_message(ground) -> None:
    ground.say(THREE, PLANNED)
    first, second = ground.all(Alignment)
    assert (first.candidate, first.source, first.aliased, first.rule) == (0, 0, (1, 2), Rule.BISECTOR)
    assert (second.candidate, second.count, second.plan, second.state) == (1, 2, 1, CandidateState.PLANNED)
    assert first.isolation == pytest.approx(210e-6)


def test_a_candidate_is_turned_to_and_rejected_or_accepted(ground) -> None:
    ground.say(THREE, PLANNED, ALIGN, TurnStarted(0.0, FIRST.joint, FIRST.heading, ""))
    assert [(a.candidate, a.state) for a in ground.all(Alignment)[2:]] == [(0, CandidateState.TURNING)]
    ground.say(checked(FIRST, None, GroupScore((0,), -9.0, False), GroupScore((1, 2), -5.0, False)))
    assert ground.latest(Alignment) == ground.all(Alignment)[-1]
    assert (ground.latest(Alignment).candidate, ground.latest(Alignment).state) == (0, CandidateState.REJECTED)
    ground.say(TurnStarted(0.0, SECOND.joint, SECOND.heading, ""))
    ground.say(checked(SECOND, 0, GroupScore((1,), 4.0, True), GroupScore((0, 2), -5.0, False)))
    assert (ground.latest(Alignment).candidate, ground.latest(Alignment).state) == (1, CandidateState.ACCEPTED)


def test_a_rule_of_the_future_is_unknown_not_an_error(ground) -> None:
    ground.say(AlignmentPlanned(0.0, (AlignmentCandidate(0, 0.1, 0.1, 1e-4, "oracle"),), EMPTY, EMPTY))
    assert ground.latest(Alignment).rule is Rule.UNKNOWN


# ---------------------------------------------------------------------------------------------------- separation


def test_a_check_that_finds_the_target_tells_group_source_and_score(ground) -> None:
    ground.say(THREE, PLANNED, checked(SECOND, 1, GroupScore((0, 2), -5.0, False), GroupScore((1,), 4.0, True)))
    other, target = ground.all(Separation)
    assert (other.members, other.accepted, other.target) == ((0, 2), False, False)
    assert (target.members, target.accepted, target.target, target.phase) == ((1,), True, True, Phase.CHECK)
    assert (target.method, target.score, target.criterion, target.si_sdr) == ("gaussian", 4.0, 1.0, None)
    status = ground.latest(Status)
    assert (status.target, status.target_found, status.score) == (1, True, 4.0)
    assert [(s.source, s.target, s.score) for s in ground.all(Source)[3:]] == [(1, True, 4.0)], "only what is new"


def test_a_check_without_the_target_says_so_with_its_best_score(ground) -> None:
    ground.say(THREE, checked(FIRST, None, GroupScore((0,), -9.0, False), GroupScore((1, 2), -5.0, False)))
    status = ground.latest(Status)
    assert (status.target, status.target_found, status.score) == (None, False, -5.0)
    assert not any(group.target for group in ground.all(Separation))


def test_a_target_among_several_is_nobody_yet(ground) -> None:
    ground.say(THREE, PLANNED, checked(FIRST, 1, GroupScore((0,), -9.0, False), GroupScore((1, 2), 3.0, True)))
    status = ground.latest(Status)
    assert (status.target, status.target_found) == (None, True)
    assert ground.latest(Alignment).state is CandidateState.REJECTED, "the voice is not the one it isolates"


def test_a_run_tells_the_score_of_the_running_target(ground) -> None:
    ground.say(THREE, separated(0, GroupScore((1,), 2.0, True), GroupScore((0, 2), 9.0, True)))
    assert ground.latest(Status).score == 2.0
    assert [group.phase for group in ground.all(Separation)] == [Phase.RUN, Phase.RUN]
    assert [group.target for group in ground.all(Separation)] == [True, False]


@pytest.mark.parametrize("outcome", [Outcome.STOPPED, Outcome.COMPLETED, Outcome.FAULT])
def test_a_recognised_target_stays_recognised_when_the_task_ends_early(ground, outcome: Outcome) -> None:
    ground.say(THREE, separated(0, GroupScore((1,), 2.0, True)), Finished(0.0, outcome, "for a reason"))
    status = ground.latest(Status)
    assert (status.target, status.target_found, status.outcome) == (1, True, outcome)


def test_a_dropped_score_takes_the_target_back(ground) -> None:
    ground.say(THREE, separated(0, GroupScore((1,), 2.0, True)))
    ground.say(separated(0, GroupScore((1,), -2.0, False)), ScoreDropped(0.0, -2.0, 1.0))
    status = ground.latest(Status)
    assert (status.target, status.target_found, status.score) == (None, False, -2.0)
    assert not ground.latest(Source).target


def test_a_new_estimate_takes_back_what_was_said_of_the_old_sources(ground) -> None:
    ground.say(THREE, PLANNED, checked(SECOND, 0, GroupScore((1,), 4.0, True)), THREE)
    ground.forget()
    ground.wait(6.0)
    assert ground.all(Alignment) == ground.all(Separation) == []
    assert ground.latest(Status).target is None
    assert all(s.score is None and not s.target for s in ground.all(Source))


# ---------------------------------------------------------------------------------------------------- curves


def test_what_each_orientation_heard_is_a_curve(ground) -> None:
    grid = np.linspace(-2e-4, 2e-4, 161)
    density = np.exp(-((grid - 1e-4) ** 2) / (2 * 1e-5**2))
    ground.say(OrientationHeard(0.0, 0, 0.5, 0.5, grid, density, (1e-4,)))
    (curve,) = ground.all(Density)
    assert (curve.rotation, curve.heading, curve.first, curve.last) == (0, 0.5, -2e-4, 2e-4)
    loudest = np.linspace(curve.first, curve.last, CURVE_POINTS)[int(np.argmax(curve.density))]
    assert loudest == pytest.approx(1e-4, abs=3e-6)
    assert max(curve.density) == pytest.approx(1.0, abs=0.1)


def test_a_new_exploration_takes_the_curves_of_the_old_one_away(ground) -> None:
    heard = [OrientationHeard(0.0, index, 0.1, 0.1, np.arange(3.0), np.ones(3), ()) for index in (0, 1, 0)]
    ground.say(*heard)
    ground.forget()
    ground.wait(10.0)
    assert {(curve.exploration, curve.rotation) for curve in ground.all(Density)} == {(2, 0)}


def test_the_isolation_of_every_source_is_a_curve_over_half_a_turn(ground) -> None:
    headings = np.linspace(0, 3.1, 63)
    isolation = np.array([np.sin(headings) * 2e-4, np.sin(headings) * 1e-4])
    ground.say(THREE, AlignmentPlanned(0.0, (FIRST,), headings, isolation))
    first, second = ground.all(Isolation)
    assert (first.source, second.source, first.plan) == (0, 1, 1)
    assert (first.first, first.last) == (0.0, 3.1)
    assert max(first.isolation) * first.maximum == pytest.approx(2e-4, rel=0.01)
    assert max(second.isolation) * second.maximum == pytest.approx(1e-4, rel=0.01)


def test_silence_has_no_curve(ground) -> None:
    ground.say(OrientationHeard(0.0, 0, 0.5, 0.5, np.arange(3.0), np.zeros(3), ()), THREE, PLANNED)
    assert ground.all(Density) == ground.all(Isolation) == []


def test_who_sounded_like_the_target_before_another_voice_was_enrolled_is_told_no_more(ground) -> None:
    ground.say(THREE, separated(0, GroupScore((1,), 3.0, True), GroupScore((0, 2), -5.0, False)))
    status = ground.latest(Status)
    assert (status.target, status.target_found, status.score) == (1, True, 3.0)
    ground.forget()
    ground.say(Enrolled(1.0, "talker-1", 2, 0.1, 5.0, None))
    status = ground.latest(Status)
    assert (status.target, status.target_found, status.score) == (None, False, None)
    assert [(each.source, each.score, each.target) for each in ground.all(Source)] == [(1, None, False)]
    groups = [(each.group, each.score, each.accepted, each.target) for each in ground.all(Separation)]
    assert groups == [(0, None, False, False), (1, None, False, False)]


def test_where_nobody_is_enrolled_no_score_is_told(ground) -> None:
    ground.reporter = Reporter(ground._board, lambda severity, text: None, sought=False)
    ground.say(THREE, separated(0, GroupScore((1,), 0.0, False), GroupScore((0, 2), 0.0, False)))
    assert [each.score for kind in (Source, Separation) for each in ground.all(kind)] == [None] * 5
    assert ground.latest(Status).score is None
    ground.say(Enrolled(1.0, "talker-1", 2, 0.1, 5.0, None))
    ground.say(separated(0, GroupScore((1,), 3.0, True), GroupScore((0, 2), -5.0, False)))
    assert (ground.latest(Status).score, ground.latest(Source).score) == (3.0, 3.0)
