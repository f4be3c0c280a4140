"""Strangers at a listening port: they hear nothing, take nobody's place, and the key holder is heard among them."""

import socket
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, suppress
from itertools import pairwise
from pathlib import Path

import pytest

from clocks import LeapingClock
from ports import free_port
from ross_payload.config import Link
from ross_payload.mavlink import Received, Router
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.signing import LATEST, SECOND, link_and_time, timestamp_of
from strangers import BEAT, KEY, STOP, Station, Strangers, key_file, stop_command
from waiting import wait_for

TICK = 0.010  # [s] between two polls
LOCAL = "127.0.0.1"


class Payload:
    """A listening port, signed or not, and what the component behind it hears."""

    def __init__(self, url: str, port: int, folder: Path | None) -> None:
        self.clock = LeapingClock()
        self.where = (LOCAL, port)
        link = Link(url=url, key_file="" if folder is None else str(key_file(folder)))
        self.links = Router.open([link], self.clock, state=folder)
        self.heard: list[Received] = []
        self.links.component(191).subscribe(self.heard.append)

    def poll(self) -> list[Received]:
        self.links.poll()
        return self.heard

    def say(self) -> bytes:
        frames: list[bytes] = []
        self.links.component(191).tap(frames.append)
        self.links.component(191).send(BEAT)
        return frames[-1]

    def close(self) -> None:
        self.links.close()


@pytest.fixture
def listening(tmp_path: Path) -> Iterator[Callable[..., Payload]]:
    """Open a payload's port; ``signed`` with the key."""
    with ExitStack() as stack:

        def start(kind: str, *, signed: bool) -> Payload:
            port = free_port()
            payload = Payload(f"{kind}:{LOCAL}:{port}", port, tmp_path if signed else None)
            return stack.enter_context(closing(payload))

        yield start


# ---------------------------------------------------------------------------------------------------- datagrams


def shares(payload: Payload, rate: float, seconds: float, *, signed: bool) -> tuple[float, float, int]:
    """Return which shares of its messages a station gets and is heard with, and what strangers got."""
    strangers, station = Strangers(payload.where), Station(time.time(), key=KEY if signed else None)
    spoken, told, owed = set(), 0, 0.0
    with closing(strangers), station.sock:
        for tick in range(round(seconds / TICK)):
            if tick % 10 == 0:
                frame = station.frame()
                station.sock.sendto(frame, payload.where)
                spoken.add((tick // 10 % 256, frame))
            owed += rate * TICK
            strangers.say(int(owed))
            owed -= int(owed)
            payload.poll()
            if tick % 9 == 0:  # 11 messages a second
                payload.links.component(191).send(BEAT)
                told += 1
            station.listen()
        ours = [heard for heard in payload.heard if (heard.packet.sequence, heard.packet.frame) in spoken]
        said = -(-round(seconds / TICK) // 10)
        return station.listen() / told, len(ours) / said, strangers.heard()


@pytest.mark.parametrize("rate", [20, 50, 200, 1000])
def test_strange_datagrams_take_nothing_from_a_signed_station(listening, rate) -> None:
    heard, obeyed, leaked = shares(listening("udpin", signed=True), rate, 3.0, signed=True)
    assert heard >= 0.9
    assert obeyed >= 0.9
    assert leaked == 0, "strangers are told nothing"


@pytest.mark.soak
@pytest.mark.parametrize("rate", [200, 1000, 5000])
def test_strange_datagrams_for_long_take_nothing_from_a_signed_station(listening, rate) -> None:
    heard, obeyed, leaked = shares(listening("udpin", signed=True), rate, 100.0, signed=True)
    print(f"{rate} strange datagrams/s: {heard:.1%} of the messages arrive, {obeyed:.1%} are heard")  # noqa: T201
    assert min(heard, obeyed) >= 0.99
    assert leaked == 0


def test_the_noise_of_strangers_stands_between_no_bytes_of_an_unsigned_station(listening) -> None:
    heard, obeyed, _ = shares(listening("udpin", signed=False), 1000, 3.0, signed=False)
    assert min(heard, obeyed) >= 0.9


@pytest.mark.parametrize(
    "said",
    [
        pytest.param(b"x", id="one byte"),
        pytest.param(Encoder(255, 190).encode(BEAT), id="an unsigned frame"),
        pytest.param(Encoder(255, 190, bytes(32), 1).encode(BEAT, 2**47), id="another key"),
        pytest.param(
            Encoder(51, 68).encode(common.MAVLink_radio_status_message(90, 90, 100, 20, 20, 0, 0)), id="a radio"
        ),
    ],
)
def test_nobody_is_told_anything_before_a_valid_signature(listening, said: bytes) -> None:
    payload = listening("udpin", signed=True)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.setblocking(False)
        for _ in range(3):
            stranger.sendto(said, payload.where)
            payload.poll()
            payload.say()
        with pytest.raises(BlockingIOError):
            stranger.recv(2048)


def test_who_plays_our_own_or_a_stations_frames_back_is_told_nothing(listening) -> None:
    payload, station = listening("udpin", signed=True), Station(time.time())
    with station.sock, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.setblocking(False)
        captured = [station.frame()]
        station.sock.sendto(captured[0], payload.where)
        wait_for(payload.poll)
        payload.say()
        captured.append(station.sock.recv(2048))
        for frame in captured:
            stranger.sendto(frame, payload.where)
            payload.poll()
            payload.say()
        with pytest.raises(BlockingIOError):
            stranger.recv(2048)
        assert station.listen() == 2, "the station itself is still answered"


def test_a_peer_of_an_unsigned_port_is_answered_from_its_first_valid_frame_on(listening) -> None:
    payload = listening("udpin", signed=False)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
        peer.setblocking(False)
        for noise in (b"x", b"\xfd", bytes(300), Encoder(9, 1).encode(BEAT)[:-1] + b"\x00"):
            peer.sendto(noise, payload.where)
            payload.poll()
            payload.say()
        with pytest.raises(BlockingIOError):
            peer.recv(2048)
        peer.sendto(Encoder(9, 1).encode(BEAT), payload.where)
        wait_for(payload.poll)
        payload.say()
        assert len(peer.recv(2048)) > 0


def test_a_sender_that_uses_our_ids_is_answered_and_so_learns_of_us(listening) -> None:
    payload = listening("udpin", signed=False)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as twin:
        twin.setblocking(False)
        twin.sendto(Encoder(1, 191).encode(BEAT), payload.where)
        wait_for(lambda: payload.poll() or payload.links.twin == 191)
        payload.say()
        assert len(twin.recv(2048)) > 0
        assert payload.heard == []


def test_frames_that_a_bridge_cuts_into_datagrams_are_heard(listening) -> None:
    payload, encoder = listening("udpin", signed=False), Encoder(9, 1)
    stream = b"".join(encoder.encode(BEAT) for _ in range(40))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as bridge:
        for start in range(0, len(stream), 13):
            bridge.sendto(stream[start : start + 13], payload.where)
            payload.poll()
    assert len(payload.heard) == 40


def test_when_there_are_too_many_the_peer_unheard_for_longest_makes_room(listening) -> None:
    payload, encoder = listening("udpin", signed=False), Encoder(9, 1)
    with ExitStack() as stack:
        peers = [stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) for _ in range(17)]
        for peer in (*peers[:16], peers[0], peers[16]):  # the first is heard again before the last comes
            peer.setblocking(False)
            peer.sendto(encoder.encode(BEAT), payload.where)
            payload.poll()
        payload.say()
        told = []
        for number, peer in enumerate(peers):
            try:
                told.append((number, bool(peer.recv(2048))))
            except BlockingIOError:
                told.append((number, False))
    assert [number for number, answered in told if not answered] == [1]


@pytest.mark.parametrize("kind", ["udpin", "tcpin"])
@pytest.mark.parametrize("lag", [120.0, 86400.0], ids=["two minutes", "a day"])
def test_a_station_whose_time_is_behind_is_told_ours_and_is_believed_then(listening, kind, lag) -> None:
    """As after a crash of ours, or where its computer has no clock: it follows what it hears, as MAVLink wants it."""
    payload, station = listening(kind, signed=True), Encoder(255, 190, KEY, 7)
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM if kind == "tcpin" else socket.SOCK_DGRAM) as sock:
        sock.connect(payload.where)
        sock.settimeout(0.01)

        def heard() -> bytes:
            payload.poll()
            with suppress(TimeoutError):
                return sock.recv(2048)
            return b""

        payload.say()
        sock.send(station.encode(BEAT, timestamp_of(time.time() - lag)))
        told = wait_for(heard)
        assert [packet.name for packet in Decoder().feed(told)] == ["HEARTBEAT"]
        payload.say()
        assert (payload.heard, heard()) == ([], b""), "it is not believed, and told no more"
        sock.send(station.encode(stop_command(), link_and_time(told)[1] + 1))
        (order,) = wait_for(payload.poll)
        assert order.may_order
        payload.say()
        assert wait_for(heard)


@pytest.mark.parametrize("behind", [300.0, 0.5])
def test_a_station_that_starts_again_with_a_clock_behind_ours_is_believed_after_one_heartbeat(
    listening, behind
) -> None:
    """Its second run is behind what its first one has heard of us, by a fraction of a second perhaps."""
    payload, first = listening("udpin", signed=True), Station(time.time() + 300.0)
    payload.say()
    with first.sock, Station(time.time()).sock as sock:
        first.sock.sendto(first.frame(), payload.where)
        wait_for(lambda: payload.poll() or payload.links.status()[0].received)
        payload.say()
        wait_for(lambda: first.sock.sendto(first.frame(), payload.where) and payload.poll())
        payload.say()
        again = Encoder(255, 190, KEY, 7)
        sock.sendto(again.encode(BEAT, timestamp_of(time.time() + 300.0 - behind)), payload.where)

        def heard() -> bytes:
            payload.poll()
            with suppress(BlockingIOError):
                return sock.recv(2048)
            return b""

        told = link_and_time(wait_for(heard))[1]
        payload.heard.clear()
        sock.sendto(again.encode(stop_command(), told + 1), payload.where)
        assert wait_for(payload.poll)


def test_a_station_is_believed_though_one_with_its_ids_and_a_clock_ahead_has_sent_a_single_frame(listening) -> None:
    """That frame was not believed: its time was not on the disk. What comes after it has to be later all the same."""
    payload, first = listening("udpin", signed=True), Station(time.time() + 600.0)
    with first.sock, Station(time.time()).sock as sock:
        sock.settimeout(0.01)
        first.sock.sendto(first.frame(), payload.where)
        wait_for(lambda: payload.poll() or payload.links.status()[0].received)
        again, stamp = Encoder(255, 190, KEY, 7), timestamp_of(time.time())

        def believed() -> bool:
            nonlocal stamp
            payload.say()
            stamp += 1
            sock.sendto(again.encode(stop_command(), stamp), payload.where)
            payload.poll()
            with suppress(TimeoutError):
                stamp = max(stamp, link_and_time(sock.recv(2048))[1])
            return bool(payload.heard)

        wait_for(believed)


def test_a_clock_at_the_end_of_all_timestamps_is_not_followed(listening) -> None:
    """After the last timestamp those of our frames would begin at 0 again: nobody would believe any, for ever."""
    payload = listening("udpin", signed=True)
    with Station(time.time()).sock as sock:
        again = Encoder(255, 190, KEY, 7)
        sock.sendto(again.encode(BEAT, LATEST), payload.where)
        wait_for(lambda: payload.poll() or payload.links.status()[0].received)
        for later in range(20):
            payload.say()
            time.sleep(0.01)
            sock.sendto(again.encode(stop_command(), timestamp_of(time.time()) + later), payload.where)
            payload.poll()
        assert payload.heard
        payload.say()
        sock.settimeout(1.0)
        assert abs(link_and_time(sock.recv(2048))[1] - timestamp_of(time.time())) < 60 * SECOND


def test_of_a_flood_of_frames_from_before_few_are_answered(listening) -> None:
    payload, station = listening("udpin", signed=True), Station(time.time() - 120.0)
    with station.sock:
        payload.say()
        for _ in range(300):
            station.sock.sendto(station.frame(), payload.where)
            payload.poll()
        assert 20 <= station.listen() < 40


# ---------------------------------------------------------------------------------------------------- connections


def connected(payload: Payload, stack: ExitStack, count: int) -> list[socket.socket]:
    """Connect clients, all of which have been let in or turned away."""
    socks = []
    for _ in range(count):
        socks.append(stack.enter_context(socket.create_connection(payload.where, timeout=20.0)))
        payload.poll()
    return socks


def test_idle_connections_do_not_keep_a_signed_stop_out(listening) -> None:
    payload, station = listening("tcpin", signed=True), Station(time.time())
    with ExitStack() as stack, station.sock:
        idle = connected(payload, stack, 100)
        (holder,) = connected(payload, stack, 1)
        holder.sendall(station.frame(stop_command()))
        wait_for(payload.poll)
        (heard,) = payload.heard
        assert (heard.packet.message.command, heard.may_order) == (STOP, True)
        payload.say()
        assert len(holder.recv(1000)) > 0
        for sock in idle[-3:]:
            sock.setblocking(False)
            with pytest.raises(BlockingIOError):
                sock.recv(10)


def test_connections_that_show_no_key_are_closed_after_five_seconds(listening) -> None:
    payload, station = listening("tcpin", signed=True), Station(time.time())
    with ExitStack() as stack, station.sock:
        holder, idle, chatty = connected(payload, stack, 3)
        holder.sendall(station.frame())
        chatty.sendall(Encoder(255, 190).encode(BEAT))
        wait_for(payload.poll)
        wait_for(lambda: payload.poll() and payload.links.status()[0].refused == 1)
        payload.clock.ahead += 4.5
        payload.poll()
        idle.setblocking(False)
        with pytest.raises(BlockingIOError):
            idle.recv(10)
        payload.clock.ahead += 0.6
        payload.poll()
        idle.settimeout(20.0)
        assert idle.recv(10) == b""
        assert chatty.recv(10) == b""
        assert payload.links.status()[0].error == "a client has sent nothing signed with the key within 5 s"
        holder.sendall(station.frame())
        wait_for(lambda: len(payload.poll()) == 2)


def test_among_seventeen_key_holders_the_one_unheard_for_longest_makes_room(listening) -> None:
    payload = listening("tcpin", signed=True)
    stations = [Station(time.time(), system=system) for system in range(200, 217)]
    with ExitStack() as stack:
        socks = []
        for number, station in enumerate(stations, 1):
            stack.enter_context(station.sock)
            socks += connected(payload, stack, 1)
            socks[-1].sendall(station.frame())
            wait_for(lambda number=number: len(payload.poll()) == number)
        assert socks[0].recv(10) == b""
        payload.say()
        assert all(sock.recv(1000) for sock in socks[1:])


def test_a_client_that_takes_a_number_again_begins_again(listening) -> None:
    """A half frame of one that has left must not swallow the first frame of the next."""
    payload, encoder = listening("tcpin", signed=False), Encoder(9, 1)
    frames = [encoder.encode(BEAT) for _ in range(3)]
    with ExitStack() as stack:
        (first,) = connected(payload, stack, 1)
        first.sendall(frames[0] + frames[1][:9])
        wait_for(payload.poll)
        first.close()
        wait_for(lambda: payload.poll() and payload.links.status()[0].error)
        (second,) = connected(payload, stack, 1)
        second.sendall(frames[2])
        wait_for(lambda: len(payload.poll()) == 2)
    assert [later.packet.sequence - sooner.packet.sequence for sooner, later in pairwise(payload.heard)] == [2]
