"""Links: real sockets and a real pseudo terminal; nothing waits, nothing piles up, nothing is raised in flight."""

import os
import pty
import socket
import sys
import time
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_payload.errors import ConfigError, LinkError
from ross_payload.links import Links, open_port
from ross_payload.links.address import Serial, Tcp, Udp, parse
from ross_protocols.codec import Encoder
from ross_protocols.values import Health, Heartbeat

FRAME = Encoder(1, 191).encode(Heartbeat(Health.ACTIVE, 6))


def free_port(kind: socket.SocketKind = socket.SOCK_DGRAM) -> int:
    with socket.socket(socket.AF_INET, kind) as sock:
        sock.bind(("127.0.0.1", 0))
        return int(sock.getsockname()[1])


def until(true: Callable[[], object], seconds: float = 5.0) -> object:
    """Wait for the kernel to deliver."""
    deadline = time.monotonic() + seconds
    while not (found := true()):
        assert time.monotonic() < deadline, "nothing came"
        time.sleep(0.001)
    return found


@pytest.fixture
def listener():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 0))
        sock.settimeout(5.0)
        yield sock


@pytest.fixture
def server():
    with socket.create_server(("127.0.0.1", 0)) as sock:
        sock.settimeout(5.0)
        yield sock


def port_of(sock: socket.socket) -> int:
    return int(sock.getsockname()[1])


# ---------------------------------------------------------------------------------------------------- URLs


@pytest.mark.parametrize(
    ("url", "address"),
    [
        ("udpin:0.0.0.0:14550", Udp("0.0.0.0", 14550, listen=True)),  # noqa: S104
        ("udpin::14550", Udp("127.0.0.1", 14550, listen=True)),
        ("udpout:ground.local:14550", Udp("ground.local", 14550, listen=False)),
        ("udpout:[fe80::1]:1", Udp("fe80::1", 1, listen=False)),
        ("tcp:127.0.0.1:65535", Tcp("127.0.0.1", 65535)),
        ("serial:/dev/ttyUSB0:57600", Serial("/dev/ttyUSB0", 57600)),
        ("serial:/dev/serial/by-path/pci-0:1:921600", Serial("/dev/serial/by-path/pci-0:1", 921600)),
    ],
)
def test_a_url_is_read(url: str, address: object) -> None:
    assert parse(url) == address


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("", "wanted udpin:host:port"),
        ("udp:127.0.0.1:14550", "wanted udpin:host:port"),
        ("127.0.0.1:14550", "wanted udpin:host:port"),
        ("udpout:127.0.0.1", "wanted udpin:host:port"),
        ("udpout::14550", "host is missing"),
        ("tcp:127.0.0.1:0", "port '0' found, a number from 1 to 65535 wanted"),
        ("tcp:127.0.0.1:65536", "port '65536' found"),
        ("tcp:127.0.0.1:-1", "port '-1' found"),
        ("tcp:127.0.0.1:http", "port 'http' found"),
        ("tcp:127.0.0.1:", "port '' found"),
        ("tcp:fe80::1:5760", "IPv6 host in brackets"),
        ("tcp:[fe80::1:5760", "IPv6 host in brackets"),
        ("serial:/dev/ttyUSB0", "wanted udpin:host:port"),
        ("serial:/dev/ttyUSB0:fast", "baud 'fast' found"),
        ("serial:/dev/ttyUSB0:0", "baud '0' found"),
    ],
)
def test_what_is_no_url_is_explained(url: str, says: str) -> None:
    with pytest.raises(ConfigError) as error:
        parse(url)
    assert says in str(error.value)
    assert f"'{url}'" in str(error.value)
    assert "\n" not in str(error.value)


@given(st.text(max_size=40))
def test_any_text_is_an_address_or_a_config_error(text: str) -> None:
    try:
        parse(text)
    except ConfigError as error:
        assert "wanted" in str(error)


# ---------------------------------------------------------------------------------------------------- UDP


def test_udpout_sends_one_datagram_per_frame(listener: socket.socket) -> None:
    with Links.open([f"udpout:127.0.0.1:{port_of(listener)}"]) as links:
        links.send(FRAME)
        links.send(FRAME)
    assert [listener.recv(1000), listener.recv(1000)] == [FRAME, FRAME]


def test_udpout_hears_the_one_it_sends_to(listener: socket.socket) -> None:
    with Links.open([f"udpout:127.0.0.1:{port_of(listener)}"]) as links:
        links.send(FRAME)
        _, payload = listener.recvfrom(1000)
        listener.sendto(FRAME, payload)
        (heard,) = until(links.poll)
    assert heard.packet.value == Heartbeat(Health.ACTIVE, 6)


def test_udpout_does_not_hear_strangers(listener: socket.socket) -> None:
    with Links.open([f"udpout:127.0.0.1:{port_of(listener)}"]) as links:
        links.send(FRAME)
        _, payload = listener.recvfrom(1000)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            stranger.sendto(FRAME, payload)
        listener.sendto(FRAME, payload)
        assert len(until(links.poll)) == 1


def test_a_udp_port_that_nobody_listens_on_costs_nothing() -> None:
    port = free_port()
    with Links.open([f"udpout:127.0.0.1:{port}"]) as links:
        for _ in range(50):
            links.send(FRAME)
            links.poll()
        ((_, counts),) = links.counts()
        assert counts.refused > 0
        assert counts.failed == 0
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as late:  # who comes late misses nothing from then on
            late.bind(("127.0.0.1", port))
            late.settimeout(5.0)
            links.send(FRAME)
            assert late.recv(1000) == FRAME


def test_the_first_frame_after_somebody_begins_to_listen_arrives() -> None:
    """The system tells of a refused datagram when the next one is sent, and does not send that one."""
    port = free_port()
    with Links.open([f"udpout:127.0.0.1:{port}"]) as links:
        links.send(b"refused")
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as late:
            late.bind(("127.0.0.1", port))
            late.settimeout(5.0)
            links.send(FRAME)
            assert late.recv(1000) == FRAME
        assert links.counts()[0][1].refused == 1


def test_udpin_answers_everyone_who_has_spoken() -> None:
    port = free_port()
    with Links.open([f"udpin::{port}"]) as links:
        links.send(FRAME)  # to nobody yet
        peers = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(3)]
        for peer in peers:
            peer.settimeout(5.0)
            peer.sendto(FRAME, ("127.0.0.1", port))
            until(links.poll)
        links.send(FRAME)
        assert [peer.recv(1000) for peer in peers] == [FRAME] * 3
        for peer in peers:
            peer.close()


def test_udpin_answers_a_bounded_number_of_peers() -> None:
    port = free_port()
    with Links.open([f"udpin::{port}"]) as links:
        for _ in range(40):
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
                peer.sendto(b"hello", ("127.0.0.1", port))
                received = links.counts()[0][1].received
                until(lambda received=received: links.poll() or links.counts()[0][1].received > received)
        before = links.counts()[0][1].sent
        links.send(FRAME)
        assert links.counts()[0][1].sent - before == 16


def test_udpin_listens_on_the_loopback_only() -> None:
    port = open_port(f"udpin::{free_port()}")
    assert port._socket.getsockname()[0] == "127.0.0.1"
    port.close()


def test_udp_speaks_ipv6() -> None:
    try:
        sock = socket.socket(socket.AF_INET6, socket.SOCK_DGRAM)
        sock.bind(("::1", 0))
    except OSError:
        pytest.skip("this machine has no IPv6 loopback (::1)")
    with sock, Links.open([f"udpout:[::1]:{port_of(sock)}"]) as links:
        sock.settimeout(5.0)
        links.send(FRAME)
        assert sock.recv(1000) == FRAME


def test_a_port_in_use_is_one_clear_line(listener: socket.socket) -> None:
    url = f"udpin::{port_of(listener)}"
    with pytest.raises(LinkError, match=f"link '{url}' cannot be opened: Address already in use"):
        open_port(url)


def test_a_host_that_does_not_exist_is_one_clear_line() -> None:
    with pytest.raises(LinkError, match=r"link .udpout:no\.such\.host\.invalid:1. cannot be opened: .+"):
        open_port("udpout:no.such.host.invalid:1")


# ---------------------------------------------------------------------------------------------------- TCP


def test_tcp_goes_both_ways(server: socket.socket) -> None:
    with Links.open([f"tcp:127.0.0.1:{port_of(server)}"]) as links:
        ground, _ = server.accept()
        with ground:
            ground.settimeout(5.0)
            links.send(FRAME)
            assert ground.recv(1000) == FRAME
            ground.sendall(FRAME[:7])
            ground.sendall(FRAME[7:])
            (heard,) = until(links.poll)
    assert heard.packet.value == Heartbeat(Health.ACTIVE, 6)


def test_a_refused_connection_is_one_clear_line() -> None:
    with pytest.raises(LinkError, match=r"^link 'tcp:127.0.0.1:\d+' cannot be opened: Connection refused$"):
        open_port(f"tcp:127.0.0.1:{free_port(socket.SOCK_STREAM)}")


def test_a_ground_station_that_does_not_read_gets_whole_frames_only(server: socket.socket) -> None:
    frames = [number.to_bytes(4, "big") * 250 for number in range(20_000)]
    with Links.open([f"tcp:127.0.0.1:{port_of(server)}"]) as links:
        ground, _ = server.accept()
        with ground:
            ground.settimeout(0.5)
            for frame in frames:
                links.send(frame)
            ((_, counts),) = links.counts()
            assert counts.dropped > 0, "the buffers of the system are bounded"
            assert counts.sent + counts.dropped == len(frames)
            stream = b""
            while len(stream) < counts.sent * 1000:
                stream += ground.recv(1 << 20)
                links.poll()  # finishes the frame that was begun
    got = [stream[start : start + 1000] for start in range(0, len(stream), 1000)]
    numbers = [int.from_bytes(frame[:4], "big") for frame in got]
    assert got == [frames[number] for number in numbers], "each frame is whole"
    assert numbers == sorted(set(numbers)), "in order, none twice"
    assert len(got) == counts.sent


def test_a_ground_station_that_leaves_does_not_stop_us(server: socket.socket) -> None:
    with Links.open([f"tcp:127.0.0.1:{port_of(server)}"]) as links:
        ground, _ = server.accept()
        ground.close()
        until(lambda: links.poll() or links.counts()[0][1].error)
        links.send(FRAME)
        ((_, counts),) = links.counts()
    assert counts.failed == 2
    assert "closed" in counts.error


# ---------------------------------------------------------------------------------------------------- serial


def test_serial_goes_both_ways() -> None:
    far, near = pty.openpty()
    with Links.open([f"serial:{os.ttyname(near)}:57600"]) as links:
        assert links.poll() == []
        links.send(FRAME)
        assert os.read(far, 1000) == FRAME
        os.write(far, FRAME)
        (heard,) = until(links.poll)
    assert heard.packet.value == Heartbeat(Health.ACTIVE, 6)
    os.close(near)
    os.close(far)


def test_a_serial_line_that_takes_nothing_drops_frames() -> None:
    far, near = pty.openpty()
    with Links.open([f"serial:{os.ttyname(near)}:57600"]) as links:
        for _ in range(10_000):
            links.send(FRAME)
        ((_, counts),) = links.counts()
    assert counts.dropped > 0
    assert counts.sent + counts.dropped == 10_000
    os.close(near)
    os.close(far)


def test_a_serial_device_that_is_pulled_out_does_not_stop_us() -> None:
    far, near = pty.openpty()
    name = os.ttyname(near)
    os.close(near)
    with Links.open([f"serial:{name}:57600"]) as links:
        os.close(far)
        for _ in range(3):
            links.send(FRAME)
            links.poll()
        ((_, counts),) = links.counts()
    assert counts.failed > 0
    assert counts.error


def test_a_serial_device_that_is_not_there_is_one_clear_line() -> None:
    with pytest.raises(LinkError, match="link 'serial:/dev/no-such:57600' cannot be opened: No such file or directory"):
        open_port("serial:/dev/no-such:57600")


def test_serial_without_its_package_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(ConfigError, match=r"pip install 'ross-payload\[serial\]'"):
        open_port("serial:/dev/ttyUSB0:57600")


# ---------------------------------------------------------------------------------------------------- all of them


def test_a_frame_goes_out_on_every_link(listener: socket.socket, server: socket.socket) -> None:
    with Links.open([f"udpout:127.0.0.1:{port_of(listener)}", f"tcp:127.0.0.1:{port_of(server)}"]) as links:
        ground, _ = server.accept()
        links.send(FRAME)
        with ground:
            assert listener.recv(1000) == ground.recv(1000) == FRAME


def test_no_link_is_opened_when_one_is_wrong(server: socket.socket) -> None:
    with pytest.raises(ConfigError, match="wanted udpin"):
        Links.open([f"tcp:127.0.0.1:{port_of(server)}", "carrier:pigeon"])
    server.settimeout(0.05)
    with pytest.raises(TimeoutError):
        server.accept()


def test_the_links_before_a_broken_one_are_closed_again(server: socket.socket) -> None:
    refused = free_port(socket.SOCK_STREAM)
    with pytest.raises(LinkError):
        Links.open([f"tcp:127.0.0.1:{port_of(server)}", f"tcp:127.0.0.1:{refused}"])
    ground, _ = server.accept()
    with ground:
        assert ground.recv(10) == b""


def test_closing_twice_is_closing_once(listener: socket.socket) -> None:
    links = Links.open([f"udpout:127.0.0.1:{port_of(listener)}"])
    links.close()
    links.close()
