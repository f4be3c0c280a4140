"""A session that version 0.1.0 recorded is listed, checked and offered, and replayed until this one decides otherwise.

Its text lies in tests/data; its audio is made again from a seed (`stored_session`).
"""

import hashlib
import json
import shutil
from pathlib import Path

import pytest

from ross_payload import orders
from ross_payload.audio.wav_files import WavFile
from ross_payload.sessions.catalog import Catalog
from ross_payload.sessions.session_reader import RecordedSession
from ross_payload.sessions.session_store import SessionStore
from stored_session import RATE, sound

pytestmark = pytest.mark.lockstep
STORED = Path(__file__).parents[1] / "data" / "session-0.1.0"
NAME = "0001-20261101T120000Z"
LATER = {orders.Enrol}  # than this session
COUNTED = 3.04  # [s]: then the exploration ends, and says how many talkers there are
AUDIO = "5d6efef8c82289d211cacf2e45c8dfbc1ae8cb529fce6265d3b1821d6db77c3d"  # SHA-256


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """The stored session with its audio, in a folder of sessions."""
    folder = tmp_path_factory.mktemp("sessions") / NAME
    shutil.copytree(STORED, folder)
    audio = WavFile(folder / "audio.wav", RATE)
    audio.write(sound((folder / "inputs.jsonl").read_text()))
    audio.close()
    return folder


def close(one, other):
    """Whether two lines of events.jsonl are the same but for the rounding of another computer."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(close(one[name], other[name]) for name in one)
    if isinstance(one, list):
        return len(one) == len(other) and all(map(close, one, other))
    if isinstance(one, float) and isinstance(other, float):
        return one == pytest.approx(other, rel=1e-3, abs=1e-3)
    return one == other


def test_the_sound_is_made_again_to_the_bit(session):
    assert hashlib.sha256((session / "audio.wav").read_bytes()).hexdigest() == AUDIO


def test_it_is_listed_and_whole(session, run):
    code, listed, _ = run("sessions", "--folder", session.parent, "--json")
    assert code == 0
    assert [(row["name"], row["seconds"], row["state"]) for row in json.loads(listed)] == [
        (NAME, pytest.approx(10.8), "the program ended")
    ]
    code, checked, _ = run("sessions", "check", session, "--json")
    contents = json.loads(checked)["contents"]
    assert (contents["inputs"], contents["orders"], contents["events"], contents["notes"]) == (540, 16, 111, [])


def test_its_files_are_offered(session):
    files = Catalog(SessionStore(session.parent)).files(NAME)
    assert files.keys() >= {"audio.wav", "inputs.jsonl", "events.jsonl", "scores.jsonl", "config.json", "session.json"}


def test_every_order_of_an_operator_is_in_it(session):
    opened = RecordedSession.open(session)
    given = {type(order) for heard in opened.inputs(opened.configuration().audio) for order in heard.orders}
    kinds = {kind for kind in vars(orders).values() if isinstance(kind, type) and issubclass(kind, orders.Order)}
    assert given == kinds - {orders.Order, orders.Task} - LATER


def test_a_replay_hears_what_was_heard_then_and_finds_talkers_by_its_own_rules(session, tmp_path, run):
    """In three seconds of three talkers both versions find five, but not in the same places."""
    code, said, error = run("replay", session, "--out", tmp_path / "out", "--json")
    assert code == 0, error
    values = json.loads(said)
    assert "the recorded mission to joint angle 26.0 deg clockwise at 4.92 s" in values["parted"]
    assert values["ended_early"] == ""
    assert values["voice"].startswith("recorded answers")
    again = [json.loads(line) for line in (tmp_path / "out" / "events.jsonl").read_text().splitlines()]
    recorded = [json.loads(line) for line in (session / "events.jsonl").read_text().splitlines()]
    heard = [[event for event in events if event["time"] < COUNTED] for events in (again, recorded)]
    assert [event["event"] for event in heard[0]] == [event["event"] for event in heard[1]]
    assert sum(event["event"] == "OrientationHeard" for event in heard[0]) == 3
    for one, other in zip(*heard, strict=True):
        if one["event"] != "SourcesEstimated":
            assert one == other or close(one, other), other
    assert {event["order"] for event in again if event["event"] == "Answered"} >= set(range(1, 16))
