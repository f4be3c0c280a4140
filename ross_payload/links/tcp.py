"""MAVLink over TCP: a client that connects without waiting, and a server for several clients."""

from __future__ import annotations

import errno
import os
import select
import socket
from concurrent.futures import Future
from dataclasses import replace
from typing import Any

from ross_payload.links.address import Tcp
from ross_payload.links.background import begin
from ross_payload.links.ports import MOST, PEERS, Counts
from ross_payload.links.stream import Stream
from ross_protocols.codec import Framer

CONNECT_TIMEOUT = 3.0  # [s]
SILENCE = 10  # after which the other side is asked whether it is still there [s]
IN_PROGRESS = (0, errno.EAGAIN, errno.EINPROGRESS)


class TcpOpener:
    """Connects to a server: looks it up, then tries its addresses one after the other, one per attempt."""

    empty_is_end = True
    baud = 0

    def __init__(self, address: Tcp) -> None:
        self._address = address
        self._lookup: Future[list[Any]] | None = None
        self._attempts = 0
        self._socket: socket.socket | None = None
        self._deadline = 0.0

    def poll(self, now: float) -> socket.socket | None:
        """Return the socket when it is connected, None while that takes longer.

        Raises
        ------
        OSError
            When there is nobody to connect to.
        """
        if self._socket is None:
            self._start(now)
            return None
        try:
            done = _connected(self._socket)
            if not done and now > self._deadline:
                raise TimeoutError(0, "nobody answers")
        except OSError:
            self.close()
            raise
        if not done:
            return None
        sock, self._socket = self._socket, None
        return sock

    def close(self) -> None:
        """Give up the attempt."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _start(self, now: float) -> None:
        where = self._address.host, self._address.port
        if self._lookup is None:
            self._lookup = begin(lambda: socket.getaddrinfo(*where, type=socket.SOCK_STREAM))
        if not self._lookup.done():
            return
        lookup, self._lookup = self._lookup, None  # looked up again for every attempt: hosts move
        choices = lookup.result()
        family, kind, protocol, _, address = choices[self._attempts % len(choices)]
        self._attempts += 1
        self._socket = prepared(socket.socket(family, kind, protocol))
        self._deadline = now + CONNECT_TIMEOUT
        error = self._socket.connect_ex(address)
        if error not in IN_PROGRESS:
            self.close()
            raise OSError(error, os.strerror(error))


class TcpServer:
    """A listening port that talks to several clients; each has its own stream."""

    def __init__(self, sock: socket.socket) -> None:
        self._socket = sock
        self._news = select.poll()
        self._news.register(sock, select.POLLIN)
        self._clients: list[tuple[Stream, Framer]] = []
        self.counts = Counts()

    def send(self, frame: bytes) -> None:
        """Send one frame to every client that can take it."""
        for client in tuple(self._clients):
            try:
                taken = client[0].send(frame)
            except OSError as error:
                self._lose(client, error)
                continue
            field = "sent" if taken else "dropped"
            self.counts = replace(self.counts, **{field: getattr(self.counts, field) + 1})

    def receive(self) -> list[bytes]:
        """Return the frames that clients have completed; let new clients in."""
        if self._news.poll(0):
            self._accept()
        pieces = [piece for client in tuple(self._clients) if (piece := self._read(client))]
        if not pieces:
            return []
        self.counts = replace(self.counts, received=self.counts.received + sum(map(len, pieces)))
        return pieces

    def close(self) -> None:
        """Close the port and every connection."""
        self._socket.close()
        for stream, _ in self._clients:
            stream.close()
        self._clients = []

    def _accept(self) -> None:
        for _ in range(PEERS):
            try:
                sock, _ = self._socket.accept()
            except OSError:  # nobody, or somebody who has left again
                return
            if len(self._clients) >= PEERS:
                sock.close()
                self.counts = replace(self.counts, refused=self.counts.refused + 1)
            else:
                self._clients.append((Stream(prepared(sock), empty_is_end=True), Framer()))

    def _read(self, client: tuple[Stream, Framer]) -> bytes:
        stream, framer = client
        try:
            stream.flush()
            return framer.whole(stream.read(MOST // len(self._clients)))
        except OSError as error:
            self._lose(client, error)
            return b""

    def _lose(self, client: tuple[Stream, Framer], error: OSError) -> None:
        client[0].close()
        self._clients.remove(client)
        self.counts = replace(self.counts, error=error.strerror or str(error))


def open_server(address: Tcp) -> TcpServer:
    """Listen on a TCP port.

    Raises
    ------
    OSError
        When the system refuses.
    """
    family, _, _, _, where = socket.getaddrinfo(address.host, address.port, type=socket.SOCK_STREAM)[0]
    sock = socket.create_server(where[:2], family=family)
    sock.setblocking(False)
    return TcpServer(sock)


def prepared(sock: socket.socket) -> socket.socket:
    """Make a TCP socket prompt, and quick to notice that the other side has vanished."""
    sock.setblocking(False)
    sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, SILENCE)
    sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPINTVL, SILENCE // 2)
    sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, 2000 * SILENCE)
    return sock


def _connected(sock: socket.socket) -> bool:
    waiting = select.poll()
    waiting.register(sock, select.POLLOUT)
    if not waiting.poll(0):
        return False
    error = sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
    if error:
        raise OSError(error, os.strerror(error))  # becomes a ConnectionRefusedError where it is one
    return True
