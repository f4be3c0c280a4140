"""Signing on the ground: against the payload's own links and against pymavlink."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from itertools import pairwise
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common

from ports import free_port
from ross_payload.clock import SystemClock
from ross_payload.config import Link
from ross_payload.ground.errors import GroundError
from ross_payload.ground.links.signing import SigningTime, read_key
from ross_payload.ground.station import Station
from ross_payload.mavlink import Received, Router
from ross_payload.transport.open_port import open_port
from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.signing import LATEST, SECOND, is_signed, link_and_time, timestamp_of
from station_bench import AUDIO, BEAT, Far
from waiting import wait_for_async

KEY, OTHER = bytes(range(32)), bytes(32)
TODAY = 1_795_000_000.0  # UNIX [s]
STOP = ross.MAV_CMD_ROSS_STOP


def unix() -> float:
    return TODAY


class Payload:
    """The payload's own links, polled on this loop."""

    def __init__(self, links: Router) -> None:
        self.links = links
        self.component = links.component(191)
        self.heard: list[Received] = []
        self.component.subscribe(self.heard.append)

    async def live(self) -> None:
        """Poll, and beat ten times a second."""
        while True:
            self.component.send(AUDIO)
            for _ in range(10):
                self.links.poll()
                await asyncio.sleep(0.01)


@contextlib.asynccontextmanager
async def payload(port: int, folder: Path, key: bytes | None, time: float = TODAY) -> AsyncIterator[Payload]:
    file = ""
    if key is not None:
        (folder / "key").write_bytes(key)
        (folder / "key").chmod(0o600)
        file = str(folder / "key")
    with Router(SystemClock(), 1, folder / "state", lambda: time) as links:
        url = f"udpout:127.0.0.1:{port}"
        links.attach(Link(url=url, key_file=file), open_port(url, SystemClock().now))
        alive = Payload(links)
        living = asyncio.create_task(alive.live())
        yield alive
        living.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await living


async def test_a_payload_and_its_ground_station_believe_each_other(tmp_path: Path) -> None:
    port = free_port()
    async with Station([f"udpin:127.0.0.1:{port}"], key=KEY, unix=unix) as station:
        async with payload(port, tmp_path, KEY) as aboard:
            await wait_for_async(lambda: station.fleet.payloads)
            station.send(common.MAVLink_command_long_message(1, 191, STOP, 0, *[0] * 7), ComponentId(1, 191))
            await wait_for_async(lambda: [h for h in aboard.heard if h.packet.name == "COMMAND_LONG" and h.may_order])
            (link,) = aboard.links.status()
            assert link.refused == 0
        (state,) = station.links()
        assert state.refused == 0
        assert state.signed == state.frames > 0


@pytest.mark.parametrize("key", [None, OTHER], ids=["unsigned", "another key"])
async def test_what_is_not_signed_with_our_key_is_refused_counted_and_explained(
    tmp_path: Path, key: bytes | None
) -> None:
    port, ahead = free_port(), [0.0]
    station = Station([f"udpin:127.0.0.1:{port}"], key=KEY, unix=unix, now=lambda: ahead[0] + SystemClock().now())
    async with station, payload(port, tmp_path, key):
        await wait_for_async(lambda: station.links()[0].refused > 3)
        ahead[0] = 6.0
        assert not station.fleet.payloads
        assert station.links()[0].frames == 0
        assert "both sides need the same key" in station.advice()


async def test_a_payload_that_signs_does_not_obey_a_station_without_its_key(tmp_path: Path) -> None:
    port = free_port()
    async with Station([f"udpin:127.0.0.1:{port}"]) as station, payload(port, tmp_path, KEY) as aboard:
        await wait_for_async(lambda: station.fleet.payloads)
        await wait_for_async(lambda: aboard.links.status()[0].refused)
        assert station.links()[0].signed > 0
        assert aboard.heard == []
        assert "accepts commands only from stations with its key" in station.advice()


async def test_a_payload_without_a_clock_follows_ours_and_is_heard(tmp_path: Path) -> None:
    port = free_port()
    station = Station([f"udpin:127.0.0.1:{port}"], key=KEY, unix=unix)
    async with station, payload(port, tmp_path, KEY, time=TODAY - 1e7):
        await wait_for_async(lambda: station.links()[0].refused)
        await wait_for_async(lambda: station.fleet.payloads)


async def test_pymavlink_believes_us_and_we_believe_it() -> None:
    port = free_port()
    ear = common.MAVLink(None)
    ear.robust_parsing = True
    ear.signing.secret_key, ear.signing.timestamp = KEY, timestamp_of(TODAY)
    mouth = common.MAVLink(None, srcSystem=1, srcComponent=1)
    mouth.signing.secret_key, mouth.signing.sign_outgoing = KEY, True
    mouth.signing.timestamp = timestamp_of(TODAY)
    async with Station([f"udpin:127.0.0.1:{port}"], key=KEY, unix=unix) as station:
        with Far(port) as far:
            far.throw(bytes(common.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3).pack(mouth)))
            await wait_for_async(lambda: station.links()[0].frames == 1)
            frame = (await wait_for_async(far.listen))[0].frame
    assert is_signed(frame)
    assert [message.get_type() for message in ear.parse_buffer(frame)] == ["HEARTBEAT"]


async def test_nothing_is_believed_twice_and_nothing_old_at_all() -> None:
    port = free_port()
    async with Station([f"udpin:127.0.0.1:{port}"], key=KEY, unix=unix) as station:
        with Far(port) as far:
            voice = Encoder(1, 191, KEY)
            frames = [voice.encode(AUDIO, timestamp_of(TODAY) + number) for number in range(10)]
            old = Encoder(2, 191, KEY).encode(AUDIO, timestamp_of(TODAY - 61))
            for frame in (*frames, *frames, old):
                far.throw(frame)
            await wait_for_async(lambda: station.links()[0].signed == 21)
        (link,) = station.links()
        assert (link.frames, link.refused) == (10, 11)


async def test_a_radio_may_report_unsigned() -> None:
    port = free_port()
    async with Station([f"udpin:127.0.0.1:{port}"], key=KEY, unix=unix) as station:
        with Far(port, system=51, component=68) as radio:
            radio.say(common.MAVLink_radio_status_message(90, 90, 100, 20, 20, 0, 0), BEAT)
            await wait_for_async(lambda: station.links()[0].refused)
        assert station.links()[0].frames == 1


def test_no_timestamp_is_used_twice_though_the_clock_goes_back() -> None:
    clock = iter([TODAY, TODAY, TODAY - 3600, 0.0, TODAY + 1])
    time = SigningTime(lambda: next(clock))
    stamps = [time.stamp(0.0) for _ in range(5)]
    assert all(after > before for before, after in pairwise(stamps))  # type: ignore[operator]
    assert stamps[-1] == timestamp_of(TODAY + 1)


def test_a_peer_that_is_ahead_is_followed_but_not_to_the_end_of_time() -> None:
    time = SigningTime(unix)
    time.learn(timestamp_of(TODAY + 3600))
    assert time.stamp(0.0) == timestamp_of(TODAY + 3600) + 1
    assert not time.covers(LATEST - SECOND, 0.0)


async def test_two_links_have_two_link_ids() -> None:
    ports = free_port(), free_port()
    async with Station([f"udpin:127.0.0.1:{port}" for port in ports], key=KEY, unix=unix):
        with Far(ports[0]) as one, Far(ports[1]) as other:
            for far in (one, other):
                far.say(BEAT)
            frames = [(await wait_for_async(far.listen))[0].frame for far in (one, other)]
    assert [link_and_time(frame)[0] for frame in frames] == [0, 1]


def test_a_key_file_is_read_like_the_payload_reads_it(tmp_path: Path) -> None:
    file = tmp_path / "key"
    file.write_text(KEY.hex() + "\n")
    file.chmod(0o600)
    assert read_key(file) == KEY


def test_a_bad_key_file_is_one_clear_line(tmp_path: Path) -> None:
    file = tmp_path / "key"
    with pytest.raises(GroundError, match=r"^key .*: cannot be read: No such file or directory$"):
        read_key(file)
    file.write_bytes(b"short")
    file.chmod(0o644)
    with pytest.raises(GroundError, match=rf"expected mode 0600, got 0644: chmod 600 {file}$"):
        read_key(file)
    file.chmod(0o600)
    with pytest.raises(GroundError, match=r"expected 32 bytes or 64 hexadecimal digits, got 5 bytes$"):
        read_key(file)
