"""MAVLink over TCP: a client that connects again and again, and a server for many clients."""

from __future__ import annotations

import asyncio
import socket
from contextlib import suppress
from itertools import count
from typing import NoReturn, cast

from ross_payload.ground.links.ports import HERE, MOST_WAITING, Health, Listener, Peer, cancelled, keep
from ross_protocols.address import Tcp

CONNECT_TIMEOUT = 2.0  # [s]: the second try of the system is in it; with the pause after it less than 3 s
VANISHED = 3  # after so long without an answer the other side is taken for gone [s]
AT_ONCE = 8192  # bytes that are read in one go: a flood lets others have their turn
MOST_CLIENTS = 128


class Connection(asyncio.BufferedProtocol):
    """One TCP connection among those of its port; ``lost`` is done when it has ended."""

    def __init__(self, peer: Peer, crowd: dict[Peer, Connection], listener: Listener) -> None:
        self.lost: asyncio.Future[Exception | None] = asyncio.get_running_loop().create_future()
        self._peer = peer
        self._crowd = crowd
        self._listener = listener
        self._buffer = bytearray(AT_ONCE)
        self._transport: asyncio.Transport | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Enter the crowd, if it has room."""
        self._transport = cast("asyncio.Transport", transport)
        if len(self._crowd) >= MOST_CLIENTS:
            self._transport.abort()
            return
        _prepare(transport.get_extra_info("socket"))
        self._crowd[self._peer] = self
        self._listener.met(self._peer)

    def get_buffer(self, sizehint: int) -> bytearray:
        """Say where to read to."""
        return self._buffer

    def buffer_updated(self, nbytes: int) -> None:
        """Pass on what came."""
        self._listener.came(self._peer, bytes(self._buffer[:nbytes]))

    def connection_lost(self, exc: Exception | None) -> None:
        """Leave the crowd."""
        if self._crowd.pop(self._peer, None) is not None:
            self._listener.gone(self._peer)
        if not self.lost.done():
            self.lost.set_result(exc)

    def send(self, frame: bytes) -> None:
        """Send one frame, whole, or drop it when too much waits already."""
        if self._transport is not None and self._transport.get_write_buffer_size() < MOST_WAITING:
            self._transport.write(frame)

    async def end(self) -> None:
        """Close it now."""
        if self._transport is not None:
            self._transport.abort()
            await self.lost


class TcpCaller:
    """A client; it tries the addresses of its host one after the other, one per attempt."""

    def __init__(self, address: Tcp, listener: Listener) -> None:
        self.health = Health()
        self._address = address
        self._listener = listener
        self._crowd: dict[Peer, Connection] = {}
        self._attempts = 0
        self._task: asyncio.Task[NoReturn] | None = None

    async def open(self) -> None:
        """Begin to connect."""
        self._task = asyncio.create_task(keep(self.health, self._hold))

    def send(self, frame: bytes, peer: Peer) -> None:
        """Send one frame, if there is a connection."""
        if HERE in self._crowd:
            self._crowd[HERE].send(frame)

    async def close(self) -> None:
        """Close the connection."""
        task, self._task = self._task, None
        await cancelled(task)

    async def _hold(self) -> None:
        connection = await self._connected()
        self.health.up, self.health.error = True, ""
        try:
            error = await asyncio.shield(connection.lost)
        finally:
            await connection.end()
        raise error or ConnectionResetError(0, "the other side closed the connection")

    async def _connected(self) -> Connection:
        loop = asyncio.get_running_loop()
        try:
            async with asyncio.timeout(CONNECT_TIMEOUT):
                sock = await self._socket()
        except TimeoutError as error:
            raise TimeoutError(0, "no answer") from error
        _, connection = await loop.create_connection(lambda: Connection(HERE, self._crowd, self._listener), sock=sock)
        return connection

    async def _socket(self) -> socket.socket:
        loop = asyncio.get_running_loop()
        choices = await loop.getaddrinfo(self._address.host, self._address.port, type=socket.SOCK_STREAM)
        family, kind, protocol, _, where = choices[self._attempts % len(choices)]
        self._attempts += 1
        sock = socket.socket(family, kind, protocol)
        try:
            sock.setblocking(False)
            await loop.sock_connect(sock, where)
        except BaseException:
            sock.close()
            raise
        return sock


class TcpListener:
    """A server; a peer is the number of a connection."""

    def __init__(self, address: Tcp, listener: Listener) -> None:
        self.health = Health()
        self._address = address
        self._listener = listener
        self._crowd: dict[Peer, Connection] = {}
        self._numbers = count(1)
        self._server: asyncio.Server | None = None

    async def open(self) -> None:
        """Listen."""
        loop = asyncio.get_running_loop()
        self._server = await loop.create_server(
            lambda: Connection(next(self._numbers), self._crowd, self._listener),
            self._address.host,
            self._address.port,
        )
        self.health.up = True

    def send(self, frame: bytes, peer: Peer) -> None:
        """Send one frame to a client, if it is still there."""
        if peer in self._crowd:
            self._crowd[peer].send(frame)

    async def close(self) -> None:
        """Close the port and every connection."""
        server, self._server = self._server, None
        if server is not None:
            server.close()
            for connection in tuple(self._crowd.values()):
                await connection.end()
            await server.wait_closed()


def _prepare(sock: socket.socket) -> None:
    """Make a connection prompt, and quick to notice that the other side has vanished."""
    with suppress(OSError):  # it has ended meanwhile
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, VANISHED)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPINTVL, 1)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, 1000 * VANISHED)
