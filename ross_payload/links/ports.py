"""The wires of telemetry: UDP, TCP and serial ports that never wait, never queue without bound and never raise.

What cannot be sent at once is dropped and counted: the next report is more worth than the last one.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

from ross_payload.errors import ConfigError, LinkError
from ross_payload.links.address import Address, Serial, Tcp, Udp, parse

CONNECT_TIMEOUT = 3.0  # [s]
LARGEST = 65536  # of one read [bytes]
READS = 64  # at most, of one call: a flood cannot hold up the loop
PEERS = 16  # that a listening UDP port answers


@dataclass(frozen=True, slots=True)
class Counts:
    """What went through a port."""

    sent: int = 0  # frames handed to the system
    dropped: int = 0  # frames that would have had to wait
    refused: int = 0  # times that nobody listened there
    failed: int = 0  # other errors, and frames for a connection that is gone
    received: int = 0  # bytes
    error: str = ""  # the latest failure, in words
    up: bool = True  # connected, as far as one can know
    reconnects: int = 0


class LinkPort(Protocol):
    """A port that counts."""

    counts: Counts

    def send(self, frame: bytes) -> None:
        """Send one frame or drop it; never waits."""

    def receive(self) -> list[bytes]:
        """Return what has arrived; never waits."""

    def close(self) -> None:
        """Give the port back; idempotent."""


class UdpPort:
    """Datagrams to one peer, or to everybody heard from."""

    def __init__(self, sock: socket.socket, listen: bool) -> None:
        self._socket = sock
        self._listen = listen
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
        datagrams = []
        for _ in range(READS):
            try:
                data, peer = self._socket.recvfrom(LARGEST)
            except BlockingIOError:
                break
            except OSError as error:  # an earlier datagram found nobody
                self._note(error)
                continue
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


class Handle(Protocol):
    """An open socket or serial device."""

    def fileno(self) -> int:
        """Return its file descriptor."""

    def close(self) -> None:
        """Close it."""


class StreamPort:
    """A byte stream in which frames are never cut: one that is begun is finished before the next one is."""

    def __init__(self, handle: Handle, empty_is_end: bool) -> None:
        self._handle: Handle | None = handle
        self._empty_is_end = empty_is_end  # reading nothing: TCP is over, serial is silent
        self._rest = b""
        self.counts = Counts()

    def send(self, frame: bytes) -> None:
        """Send one frame, or drop it when the stream is busy or gone."""
        self._flush()
        if self._handle is None:
            self.counts = replace(self.counts, failed=self.counts.failed + 1)
        elif self._rest:
            self.counts = replace(self.counts, dropped=self.counts.dropped + 1)
        else:
            self._rest = frame
            self.counts = replace(self.counts, sent=self.counts.sent + 1)
            self._flush()

    def receive(self) -> list[bytes]:
        """Return what has arrived, and finish the frame that is begun."""
        self._flush()
        pieces: list[bytes] = []
        for _ in range(READS):
            piece = self._read()
            if not piece:
                break
            pieces.append(piece)
        self.counts = replace(self.counts, received=self.counts.received + sum(map(len, pieces)))
        return pieces

    def close(self) -> None:
        """Close the stream."""
        if self._handle is not None:
            self._handle.close()
            self._handle = None

    def _read(self) -> bytes:
        if self._handle is None:
            return b""
        try:
            piece = os.read(self._handle.fileno(), LARGEST)
        except BlockingIOError:
            return b""
        except OSError as error:
            self._lose(error)
            return b""
        if not piece and self._empty_is_end:
            self._lose(ConnectionResetError(0, "the other side closed the connection"))
        return piece

    def _flush(self) -> None:
        if self._handle is None or not self._rest:
            return
        try:
            self._rest = self._rest[os.write(self._handle.fileno(), self._rest) :]
        except BlockingIOError:
            return
        except OSError as error:
            self._lose(error)

    def _lose(self, error: OSError) -> None:
        self.counts = noted(self.counts, error)
        self._rest = b""
        self.close()


def open_port(url: str) -> LinkPort:
    """Open the port of a URL.

    Raises
    ------
    ConfigError
        When the URL is malformed or needs an extra that is missing.
    LinkError
        When the port cannot be opened, in one line.
    """
    address = parse(url)
    try:
        return _open(address)
    except OSError as error:  # pyserial's errors and name resolution are OSErrors too
        reason = os.strerror(error.errno) if error.errno and error.errno > 0 else error.strerror or str(error)
        raise LinkError(f"link '{url}' cannot be opened: {reason}") from error
    except ValueError as error:  # a name or a baud rate that the system cannot take
        raise ConfigError(f"link '{url}': {error}") from error


def noted(counts: Counts, error: OSError) -> Counts:
    """Count one failure to send or receive."""
    if isinstance(error, BlockingIOError):
        return replace(counts, dropped=counts.dropped + 1)
    if isinstance(error, ConnectionRefusedError):
        return replace(counts, refused=counts.refused + 1)
    return replace(counts, failed=counts.failed + 1, error=error.strerror or str(error))


def _open(address: Address) -> LinkPort:
    match address:
        case Udp():
            return _open_udp(address)
        case Tcp(host, port):
            stream = socket.create_connection((host, port), timeout=CONNECT_TIMEOUT)
            stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            stream.setblocking(False)
            return StreamPort(stream, empty_is_end=True)
        case Serial():
            return _open_serial(address)


def _open_udp(address: Udp) -> UdpPort:
    family, kind, protocol, _, where = socket.getaddrinfo(address.host, address.port, type=socket.SOCK_DGRAM)[0]
    sock = socket.socket(family, kind, protocol)
    try:
        sock.setblocking(False)
        (sock.bind if address.listen else sock.connect)(where)
    except OSError:
        sock.close()
        raise
    return UdpPort(sock, address.listen)


def _open_serial(address: Serial) -> StreamPort:
    try:
        import serial  # noqa: PLC0415  an extra: only those who use it need it
    except ModuleNotFoundError as error:
        raise ConfigError("a serial link needs the package pyserial: pip install 'ross-payload[serial]'") from error
    return StreamPort(serial.Serial(address.device, address.baud, timeout=0, exclusive=True), empty_is_end=False)
