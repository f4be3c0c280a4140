"""Who holds a connection to the page: half-open ones give way, and nobody who is let in is cut for them."""

import asyncio
import socket
import ssl
from contextlib import asynccontextmanager, contextmanager, suppress

import pytest

from ground_page import browser, page
from hand_station import HandStation
from ross_payload.ground.web.connections import Connections, raise_descriptor_limit

HALF = b"GET / HTTP/1.1\r\nHost: here\r\nX-Slow: "
WAIT = 20.0  # [s] for what must come


class Server(asyncio.Protocol):
    """Lets in whoever says so; sockets and downloads go on for ever."""

    def __init__(self, connections):
        self.connections = connections

    def connection_made(self, transport):
        self.transport = transport

    def data_received(self, data):
        if data.startswith(b"let me in"):
            with self.connections.answering(self):
                self.transport.write(b"yes")
        elif data.startswith((b"socket", b"download")):
            self.held = self.connections.answering(self, lasting=data.startswith(b"socket"))
            self.held.__enter__()  # it is never answered to its end
            self.transport.write(b"yes")


@asynccontextmanager
async def served(tls=None, **limits):
    """Connections that are accepted, and what makes one, which is closed in the end."""
    connections = Connections(**limits)
    listener = socket.create_server(("127.0.0.1", 0))
    with listener, connections.accepted(listener, lambda: Server(connections), tls):
        async with crowd(listener.getsockname()) as connected:
            yield connections, connected
        async with asyncio.timeout(WAIT):
            while len(connections):
                await asyncio.sleep(0.01)


@asynccontextmanager
async def crowd(place):
    """Yield what connects to a place; all of it is closed in the end."""
    clients = []

    async def connected(source="127.0.0.1"):
        clients.append(Client(*await asyncio.open_connection(*place, local_addr=(source, 0))))
        return clients[-1]

    try:
        yield connected
    finally:
        for client in clients:
            client.writer.transport.abort()
        for client in clients:
            with suppress(OSError):
                await client.writer.wait_closed()


class Client:
    """One connection."""

    def __init__(self, reader, writer):
        self.reader, self.writer = reader, writer

    async def ask(self, words):
        self.writer.write(words)
        async with asyncio.timeout(WAIT):
            return await self.reader.read(3)

    async def is_cut(self):
        """Wait until it is."""
        async with asyncio.timeout(WAIT):
            try:
                return await self.reader.read() is not None
            except ConnectionResetError:
                return True

    @property
    def is_open(self):
        return not self.reader.at_eof() and self.reader.exception() is None


async def test_the_oldest_half_open_one_gives_way_first():
    async with served(most=20, most_per_address=20) as (connections, connected):
        inside = await connected()
        assert await inside.ask(b"let me in") == b"yes"
        first = await connected()
        for _ in range(30):
            await connected()
        assert await first.is_cut()
        assert await inside.ask(b"let me in") == b"yes"
        newest = await connected()
        assert await newest.ask(b"let me in") == b"yes"
        assert len(connections) <= 20


async def test_idle_ones_give_way_before_downloads_and_a_web_socket_never():
    async with served(most=18, most_per_address=18) as (_, connected):
        live, download, idle = [await connected() for _ in range(3)]
        assert await live.ask(b"socket") == b"yes"
        assert await download.ask(b"download") == b"yes"
        assert await idle.ask(b"let me in") == b"yes"
        for _ in range(16):
            assert await (await connected()).ask(b"socket") == b"yes"
        assert await idle.is_cut()
        assert download.is_open
        assert await (await connected()).ask(b"socket") == b"yes"
        assert await download.is_cut()
        assert live.is_open


async def test_one_address_makes_room_among_its_own():
    async with served(most=40, most_per_address=20) as (connections, connected):
        honest = await connected("127.0.0.2")
        flood = [await connected() for _ in range(60)]
        assert await flood[0].is_cut()
        assert await honest.ask(b"let me in") == b"yes"
        assert len(connections) <= 21


@pytest.mark.parametrize("trickles", [False, True])
async def test_a_header_that_does_not_come_to_its_end_is_cut(trickles):
    async with served(header_timeout=0.5) as (connections, connected):
        slow = await connected()
        start = asyncio.get_running_loop().time()
        while trickles and not slow.reader.at_eof() and slow.reader.exception() is None:
            slow.writer.write(b"x")
            await asyncio.sleep(0.05)
        assert await slow.is_cut()
        assert 0.4 < asyncio.get_running_loop().time() - start < WAIT
        assert len(connections) == 0


@pytest.mark.parametrize("limits", [{"header_timeout": 0.3}, {"most": 16, "most_per_address": 16}])
async def test_a_handshake_that_does_not_begin_gives_way_too(limits):
    async with served(ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER), **limits) as (connections, connected):
        silent = [await connected() for _ in range(40)]
        assert await silent[0].is_cut()
        nonsense = await connected()
        nonsense.writer.write(b"GET / HTTP/1.1\r\n\r\n")
        assert await nonsense.is_cut()
        assert len(connections) <= 40


async def test_whoever_is_let_in_outlives_the_time_for_headers():
    async with served(header_timeout=0.2) as (_, connected):
        inside, slow = await connected(), await connected()
        assert await inside.ask(b"let me in") == b"yes"
        assert await slow.is_cut()
        assert await inside.ask(b"let me in") == b"yes"


async def test_a_browser_that_watches_keeps_its_socket_in_a_flood_of_half_open_requests():
    with descriptors(2000):
        async with page(HandStation()) as here, browser(here.url) as one:
            await one.next("hello")
            async with crowd(("127.0.0.1", int(here.url.rstrip("/").rpartition(":")[2]))) as connected:
                flood = [await connected() for _ in range(700)]
                for each in flood:
                    each.writer.write(HALF)
                assert await flood[0].is_cut()
                await one.say(type="watch", id="no")
                await one.next("refused")
                async with browser(here.url) as other:
                    await other.next("hello")


@contextmanager
def descriptors(wanted):
    if raise_descriptor_limit() < wanted:
        pytest.skip(f"needs {wanted} descriptors")
    yield
