"""Router over UDP: real sockets; nothing waits, nothing piles up, nothing is raised in flight."""

import socket
from collections.abc import Iterator
from contextlib import ExitStack, closing, suppress

import pytest

from clocks import LeapingClock
from links_bench import BEAT, links_to, status
from ports import free_port
from ross_payload.clock import SystemClock
from ross_payload.errors import LinkError
from ross_payload.mavlink import Received, Router
from ross_payload.transport.open_port import open_port
from ross_payload.transport.udp import MAX_DATAGRAMS, SILENT_S
from ross_protocols.mavlink.codec import Encoder
from waiting import wait_for

FRAME = Encoder(255, 190).encode(BEAT)


class Ear:
    """Polls and keeps what a component hears."""

    def __init__(self, links: Router) -> None:
        self._links = links
        self.heard: list[Received] = []
        links.component(191).subscribe(self.heard.append)

    def poll(self) -> list[Received]:
        self._links.poll()
        return self.heard


@pytest.fixture
def listener() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 0))
        sock.settimeout(10.0)
        yield sock


def port_of(sock: socket.socket) -> int:
    return int(sock.getsockname()[1])


def test_udpout_sends_one_datagram_per_frame(listener: socket.socket) -> None:
    with links_to(f"udpout:127.0.0.1:{port_of(listener)}") as links:
        frames: list[bytes] = []
        links.component(191).tap(frames.append)
        for _ in range(2):
            links.component(191).send(BEAT)
    assert [listener.recv(1000), listener.recv(1000)] == frames


def test_udpout_hears_the_one_it_sends_to_and_no_stranger(listener: socket.socket) -> None:
    with links_to(f"udpout:127.0.0.1:{port_of(listener)}") as links:
        ear = Ear(links)
        links.component(191).send(BEAT)
        _, payload = listener.recvfrom(1000)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            stranger.sendto(Encoder(7, 7).encode(BEAT), payload)
        listener.sendto(FRAME, payload)
        (heard,) = wait_for(ear.poll)
    assert (heard.packet.system_id, heard.packet.value) == (255, BEAT)


def test_a_udp_port_that_nobody_listens_on_costs_nothing() -> None:
    port = free_port()
    with links_to(f"udpout:127.0.0.1:{port}") as links:
        for _ in range(50):
            links.component(191).send(BEAT)
            links.poll()
        assert status(links).error == ""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as late:
            late.bind(("127.0.0.1", port))
            late.settimeout(10.0)
            links.component(191).send(BEAT)
            assert late.recv(1000)[4] == 50, "who comes late misses nothing from then on"


def test_what_comes_behind_a_burst_of_others_is_heard() -> None:
    """As many as a flood of 30,000 datagrams/s brings between two polls."""
    port = free_port()
    with links_to(f"udpin::{port}") as links, ExitStack() as stack:
        ear = Ear(links)
        pilot, flooder = (stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) for _ in range(2))
        pilot.sendto(FRAME, ("127.0.0.1", port))
        wait_for(lambda: len(ear.poll()) == 1)
        for _ in range(400):
            flooder.sendto(b"noise", ("127.0.0.1", port))
        pilot.sendto(FRAME, ("127.0.0.1", port))
        wait_for(lambda: len(ear.poll()) == 2)


def test_udpin_answers_everyone_who_has_spoken() -> None:
    port = free_port()
    with links_to(f"udpin::{port}") as links:
        ear = Ear(links)
        links.component(191).send(BEAT)  # to nobody yet
        peers = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(3)]
        for number, peer in enumerate(peers):
            peer.settimeout(10.0)
            peer.sendto(FRAME, ("127.0.0.1", port))
            wait_for(lambda number=number: len(ear.poll()) > number)
        links.component(191).send(BEAT)
        assert [peer.recv(1000)[4] for peer in peers] == [1, 1, 1]
        for peer in peers:
            peer.close()


def test_udpin_answers_a_bounded_number_of_peers() -> None:
    port = open_port(f"udpin::{free_port()}", SystemClock().now)
    where = port._socket.getsockname()
    for number in range(40):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
            peer.sendto(b"hello", where)
            wait_for(lambda number=number: port.receive() or port.counts.received == 5 * (number + 1))
    port.send(FRAME)
    assert port.counts.sent == 16
    port.close()


@pytest.mark.parametrize(("host", "family"), [("127.0.0.1", socket.AF_INET), ("::1", socket.AF_INET6)])
def test_udpin_sends_nothing_more_to_where_nobody_listens_any_more_until_it_speaks_again(
    host: str, family: int
) -> None:
    port, clock = free_port(), LeapingClock()
    bracketed = f"[{host}]" if ":" in host else host
    with links_to(f"udpin:{bracketed}:{port}", clock=clock) as links, ExitStack() as stack:

        def peer(at: int = 0) -> socket.socket:
            sock = stack.enter_context(socket.socket(family, socket.SOCK_DGRAM))
            sock.bind((host, at))
            sock.setblocking(False)
            return sock

        def hears(sock: socket.socket) -> bool:
            try:
                return bool(sock.recv(2048))
            except BlockingIOError:
                return False

        component, (gone, quiet) = links.component(191), (peer(), peer())
        for sock in (gone, quiet):
            sock.sendto(FRAME, (host, port))
            links.poll()
        where = port_of(gone)
        gone.close()
        for _ in range(20):
            component.send(BEAT)
            assert hears(quiet), "what the other one is refused takes nothing from it"
        clock.ahead += 2 * SILENT_S
        links.poll()
        again = peer(where)
        component.send(BEAT)
        assert (hears(again), hears(quiet)) == (False, True)
        again.sendto(FRAME, (host, port))
        links.poll()
        component.send(BEAT)
        assert (hears(again), hears(quiet)) == (True, True)
        assert (status(links).dropped, status(links).error) == (0, "")


def test_udpin_goes_on_sending_to_who_was_heard_lately_whatever_is_reported_of_it() -> None:
    """Nothing proves who wrote an ICMP message: ten a second would keep a station from all telemetry."""
    port = free_port()
    with links_to(f"udpin:127.0.0.1:{port}") as links, ExitStack() as stack:
        first = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        first.sendto(FRAME, ("127.0.0.1", port))
        links.poll()
        where = first.getsockname()[1]
        first.close()
        links.component(191).send(BEAT)  # is refused
        links.poll()
        again = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        again.bind(("127.0.0.1", where))
        again.settimeout(1.0)
        links.component(191).send(BEAT)
        assert again.recv(2048)


def test_udpin_sends_to_everybody_while_what_is_reported_of_one_finds_no_room() -> None:
    """Reports lie in the buffer for what arrives: when it is full, the system tells the error alone."""
    where = ("127.0.0.1", free_port())
    with ExitStack() as stack:
        port = stack.enter_context(closing(open_port(f"udpin:127.0.0.1:{where[1]}", SystemClock().now)))
        port._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        gone, here, loud = [stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) for _ in range(3)]
        for peer in (gone, here):
            peer.sendto(FRAME, where)
            port.receive()
        gone.close()
        for _ in range(100):
            loud.sendto(bytes(1000), where)
        here.settimeout(1.0)
        for _ in range(3):
            port.send(FRAME)
            assert here.recv(2048) == FRAME


def test_udpin_hears_what_has_arrived_behind_more_reports_than_it_reads_at_once() -> None:
    where = ("127.0.0.1", free_port())
    with (
        closing(open_port(f"udpin:127.0.0.1:{where[1]}", SystemClock().now)) as port,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as station,
    ):
        station.sendto(FRAME, where)
        nobody = ("127.0.0.1", free_port())
        for _ in range(3 * MAX_DATAGRAMS):
            with suppress(ConnectionRefusedError):  # every second one
                port._socket.sendto(FRAME, nobody)
        assert port.receive() == [FRAME]


def test_udpin_listens_on_the_loopback_only() -> None:
    port = open_port(f"udpin::{free_port()}", SystemClock().now)
    assert port._socket.getsockname()[0] == "127.0.0.1"
    port.close()


def test_udp_speaks_ipv6() -> None:
    try:
        sock = socket.socket(socket.AF_INET6, socket.SOCK_DGRAM)
        sock.bind(("::1", 0))
    except OSError:
        pytest.skip("this machine has no IPv6 loopback (::1)")
    with sock, links_to(f"udpout:[::1]:{port_of(sock)}") as links:
        sock.settimeout(10.0)
        links.component(191).send(BEAT)
        assert sock.recv(1000)


def test_a_port_in_use_is_one_clear_line_for_the_patient_too(listener: socket.socket) -> None:
    url = f"udpin::{port_of(listener)}"
    for patient in (False, True):
        with pytest.raises(LinkError, match=f"^link '{url}' cannot be opened: Address already in use$"):
            links_to(url, patient=patient)


def test_a_host_that_does_not_exist_is_one_clear_line() -> None:
    with pytest.raises(LinkError, match=r"^link .udpout:no\.such\.host\.invalid:1. cannot be opened: .+$"):
        links_to("udpout:no.such.host.invalid:1")


def test_a_broadcast_address_is_named_as_what_it_is() -> None:
    with pytest.raises(LinkError, match=r"expected the address of one computer, got a broadcast address"):
        links_to("udpout:127.255.255.255:14550")


def test_a_patient_link_to_a_host_that_is_not_known_yet_says_so_and_goes_on() -> None:
    with links_to("udpout:no.such.host.invalid:1", patient=True) as links:
        links.component(191).send(BEAT)
        wait_for(lambda: links.poll() or status(links).error, seconds=60.0)
        assert not status(links).up
        assert status(links).dropped == 1


def test_a_patient_link_finds_its_host_by_itself(listener: socket.socket) -> None:
    with links_to(f"udpout:localhost:{port_of(listener)}", patient=True) as links:
        wait_for(lambda: links.poll() or status(links).up)
        links.component(191).send(BEAT)
        assert listener.recv(1000)


def test_closing_twice_is_closing_once(listener: socket.socket) -> None:
    links = links_to(f"udpout:127.0.0.1:{port_of(listener)}")
    links.close()
    links.close()
