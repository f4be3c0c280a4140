import io
import json
import logging
import os
import re
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from ross_payload.events import (
    Answer,
    Answered,
    Estimate,
    Finished,
    Outcome,
    Separated,
    SourcesEstimated,
    State,
    StateChanged,
    TurnStarted,
)
from ross_payload.health import AudioHealth, AudioTrouble, RecordingState, RecordingStatus
from ross_payload.interfaces import Attitude, AudioBlock, Input
from ross_payload.logs import Changes, LogObserver, Repeats, is_journal, logging_to, words
from ross_payload.pointing import Pointing
from ross_protocols.mavlink.component_id import ComponentId

LOG = logging.getLogger("ross_payload.mavlink")


@pytest.fixture
def written():
    """Log in a format at a level; return what was written."""

    def write(call, form="text", level="info"):
        stream = io.StringIO()
        with logging_to(stream, level, form, {}):
            call()
        return stream.getvalue()

    return write


def hop(*, earth=True):
    block = AudioBlock(np.zeros((2, 160), np.float32), index=0, time=0.0)
    return Input(block, 0.0, Pointing(earth=earth), settled=True, attitude=Attitude(0.0, known=earth))


def said(event):
    return lambda: LogObserver().on_event(event, hop())


def test_a_text_line_has_time_level_logger_and_message(written):
    line = written(lambda: LOG.warning("link %s is gone", "tcp:host:1"))
    time, rest = line.rstrip("\n").split(" ", 1)
    assert rest == "warning mavlink: link tcp:host:1 is gone"
    assert time.endswith("Z")


def test_a_json_line_is_one_object_with_fields(written):
    line = written(lambda: LOG.error("lost %d", 3, extra={"fields": {"lost": 3, "rate": float("nan")}}), "json")
    assert line.count("\n") == 1
    value = json.loads(line)
    assert (value["level"], value["logger"], value["message"]) == ("error", "ross_payload.mavlink", "lost 3")
    assert value["fields"] == {"lost": 3, "rate": None}


@pytest.mark.parametrize("form", ["text", "json"])
def test_a_peer_cannot_forge_a_second_line(written, form):
    text = written(lambda: LOG.info("peer said %s", "a\n2026-01-01 info mavlink: \x1b[31mforged"), form)
    assert text.count("\n") == 1
    assert "\x1b" not in text


def test_an_exception_comes_with_its_traceback(written):
    def fail():
        try:
            raise ValueError("why")
        except ValueError:
            LOG.exception("broke")

    assert "ValueError: why" in written(fail)
    assert "ValueError: why" in json.loads(written(fail, "json"))["traceback"]


def test_what_is_below_the_level_is_not_written(written):
    assert written(lambda: LOG.info("chatter"), level="warning") == ""
    assert "chatter" in written(lambda: LOG.debug("chatter"), level="debug")


def test_the_handler_goes_with_the_command(written):
    root = logging.getLogger()
    before = (root.level, list(root.handlers))
    written(lambda: LOG.info("hello"))
    assert (root.level, list(root.handlers)) == before


@pytest.fixture
def unread():
    """Both ends of a pipe: where to log, and what nobody reads yet."""
    reads, writes = os.pipe()
    with os.fdopen(writes, "w") as stream, os.fdopen(reads, "rb", buffering=0) as reader:
        yield stream, reader


@pytest.mark.timeout(60)
def test_nobody_waits_for_a_pipe_that_nobody_reads(unread):
    stream, _ = unread
    with logging_to(stream, "info", "text", {}):
        for number in range(5000):
            LOG.info("line %d: %s", number, "x" * 200)


@pytest.mark.timeout(60)
def test_lines_that_a_slow_reader_loses_are_counted(unread):
    stream, reader = unread
    with ThreadPoolExecutor(1) as readers:
        with logging_to(stream, "info", "text", {}):
            for number in range(5000):
                LOG.info("line %d: %s", number, "x" * 200)
            read = readers.submit(reader.readall)
        stream.close()
    written = read.result().decode()
    lost = [int(count) for count in re.findall(r"warning log_writer: (\d+) log lines were lost", written)]
    assert lost
    assert len(re.findall("line \\d+: x", written)) + sum(lost) == 5000


@pytest.mark.timeout(60)
def test_what_a_late_reader_has_not_taken_by_the_end_is_not_written(unread):
    stream, reader = unread
    with logging_to(stream, "info", "text", {}):
        for number in range(1000):
            LOG.info("line %d: %s", number, "x" * 200)
    stream.close()
    assert 0 < reader.readall().count(b"\n") < 500  # what a pipe holds


def test_lines_for_a_reader_who_has_gone_end_nothing(unread, capfd):
    stream, reader = unread
    reader.close()
    with logging_to(stream, "info", "text", {}):
        LOG.info("good")
    assert capfd.readouterr().err == ""


def journal_lines(tmp_path, form):
    path = tmp_path / "journal"
    with path.open("w+") as stream:
        status = os.fstat(stream.fileno())
        environment = {"JOURNAL_STREAM": f"{status.st_dev}:{status.st_ino}"}
        with logging_to(stream, "info", form, environment):
            LOG.info("good")
            try:
                raise ValueError("why")
            except ValueError:
                LOG.exception("bad")
        return path.read_text().splitlines()


def test_where_no_thread_is_left_whoever_logs_writes(tmp_path, monkeypatch):
    """It was a traceback, and the descriptor stayed open."""

    def refused(thread):
        raise RuntimeError("can't start new thread")

    with (tmp_path / "log").open("w") as stream:
        before = set(Path("/proc/self/fd").iterdir())
        with monkeypatch.context() as patch:
            patch.setattr(threading.Thread, "start", refused)
            with logging_to(stream, "info", "text"):
                logging.getLogger("ross_payload.mission").info("idle")
        assert set(Path("/proc/self/fd").iterdir()) == before
    assert (tmp_path / "log").read_text().endswith("info    mission: idle\n")


def test_the_journal_gets_a_priority_on_every_line(tmp_path):
    lines = journal_lines(tmp_path, "text")
    assert lines[0] == "<6>info    mavlink: good"
    assert all(line.startswith("<3>") for line in lines[1:])
    assert lines[-1] == "<3>ValueError: why"


def test_the_journal_gets_a_priority_before_json(tmp_path):
    good, bad = journal_lines(tmp_path, "json")
    assert json.loads(good.removeprefix("<6>"))["message"] == "good"
    assert json.loads(bad.removeprefix("<3>"))["message"] == "bad"


def test_a_stream_that_is_sent_elsewhere_is_not_the_journal(tmp_path):
    with (tmp_path / "file").open("w") as stream:
        assert not is_journal(stream, {"JOURNAL_STREAM": "1:2"})
    assert not is_journal(io.StringIO(), {"JOURNAL_STREAM": "1:2"})


def record(time, text="lost %d", level=logging.WARNING):
    made = logging.LogRecord("ross_payload.audio", level, "", 0, text, (1,), None)
    made.created = time
    return made


def test_repeated_warnings_come_five_at_once_and_then_every_ten_seconds():
    repeats = Repeats()
    passed = [repeats.filter(record(0.1 * k)) for k in range(600)]  # 10 a second for a minute
    assert all(passed[:5])
    assert sum(passed) == 5 + 5  # the sixth of the later ones would be due at 60 s


def test_the_next_one_tells_how_many_were_held_back():
    repeats = Repeats()
    for _ in range(8):
        repeats.filter(record(0.0))
    late = record(30.0)
    assert repeats.filter(late)
    assert late.held == 3


def test_other_warnings_and_all_news_pass_meanwhile():
    repeats = Repeats()
    for _ in range(8):
        repeats.filter(record(0.0))
    assert repeats.filter(record(0.0, "port %d gone"))
    assert repeats.filter(record(0.0, level=logging.ERROR))
    assert all(repeats.filter(record(0.0, level=logging.INFO)) for _ in range(100))


def test_endlessly_many_kinds_take_no_endless_memory():
    repeats = Repeats()
    for k in range(5000):
        repeats.filter(record(0.0, f"text {k}"))
    assert len(repeats._kinds) <= 256


def test_a_mission_tells_its_states_turns_and_end(written):
    line = written(said(StateChanged(1.0, State.RUN, "source 0")))
    assert line.endswith("info    mission: run: source 0\n")
    line = written(said(TurnStarted(1.0, np.pi / 4, np.pi / 2, "rotation 1")))
    assert "heading 270.0 deg from north, joint 45.0 deg counter-clockwise" in line
    line = written(said(Finished(1.0, Outcome.FAULT, "motor stalled")))
    assert "critical mission" in line
    assert "motor stalled" in line


def test_a_heading_in_the_log_counts_from_the_nose_while_north_is_unknown(written):
    turned = TurnStarted(1.0, 0.0, np.deg2rad(-80), "rotation 1")
    line = written(lambda: LogObserver().on_event(turned, hop(earth=False)))
    assert "heading 80.0 deg from the nose, joint 0.0 deg: rotation 1" in line


def test_events_bring_their_plain_values_and_no_arrays(written):
    event = Separated(12.0, 160000, 0.5, np.zeros((2, 16000)), (), 0, "gaussian", "fits")
    value = json.loads(written(said(event), "json"))
    assert value["fields"] == {
        "event": "Separated", "time": 12.0, "start": 160000, "heading": 0.5, "target": 0, "method": "gaussian",
        "why": "fits",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("answer", "level"),
    [
        (Answer.ACCEPTED, logging.INFO),
        (Answer.REFUSED, logging.WARNING),
        (Answer.PROGRESS, logging.DEBUG),
        (Answer.FAILED, logging.WARNING),
    ],
)
def test_answers_weigh_as_much_as_they_matter(answer, level):
    assert words(Answered(1.0, 7, answer, "busy"), earth=True)[0] == level


def test_what_nobody_needs_is_for_debugging(written):
    event = SourcesEstimated(1.0, Estimate(()), rotations=1, final=False)
    assert written(said(event)) == ""
    assert "SourcesEstimated" in written(said(event), level="debug")


@dataclass
class Way:
    """What of a LinkStatus is looked at."""

    url: str
    up: bool
    error: str
    twins: int
    role: str = "ground"
    peers: tuple = ()


class Payload:
    """What `Changes` looks at, at one moment."""

    def __init__(self):
        self.up, self.error, self.twins = True, "", 0
        self.role, self.peers = "ground", ()
        self.ears, self.recorder = AudioHealth(), RecordingStatus()

    def links(self):
        return (Way("tcp:host:1", self.up, self.error, self.twins, self.role, self.peers),)


@pytest.fixture
def watched(written):
    """Log what a change of the payload makes `Changes` say, after a first look."""

    def look(change, form="text"):
        payload = Payload()
        changes = Changes(payload.links, lambda: payload.ears, lambda: payload.recorder)
        changes.poll()

        def again():
            change(payload)
            changes.poll()
            changes.poll()

        return written(again, form)

    return look


def test_nothing_that_stays_as_it_is_is_written(watched):
    assert watched(lambda payload: None) == ""


def test_a_link_that_goes_is_written_once_with_its_error(watched):
    def go(payload):
        payload.up, payload.error = False, "connection reset"

    text = watched(go)
    assert text.count("\n") == 1
    assert "warning condition: link tcp:host:1 is down: connection reset" in text


def test_another_payload_with_our_ids_is_written(watched):
    def speak(payload):
        payload.twins += 1

    text = watched(speak)
    assert text.count("\n") == 1
    assert "our system and component id" in text


@pytest.mark.parametrize(("role", "lines"), [("autopilot", 1), ("ground", 0)])
def test_a_link_on_which_no_autopilot_is_heard_is_written_once(written, role, lines):
    payload = Payload()
    payload.role, payload.peers = role, (ComponentId(255, 190),)
    changes = Changes(payload.links, lambda: payload.ears, lambda: payload.recorder)
    changes.poll()
    assert written(lambda: [changes.poll() for _ in range(5)]) == "", "one may come"
    assert written(lambda: [changes.poll() for _ in range(30)]).count("no autopilot is heard") == lines
    payload.peers += (ComponentId(1, 1),)
    assert written(lambda: [changes.poll() for _ in range(3)]).count("an autopilot is heard") == lines


def test_different_events_are_not_taken_for_repeats(written):
    def refused():
        for order in range(20):
            said(Answered(1.0, order, Answer.REFUSED, "busy"))()

    assert written(refused).count("\n") == 20


def test_trouble_of_the_microphones_is_written_when_it_begins_and_when_it_ends(watched):
    def clip(payload):
        payload.ears = AudioHealth(AudioTrouble.CLIPPING | AudioTrouble.DEAD_2, level_db=(-3.0, -120.0))

    line = json.loads(watched(clip, "json"))
    assert line["message"] == "microphones: clipping, dead 2"
    assert line["fields"]["level_db"] == [-3.0, -120.0]


def test_a_recording_that_begins_and_one_that_the_disk_ends_are_written(watched):
    def begin(payload):
        payload.recorder = RecordingStatus(RecordingState.ON, "20261121T150000Z")

    def full(payload):
        payload.recorder = RecordingStatus(RecordingState.FULL, reason="0.4 GB left")

    assert "info    condition: recording is on 20261121T150000Z" in watched(begin)
    assert "warning condition: recording is full: 0.4 GB left" in watched(full)
