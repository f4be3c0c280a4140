"""TCP: a client that connects without waiting, and a server for several clients."""

from __future__ import annotations

import errno
import os
import select
import socket
from collections import Counter
from collections.abc import Collection, Sequence
from concurrent.futures import Future
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field, replace
from itertools import count
from typing import Any

from ross_payload.errors import reason
from ross_payload.transport import ports
from ross_payload.transport.async_task import begin
from ross_payload.transport.byte_stream import Stream
from ross_payload.transport.link_url import Tcp
from ross_protocols.mavlink.codec import Framer

MIN_READ_BYTES = 128  # of one client in one call
ACCEPTED_AT_ONCE = 16  # clients, in one call
ACCEPT_PAUSE_S = 1.0  # when the system has no descriptor left for another client
IN_PROGRESS = (0, errno.EAGAIN, errno.EINPROGRESS)
EXHAUSTED = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)


class TcpOpener:
    """Connects to a server: looks it up, then tries its addresses one after the other, one per attempt."""

    empty_is_end = True
    baud = 0
    progress = ""

    def __init__(self, address: Tcp, options: ports.PortOptions = ports.DEFAULTS) -> None:
        self._address = address
        self._options = options
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
        self._socket = prepared(socket.socket(family, kind, protocol), self._options)
        self._deadline = now + self._options.connect_timeout_s
        error = self._socket.connect_ex(address)
        if error not in IN_PROGRESS:
            self.close()
            raise OSError(error, os.strerror(error))


@dataclass(eq=False, slots=True)
class _Client:
    """One connection to a server."""

    stream: Stream
    host: str
    since: float  # when it was first looked at [s]
    framer: Framer = field(default_factory=Framer)
    admitted: bool = False


class TcpServer:
    """A port that listens and talks to several clients; each has its own stream.

    Clients are in the order in which they were admitted or heard; those not admitted come and go among themselves.
    """

    connected = True

    def __init__(self, listeners: Sequence[socket.socket], options: ports.PortOptions = ports.DEFAULTS) -> None:
        self._listeners = {sock.fileno(): sock for sock in listeners}
        self._options = options
        self._events = select.epoll()
        self._accept_at = 0.0  # [s]
        self._accepting = False
        self._clients: dict[int, _Client] = {}  # by their number
        self._numbers = count(1)
        self._admission = False
        self.counts = ports.Counts()
        self._set_accepting(True)

    @property
    def clients(self) -> tuple[ports.Peer, ...]:
        """The clients that are connected."""
        return tuple(self._clients)

    def fileno(self) -> int:
        """Return a descriptor that is readable when a client has come, or something of one."""
        return self._events.fileno()

    def host_of(self, peer: ports.Peer) -> str:
        """Return the address of a client; empty: it is gone."""
        client = self._clients.get(peer) if isinstance(peer, int) else None
        return "" if client is None else client.host

    def require_admission(self) -> None:
        """Send to admitted clients only."""
        self._admission = True

    def send(self, frame: bytes) -> None:
        """Send one frame to every client that is answered and can take it."""
        for number, client in tuple(self._clients.items()):
            if client.admitted or not self._admission:
                self.send_to(frame, number)

    def send_to(self, frame: bytes, peer: ports.Peer) -> None:
        """Send one frame to a client, if it is still there and can take it."""
        client = self._clients.get(peer)
        if client is None:
            return
        try:
            taken = client.stream.send(frame)
        except OSError as error:
            self._lose(peer, reason(error))
            return
        self.counts = ports.with_outcome(self.counts, taken)

    def receive(self) -> list[bytes]:
        """Return the frames that clients have completed; let new clients in."""
        arrivals = self.receive_from(0.0, ())
        for number, _ in arrivals:
            self.admit(number)
        frames = (self._clients[number].framer.whole(data) for number, data in arrivals)
        return [whole for whole in frames if whole]

    def receive_from(self, now: float, busy: Collection[ports.Peer]) -> list[tuple[ports.Peer, bytes]]:
        """Return what clients have sent since the last call; let new clients in."""
        if self._events.closed:
            return []
        self._set_accepting(now >= self._accept_at)
        ready = {descriptor for descriptor, _ in self._events.poll(0)}
        for descriptor in ready & self._listeners.keys():
            ready |= self._accept(self._listeners[descriptor], now)
        share = max(ports.MAX_READ_BYTES // max(len(ready), 1), MIN_READ_BYTES)
        arrivals = [
            (number, data)
            for number in tuple(self._clients)
            if number not in busy and (data := self._read(number, share, ready))
        ]
        self.counts = replace(self.counts, received=self.counts.received + sum(len(data) for _, data in arrivals))
        return arrivals

    def admit(self, peer: ports.Peer) -> None:
        """Answer a client; when there are too many, the one unheard for longest has to go."""
        client = self._clients.pop(peer, None)
        if client is None:  # it has left
            return
        client.admitted = True
        self._clients[peer] = client
        admitted = [number for number, each in self._clients.items() if each.admitted]
        if len(admitted) > self._options.max_clients:
            self._lose(admitted[0], "too many clients")

    def expire(self, timeout: float, now: float) -> None:
        """Close the connections that were not admitted within ``timeout`` [s]."""
        late = [n for n, client in self._clients.items() if not client.admitted and now - client.since > timeout]
        for number in late:
            self._lose(number, f"a client has sent nothing signed with the key within {timeout:g} s")

    def close(self) -> None:
        """Close the port and every connection."""
        for listener in self._listeners.values():
            listener.close()
        for client in self._clients.values():
            client.stream.close()
        self._clients = {}
        self._events.close()

    def _set_accepting(self, accepting: bool) -> None:
        """Look at the listeners, or leave clients that cannot be let in with the system."""
        if accepting != self._accepting:
            self._accepting = accepting
            for descriptor in self._listeners:
                (self._events.register if accepting else self._events.unregister)(descriptor)

    def _accept(self, listener: socket.socket, now: float) -> set[int]:
        """Let new clients in; return their file descriptors: what they have said may be here already."""
        found: set[int] = set()
        for _ in range(ACCEPTED_AT_ONCE):
            try:
                sock, (host, *_) = listener.accept()
            except OSError as error:  # nobody, or somebody who has left again
                if error.errno in EXHAUSTED:
                    self.counts = ports.with_failure(self.counts, error)
                    self._accept_at = now + ACCEPT_PAUSE_S
                break
            stream = Stream(prepared(sock, self._options), empty_is_end=True)
            number = next(self._numbers)
            self._clients[number] = _Client(stream, host, now)
            self._events.register(sock.fileno(), select.EPOLLIN)
            found.add(sock.fileno())
            self._make_room()
            if self._options.first_come and number in self._clients:
                self._clients[number].admitted = True
        return found

    def _make_room(self) -> None:
        """Close the oldest connection that is not admitted, of the host that has the most of them, when it is full."""
        waiting = [(number, client.host) for number, client in self._clients.items() if not client.admitted]
        if (
            len(waiting) <= ports.MAX_WAITING_CLIENTS
            if self._admission
            else len(self._clients) <= self._options.max_clients
        ):
            return
        of_host = Counter(host for _, host in waiting)
        number, _ = max(waiting, key=lambda each: of_host[each[1]])  # the first of the largest is the oldest
        self._lose(number, "too many clients")
        self.counts = replace(self.counts, refused=self.counts.refused + 1)

    def _read(self, number: int, most: int, ready: Collection[int]) -> bytes:
        stream = self._clients[number].stream
        try:
            stream.flush()
            return stream.read(most) if stream.fileno() in ready else b""
        except OSError as error:
            self._lose(number, reason(error))
            return b""

    def _lose(self, number: int, why: str) -> None:
        stream = self._clients.pop(number).stream
        self._events.unregister(stream.fileno())
        stream.close()
        self.counts = replace(self.counts, error=why)


def open_listeners(address: Tcp) -> list[socket.socket]:
    """Listen on a TCP port, on every address that the host has.

    Raises
    ------
    OSError
        When the system refuses.
    """
    with ExitStack() as stack:
        sockets: list[socket.socket] = []
        for family, _, _, _, where in socket.getaddrinfo(address.host, address.port, type=socket.SOCK_STREAM):
            try:
                sock = stack.enter_context(socket.create_server(where[:2], family=family))
            except OSError as error:  # a name may stand for IPv6 where there is none
                if not sockets or error.errno != errno.EADDRNOTAVAIL:
                    raise
                continue
            sock.setblocking(False)
            sockets.append(sock)
        stack.pop_all()
    return sockets


def prepared(sock: socket.socket, options: ports.PortOptions = ports.DEFAULTS) -> socket.socket:
    """Make a TCP socket prompt, and quick to notice that the other side has vanished."""
    sock.setblocking(False)
    vanished = options.vanished_after_s
    with suppress(OSError):  # it has ended meanwhile
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, max(int(vanished / 2), 1))
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPINTVL, max(int(vanished / 4), 1))
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, int(1000 * vanished))
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
