"""MAVLink over UDP."""

from __future__ import annotations

import select
import socket
from collections.abc import Callable, Collection
from concurrent.futures import Future
from dataclasses import replace

from ross_payload.interfaces import Clock
from ross_payload.links.address import Udp
from ross_payload.links.background import Backoff, begin
from ross_payload.links.ports import MOST, PEERS, Counts, Peer, noted

LARGEST = 2048  # of one datagram [bytes]
DATAGRAMS = 512  # at most, of one call: 50,000 a second, before the system drops what a flood leaves no room for
WAITING = 1 << 20  # of datagrams that may wait with the system, which may grant less [bytes]
MOST_OF_ALL = DATAGRAMS * LARGEST  # of one call, where what strangers say is thrown away unread [bytes]


class UdpPort:
    """Datagrams to one peer."""

    def __init__(self, sock: socket.socket) -> None:
        self._socket = sock
        self._news = select.poll()
        self._news.register(sock, select.POLLIN)
        self.counts = Counts()

    def send(self, frame: bytes) -> None:
        """Send one datagram."""
        self._try(lambda: self._socket.send(frame))

    def receive(self) -> list[bytes]:
        """Return the datagrams that have arrived."""
        return [data for _, data in self._datagrams(MOST)]

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()

    def _datagrams(self, most: int) -> list[tuple[Peer, bytes]]:
        """Read datagrams, until they are ``most`` bytes or more."""
        found: list[tuple[Peer, bytes]] = []
        size = 0
        if not self._news.poll(0):
            return found
        while size < most and len(found) < DATAGRAMS:
            try:
                data, peer = self._socket.recvfrom(LARGEST)
            except BlockingIOError:
                break
            except OSError as error:  # an earlier datagram found nobody
                self._note(error)
                break
            found.append((peer, data))
            size += len(data)
        self.counts = replace(self.counts, received=self.counts.received + size)
        return found

    def _try(self, send: Callable[[], int]) -> None:
        for _ in range(2):
            try:
                send()
            except ConnectionRefusedError as error:  # the news is of an earlier datagram; this one was not sent
                self._note(error)
                continue
            except OSError as error:
                self._note(error)
            else:
                self.counts = replace(self.counts, sent=self.counts.sent + 1)
            return

    def _note(self, error: OSError) -> None:
        self.counts = noted(self.counts, error)


class UdpListener(UdpPort):
    """Datagrams to everybody heard from or, where admission is required, to those admitted."""

    connected = False

    def __init__(self, sock: socket.socket) -> None:
        super().__init__(sock)
        self._peers: dict[Peer, None] = {}  # the latest heard from is last
        self._admission = False

    def require_admission(self) -> None:
        """Send to admitted peers only."""
        self._admission = True

    def send(self, frame: bytes) -> None:
        """Send one datagram to each peer."""
        for peer in self._peers:
            self._try(lambda peer=peer: self._socket.sendto(frame, peer))  # type: ignore[misc]

    def receive(self) -> list[bytes]:
        """Return the datagrams that have arrived."""
        return [data for _, data in self._met(self._datagrams(MOST))]

    def receive_from(self, now: float, busy: Collection[Peer]) -> list[tuple[Peer, bytes]]:
        """Return the datagrams that have arrived and their senders; those of ``busy`` peers are dropped."""
        return [(peer, data) for peer, data in self._met(self._datagrams(MOST_OF_ALL)) if peer not in busy]

    def admit(self, peer: Peer) -> None:
        """Answer a peer; the one unheard for longest makes room."""
        self._peers.pop(peer, None)
        self._peers[peer] = None
        if len(self._peers) > PEERS:
            del self._peers[next(iter(self._peers))]

    def expire(self, patience: float, now: float) -> None:
        """Datagrams have no connection that could be closed."""

    def _met(self, datagrams: list[tuple[Peer, bytes]]) -> list[tuple[Peer, bytes]]:
        if not self._admission:
            for peer, _ in datagrams:
                self.admit(peer)
        return datagrams


class PatientUdpPort:
    """Datagrams to a host whose name cannot be looked up yet, as before the network is up."""

    def __init__(self, address: Udp, clock: Clock) -> None:
        self._address = address
        self._clock = clock
        self._backoff = Backoff()
        self._next = clock.now()
        self._opening: Future[UdpPort] | None = None
        self._port: UdpPort | None = None
        self._counts = Counts(up=False)

    @property
    def counts(self) -> Counts:
        """How the port is."""
        return self._counts if self._port is None else self._port.counts

    def send(self, frame: bytes) -> None:
        """Send one datagram as soon as it is known where to."""
        if self._port is None:
            self._counts = replace(self._counts, failed=self._counts.failed + 1)
        else:
            self._port.send(frame)

    def receive(self) -> list[bytes]:
        """Return the datagrams that have arrived."""
        if self._port is None:
            self._look_up(self._clock.now())
        return [] if self._port is None else self._port.receive()

    def close(self) -> None:
        """Close the socket."""
        if self._opening is not None:
            self._opening.add_done_callback(lambda done: None if done.exception() else done.result().close())
        if self._port is not None:
            self._port.close()

    def _look_up(self, now: float) -> None:
        if self._opening is None and now >= self._next:
            self._opening = begin(lambda: open_udp(self._address))
        elif self._opening is not None and self._opening.done():
            opening, self._opening = self._opening, None
            try:
                self._port = opening.result()
            except OSError as error:
                self._counts = replace(self._counts, error=error.strerror or str(error))
                self._next = now + self._backoff.wait()


def open_udp(address: Udp) -> UdpPort:
    """Open a UDP port; looks the host up, which may take a while.

    Raises
    ------
    OSError
        When the system refuses.
    """
    family, kind, protocol, _, where = socket.getaddrinfo(address.host, address.port, type=socket.SOCK_DGRAM)[0]
    sock = socket.socket(family, kind, protocol)
    try:
        sock.setblocking(False)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, WAITING)
        (sock.bind if address.listen else sock.connect)(where)
    except OSError:
        sock.close()
        raise
    return UdpListener(sock) if address.listen else UdpPort(sock)
