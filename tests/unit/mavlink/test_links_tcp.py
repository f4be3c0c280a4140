"""Router over TCP: a client that comes back, a server with several clients; frames are never cut."""

import socket
import time
from collections.abc import Iterator

import pytest

from clocks import LeapingClock
from links_bench import BEAT, hears, links_to, status
from ports import free_port
from ross_payload.clock import SystemClock
from ross_payload.errors import ConfigError, LinkError
from ross_payload.mavlink import Router
from ross_payload.transport.open_port import open_port
from ross_protocols.mavlink.codec import Encoder
from waiting import wait_for

FRAME = Encoder(255, 190).encode(BEAT)


@pytest.fixture
def server() -> Iterator[socket.socket]:
    with socket.create_server(("127.0.0.1", 0)) as sock:
        sock.settimeout(10.0)
        yield sock


def port_of(sock: socket.socket) -> int:
    return int(sock.getsockname()[1])


# ---------------------------------------------------------------------------------------------------- client


def test_tcp_goes_both_ways(server: socket.socket) -> None:
    with links_to(f"tcp:127.0.0.1:{port_of(server)}") as links:
        heard = hears(links)
        ground, _ = server.accept()
        with ground:
            ground.settimeout(10.0)
            links.component(191).send(BEAT)
            assert len(ground.recv(1000)) == len(FRAME)
            ground.sendall(FRAME[:7])
            ground.sendall(FRAME[7:])
            wait_for(lambda: links.poll() or heard)
    assert [one.packet.value for one in heard] == [BEAT]


def test_a_refused_connection_is_one_clear_line_for_the_impatient() -> None:
    with pytest.raises(LinkError, match=r"^link 'tcp:127.0.0.1:\d+' cannot be opened: Connection refused$"):
        links_to(f"tcp:127.0.0.1:{free_port()}")


def test_a_patient_link_waits_for_a_server_that_comes_late() -> None:
    port, clock = free_port(), LeapingClock()
    with links_to(f"tcp:127.0.0.1:{port}", clock=clock, patient=True) as links:
        wait_for(lambda: links.poll() or status(links).error)
        assert (status(links).up, status(links).error) == (False, "Connection refused")
        with socket.create_server(("127.0.0.1", port)) as server:
            server.settimeout(10.0)
            clock.ahead += 10.0
            wait_for(lambda: links.poll() or status(links).up)
            ground, _ = server.accept()
            with ground:
                links.component(191).send(BEAT)
                assert len(ground.recv(1000)) == len(FRAME)
        assert status(links).reconnects == 0, "the first connection is not one again"


def test_a_server_that_leaves_and_returns_is_found_again(server: socket.socket) -> None:
    clock = LeapingClock()
    with links_to(f"tcp:127.0.0.1:{port_of(server)}", clock=clock) as links:
        heard = hears(links)
        ground, _ = server.accept()
        ground.close()
        wait_for(lambda: links.poll() or not status(links).up)
        links.component(191).send(BEAT)
        assert status(links).dropped > 0
        clock.ahead += 10.0
        wait_for(lambda: links.poll() or status(links).up)
        ground, _ = server.accept()
        with ground:
            ground.sendall(FRAME)
            wait_for(lambda: links.poll() or heard)
        assert status(links).reconnects == 1


def test_attempts_become_rarer() -> None:
    port, clock = free_port(), LeapingClock()
    with links_to(f"tcp:127.0.0.1:{port}", clock=clock, patient=True) as links:
        port = links._links[0]._port
        attempts = []
        for _ in range(40):
            refused = port.counts.refused
            started = clock.ahead
            while port.counts.refused == refused and clock.ahead - started < 20:
                links.poll()
                clock.ahead += 0.1
                time.sleep(0.001)  # the lookup has a thread of its own
            attempts.append(clock.ahead - started)
            if attempts[-1] > 7.9:
                break
        assert attempts[-1] > 7.9, attempts
        assert len(attempts) < 15


def test_opening_does_not_wait_for_a_server_that_never_answers() -> None:
    with socket.socket() as full:  # a listener whose queue is full lets nobody in
        full.bind(("127.0.0.1", 0))
        full.listen(0)
        crowd = [socket.socket() for _ in range(3)]
        for sock in crowd:
            sock.setblocking(False)
            sock.connect_ex(full.getsockname())
        clock = LeapingClock()
        with links_to(f"tcp:127.0.0.1:{port_of(full)}", clock=clock, patient=True) as links:
            slowest = 0.0
            for _ in range(50):
                before = time.thread_time()
                links.poll()
                slowest = max(slowest, time.thread_time() - before)
                time.sleep(0.002)
            clock.ahead += 4.0
            links.poll()
            assert status(links).error == "no answer"
        assert slowest < 0.05
        for sock in crowd:
            sock.close()


def test_a_ground_station_that_does_not_read_gets_whole_frames_only(server: socket.socket) -> None:
    frames = [number.to_bytes(4, "big") * 250 for number in range(20_000)]
    port = open_port(f"tcp:127.0.0.1:{port_of(server)}", SystemClock().now)
    ground, _ = server.accept()
    with ground:
        ground.settimeout(0.5)
        for frame in frames:
            port.send(frame)
        assert port.counts.dropped > 0, "the buffers of the system are bounded"
        assert port.counts.sent + port.counts.dropped == len(frames)
        stream = b""
        while len(stream) < port.counts.sent * 1000:
            stream += ground.recv(1 << 20)
            port.receive()  # finishes the frame that was begun
    port.close()
    got = [stream[start : start + 1000] for start in range(0, len(stream), 1000)]
    numbers = [int.from_bytes(frame[:4], "big") for frame in got]
    assert got == [frames[number] for number in numbers], "each frame is whole"
    assert numbers == sorted(set(numbers)), "in order, none twice"
    assert len(got) == port.counts.sent


# ---------------------------------------------------------------------------------------------------- server


def joined(links: Router, port: int, count: int) -> list[socket.socket]:
    clients = [socket.create_connection(("127.0.0.1", port), timeout=10.0) for _ in range(count)]
    server = links._links[0]._port
    wait_for(lambda: links.poll() or len(server._clients) + server.counts.refused == count)
    return clients


def test_a_server_talks_to_all_its_clients() -> None:
    port = free_port()
    with links_to(f"tcpin::{port}") as links:
        clients = joined(links, port, 3)
        links.component(191).send(BEAT)
        assert [len(client.recv(1000)) for client in clients] == [len(FRAME)] * 3
        for client in clients:
            client.close()


def test_frames_of_two_clients_that_come_in_pieces_do_not_mix() -> None:
    port = free_port()
    one, two = Encoder(255, 190), Encoder(254, 190)
    with links_to(f"tcpin::{port}") as links:
        heard = hears(links)
        clients = joined(links, port, 2)
        for _ in range(10):
            first, second = one.encode(BEAT), two.encode(BEAT)
            for piece, client in ((first[:9], 0), (second[:5], 1), (first[9:], 0), (second[5:], 1)):
                clients[client].sendall(piece)
                before = status(links).received_bytes
                links.poll()
                time.sleep(0.002)
                links.poll()
                assert status(links).received_bytes >= before
        wait_for(lambda: links.poll() or len(heard) == 20)
        assert (status(links).bad, status(links).lost) == (0, 0)
        for client in clients:
            client.close()
    assert {one.packet.system_id for one in heard} == {254, 255}


def test_a_client_that_leaves_makes_room_and_the_others_stay() -> None:
    port = free_port()
    with links_to(f"tcpin::{port}") as links:
        stays, leaves = joined(links, port, 2)
        leaves.close()
        wait_for(lambda: links.poll() or status(links).error)
        links.component(191).send(BEAT)
        assert len(stays.recv(1000)) == len(FRAME)
        assert status(links).up
        stays.close()


def test_the_seventeenth_client_takes_the_place_of_the_oldest_that_has_said_nothing() -> None:
    port = free_port()
    with links_to(f"tcpin::{port}") as links:
        heard = hears(links)
        clients = joined(links, port, 16)
        clients[0].sendall(FRAME)
        wait_for(lambda: links.poll() or heard)
        clients.append(socket.create_connection(("127.0.0.1", port), timeout=10.0))
        wait_for(lambda: links.poll() or status(links).error)
        assert clients[1].recv(10) == b""
        links.component(191).send(BEAT)
        assert [len(clients[number].recv(1000)) for number in (0, 2, 16)] == [len(FRAME)] * 3
        for client in clients:
            client.close()


def test_when_all_sixteen_clients_speak_the_seventeenth_is_turned_away() -> None:
    port = free_port()
    with links_to(f"tcpin::{port}") as links:
        heard = hears(links)
        clients = joined(links, port, 16)
        for client in clients:
            client.sendall(FRAME)
        wait_for(lambda: links.poll() or len(heard) == 16)
        clients.append(socket.create_connection(("127.0.0.1", port), timeout=10.0))
        wait_for(lambda: links.poll() or status(links).error)
        assert clients[16].recv(10) == b""
        for client in clients:
            client.close()


def test_a_server_listens_on_the_loopback_only_and_says_when_its_port_is_in_use(server: socket.socket) -> None:
    port = open_port(f"tcpin::{free_port()}", SystemClock().now)
    (listener,) = port._listeners.values()
    assert listener.getsockname()[0] == "127.0.0.1"
    port.close()
    with pytest.raises(LinkError, match="cannot be opened: Address already in use"):
        links_to(f"tcpin::{port_of(server)}", patient=True)


# ---------------------------------------------------------------------------------------------------- several links


def test_no_link_is_opened_when_one_is_wrong(server: socket.socket) -> None:
    with pytest.raises(ConfigError, match="expected udpin"):
        links_to(f"tcp:127.0.0.1:{port_of(server)}", "carrier:pigeon")
    server.settimeout(0.05)
    with pytest.raises(TimeoutError):
        server.accept()


def test_the_links_before_a_broken_one_are_closed_again(server: socket.socket) -> None:
    with pytest.raises(LinkError):
        links_to(f"tcp:127.0.0.1:{port_of(server)}", f"tcp:127.0.0.1:{free_port()}")
    ground, _ = server.accept()
    with ground:
        assert ground.recv(10) == b""
