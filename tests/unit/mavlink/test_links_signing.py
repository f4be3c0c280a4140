"""Signed links: whose frames are believed, whatever is forged or played again, and what signatures cost."""

import threading
from pathlib import Path

from pymavlink.dialects.v20 import common

from clocks import FakeClock
from links_bench import Wire
from ross_payload.config import Link
from ross_payload.mavlink import Router
from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.signing import is_good, is_signed, link_and_time, timestamp_of
from signing_bench import BEAT, EXPLORE, KEY, OTHER, STOP, TODAY, GroundStation, GroundStationWithoutKey, Payload, order


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
