"""What an operator reads: the story in few words, whole, and not too often."""

import math
from dataclasses import replace

import pytest

from ross_payload.events import (
    AlignmentCandidate,
    AlignmentPlanned,
    Checked,
    Doubted,
    Estimate,
    Event,
    Finished,
    GroupScore,
    NoiseMeasured,
    Outcome,
    ScoreDropped,
    SourceEstimate,
    SourcesEstimated,
    SourcesReconsidered,
    State,
    StateChanged,
)
from ross_payload.ground.model.status_text import MOST_CHUNKS
from ross_payload.health import AudioHealth, AudioTrouble, RecordingState, RecordingStatus
from ross_payload.mavlink.message_board import Board
from ross_payload.mavlink.message_scheduler import Stream
from ross_payload.telemetry import status_texts
from ross_payload.telemetry.status_texts import LONGEST, PREFIX, OperatorTexts, line
from ross_protocols.mavlink.values import Severity, Text

CANDIDATE = AlignmentCandidate(1, 0.5, 0.5, 210e-6, "gain")
SOURCE = SourceEstimate(0.0, sigma=0.02, confidence=0.9, resolved=True)
TARGET = (GroupScore((1,), 4.04, True),)
NOTHING = None  # to plan with, nobody looks at it here


class Ear:
    """Hears what is said, and holds the clock."""

    def __init__(self) -> None:
        self.now = 0.0
        self.heard: list[Text] = []
        self.say = OperatorTexts(self.heard.extend, lambda: self.now).send


def test_of_a_line_beyond_all_measure_the_beginning_is_heard_on_a_link() -> None:
    """As a fault of a driver of others may be."""
    link = Stream({}, lambda value: 79)
    say = OperatorTexts(link.queue_texts, lambda: 0.0).send
    say(Severity.INFO, "before it")
    say(Severity.CRITICAL, "mission over: " + "a plug-in's long story " * 100)
    said = [text.text for text in link.due(Board(), 0.0, math.inf) if isinstance(text, Text)]
    assert said[0] == "RoSS: before it"
    assert said[1].startswith("RoSS: mission over: a plug-in's long story")
    assert "".join(said[1:]).endswith("...")
    assert len("".join(said[1:])) == LONGEST
    assert len(said[1:]) <= MOST_CHUNKS


@pytest.mark.parametrize(
    ("event", "told"),
    [
        (StateChanged(0.0, State.LEAD_IN), (Severity.INFO, "mission started")),
        (StateChanged(0.0, State.RUN), None),
        (NoiseMeasured(0.0, None, 2.0), (Severity.WARNING, "no quiet lead-in: the noise level is unknown")),
        (NoiseMeasured(0.0, -60.0, 2.0), None),
        (SourcesEstimated(0.0, Estimate((SOURCE,)), 12, final=True), (Severity.INFO, "1 source found after 12 turns")),
        (SourcesReconsidered(0.0, Estimate((SOURCE,))), None),
        (
            SourcesReconsidered(0.0, Estimate((SOURCE, SOURCE)), (1,)),
            (Severity.NOTICE, "1 source dropped: most probably nobody"),
        ),
        (SourcesEstimated(0.0, Estimate((SOURCE,)), 3, final=False), None),
        (AlignmentPlanned(0.0, (CANDIDATE,) * 2, NOTHING, NOTHING), (Severity.INFO, "2 headings to try")),
        (Checked(0.0, CANDIDATE, TARGET, 0, "", ""), (Severity.NOTICE, "target recognised: source 1, score 4.0")),
        (Checked(0.0, CANDIDATE, TARGET, None, "", ""), None),
        (ScoreDropped(0.0, -2.0, 0.5), (Severity.WARNING, "target lost, score -2.0 below 0.5")),
        (
            ScoreDropped(0.0, 2.94, 2.83, other=3),
            (Severity.WARNING, "source 3 may be the target, score 2.8 beside 2.9"),
        ),
        (Doubted(0.0, "nobody is there"), (Severity.WARNING, "exploring after all: nobody is there")),
        (Finished(0.0, Outcome.TARGET_FOUND, "it is 1"), (Severity.NOTICE, "mission over: it is 1")),
        (Finished(0.0, Outcome.COMPLETED, "parked"), (Severity.INFO, "mission over: parked")),
        (Finished(0.0, Outcome.FAULT, "hot"), (Severity.CRITICAL, "mission over: hot")),
    ],
)
def test_an_operator_reads_what_matters(event: Event, told: tuple[Severity, str] | None) -> None:
    assert line(event) == told


def test_texts_do_not_flood_and_faults_are_never_held_back() -> None:
    ear = Ear()
    for _ in range(100):
        ear.say(Severity.INFO, "again")
    assert len(ear.heard) == status_texts.BURST
    ear.say(Severity.ERROR, "the motor is hot")
    assert ear.heard[-1] == Text(Severity.ERROR, f"{PREFIX}the motor is hot")
    ear.now += 100.0
    ear.say(Severity.INFO, "later")
    assert ear.heard[-1].text == f"{PREFIX}later"


def test_a_long_text_arrives_whole() -> None:
    ear = Ear()
    reason = "the actuator did not arrive: " + "at 1.571 rad, not 3.142, " * 5
    ear.say(Severity.CRITICAL, reason)
    assert "".join(text.text for text in ear.heard) == PREFIX + reason
    assert len({text.id for text in ear.heard}) == 1
    assert [text.chunk for text in ear.heard] == list(range(len(ear.heard)))


def test_two_long_texts_are_told_apart() -> None:
    ear = Ear()
    ear.say(Severity.INFO, "a" * 60)
    ear.say(Severity.INFO, "b" * 60)
    assert len({text.id for text in ear.heard}) == 2


def test_what_is_wrong_with_the_microphones_is_named() -> None:
    well, ill = AudioHealth(), AudioHealth(AudioTrouble.CLIPPING | AudioTrouble.DEAD_2)
    assert status_texts.microphone_text(well, ill) == (Severity.WARNING, "microphones: clipping, dead 2")
    assert status_texts.microphone_text(ill, ill) is None
    assert status_texts.microphone_text(ill, well) == (Severity.NOTICE, "microphones recovered")


def test_a_recording_that_stops_by_itself_is_a_warning() -> None:
    on = RecordingStatus(RecordingState.ON, "20261121T120000Z")
    full = RecordingStatus(RecordingState.FULL, reason="the disk is full")
    assert status_texts.recorder_text(RecordingStatus(), on) == (Severity.INFO, "recording 20261121T120000Z")
    assert status_texts.recorder_text(on, full) == (Severity.WARNING, "recording stopped: the disk is full")
    assert status_texts.recorder_text(on, RecordingStatus()) == (Severity.INFO, "recording ended")
    path = "/var/lib/ross/recordings/0001"
    begun, over = replace(on, path=path), RecordingStatus(seconds=41.2, path=path)
    assert status_texts.recorder_text(RecordingStatus(), begun) == (Severity.INFO, f"recording to {path}")
    assert status_texts.recorder_text(begun, over) == (Severity.INFO, f"recorded 41 s to {path}")
    assert status_texts.recorder_text(full, full) is None
