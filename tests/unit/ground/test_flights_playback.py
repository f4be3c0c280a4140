"""A flight is the same whether it is played or sought in, and seeking is quick."""

import asyncio
import gc
import threading
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from examples import examples
from flight_logs import UNIX, full_tick, record, vehicle_frames, write_hour
from ross_payload.ground.flights import playback as playing
from ross_payload.ground.flights.log_file import LogFile
from ross_payload.ground.flights.playback import Playback
from ross_payload.ground.flights.reading import Flight, open_flight
from ross_payload.ground.model.fleet import Fleet
from ross_payload.ground.web.playback_session import PlaybackSession
from ross_protocols.mavlink.codec import Encoder, chunks
from ross_protocols.mavlink.values import Health, Heartbeat, Severity

pytestmark = pytest.mark.lockstep

SPACING = 120  # frames between two moments that are remembered, in place of more in a longer flight
LONG_TEXT = "RoSS: " + "a text that needs more than one chunk, " * 3


def told(steps, start=0.0):
    for step in range(steps):
        yield from full_tick(start + step / 10, step)
        if step % 10 == 0:
            yield from chunks(Severity.INFO, LONG_TEXT, 1 + step)


@pytest.fixture(autouse=True, scope="module")
def closer():
    """Moments are remembered as often in this flight as in one of four times its length."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(playing, "SPACING", SPACING)
        yield


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    """Two payloads, one of which starts again, an autopilot, texts in chunks, and lost frames."""
    first, second = Encoder(1, 191), Encoder(2, 191)
    ours = [first.encode(value) for value in told(15)]
    others = [second.encode(value) for value in [*told(6, start=100.0), Heartbeat(Health.BOOT, 0), *told(9)]]
    vehicle = list(vehicle_frames(steps=10))
    mixed = [frame for trio in zip(ours, others, vehicle * 6, strict=False) for frame in trio]
    kept = [frame for place, frame in enumerate(mixed) if place % 23]
    path = tmp_path_factory.mktemp("flights") / "mixed.tlog"
    path.write_bytes(b"".join(record(UNIX + 3_000 * place, frame) for place, frame in enumerate(kept)))
    return open_flight(path)


def heard_all(flight, at):
    """The fleet that has heard every frame until a time, one by one."""
    fleet = Fleet()
    for time_of_frame, packet in flight.packets(np.flatnonzero(flight.at <= at)):
        fleet.on_packet(packet, time_of_frame)
    return fleet


def known(fleet):
    return fleet.payloads, fleet.vehicles, fleet.hidden(0.0)


SHARES = st.floats(0.0, 1.0)


@settings(max_examples=examples(8))
@given(shares=st.lists(SHARES, min_size=1, max_size=4))
def test_wherever_one_came_from_the_fleet_is_that_of_the_moment(flight, shares):
    playback = Playback(flight)
    for share in shares:
        playback.seek(share * flight.duration)
    assert known(playback.fleet) == known(heard_all(flight, playback.at))


@settings(max_examples=examples(5))
@given(share=SHARES, steps=st.integers(1, 30), speed=st.sampled_from([1.0, 4.0, 64.0]))
def test_playing_comes_to_the_same_as_seeking(flight, share, steps, speed):
    played, sought = Playback(flight), Playback(flight)
    played.seek(share * flight.duration)
    played.playing, played.speed = True, speed
    for _ in range(steps):
        played.advance(0.05)
    sought.seek(played.at)
    assert known(played.fleet) == known(sought.fleet)


def test_what_follows_a_seek_back_is_heard_as_the_first_time(flight):
    playback = Playback(flight)
    playback.seek(flight.duration)
    playback.seek(0.3 * flight.duration)
    playback.seek(flight.duration)
    assert known(playback.fleet) == known(heard_all(flight, flight.duration))


def test_the_past_does_not_change_when_the_future_is_heard(flight):
    playback = Playback(flight)
    playback.seek(0.5 * flight.duration)
    before = playback.fleet.copy()
    kept = known(before)
    playback.seek(flight.duration)
    assert known(before) == kept


def test_it_plays_at_its_speed_and_stops_at_the_end(flight):
    playback = Playback(flight)
    playback.advance(1.0)
    assert playback.at == 0.0
    playback.playing, playback.speed = True, 4.0
    playback.advance(0.25)
    assert playback.at == pytest.approx(1.0)
    assert playback.playing
    playback.advance(1e6)
    assert playback.at == flight.duration
    assert not playback.playing


@pytest.mark.parametrize(("asked", "given"), [(0.0, 1.0), (float("nan"), 1.0), (1e9, 64.0), (8.0, 8.0)])
def test_a_speed_is_one_that_can_be_played(flight, asked, given):
    playback = Playback(flight)
    playback.speed = asked
    assert playback.speed == given


@pytest.mark.parametrize("at", [-5.0, float("nan"), float("-inf")])
def test_before_the_beginning_is_the_beginning(flight, at):
    playback = Playback(flight)
    playback.seek(at)
    assert playback.at == 0.0


def test_reading_ahead_makes_all_of_it_quick_and_changes_nothing(flight):
    playback = Playback(flight)
    assert playback.ready < flight.duration
    before = known(playback.fleet.copy())
    shares = [playback.prepare() for _ in range(10)]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert playback.ready == flight.duration
    assert known(playback.fleet) == before
    playback.seek(flight.duration)
    assert known(playback.fleet) == known(heard_all(flight, flight.duration))


def test_seeking_in_what_was_read_hears_few_frames(flight):
    """A bound on work, which no busy machine changes; what it takes in milliseconds is a soak test's."""
    playback = Playback(flight)
    while playback.prepare() < 1.0:
        pass
    heard = []
    read = flight.packets

    class Counting:
        at, duration, payloads, index = flight.at, flight.duration, flight.payloads, flight.index

        def packets(self, which):
            heard.append(len(which))
            return read(which)

    playback.flight = Counting()
    for share in (0.9, 0.1, 0.55, 0.2):
        heard.clear()
        playback.seek(share * flight.duration)
        assert sum(heard) <= SPACING


@pytest.mark.soak
def test_an_hour_of_five_payloads_opens_in_seconds_and_seeks_in_a_tenth_of_one(tmp_path):
    count = write_hour(tmp_path / "hour.tlog")
    since = time.perf_counter()
    flight = open_flight(tmp_path / "hour.tlog")
    opened = time.perf_counter() - since
    playback = Playback(flight)
    while playback.prepare() < 1.0:
        pass
    took = []
    for share in np.random.default_rng(1).uniform(size=50):
        since = time.perf_counter()
        playback.seek(share * flight.duration)
        took.append(time.perf_counter() - since)
    told = f"{count} frames: opened in {opened:.1f} s, seek median {np.median(took):.3f} s, worst {max(took):.3f} s"
    assert opened < 10, told
    assert np.median(took) < 0.1, told


def test_a_seek_that_nobody_waits_for_any_longer_is_given_up(flight):
    left = [2]  # portions that are read until then

    def obsolete():
        left[0] -= 1
        return left[0] < 0

    playback = Playback(flight, obsolete)
    playback.seek(flight.duration)
    assert max(each.last for each in playback.fleet.payloads.values()) < 0.9 * flight.duration
    left[0] = 1000
    for share in (0.2, 1.0):
        playback.seek(share * flight.duration)
        assert known(playback.fleet) == known(heard_all(flight, playback.at))


async def is_read_no_further(read):
    await asyncio.sleep(0.2)
    count = len(read)
    await asyncio.sleep(0.3)
    return len(read) == count


async def test_nothing_of_a_flight_is_read_on_once_it_is_closed_or_sought_elsewhere(tmp_path, monkeypatch):
    path = tmp_path / "long.tlog"
    write_hour(path, seconds=30, payloads=1)
    read, going = [], threading.Event()
    packets = Flight.packets

    def slow(self, which):
        read.append(int(which[-1]))
        going.set()
        time.sleep(0.05)
        return packets(self, which)

    session = PlaybackSession("a", "long", lambda: None)
    session.start(lambda: path, pytest.fail)
    while session.playback is None:
        await asyncio.sleep(0.01)
    monkeypatch.setattr(Flight, "packets", slow)
    session.request(seek=30.0)
    await asyncio.to_thread(going.wait, 20)
    session.request(seek=0.5)
    while session.playback.at > 1.0:
        await asyncio.sleep(0.01)
    assert len(read) < 10, "the earlier one was read to its end"
    going.clear()
    session.request(seek=30.0)
    await asyncio.to_thread(going.wait, 20)
    await session.close()
    assert await is_read_no_further(read)


async def test_the_file_of_a_flight_is_closed_with_it(tmp_path):
    path = tmp_path / "short.tlog"
    write_hour(path, seconds=5, payloads=1)
    session = PlaybackSession("a", "short", lambda: None)
    gc.collect()
    gc.disable()
    try:
        session.start(lambda: path, pytest.fail)
        while session.playback is None:
            await asyncio.sleep(0.01)
        session.request(seek=4.0, play=True)
        await asyncio.sleep(0.2)
        closed = session.playback.flight.file.close
        assert closed.alive
        await session.close()
        async with asyncio.timeout(20):
            while closed.alive:
                await asyncio.sleep(0.01)
    finally:
        gc.enable()


async def test_a_flight_that_is_closed_while_it_is_opened_is_read_no_further(tmp_path, monkeypatch):
    path = tmp_path / "long.tlog"
    write_hour(path, seconds=30, payloads=1)
    read, going = [], threading.Event()

    def pieces(self):
        for start in range(0, self.size, 4096):
            read.append(start)
            going.set()
            time.sleep(0.02)
            yield self.read(start, 4096)

    monkeypatch.setattr(LogFile, "pieces", pieces)
    session = PlaybackSession("a", "long", lambda: None)
    session.start(lambda: path, pytest.fail)
    await asyncio.to_thread(going.wait, 20)
    await session.close()
    assert await is_read_no_further(read)
