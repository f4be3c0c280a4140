"""MAVLink over UDP: a port that hears everybody, or one that speaks to somebody."""

from __future__ import annotations

import asyncio
import socket
from typing import Any, NoReturn, cast

from ross_payload.ground.links.ports import HERE, MOST_WAITING, Health, Listener, Peer, cancelled, keep, words
from ross_protocols.address import Udp

BUFFER = 1 << 20  # of a socket [bytes]


class UdpListener(asyncio.DatagramProtocol):
    """A UDP port; a peer is an address that something came from."""

    def __init__(self, address: Udp, listener: Listener) -> None:
        self.health = Health()
        self._address = address
        self._listener = listener
        self._transport: asyncio.DatagramTransport | None = None

    async def open(self) -> None:
        """Listen."""
        where = self._address.host, self._address.port
        loop = asyncio.get_running_loop()
        self._transport, _ = await loop.create_datagram_endpoint(lambda: self, local_addr=where)
        _enlarge(self._transport)
        self.health.up = True

    def send(self, frame: bytes, peer: Any) -> None:
        """Send one datagram."""
        _send(self._transport, frame, peer)

    async def close(self) -> None:
        """Close the socket."""
        transport, self._transport = self._transport, None
        await _closed(transport)

    def datagram_received(self, data: bytes, addr: Any) -> None:
        """Pass on what came."""
        self.health.error = ""
        self._listener.came(addr, data)

    def error_received(self, exc: Exception) -> None:
        """Note that something could not be sent."""
        self.health.error = words(exc)


class UdpCaller(asyncio.DatagramProtocol):
    """Datagrams to and from one address, looked up again after every failure: hosts and networks move."""

    def __init__(self, address: Udp, listener: Listener) -> None:
        self.health = Health()
        self._address = address
        self._listener = listener
        self._transport: asyncio.DatagramTransport | None = None
        self._lost: asyncio.Future[None] | None = None
        self._task: asyncio.Task[NoReturn] | None = None

    async def open(self) -> None:
        """Begin to look up the host."""
        self._task = asyncio.create_task(keep(self.health, self._hold))

    def send(self, frame: bytes, peer: Peer) -> None:
        """Send one datagram."""
        _send(self._transport, frame, None)

    async def close(self) -> None:
        """Close the socket."""
        task, self._task = self._task, None
        await cancelled(task)

    def datagram_received(self, data: bytes, addr: Any) -> None:
        """Pass on what came."""
        self.health.up, self.health.error = True, ""
        self._listener.came(HERE, data)

    def error_received(self, exc: Exception) -> None:
        """Note that nobody listens there; begin anew after anything else."""
        self.health.up, self.health.error = False, words(exc)
        if not isinstance(exc, ConnectionRefusedError) and self._lost is not None and not self._lost.done():
            self._lost.set_exception(exc)

    async def _hold(self) -> None:
        loop = asyncio.get_running_loop()
        self._lost = loop.create_future()
        where = self._address.host, self._address.port
        self._transport, _ = await loop.create_datagram_endpoint(lambda: self, remote_addr=where)
        _enlarge(self._transport)
        self.health.up = True
        self._listener.met(HERE)
        try:
            await self._lost
        finally:
            transport, self._transport = self._transport, None
            self._listener.gone(HERE)
            await _closed(transport)


def _enlarge(transport: asyncio.DatagramTransport) -> None:
    """Let the system keep more for us, as far as it likes: payloads speak in bursts, and we may be busy."""
    transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER)


def _send(transport: asyncio.DatagramTransport | None, frame: bytes, peer: Any) -> None:
    if transport is not None and cast("asyncio.WriteTransport", transport).get_write_buffer_size() < MOST_WAITING:
        transport.sendto(frame, peer)


async def _closed(transport: asyncio.DatagramTransport | None) -> None:
    if transport is not None:
        transport.abort()
        await asyncio.sleep(0)  # the socket is closed in the next round of the loop
