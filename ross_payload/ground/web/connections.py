"""Who may hold a connection to the page: half-open ones never keep a browser out.

A connection counts as open when a request of it has passed the guard of `login`. Until then it has `HEADER_TIMEOUT`,
TLS handshake included. When there are too many, in all or of one address, one gives way to whoever comes next: the
oldest half-open one, else the one that has been idle for longest, else the oldest download; never a WebSocket.
"""

from __future__ import annotations

import asyncio
import resource
import socket
import ssl
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass

from ross_payload.ground.web.faults import Reporter

HEADER_TIMEOUT = 10.0  # [s] from its start until a request has passed the guard
MOST = 512  # connections
MOST_PER_ADDRESS = 384
RESERVED = 128  # descriptors for all else: links, logs, WebSockets' files
ACCEPTED_AT_ONCE = 32  # before anything else has its turn
PAUSE = 0.1  # [s] when the system has no descriptor left
WANTED_DESCRIPTORS = 65_536

Protocols = Callable[[], asyncio.Protocol]


def raise_descriptor_limit() -> int:
    """Raise the soft limit of descriptors to the hard one, within reason; return what it is."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = WANTED_DESCRIPTORS if hard == resource.RLIM_INFINITY else min(hard, WANTED_DESCRIPTORS)
    if soft == resource.RLIM_INFINITY or soft >= wanted:
        return soft
    with suppress(OSError, ValueError):
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
    return resource.getrlimit(resource.RLIMIT_NOFILE)[0]


@dataclass(slots=True, eq=False)
class Connection:
    """One connection, from its accept to its end."""

    address: str
    passed: bool = False  # a request of it has passed the guard
    busy: int = 0  # requests that are being answered
    lasting: bool = False  # it carries a WebSocket
    transport: asyncio.BaseTransport | None = None  # None: its handshake goes on
    opening: asyncio.Task[None] | None = None
    timeout: asyncio.TimerHandle | None = None

    def cut(self) -> None:
        """End it without a word."""
        if isinstance(self.transport, asyncio.Transport):
            self.transport.abort()
        elif self.opening is not None:
            self.opening.cancel()

    @property
    def yields(self) -> int:
        """How readily it gives way: 0 first, 3 never."""
        return 3 if self.lasting else 2 if self.busy else 1 if self.passed else 0


class Connections:
    """Accepts connections on a bound socket, and bounds their number and age.

    Parameters
    ----------
    most, most_per_address
        How many there may be, in all and of one address.
    header_timeout
        See `HEADER_TIMEOUT` [s].
    """

    def __init__(
        self, *, most: int = MOST, most_per_address: int = MOST_PER_ADDRESS, header_timeout: float = HEADER_TIMEOUT
    ) -> None:
        soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
        self._most = most if soft == resource.RLIM_INFINITY else max(min(most, soft - RESERVED), 16)
        self._most_per_address = min(most_per_address, self._most)
        self._header_timeout = header_timeout
        self._connections: dict[Connection, None] = {}  # by their latest use, the oldest first
        self._of_protocol: dict[asyncio.BaseProtocol, Connection] = {}
        self._by_address: Counter[str] = Counter()
        self._report = Reporter()

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._connections)

    @contextmanager
    def accepted(self, listener: socket.socket, protocols: Protocols, tls: ssl.SSLContext | None) -> Iterator[None]:
        """Accept on a bound socket; in the end what is half-open is cut, and the rest is left to its protocols."""
        listener.setblocking(False)
        listener.listen(MOST)
        loop = asyncio.get_running_loop()
        over = False

        def accept() -> None:
            if not self._accept(listener, protocols, tls):
                loop.remove_reader(listener)
                loop.call_later(PAUSE, resume)

        def resume() -> None:
            if not over:
                loop.add_reader(listener, accept)

        resume()
        try:
            yield
        finally:
            over = True
            loop.remove_reader(listener)
            for connection in [each for each in self._connections if not each.passed]:
                connection.cut()

    def _accept(self, listener: socket.socket, protocols: Protocols, tls: ssl.SSLContext | None) -> bool:
        """Take who waits, some at once; False: the system has no descriptor or no memory left."""
        for _ in range(ACCEPTED_AT_ONCE):
            try:
                made, place = listener.accept()
            except (BlockingIOError, InterruptedError, ConnectionAbortedError):
                return True
            except OSError as error:
                self._report(f"no connection can be accepted: {error.strerror}")
                self._make_room(self._connections)
                return False
            self._begin(made, str(place[0]), protocols, tls)
        return True

    @contextmanager
    def answering(self, protocol: asyncio.BaseProtocol, *, lasting: bool = False) -> Iterator[None]:
        """Count a request that has passed the guard as long as it is answered; ``lasting``: for a WebSocket."""
        connection = self._of_protocol.get(protocol) or Connection("")
        if connection.timeout is not None:
            connection.timeout.cancel()
        connection.passed, connection.lasting = True, lasting
        connection.busy += 1
        try:
            yield
        finally:
            connection.busy -= 1
            connection.lasting = False
            if connection in self._connections:  # the latest to be used
                del self._connections[connection]
                self._connections[connection] = None

    def _begin(self, made: socket.socket, address: str, protocols: Protocols, tls: ssl.SSLContext | None) -> None:
        if self._by_address[address] >= self._most_per_address:
            self._make_room({each: None for each in self._connections if each.address == address})
        elif len(self._connections) >= self._most:
            self._make_room(self._connections)
        connection = Connection(address)
        self._connections[connection] = None
        self._by_address[address] += 1
        loop = asyncio.get_running_loop()
        connection.timeout = loop.call_later(self._header_timeout, connection.cut)
        connection.opening = loop.create_task(self._open(connection, made, protocols, tls))
        connection.opening.add_done_callback(lambda _: self._opened(connection, made))

    async def _open(
        self, connection: Connection, made: socket.socket, protocols: Protocols, tls: ssl.SSLContext | None
    ) -> None:
        """Do the handshake and hand the connection over; whoever does it badly is nobody's fault."""
        with suppress(OSError):  # also what TLS has to complain of
            await asyncio.get_running_loop().connect_accepted_socket(
                lambda: _Watched(self, connection, protocols()), made, ssl=tls
            )

    def _opened(self, connection: Connection, made: socket.socket) -> None:
        if connection.transport is None:
            made.close()
            self.lost(connection)

    def made(self, connection: Connection, transport: asyncio.BaseTransport, protocol: asyncio.BaseProtocol) -> None:
        """Learn that its handshake is over."""
        connection.transport = transport
        self._of_protocol[protocol] = connection

    def lost(self, connection: Connection, protocol: asyncio.BaseProtocol | None = None) -> None:
        """Learn that a connection is over; idempotent."""
        if protocol is not None:
            self._of_protocol.pop(protocol, None)
        if connection.timeout is not None:
            connection.timeout.cancel()
        if connection in self._connections:
            del self._connections[connection]
            self._by_address[connection.address] -= 1
            if not self._by_address[connection.address]:
                del self._by_address[connection.address]

    def _make_room(self, among: dict[Connection, None]) -> None:
        """Cut the one that gives way most readily, the oldest of these."""
        cut = min(among, key=lambda each: each.yields, default=None)
        if cut is not None and cut.yields < 3:
            cut.cut()
            self.lost(cut)


class _Watched(asyncio.Protocol):
    """Passes everything on, and tells when it begins and ends."""

    def __init__(self, connections: Connections, connection: Connection, inner: asyncio.Protocol) -> None:
        self._connections, self._connection, self._inner = connections, connection, inner
        self.data_received = inner.data_received  # type: ignore[method-assign] # what comes most often goes straight on

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin."""
        self._connections.made(self._connection, transport, self._inner)
        self._inner.connection_made(transport)

    def connection_lost(self, error: Exception | None) -> None:
        """End."""
        self._connections.lost(self._connection, self._inner)
        self._inner.connection_lost(error)

    def eof_received(self) -> bool | None:
        """Pass it on."""
        return self._inner.eof_received()

    def pause_writing(self) -> None:
        """Pass it on."""
        self._inner.pause_writing()

    def resume_writing(self) -> None:
        """Pass it on."""
        self._inner.resume_writing()
