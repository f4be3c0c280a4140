"""MAVLink over UDP."""

from __future__ import annotations

import select
import socket
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import replace
from typing import Any

from ross_payload.interfaces import Clock
from ross_payload.links.address import Udp
from ross_payload.links.background import Backoff, begin
from ross_payload.links.ports import MOST, PEERS, Counts, noted

LARGEST = 2048  # of one datagram [bytes]
DATAGRAMS = 256  # at most, of one call


class UdpPort:
    """Datagrams to one peer, or to everybody heard from."""

    def __init__(self, sock: socket.socket, listen: bool) -> None:
        self._socket = sock
        self._listen = listen
        self._news = select.poll()
        self._news.register(sock, select.POLLIN)
        self._peers: dict[Any, None] = {}  # the latest heard from is last
        self.counts = Counts()

    def send(self, frame: bytes) -> None:
        """Send one datagram to each peer."""
        if not self._listen:
            self._try(lambda: self._socket.send(frame))
        for peer in self._peers:
            self._try(lambda peer=peer: self._socket.sendto(frame, peer))  # type: ignore[misc]

    def receive(self) -> list[bytes]:
        """Return the datagrams that have arrived."""
        datagrams: list[bytes] = []
        if not self._news.poll(0):
            return datagrams
        while sum(map(len, datagrams)) < MOST and len(datagrams) < DATAGRAMS:
            try:
                data, peer = self._socket.recvfrom(LARGEST)
            except BlockingIOError:
                break
            except OSError as error:  # an earlier datagram found nobody
                self._note(error)
                break
            self._meet(peer)
            datagrams.append(data)
        self.counts = replace(self.counts, received=self.counts.received + sum(map(len, datagrams)))
        return datagrams

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()

    def _meet(self, peer: Any) -> None:
        if self._listen:
            self._peers.pop(peer, None)
            self._peers[peer] = None
            if len(self._peers) > PEERS:
                del self._peers[next(iter(self._peers))]

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
        (sock.bind if address.listen else sock.connect)(where)
    except OSError:
        sock.close()
        raise
    return UdpPort(sock, address.listen)
