"""The CAN bus between processes: python-can's own client, what is no frame, and clients that do not read."""

import asyncio
import socket
import struct
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress

import pytest

from manual import block, executed
from ross_payload.actuators.wires import open_wire
from ross_payload.clock import SystemClock
from ross_payload.errors import ConfigError, LinkError
from ross_payload.transport.link_url import tcp_endpoint
from ross_protocols.can import CanFrame
from ross_sim.devices.can_hub import MOST_CLIENTS, MOST_WAITING, CanHub
from waiting import wait_for

can = pytest.importorskip("can")
CLOCK = SystemClock()


class Running:
    """A hub on a thread of its own."""

    def __init__(self):
        self.hub = CanHub(CLOCK)
        self.port = 0
        self._up = threading.Event()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._live()))

    def start(self):
        self._thread.start()
        assert self._up.wait(10)

    def stop(self):
        with suppress(RuntimeError):  # it has stopped before
            self._loop.call_soon_threadsafe(self._ended.set)
        self._thread.join(10)

    async def _live(self):
        self._loop, self._ended = asyncio.get_running_loop(), asyncio.Event()
        await self.hub.serve("127.0.0.1", 0, self._told, self._ended)

    def _told(self, port):
        self.port = port
        self._up.set()


@pytest.fixture
def hub():
    running = Running()
    running.start()
    yield running
    running.stop()


@contextmanager
def client(hub, channel="can0"):
    port = open_wire(f"can:socketcand:127.0.0.1:{hub.port}:{channel}", CLOCK)
    try:
        port.send(CanFrame(0x7FF, b"", extended=False))  # its answers are read: it may be told frames
        yield port
    finally:
        port.close()


@contextmanager
def raw(hub):
    with socket.create_connection(("127.0.0.1", hub.port), 10) as connection:
        assert connection.recv(100) == b"< hi >"
        yield connection


def heard(port, wanted, seconds=10.0):
    """Receive until so many frames other than greetings are here."""
    frames, end = [], time.monotonic() + seconds
    while len(frames) < wanted:
        assert time.monotonic() < end, frames
        frames += [frame for frame in port.receive() if frame.id != 0x7FF]
        time.sleep(0.002)
    return frames


FRAMES = [CanFrame(0x1234567, b"abcdefgh"), CanFrame(0x123, b"\x00\x0f", extended=False), CanFrame(0x12, b"")]


def test_frames_reach_everybody_but_their_sender_whole_and_in_order(hub):
    with client(hub) as one, client(hub) as two, client(hub) as three:
        for frame in FRAMES:
            one.send(frame)
        assert heard(two, 3) == heard(three, 3) == FRAMES
        assert [frame for frame in one.receive() if frame.id != 0x7FF] == []


def test_the_program_of_the_guide_joins(hub):
    text = block("docs/how-to/simulate-devices.md", "python", "socketcand").text
    assert "port=29536" in text
    bus = executed(text.replace("29536", str(hub.port)))["bus"]
    try:
        with client(hub) as other:
            bus.send(can.Message(arbitration_id=1, data=b"b", is_extended_id=False))
            assert heard(other, 1) == [CanFrame(1, b"b", extended=False)]
            other.send(FRAMES[1])
            received = bus.recv(10)
        while received.arbitration_id == 0x7FF:  # the greeting of the other one
            received = bus.recv(10)
    finally:
        bus.shutdown()
    assert (received.arbitration_id, bytes(received.data)) == (0x123, b"\x00\x0f")


def test_channels_are_apart(hub):
    with client(hub, "left") as left, client(hub, "right") as right, client(hub, "left") as ear:
        right.send(CanFrame(1, b"r"))
        left.send(CanFrame(2, b"l"))
        assert heard(ear, 1) == [CanFrame(2, b"l")]


def test_it_tells_that_it_lives(hub):
    with raw(hub) as connection:
        connection.sendall(b"< echo >")
        assert connection.recv(100) == b"< echo >"


@pytest.mark.parametrize(
    "rubbish",
    [
        b"GET / HTTP/1.1\r\n\r\n>",
        b"< send 123 9 1 2 3 4 5 6 7 8 9 >",
        b"< send xyz 0 >",
        b"< send 12345678901 0 >",
        b"< send 123 2 1 >",
        b"< send 123 1 100 >",
        b"< send FFFFFFFF 0 >",
        b"< send 123 -1 >",
        "< open cän0 >".encode(),
        b"< open can1 >",
        b"\xff\x00>",
        b"<<>>",
        b"< send >",
    ],
)
def test_rubbish_reaches_nobody_and_its_sender_may_go_on(hub, rubbish):
    with raw(hub) as rude, client(hub) as ear:
        for word in (b"< open can0 >", b"< rawmode >"):
            rude.sendall(word)
            assert rude.recv(100) == b"< ok >"
        rude.sendall(rubbish + b"< send 123 2 1 FF >")
        assert heard(ear, 1) == [CanFrame(0x123, b"\x01\xff", extended=False)]
        assert hub.hub.refused >= 1


def test_a_word_without_an_end_is_hung_up_on_and_others_live(hub):
    with raw(hub) as rude, client(hub) as one, client(hub) as two:
        rude.sendall(b"<" + bytes(10_000))
        rude.settimeout(10)
        with suppress(ConnectionError):
            while rude.recv(100):
                pass
        one.send(CanFrame(5, b"x"))
        assert heard(two, 1) == [CanFrame(5, b"x")]


def test_who_does_not_read_is_dropped_and_the_others_lose_nothing(hub):
    with raw(hub) as deaf, client(hub) as one, client(hub) as two:
        deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        for word in (b"< open can0 >", b"< rawmode >"):
            deaf.sendall(word)
            assert deaf.recv(100) == b"< ok >"
        deaf.sendall(b"< send 7FF 0 >")
        sent, got = 0, []
        while not hub.hub.dropped:
            assert sent < 100 * MOST_WAITING / 40
            for _ in range(200):
                one.send(CanFrame(sent % 1000, b"12345678"))
                sent += 1
            got += heard(two, 200)
        assert [frame.id for frame in got] == [number % 1000 for number in range(sent)]


def test_a_hub_that_goes_is_said_and_one_that_is_not_there_too(hub):
    with client(hub) as port:
        hub.stop()
        with pytest.raises(LinkError, match="takes no frames"):
            for _ in range(1000):
                port.send(CanFrame(1, b"x"))
                time.sleep(0.001)
    begin = time.monotonic()
    with pytest.raises(LinkError, match="cannot join the bus"):
        open_wire(f"can:socketcand:127.0.0.1:{hub.port}", CLOCK)
    assert time.monotonic() - begin < 5


def test_a_hub_that_dies_is_said_in_one_line_without_a_traceback():
    """python-can puts one into its error, which the operator was then told."""
    with socket.create_server(("127.0.0.1", 0)) as server, ThreadPoolExecutor() as dying:
        url = f"can:socketcand:127.0.0.1:{server.getsockname()[1]}:can0"
        died = dying.submit(die, server)
        port = open_wire(url, CLOCK)
        died.result(10)
        with pytest.raises(LinkError) as told:
            wait_for(port.receive)
        port.close()
    assert str(told.value) == f"wire '{url}' is down: Connection reset by peer"


def die(server):
    """Greet those who join, let one in, and reset the connection as a program does that is killed."""
    with server.accept()[0] as probe:
        probe.sendall(b"< hi >")
        client, _ = server.accept()
    client.sendall(b"< hi >")
    for _ in ("open", "rawmode"):
        client.recv(100)
        client.sendall(b"< ok >")
    client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    client.close()


@pytest.mark.parametrize("rest", ["", "127.0.0.1", "127.0.0.1:0", "127.0.0.1:99999", "127.0.0.1:1:a b"])
def test_a_wrong_address_of_a_hub_says_what_was_wanted(rest):
    with pytest.raises(ConfigError, match=r"expected can:socketcand:HOST:PORT"):
        open_wire(f"can:socketcand:{rest}", CLOCK)


@pytest.mark.parametrize("text", ["tcp:127.0.0.1", "udp:127.0.0.1:1", "tcp:127.0.0.1:99999", "tcp::5", ""])
def test_a_wrong_address_to_listen_on_says_what_was_wanted(text):
    with pytest.raises(ConfigError, match="expected tcp:HOST:PORT"):
        tcp_endpoint(text, "--listen", min_port=0)


def test_nodes_of_the_package_dronecan_meet_there(hub):
    dronecan = pytest.importorskip("dronecan")
    can_bus = pytest.importorskip("can")
    options = {"host": "127.0.0.1", "port": hub.port, "tcp_tune": True}
    with can_bus.Bus("can0", "socketcand", ignore_config=True, **options) as theirs, client(hub) as ours:
        payload = dronecan.uavcan.protocol.NodeStatus(uptime_sec=7)
        transfer = dronecan.transport.Transfer(3, source_node_id=50, payload=payload)
        for frame in transfer.to_frames():
            theirs.send(can_bus.Message(arbitration_id=frame.message_id, data=frame.bytes, is_extended_id=True))
        (frame,) = heard(ours, 1)
        back = dronecan.transport.Transfer()
        back.from_frames([dronecan.transport.Frame(frame.id, frame.data)])
        assert back.payload.uptime_sec == 7


def test_a_master_of_the_package_canopen_reads_an_object_there(hub):
    """The other node is three lines of expedited upload."""
    canopen = pytest.importorskip("canopen")
    network = canopen.Network()
    network.connect(interface="socketcand", channel="can0", host="127.0.0.1", port=hub.port, tcp_tune=True)
    done = threading.Event()

    def answer(node):
        while not done.is_set():
            for frame in node.receive():
                if frame.id == 0x605:
                    node.send(CanFrame(0x585, b"\x43" + frame.data[1:4] + b"\x92\x01\x02\x00", extended=False))
            time.sleep(0.002)

    with client(hub) as node:
        thread = threading.Thread(target=answer, args=(node,))
        thread.start()
        try:
            remote = network.add_node(5, canopen.ObjectDictionary())
            remote.sdo.RESPONSE_TIMEOUT = 5.0
            assert remote.sdo.upload(0x1000, 0) == b"\x92\x01\x02\x00"
        finally:
            done.set()
            thread.join()
            network.disconnect()


def test_a_client_too_many_is_refused_aloud_and_the_others_go_on(hub, caplog):
    with client(hub) as one, client(hub) as other:
        crowd = [socket.create_connection(("127.0.0.1", hub.port), 10) for _ in range(MOST_CLIENTS - 2)]
        for each in crowd:
            assert each.recv(100) == b"< hi >"
        for _ in range(3):
            with socket.create_connection(("127.0.0.1", hub.port), 10) as late:
                late.settimeout(10)
                said = b"".join(iter(lambda late=late: late.recv(100), b""))
                assert said == b"< error clients: expected at most 64, got one more >"
        lines = [entry.getMessage() for entry in caplog.records]
        assert lines[0] == "clients: expected at most 64, got one more: refused"
        one.send(CanFrame(0x123, b"ab"))
        assert heard(other, 1) == [CanFrame(0x123, b"ab")]
        for each in crowd:
            each.close()
        end = time.monotonic() + 10
        while not _is_welcome(hub):
            assert time.monotonic() < end, "the place of a client that has gone is never free"


def _is_welcome(hub):
    with socket.create_connection(("127.0.0.1", hub.port), 10) as again:
        return again.recv(100) == b"< hi >"


def test_a_client_that_has_gone_is_sent_nothing_and_fills_no_log(hub, caplog):
    held, going = threading.Event(), threading.Event()

    def hold():
        held.set()
        going.wait(10)

    with joined(hub) as speaker, joined(hub) as gone:
        gone.sendall(b"< send 123 1 00 >")
        told(speaker, b"frame 123")
        hub._loop.call_soon_threadsafe(hold)
        assert held.wait(10)
        speaker.sendall(b"< send 123 1 00 >" * 20)
        gone.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        gone.close()  # at once, as when a process dies
        going.set()
        with joined(hub) as late:
            speaker.sendall(b"< send 124 1 00 >")
            late.sendall(b"< send 125 1 00 >")
            told(speaker, b"frame 125")
    assert [record.message for record in caplog.records if record.name == "asyncio"] == []


def told(sock, word):
    heard = b""
    while word not in heard:
        heard += sock.recv(4096)


@contextmanager
def joined(hub):
    with socket.create_connection(("127.0.0.1", hub.port), 10) as sock:
        sock.sendall(b"< open can0 >< rawmode >")
        heard = b""
        while heard.count(b"< ok >") < 2:
            heard += sock.recv(4096)
        sock.sendall(b"< send 7ff 1 00 >")  # from now on it listens
        yield sock
