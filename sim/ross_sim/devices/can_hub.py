"""A CAN bus between processes, without a kernel driver: a server that speaks the protocol of socketcand.

A client gets ``< hi >``, opens a channel and asks for raw mode; then what one sends, all others on its channel hear.
What a client says that is no frame is counted and otherwise left alone: python-can takes any answer for a frame.
"""

from __future__ import annotations

import asyncio
import logging
import re
import socket
from collections.abc import Callable
from contextlib import suppress

from ross_payload.errors import LinkError, refused_as
from ross_payload.interfaces import Clock
from ross_protocols.can import MOST_DATA

LONGEST = 4096  # that a client may say without an end [bytes]
MOST_WAITING = 262_144  # for a client that does not read [bytes]
MOST_CLIENTS = 64  # a bus has no more nodes, and every client takes one of this process's descriptors
LOUD = 1.0  # [s] between two lines of the log about clients that were refused
QUIET = 0.1  # [s] after raw mode is granted, so that its answer is read alone; ends with the client's first frame
log = logging.getLogger(__name__)
_CHANNEL = re.compile(r"[A-Za-z0-9_.-]{1,16}")
_NUMBER = re.compile(r"[0-9A-Fa-f]{1,8}")


class CanHub:
    """All channels and who is on them; everything happens on one event loop."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._clients: set[_Client] = set()
        self.refused = 0  # what was no frame
        self.dropped = 0  # clients that did not read
        self._loud_at = -LOUD  # when the log was told of a refused client [s]

    async def serve(self, host: str, port: int, on_port: Callable[[int], None], ended: asyncio.Event) -> None:
        """Serve until ``ended``; ``on_port`` is called with the port.

        Raises
        ------
        LinkError
            When the address cannot be listened on.
        """
        with refused_as(LinkError, f"tcp:{host}:{port}: cannot listen"):
            server = await asyncio.start_server(self._attend, host, port, limit=LONGEST)
        async with server:
            on_port(server.sockets[0].getsockname()[1])
            await ended.wait()
            for client in self._clients:
                client.writer.transport.abort()
            while self._clients:
                await asyncio.sleep(0)

    async def _attend(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if len(self._clients) >= MOST_CLIENTS:
            await self._turn_away(writer)
            return
        client = _Client(writer)
        writer.get_extra_info("socket").setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._clients.add(client)
        client.send("< hi >")
        try:
            while True:
                line = await reader.readuntil(b">")
                self._obey(client, line)
        except (asyncio.IncompleteReadError, asyncio.LimitOverrunError, OSError):  # gone, or never ends a word
            pass
        finally:
            self._clients.discard(client)
            writer.close()
            with suppress(OSError):
                await writer.wait_closed()

    async def _turn_away(self, writer: asyncio.StreamWriter) -> None:
        """Refuse a client, and say so to it and in the log."""
        words = f"clients: expected at most {MOST_CLIENTS}, got one more"
        if self._clock.now() >= self._loud_at + LOUD:
            self._loud_at = self._clock.now()
            log.warning("%s: refused", words)
        writer.write(f"< error {words} >".encode("ascii"))
        writer.close()
        with suppress(OSError):
            await writer.wait_closed()

    def _obey(self, client: _Client, line: bytes) -> None:
        match line.decode("ascii", "replace").strip().removeprefix("<").removesuffix(">").split():
            case ["open", channel] if _CHANNEL.fullmatch(channel) and not client.channel:
                client.channel = channel
                client.send("< ok >")
            case ["rawmode"] if client.channel and not client.raw:
                client.raw, client.listens = True, self._clock.now() + QUIET
                client.send("< ok >")
            case ["echo"]:
                client.send("< echo >")
            case ["send", number, length, *data] if client.raw:
                self._carry(client, number, length, data)
            case _:
                self._refuse(client)

    def _carry(self, client: _Client, number: str, length: str, data: list[str]) -> None:
        payload = _payload(length, data)
        if payload is None or not _is_identifier(number):
            self._refuse(client)
            return
        now = self._clock.now()
        client.listens = now  # it has read our answers
        frame = f"< frame {number} {now:.6f} {payload.hex()} >"
        for other in tuple(self._clients):
            if other is not client and other.channel == client.channel and other.raw and now >= other.listens:
                self.dropped += not other.send(frame)

    def _refuse(self, client: _Client) -> None:
        self.refused += 1
        if not client.raw:
            client.send("< error unknown command >")


class _Client:
    """One connection."""

    def __init__(self, writer: asyncio.StreamWriter) -> None:
        self.writer = writer
        self.channel = ""
        self.raw = False
        self.listens = 0.0  # from when on it may be told frames [s]

    def send(self, text: str) -> bool:
        """Send a word; hang up on a client that does not read, and return False."""
        if self.writer.transport.is_closing():  # it has gone: nobody waits for it
            return True
        if self.writer.transport.get_write_buffer_size() > MOST_WAITING:
            self.writer.transport.abort()
            return False
        self.writer.write(text.encode("ascii"))
        return True


def _is_identifier(number: str) -> bool:
    """Tell whether hexadecimal digits are an identifier: three for 11 bits, eight for 29."""
    if len(number) not in (3, 8) or not _NUMBER.fullmatch(number):
        return False
    return int(number, 16) < 2 ** (11 if len(number) == 3 else 29)


def _payload(length: str, data: list[str]) -> bytes | None:
    """Return the data of a frame; None when it is none."""
    if not all(_NUMBER.fullmatch(byte) and len(byte) <= 2 for byte in data):
        return None
    right = _NUMBER.fullmatch(length) and int(length, 16) == len(data) <= MOST_DATA
    return bytes(int(byte, 16) for byte in data) if right else None
