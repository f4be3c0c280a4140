"""The time of signatures: it only grows, survives restarts, and a clock that is years ahead is told."""

from itertools import pairwise
from pathlib import Path

import pytest

from ross_payload.config import Config
from ross_payload.telemetry.component import Telemetry
from ross_protocols.mavlink.codec import Decoder
from ross_protocols.mavlink.signing import SECOND, link_and_time
from ross_protocols.mavlink.values import Text
from signing_bench import OTHER, TODAY, GroundStation, Payload


def test_signing_time_only_grows_and_follows_the_clock(payload: Payload) -> None:
    stamps = []
    for _ in range(300):
        payload.clock.time += 1.0
        stamps.append(link_and_time(payload.say())[1])
        payload.settle()
    assert all(after > before for before, after in pairwise(stamps))
    assert stamps[-1] - stamps[0] == pytest.approx(299 * SECOND, abs=2)


def test_two_messages_at_one_moment_have_two_times(payload: Payload) -> None:
    assert len({link_and_time(payload.say())[1] for _ in range(1000)}) == 1000


@pytest.mark.parametrize("unix", [TODAY, 0.0, TODAY - 86400.0], ids=["clock kept", "no clock", "clock of yesterday"])
@pytest.mark.parametrize("crash", [True, False])
def test_no_time_is_used_again_after_a_restart(tmp_path: Path, key_file: Path, unix: float, crash: bool) -> None:
    payload = Payload(tmp_path / "state", key_file)
    for _ in range(100):
        payload.clock.time += 1.0
        last = payload.say()
        payload.settle()
    if not crash:
        payload.links.close()
    with Payload(tmp_path / "state", key_file, unix) as again:
        assert link_and_time(again.say())[1] > link_and_time(last)[1]


@pytest.mark.parametrize("unix", [TODAY + 100, 0.0], ids=["clock kept", "no clock"])
@pytest.mark.parametrize("crash", [True, False])
def test_a_session_cannot_be_played_again_after_a_restart(
    tmp_path: Path, key_file: Path, unix: float, crash: bool
) -> None:
    payload, ground = Payload(tmp_path / "state", key_file), GroundStation()
    session = []
    for _ in range(100):
        payload.clock.time += 1.0
        ground.mav.signing.timestamp += SECOND
        session.append(ground.say())
        assert payload.hear(session[-1]) == 1
        session.append(payload.say())
        payload.settle()
    if not crash:
        payload.links.close()
    with Payload(tmp_path / "state", key_file, unix) as again:
        assert again.hear(*session) == 0
        for frame in session:
            again.clock.time += 1.0
            assert again.hear(frame) == 0


def test_a_ground_station_that_was_there_goes_on_after_our_restart(tmp_path: Path, key_file: Path) -> None:
    payload, ground = Payload(tmp_path / "state", key_file), GroundStation()
    assert payload.hear(ground.say()) == 1
    with Payload(tmp_path / "state", key_file, TODAY + 5) as again:  # no orderly end: a minute was reserved
        assert ground.believes(again.say())
        assert again.hear(ground.say()) == 1, "it has followed our time, as MAVLink wants it"


def test_the_file_is_written_once_a_minute(payload: Payload, tmp_path: Path) -> None:
    contents = set()
    for _ in range(600):
        payload.clock.time += 1.0
        payload.say()
        payload.settle()
        contents.add((tmp_path / "state" / "signing-time").read_text())
    assert 9 <= len(contents) <= 22


def test_the_saved_bound_is_always_above_what_was_used(payload: Payload, tmp_path: Path) -> None:
    for _ in range(300):
        payload.clock.time += 0.7
        used = link_and_time(payload.say())[1]
        assert int((tmp_path / "state" / "signing-time").read_text()) >= used
        payload.settle()


YEARS = 20 * 365.25 * 86_400.0  # [s]


@pytest.fixture
def carried_along(tmp_path, key_file):
    """The state folder of a payload that has heard a key holder whose clock is 20 years ahead, and was switched off."""
    with Payload(tmp_path, key_file) as payload:
        ahead = GroundStation(unix=TODAY + YEARS)
        for _ in range(100):  # the bound is raised in the background
            if payload.hear(ahead.say()):
                break
            payload.settle()
        else:
            raise AssertionError("it is never believed")
    return tmp_path


def test_a_clock_years_ahead_is_said_in_the_log_and_to_the_ground(carried_along, key_file, caplog):
    with Payload(carried_along, key_file) as payload:
        assert payload.hear(GroundStation().say()) == 0, "nobody is shut out"
        (line,) = [record.getMessage() for record in caplog.records if "signing time" in record.getMessage()][-1:]
        assert "20 years ahead of this computer's clock" in line
        assert f"delete {carried_along / 'signing-time'}, and give all sides a new key" in line
        texts, ear = [], Decoder()
        telemetry = Telemetry(Config(), payload.clock, payload.links)
        for _ in range(130):
            payload.clock.time += 1.0
            telemetry.poll()
            payload.settle()
            packets = [packet for frame in payload.wire.sent for packet in ear.feed(frame)]
            texts += [packet.value.text for packet in packets if isinstance(packet.value, Text)]
            payload.wire.sent.clear()
        said = [text for text in texts if "signing time is 20 years" in text]
        assert 2 <= len(said) <= 3, "not once a minute"


def test_a_new_key_and_no_signing_time_let_a_station_in_again(carried_along, key_file, caplog):
    (carried_along / "signing-time").unlink()
    key_file.write_bytes(OTHER)
    caplog.clear()
    with Payload(carried_along, key_file) as payload:
        assert payload.hear(GroundStation(OTHER).say()) == 1
        assert payload.links.signing_ahead == ""
    assert caplog.records == []


@pytest.mark.parametrize("unix", [0.0, TODAY - 3600.0], ids=["a clock that was never set", "an hour behind"])
def test_a_clock_that_was_never_set_or_is_little_behind_is_no_trouble(tmp_path, key_file, unix, caplog):
    with Payload(tmp_path, key_file) as payload:
        assert payload.hear(GroundStation().say()) == 1
    with Payload(tmp_path, key_file, unix) as payload:
        assert payload.links.signing_ahead == ""
    assert caplog.records == []
