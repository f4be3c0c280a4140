"""Signed links: whose frames are believed, that no time is used twice, and that nothing can be played to us again."""

import shutil
import threading
from itertools import pairwise
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common

from clocks import FakeClock
from full_disk import lose
from links_bench import Wire
from ross_payload.config import Config, Link
from ross_payload.mavlink import Received, Router
from ross_payload.telemetry.component import Telemetry
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.signing import SECOND, is_good, is_signed, link_and_time, timestamp_of
from ross_protocols.mavlink.values import Health, Heartbeat, Text

KEY = bytes(range(32))
OTHER = bytes(32)
BEAT = Heartbeat(Health.ACTIVE, 6)
STOP, EXPLORE = 54004, 54000
TODAY = 1_795_000_000.0  # UNIX [s]


class Payload:
    """One life of a payload with one signed link; ``die`` is a power cut, leaving the block an orderly end."""

    def __init__(self, state: Path, key_file: Path, unix: float = TODAY) -> None:
        self.clock = FakeClock()
        self.wire = Wire()
        self.links = Router(self.clock, 1, state, lambda: unix + self.clock.time)
        self.links.attach(Link(url="udpin::14550", key_file=str(key_file)), self.wire)
        self.heard: list[Received] = []
        self.links.component(191).subscribe(self.heard.append)

    def hear(self, *frames: bytes) -> int:
        """Return how many of these frames were believed."""
        before = len(self.heard)
        self.wire.coming += frames
        self.links.poll()
        return len(self.heard) - before

    def say(self) -> bytes:
        self.links.component(191).send(BEAT)
        return self.wire.sent[-1]

    def settle(self) -> None:
        """Wait until the file is written."""
        saving = self.links._signing._saving if self.links._signing else None
        if saving is not None:
            saving.exception(timeout=20)

    def __enter__(self) -> "Payload":
        return self

    def __exit__(self, *_: object) -> None:
        self.links.close()


class GroundStation:
    """pymavlink itself: another implementation of signing."""

    def __init__(self, key: bytes = KEY, unix: float = TODAY, link_id: int = 7) -> None:
        self.mav = common.MAVLink(None, srcSystem=255, srcComponent=190)
        self.mav.robust_parsing = True
        self.mav.signing.secret_key = key
        self.mav.signing.sign_outgoing = True
        self.mav.signing.link_id = link_id
        self.mav.signing.timestamp = timestamp_of(unix)

    def say(self) -> bytes:
        frame = bytes(common.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3).pack(self.mav))
        self.mav.seq = (self.mav.seq + 1) % 256
        return frame

    def believes(self, frame: bytes) -> bool:
        return [message.get_type() for message in self.mav.parse_buffer(frame) or []] == ["HEARTBEAT"]


class GroundStationWithoutKey(GroundStation):
    """Signs nothing."""

    def __init__(self) -> None:
        super().__init__()
        self.mav.signing.sign_outgoing = False


@pytest.fixture
def key_file(tmp_path: Path) -> Path:
    path = tmp_path / "key"
    path.write_bytes(KEY)
    path.chmod(0o600)
    return path


@pytest.fixture
def payload(tmp_path: Path, key_file: Path):
    with Payload(tmp_path / "state", key_file) as payload:
        yield payload


# ---------------------------------------------------------------------------------------------------- whom to believe


def test_both_sides_believe_each_other(payload: Payload) -> None:
    ground = GroundStation()
    assert all(ground.believes(payload.say()) for _ in range(10))
    assert payload.hear(*(ground.say() for _ in range(10))) == 10
    assert all(heard.may_order for heard in payload.heard)


def test_what_is_unsigned_or_signed_with_another_key_is_not_heard(payload: Payload) -> None:
    assert payload.hear(GroundStation(OTHER).say(), Encoder(255, 190).encode(BEAT)) == 0
    (status,) = payload.links.status()
    assert status.refused == 2
    assert status.peers == ()


def test_a_frame_changed_under_way_is_not_heard(payload: Payload) -> None:
    frame = bytearray(GroundStation().say())
    frame[-1] ^= 1
    assert payload.hear(bytes(frame)) == 0


def test_a_radio_may_report_unsigned_and_order_nothing(payload: Payload) -> None:
    radio = Encoder(51, 68)
    assert payload.hear(radio.encode(common.MAVLink_radio_status_message(90, 90, 100, 20, 20, 0, 0))) == 1
    assert not payload.heard[0].may_order


def test_nothing_is_believed_twice(payload: Payload) -> None:
    ground = GroundStation()
    frames = [ground.say() for _ in range(20)]
    assert payload.hear(*frames) == 20
    assert payload.hear(*frames, *reversed(frames)) == 0


def test_our_own_signed_frames_played_back_are_nothing(payload: Payload) -> None:
    frames = [payload.say() for _ in range(20)]
    assert payload.hear(*frames, *frames) == 0
    assert payload.links.twin is None


def test_a_new_stream_may_be_a_minute_behind_and_no_more(payload: Payload) -> None:
    assert payload.hear(GroundStation(unix=TODAY - 59, link_id=1).say()) == 1
    assert payload.hear(GroundStation(unix=TODAY - 61, link_id=2).say()) == 0


def test_streams_are_told_apart_by_link_and_sender(payload: Payload) -> None:
    late, early = GroundStation(link_id=1, unix=TODAY), GroundStation(link_id=2, unix=TODAY - 30)
    assert payload.hear(late.say(), early.say()) == 2


def test_a_peer_that_is_ahead_is_followed_as_soon_as_the_disk_has_it(payload: Payload) -> None:
    ground = GroundStation(unix=TODAY + 3600)
    assert payload.hear(ground.say()) == 0, "nothing above the saved bound is believed"
    payload.settle()
    assert payload.hear(ground.say()) == 1
    assert link_and_time(payload.say())[1] > timestamp_of(TODAY + 3600)


# ---------------------------------------------------------------------------------------------------- time


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


# ---------------------------------------------------------------------------------------------------- a full disk


def order(ground: GroundStation, number: int) -> bytes:
    return bytes(common.MAVLink_command_long_message(1, 191, number, 0, *[0.0] * 7).pack(ground.mav))


@pytest.fixture
def full(payload: Payload, tmp_path: Path) -> GroundStation:
    """A ground station of a payload whose disk takes nothing, when the saved time is over."""
    ground = GroundStation()
    assert payload.hear(ground.say()) == 1
    assert ground.believes(payload.say())
    lose(tmp_path / "state" / "signing-time")
    payload.clock.time += 70.0
    ground.mav.signing.timestamp += 70 * SECOND
    payload.links.component(191).send(BEAT)
    payload.settle()
    payload.links.component(191).send(BEAT)
    assert payload.links.trouble.endswith("signing-time: Is a directory")
    return ground


def test_a_stop_is_obeyed_whatever_the_disk_says(payload: Payload, full: GroundStation) -> None:
    frames = [order(full, STOP) for _ in range(20)]
    assert payload.hear(*frames) == 20
    assert all(heard.may_order for heard in payload.heard[-20:])


def test_a_stop_that_is_played_again_is_obeyed_while_the_disk_takes_nothing(
    payload: Payload, full: GroundStation
) -> None:
    frame = order(full, STOP)
    assert payload.hear(*[frame] * 20) == 20
    assert all(heard.may_order for heard in payload.heard[-20:])


def test_a_stop_that_is_played_again_is_nothing_while_the_disk_is_well(payload: Payload) -> None:
    frame = order(GroundStation(), STOP)
    assert payload.hear(*[frame] * 20) == 1


def test_a_stop_of_a_station_ahead_of_us_does_not_wait_for_the_disk(payload: Payload) -> None:
    assert payload.hear(order(GroundStation(unix=TODAY + 3600), STOP)) == 1
    assert payload.heard[-1].may_order


def test_other_orders_are_heard_and_refused_while_the_disk_takes_nothing(payload: Payload, full: GroundStation) -> None:
    assert payload.hear(order(full, EXPLORE), full.say()) == 2
    assert [heard.may_order for heard in payload.heard[-2:]] == [False, False]
    assert all("signing-time: Is a directory" in heard.refusal for heard in payload.heard[-2:])


def test_what_is_played_again_or_forged_is_nothing_to_a_full_disk_either(payload: Payload, full: GroundStation) -> None:
    frame = order(full, EXPLORE)
    assert payload.hear(frame) == 1
    forged = GroundStation(OTHER, unix=TODAY + 90)
    assert payload.hear(frame, order(forged, STOP), Encoder(255, 190).encode(BEAT)) == 0


def test_answers_are_signed_and_believed_while_the_disk_takes_nothing(payload: Payload, full: GroundStation) -> None:
    frames = []
    for _ in range(500):
        payload.clock.time += 0.05
        frames.append(payload.say())
    assert all(full.believes(frame) for frame in frames)
    assert link_and_time(frames[-1])[1] < timestamp_of(TODAY + 60), "nothing beyond what was saved"


def test_a_disk_with_room_again_ends_it(payload: Payload, full: GroundStation, tmp_path: Path) -> None:
    shutil.rmtree(tmp_path / "state" / "signing-time")
    for _ in range(3):
        payload.clock.time += 2.0
        payload.say()
        payload.settle()
    payload.say()
    assert payload.links.trouble == ""
    assert payload.hear(order(full, EXPLORE)) == 1
    assert payload.heard[-1].may_order


def flip(frame: bytes, place: int) -> bytes:
    """Return a frame with one bit changed."""
    changed = bytearray(frame)
    changed[place // 8] ^= 1 << place % 8
    return bytes(changed)


def test_of_thousands_of_forged_or_replayed_frames_none_is_believed(payload: Payload) -> None:
    """Every bit flipped, another key, no signature, and the whole session once more."""
    ground, other = GroundStation(), GroundStation(OTHER)
    session = [order(ground, number) for number in (STOP, EXPLORE, 54009) for _ in range(200)]
    assert sum(payload.hear(frame) for frame in session) == 600
    unsigned = [order(GroundStationWithoutKey(), STOP) for _ in range(600)]
    fresh = order(ground, STOP)
    flipped = [flip(fresh, place) for place in range(8 * len(fresh))]
    frames = [*session, *(order(other, STOP) for _ in range(600)), *unsigned, *flipped]
    assert len(frames) >= 2000
    believed = 0
    for frame in frames:
        believed += payload.hear(frame)
        payload.wire.coming.append(bytes(600))  # ends whatever has begun
        for _ in range(6):
            payload.links.poll()
    assert believed == 0


# ---------------------------------------------------------------------------------------------------- frames


def test_logs_hear_the_unsigned_frame(payload: Payload) -> None:
    frames: list[bytes] = []
    payload.links.component(191).tap(frames.append)
    signed = payload.say()
    assert is_signed(signed)
    assert is_good(signed, KEY)
    assert not is_good(signed, OTHER)
    assert not is_signed(frames[0])


def test_signatures_count_in_the_budget(tmp_path: Path, key_file: Path) -> None:
    links = Router(FakeClock(), 1, tmp_path, lambda: TODAY)
    wire = Wire()
    with links:
        links.attach(Link(url="udpin::1", key_file=str(key_file), max_bytes_s=10_000), wire)
        before = links.status()[0].room
        links.component(191).send(BEAT)
        assert links.status()[0].room == before - len(wire.sent[0])


def test_no_thread_is_left_behind(tmp_path: Path, key_file: Path) -> None:
    before = set(threading.enumerate())
    with Payload(tmp_path / "state", key_file) as payload:
        for _ in range(5):
            payload.clock.time += 20.0
            payload.say()
        begun = set(threading.enumerate()) - before
    for thread in begun:
        thread.join(timeout=20)
    assert not any(thread.is_alive() for thread in begun)


# ---------------------------------------------------------------------------------------------------- years ahead

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
