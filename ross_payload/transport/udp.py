"""UDP: datagrams to one peer, and a port that answers those heard from."""

from __future__ import annotations

import errno
import math
import select
import socket
import struct
from collections.abc import Callable, Collection, Iterable
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import replace

from ross_payload.errors import reason
from ross_payload.transport import ports
from ross_payload.transport.async_task import Backoff, begin
from ross_payload.transport.link_url import Udp

MAX_DATAGRAM_BYTES = 2048
MAX_DATAGRAMS = 512  # of one call: 50,000 a second, before the system drops what a flood leaves no room for
BUFFER_BYTES = 4 << 20  # of datagrams that may wait with the system, which may grant less: 0.3 s of a flood of 30,000/s
BROADCAST = "expected the address of one computer, got a broadcast address; or let it connect to a udpin link"
REPORTS = ((socket.IPPROTO_IP, 11), (socket.IPPROTO_IPV6, 25))  # IP_RECVERR and IPV6_RECVERR of linux/in.h and in6.h
REPORT = struct.Struct("=IB11x")  # the begin of sock_extended_err: which error, and who says so
BY_NETWORK = (2, 3)  # SO_EE_ORIGIN_ICMP and _ICMP6
REPORT_BYTES = 512  # of what comes with one report
ATTEMPTS = 3  # to send one datagram, when what the system reports is about others
SILENT_S = 5.0  # without a word of a peer: anybody can write a report about one that is still there [s]
ALL_BYTES = MAX_DATAGRAMS * MAX_DATAGRAM_BYTES  # of one call, where what strangers say is thrown away unread


class UdpPeer:
    """Datagrams to and from one address.

    Its host is looked up again after a failure, but for that nobody listens there: hosts and networks move. Until it
    is known again the old socket stays in use.

    Parameters
    ----------
    address
        Whom to speak to.
    now
        Tells the time [s].
    sock
        What is open already; None: the host is looked up in the background.
    options
        How long the pauses between two attempts are.
    """

    def __init__(
        self,
        address: Udp,
        now: Callable[[], float],
        sock: socket.socket | None = None,
        options: ports.PortOptions = ports.DEFAULTS,
    ) -> None:
        self._address = address
        self._now = now
        self._backoff = Backoff(options.first_pause_s, options.longest_pause_s)
        self._retry_at = now()
        self._opening: Future[socket.socket] | None = None
        self._stale = sock is None
        self._socket: socket.socket | None = None
        self._events = select.epoll()
        self.counts = ports.Counts(up=False)
        if sock is not None:
            self._begin(sock)

    def fileno(self) -> int:
        """Return a descriptor that is readable when something has arrived."""
        return self._events.fileno()

    def host_of(self, peer: ports.Peer) -> str:
        """Return the address of the other side; empty: not known yet."""
        return "" if self._socket is None else str(self._socket.getpeername()[0])

    def send(self, frame: bytes) -> None:
        """Send one datagram, if it is known where to."""
        sock = self._socket
        if sock is None:
            self.counts = replace(self.counts, failed=self.counts.failed + 1)
        else:
            self._note(_sent(self.counts, lambda: sock.send(frame)))

    def receive(self) -> list[bytes]:
        """Return the datagrams that have arrived."""
        if self._events.closed:
            return []
        if self._stale:
            self._look_up(self._now())
        if self._socket is None or not self._events.poll(0):
            return []
        datagrams, counts = _received(self._socket, self.counts, ports.MAX_READ_BYTES)
        self._note(counts)
        if datagrams:
            self._backoff.reset()
        return [data for _, data in datagrams]

    def close(self) -> None:
        """Close the socket."""
        if self._opening is not None:
            self._opening.add_done_callback(lambda done: None if done.exception() else done.result().close())
        if self._socket is not None:
            self._socket.close()
            self._socket = None
        self._events.close()

    def _note(self, counts: ports.Counts) -> None:
        self._stale = self._stale or counts.failed > self.counts.failed
        self.counts = counts

    def _look_up(self, now: float) -> None:
        if self._opening is None and now >= self._retry_at:
            self._opening = begin(lambda: open_udp(self._address))
        elif self._opening is not None and self._opening.done():
            opening, self._opening = self._opening, None
            self._retry_at = now + self._backoff.wait()
            try:
                self._begin(opening.result())
            except (OSError, ValueError) as error:  # a ValueError: a name that cannot be one
                self.counts = replace(self.counts, error=reason(error), trouble=reason(error))

    def _begin(self, sock: socket.socket) -> None:
        if self._socket is not None:
            self._events.unregister(self._socket)
            self._socket.close()
        self._socket, self._stale = sock, False
        self._events.register(sock, select.EPOLLIN)
        self.counts = replace(self.counts, up=True, trouble="")


class UdpServer:
    """Datagrams to everybody heard from or, where admission is required, to those admitted.

    A silent peer whose computer answers that no program has its port is sent nothing until it is heard again.

    Parameters
    ----------
    sock
        Bound.
    now
        Tells the time [s].
    """

    connected = False

    def __init__(self, sock: socket.socket, now: Callable[[], float]) -> None:
        self._socket = sock
        self._now = now
        self._peers: dict[ports.Peer, float] = {}  # when it was heard [s]; the latest is last
        self._admission = False
        self.counts = ports.Counts()
        for level, option in REPORTS:
            with suppress(OSError):  # of the other family
                sock.setsockopt(level, option, 1)

    def fileno(self) -> int:
        """Return a descriptor that is readable when something has arrived."""
        return self._socket.fileno()

    def host_of(self, peer: ports.Peer) -> str:
        """Return the address of a peer."""
        return str(peer[0]) if isinstance(peer, tuple) else ""

    def require_admission(self) -> None:
        """Send to admitted peers only."""
        self._admission = True

    def send(self, frame: bytes) -> None:
        """Send one datagram to each peer."""
        for peer in tuple(self._peers):
            self.send_to(frame, peer)

    def send_to(self, frame: bytes, peer: ports.Peer) -> None:
        """Send one datagram."""
        for left in reversed(range(ATTEMPTS)):
            try:
                self._socket.sendto(frame, peer)
            except OSError as error:
                if left and not isinstance(error, BlockingIOError):  # about an earlier datagram; this one was not sent
                    continue
                self.counts = ports.with_failure(self.counts, error)
            else:
                self.counts = replace(self.counts, sent=self.counts.sent + 1)
            return

    def receive(self) -> list[bytes]:
        """Return the datagrams that have arrived."""
        return [data for _, data in self._arrived(ports.MAX_READ_BYTES)]

    def receive_from(
        self, now: float, busy: Collection[ports.Peer], max_bytes: int = ALL_BYTES
    ) -> list[tuple[ports.Peer, bytes]]:
        """Return the datagrams that have arrived and their senders; those of ``busy`` peers are dropped."""
        return [(peer, data) for peer, data in self._arrived(max_bytes) if peer not in busy]

    def admit(self, peer: ports.Peer) -> None:
        """Answer a peer; the one unheard for longest makes room."""
        self._peers.pop(peer, None)
        self._peers[peer] = self._now()
        if len(self._peers) > ports.MAX_PEERS:
            del self._peers[next(iter(self._peers))]

    def expire(self, timeout: float, now: float) -> None:
        """Datagrams have no connection that could be closed."""

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()

    def _read_reports(self) -> None:
        """Forget the silent peers at whose ports nobody listens."""
        for _ in range(MAX_DATAGRAMS):
            try:
                _, control, _, peer = self._socket.recvmsg(0, REPORT_BYTES, socket.MSG_ERRQUEUE)
            except OSError:
                return
            if _nobody_listens(control) and self._now() - self._peers.get(peer, math.inf) > SILENT_S:
                del self._peers[peer]

    def _arrived(self, max_bytes: int) -> list[tuple[ports.Peer, bytes]]:
        self._read_reports()
        datagrams, self.counts = _received(self._socket, self.counts, max_bytes)
        if not self._admission:
            for peer, _ in datagrams:
                self.admit(peer)
        return datagrams


def open_udp(address: Udp) -> socket.socket:
    """Open a UDP socket; looks the host up, which may take a while.

    Raises
    ------
    OSError
        When the system refuses.
    """
    family, kind, protocol, _, where = socket.getaddrinfo(address.host, address.port, type=socket.SOCK_DGRAM)[0]
    sock = socket.socket(family, kind, protocol)
    try:
        sock.setblocking(False)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)
        (sock.bind if address.listen else sock.connect)(where)
    except OSError as error:
        sock.close()
        if error.errno == errno.EACCES and not address.listen:  # answers would come from another address
            raise OSError(0, BROADCAST) from error
        raise
    return sock


def _nobody_listens(control: Iterable[tuple[int, int, bytes]]) -> bool:
    """Tell whether a report says that a datagram reached a computer where no program has its port."""
    reports = [REPORT.unpack_from(data) for level, kind, data in control if (level, kind) in REPORTS]
    return any(error == errno.ECONNREFUSED and origin in BY_NETWORK for error, origin in reports)


def _received(
    sock: socket.socket, counts: ports.Counts, max_bytes: int
) -> tuple[list[tuple[ports.Peer, bytes]], ports.Counts]:
    """Read datagrams until they are ``max_bytes`` or more; return them, and what is counted then."""
    found: list[tuple[ports.Peer, bytes]] = []
    size = 0
    for _ in range(MAX_DATAGRAMS):
        if size >= max_bytes:
            break
        try:
            data, peer = sock.recvfrom(MAX_DATAGRAM_BYTES)
        except BlockingIOError:
            break
        except OSError as error:  # an earlier datagram found nobody; what has arrived waits behind the news
            counts = ports.with_failure(counts, error)
            continue
        found.append((peer, data))
        size += len(data)
    return found, replace(counts, received=counts.received + size, trouble="" if found else counts.trouble)


def _sent(counts: ports.Counts, send: Callable[[], int]) -> ports.Counts:
    """Send one datagram; return what is counted then."""
    for _ in range(2):
        try:
            send()
        except ConnectionRefusedError as error:  # the news is of an earlier datagram; this one was not sent
            counts = ports.with_failure(counts, error)
            continue
        except OSError as error:
            return ports.with_failure(counts, error)
        return replace(counts, sent=counts.sent + 1)
    return counts
