"""MAVLink over TCP: a client that connects without waiting, and a server for several clients."""

from __future__ import annotations

import errno
import os
import select
import socket
from collections import Counter
from collections.abc import Collection
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from itertools import count
from typing import Any

from ross_payload.links.address import Tcp
from ross_payload.links.background import begin
from ross_payload.links.ports import MOST, PEERS, WAITING, Counts, Peer
from ross_payload.links.stream import Stream
from ross_protocols.codec import Framer

CONNECT_TIMEOUT = 3.0  # [s]
LEAST = 128  # that one client may say in one call [bytes]
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
                raise TimeoutError(0, "no answer")
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


@dataclass(eq=False, slots=True)
class _Client:
    """One connection to a server."""

    descriptor: int
    stream: Stream
    host: str
    since: float  # when it was first looked at [s]
    framer: Framer = field(default_factory=Framer)
    admitted: bool = False


class TcpServer:
    """A listening port that talks to several clients; each has its own stream.

    Clients are in the order in which they were admitted or heard; those not admitted come and go among themselves.
    """

    connected = True

    def __init__(self, sock: socket.socket) -> None:
        self._socket = sock
        self._news = select.poll()
        self._news.register(sock, select.POLLIN)
        self._clients: dict[int, _Client] = {}  # by their number
        self._numbers = count(1)
        self._admission = False
        self.counts = Counts()

    def require_admission(self) -> None:
        """Send to admitted clients only."""
        self._admission = True

    def send(self, frame: bytes) -> None:
        """Send one frame to every client that is answered and can take it."""
        for number, client in tuple(self._clients.items()):
            if self._admission and not client.admitted:
                continue
            try:
                taken = client.stream.send(frame)
            except OSError as error:
                self._lose(number, error.strerror or str(error))
                continue
            field = "sent" if taken else "dropped"
            self.counts = replace(self.counts, **{field: getattr(self.counts, field) + 1})

    def receive(self) -> list[bytes]:
        """Return the frames that clients have completed; let new clients in."""
        arrivals = self.receive_from(0.0, ())
        for number, _ in arrivals:
            self.admit(number)
        frames = (self._clients[number].framer.whole(data) for number, data in arrivals)
        return [whole for whole in frames if whole]

    def receive_from(self, now: float, busy: Collection[Peer]) -> list[tuple[Peer, bytes]]:
        """Return what clients have sent since the last call; let new clients in."""
        ready = {descriptor for descriptor, _ in self._news.poll(0)}
        if self._socket.fileno() in ready:
            ready |= self._accept(now)
        share = max(MOST // max(len(ready), 1), LEAST)
        arrivals = [
            (number, data)
            for number in tuple(self._clients)
            if number not in busy and (data := self._read(number, share, ready))
        ]
        self.counts = replace(self.counts, received=self.counts.received + sum(len(data) for _, data in arrivals))
        return arrivals

    def admit(self, peer: Peer) -> None:
        """Answer a client; when there are too many, the one unheard for longest has to go."""
        client = self._clients.pop(peer, None)
        if client is None:  # it has left
            return
        client.admitted = True
        self._clients[peer] = client
        admitted = [number for number, each in self._clients.items() if each.admitted]
        if len(admitted) > PEERS:
            self._lose(admitted[0], "too many clients")

    def expire(self, patience: float, now: float) -> None:
        """Close the connections that were not admitted within ``patience`` [s]."""
        late = [n for n, client in self._clients.items() if not client.admitted and now - client.since > patience]
        for number in late:
            self._lose(number, f"a client has sent nothing signed with the key within {patience:g} s")

    def close(self) -> None:
        """Close the port and every connection."""
        self._socket.close()
        for client in self._clients.values():
            client.stream.close()
        self._clients = {}

    def _accept(self, now: float) -> set[int]:
        """Let new clients in; return their file descriptors: what they have said may be here already."""
        found: set[int] = set()
        for _ in range(PEERS):
            try:
                sock, (host, *_) = self._socket.accept()
            except OSError:  # nobody, or somebody who has left again
                break
            stream = Stream(prepared(sock), empty_is_end=True)
            self._clients[next(self._numbers)] = _Client(sock.fileno(), stream, host, now)
            self._news.register(sock, select.POLLIN)
            found.add(sock.fileno())
            self._make_room()
        return found

    def _make_room(self) -> None:
        """Close the oldest connection that is not admitted, of the host that has the most of them, when it is full."""
        waiting = [(number, client.host) for number, client in self._clients.items() if not client.admitted]
        if len(waiting) <= WAITING if self._admission else len(self._clients) <= PEERS:
            return
        of_host = Counter(host for _, host in waiting)
        number, _ = max(waiting, key=lambda each: of_host[each[1]])  # the first of the largest is the oldest
        self._lose(number, "too many clients")
        self.counts = replace(self.counts, refused=self.counts.refused + 1)

    def _read(self, number: int, most: int, ready: Collection[int]) -> bytes:
        client = self._clients[number]
        try:
            client.stream.flush()
            return client.stream.read(most) if client.descriptor in ready else b""
        except OSError as error:
            self._lose(number, error.strerror or str(error))
            return b""

    def _lose(self, number: int, why: str) -> None:
        client = self._clients.pop(number)
        self._news.unregister(client.descriptor)
        client.stream.close()
        self.counts = replace(self.counts, error=why)


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
