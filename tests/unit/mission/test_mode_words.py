"""What a person reads about pipelined and informed missions."""

import io
import logging

import numpy as np
import pytest
from rich.console import Console

from ross_payload.alignment.paper_rules import paper_plan
from ross_payload.alignment.plan import Turn, plan
from ross_payload.events import (
    AlignmentCandidate,
    AlignmentPlanned,
    Checked,
    Doubted,
    Estimate,
    GroupScore,
    ScoreDropped,
    SourceEstimate,
    SourcesEstimated,
)
from ross_payload.mission.exploit import HEARD_BEFORE
from ross_payload.telemetry.event_messages import Stamp, alignments
from ross_payload.telemetry.status_texts import line
from ross_protocols.mavlink.values import Severity
from ross_sim.sitl.mission_view import PlainLines, in_words, showing_streams

TOLD = SourcesEstimated(
    2.0, Estimate((SourceEstimate(np.pi / 2, 0.01, 1.0, resolved=True),)), rotations=0, final=True, informed=True
)
DOUBTED = Doubted(9.0, "none of the 1 voices is the target's")


def test_what_was_told_is_not_said_to_be_found():
    assert line(TOLD) == (Severity.INFO, "using 1 known source, not exploring")
    assert in_words(TOLD, earth=True) == "known without exploring: K = 1 at 270.0 deg from north"


def test_the_end_of_belief_is_a_warning_with_its_reason():
    severity, words = line(DOUBTED)
    assert severity is Severity.WARNING
    assert DOUBTED.reason in words
    assert "explor" in words
    assert DOUBTED.reason in in_words(DOUBTED, earth=False)


def test_a_voice_that_gives_way_is_told_with_what_comes_next():
    assert in_words(ScoreDropped(9.0, -2.0, 0.5), earth=False) == (
        "the score dropped to -2.0, below 0.5: starting again"
    )
    assert in_words(ScoreDropped(9.0, 2.94, 2.83, other=3), earth=False) == (
        "source 3 sounds as much like the target, +2.8 beside +2.9: it comes next"
    )


def test_who_is_recognised_is_told_by_its_source_and_what_it_was_recognised_by():
    at, scores = (
        AlignmentCandidate(1, 0.0, 0.0, 0.0, "gain"),
        (GroupScore((1,), 4.8, True), GroupScore((0, 2), -3, False)),
    )
    assert in_words(Checked(9.0, at, scores, 0, "refined", HEARD_BEFORE), earth=False) == (
        "voice scores by refined, by what was heard before (1: +4.8, 0+2: -3.0): source 1 is the target"
    )
    assert in_words(Checked(9.0, at, scores, None, "refined", "directions known"), earth=False) == (
        "voice scores by refined (1: +4.8, 0+2: -3.0): no target here"
    )


@pytest.mark.parametrize("planner", [plan, paper_plan])
@pytest.mark.parametrize("upper", [0.02, 3.0])
@pytest.mark.parametrize("degrees", [(40,), (30, -30), (0, 100, -120), (0, 70, 100, -120)])
def test_a_ground_station_knows_every_rule_that_plans(planner, upper, degrees):
    talkers = [SourceEstimate(float(np.deg2rad(a)), 0.01, 1.0, resolved=True) for a in degrees]
    found = planner(talkers, Turn(0.0, 0.0, 0.0, upper), 0.05 / 343.0)
    event = AlignmentPlanned(0.0, found.candidates, found.headings, found.isolation)
    values = alignments(event, 1, Stamp(0, earth=False))
    assert [value.rule.name.lower() for value in values] == [candidate.rule for candidate in found.candidates]


def test_what_live_listening_logs_is_shown_with_the_time_of_the_mission():
    stream = io.StringIO()
    log = logging.getLogger("ross_payload.listening.stream")
    with showing_streams(PlainLines(Console(file=stream, width=200))):
        log.info("stream 0 (target to memory) begins")
        log.warning("stream 0 (target to memory): the disk is full")
    log.info("not shown")
    assert stream.getvalue().splitlines() == [
        "   0.00 s  stream 0 (target to memory) begins",
        "   0.00 s  stream 0 (target to memory): the disk is full",
    ]
