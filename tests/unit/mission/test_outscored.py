"""Who is visited when somebody else sounds about as much like the target as the voice that was heard for T_run."""

import pytest

from mission_bench import RATE
from ross_payload.events import AlignmentCandidate, Estimate
from ross_payload.mission.exploit import ALIKE, Search
from ross_payload.mission.voice_evidence import Evidence

CRITERION = 0.5  # [nat]


def search(scores: dict[int, float], left: tuple[int, ...]) -> Search:
    """Sources 0 to 2 have candidates, of whom some are left."""
    candidates = tuple(AlignmentCandidate(source, 0.1 * source, 0.1 * source, 1e-4, "gain") for source in range(3))
    evidence = Evidence(RATE, None, dict(scores))
    return Search(Estimate(()), evidence, candidates, [candidates[source] for source in left], None)


@pytest.mark.parametrize(
    ("scores", "comes"),
    [
        ({1: 2.9, 2: 2.8}, 1),
        ({1: 3.1 - ALIKE, 2: 2.0}, 2),
        ({1: 2.9 - ALIKE}, None),
        ({}, None),
    ],
)
def test_the_likeliest_of_those_who_are_left_and_sound_nearly_as_much_like_the_target(scores, comes):
    among = search({0: 3.0} | scores, left=(1, 2))
    assert among.outscored(0, 3.0, CRITERION) == comes
    assert among.first == comes
    assert [each.source for each in among.left] == ([1, 2, 0] if comes else [1, 2])


def test_nobody_below_the_criterion_comes_however_near():
    assert search({0: 0.7, 1: 0.4}, left=(1,)).outscored(0, 0.7, CRITERION) is None


def test_who_has_been_visited_does_not_come():
    assert search({0: 3.0, 1: 5.0}, left=(2,)).outscored(0, 3.0, CRITERION) is None


def test_who_was_heard_for_t_run_comes_again_only_with_a_higher_score_and_once():
    among = search({0: 3.0, 1: 2.5}, left=(1,))
    assert among.outscored(0, 3.0, CRITERION) == 1
    lower, higher = (search({0: 3.0, 1: value}, left=(0,)) for value in (3.1, 2.9))
    for again in (lower, higher):
        again.returned.add(0)
    assert lower.outscored(1, 3.1, CRITERION) is None
    assert higher.outscored(1, 2.9, CRITERION) == 0
    among.evidence.scores[1] = 9.0
    assert among.outscored(0, 1.0, CRITERION) is None  # the array does not turn to and fro


def test_a_voice_that_no_heading_isolates_is_not_left():
    assert search({7: 1.0, 1: 5.0}, left=(1,)).outscored(7, 1.0, CRITERION) is None
