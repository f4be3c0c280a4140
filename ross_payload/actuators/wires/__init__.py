"""The wires of actuators by URL, and one that leads over TCP to a device in another process.

A scheme is an entry point in ``ross_payload.wires``. Over TCP the device listens: it greets with one JSON line that
names the protocol and tells its clock (but for raw bytes, as devices of others send them), then frames cross both ways.
"""

from __future__ import annotations

import json
import math
import socket
from typing import Any, Protocol

from ross_payload import plugins
from ross_payload.errors import ConfigError, LinkError
from ross_payload.interfaces import Clock, Port
from ross_payload.links.address import Tcp, parse

GROUP = "ross_payload.wires"
VERSION = 1
PATIENCE = 2.0  # with a connection, a greeting, a last frame [s]
SAME_CLOCK = 1.0  # two processes of one machine tell the same time, but for the way of the greeting [s]
MOST_WAITING = 4_000_000  # [bytes]
GREETING = 200  # longest [bytes]


class Wire(Protocol):
    """The object behind an entry point in ``ross_payload.wires``."""

    def open(self, url: str, clock: Clock) -> Port:
        """Open the port that a URL of this scheme names."""


class Codec(Protocol):
    """Frames to bytes and back; each end of a wire has its own."""

    @property
    def name(self) -> str:
        """The protocol, as in the greeting; empty: a device of others, which does not greet."""

    def pack(self, frame: Any) -> bytes:
        """Turn one frame into bytes."""

    def feed(self, data: bytes) -> list[Any]:
        """Return the frames that are complete.

        Raises
        ------
        LinkError
            When the bytes are no frame.
        """


def open_wire(url: str, clock: Clock) -> Port:
    """Open the wire that a URL names.

    Raises
    ------
    ConfigError
        When its scheme or what follows is unknown; lists what there is.
    LinkError
        When it cannot be opened.
    """
    wire: Wire = plugins.load(GROUP, url.partition(":")[0])
    return wire.open(url, clock)


def check_wire(url: str) -> None:
    """Refuse a URL that `open_wire` refuses, and open nothing; a plug-in without ``check`` is asked when it opens.

    Raises
    ------
    ConfigError
        When its scheme or what follows is unknown; lists what there is.
    """
    check = getattr(plugins.load(GROUP, url.partition(":")[0]), "check", None)
    if check is not None:
        check(url)


def served_at(url: str) -> Tcp:
    """Read SCHEME:tcp:HOST:PORT.

    Raises
    ------
    ConfigError
        When it is something else.
    """
    scheme, _, rest = url.partition(":")
    address = parse(rest)
    if not isinstance(address, Tcp):
        raise ConfigError(f"wire '{url}': expected {scheme}:tcp:HOST:PORT")
    return address


class TcpWire:
    """A wire over a connected socket. What was sent to a device that has gone is lost; `receive` says so.

    Parameters
    ----------
    connection
        Connected and greeted.
    codec
        Of this end.
    name
        Of the other end, for messages.
    """

    def __init__(self, connection: socket.socket, codec: Codec, name: str) -> None:
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._connection = connection
        self._codec = codec
        self._name = name
        self._waiting = bytearray()
        self._gone = ""

    def fileno(self) -> int:
        """Return the descriptor of the socket, for who waits for it."""
        return self._connection.fileno()

    def send(self, frame: Any) -> None:
        """Send one frame; what the socket does not take now goes later."""
        if self._gone:
            return
        self._waiting += self._codec.pack(frame)
        self._flush()

    def receive(self) -> list[Any]:
        """Return the frames that have arrived.

        Raises
        ------
        LinkError
            When the other end has gone, after its last frame.
        """
        self._flush()
        frames = self._codec.feed(self._arrived())
        if self._gone and not frames:
            raise LinkError(f"{self._name}: {self._gone}")
        return frames

    def close(self) -> None:
        """Hand over what still waits, for a while at most, and close; idempotent."""
        if self._connection.fileno() < 0:
            return
        try:
            self._connection.settimeout(PATIENCE)
            self._connection.sendall(self._waiting)
        except OSError as error:
            self._gone = error.strerror or str(error)
        self._waiting.clear()
        self._connection.close()

    def _flush(self) -> None:
        try:
            while self._waiting and not self._gone:
                del self._waiting[: self._connection.send(self._waiting)]
        except BlockingIOError:
            if len(self._waiting) > MOST_WAITING:
                self._gone = "the other side does not read"
        except OSError as error:
            self._gone = error.strerror or str(error)

    def _arrived(self) -> bytes:
        data = bytearray()
        try:
            while not self._gone:
                some = self._connection.recv(65536)
                data += some
                if not some:
                    self._gone = "the other side closed the connection"
        except BlockingIOError:
            pass
        except OSError as error:
            self._gone = error.strerror or str(error)
        return bytes(data)


def greeting(codec: Codec, clock: Clock) -> bytes:
    """Return the first line of a device; nothing for a protocol that has none."""
    if not codec.name:
        return b""
    return json.dumps({"ross_wire": codec.name, "version": VERSION, "now": clock.now()}).encode() + b"\n"


def connect(url: str, codec: Codec, clock: Clock) -> TcpWire:
    """Connect to a device; ``url`` is SCHEME:tcp:HOST:PORT.

    Raises
    ------
    ConfigError
        When the URL is malformed.
    LinkError
        When nobody answers, or somebody else than the device wanted.
    """
    address = served_at(url)
    try:
        connection = socket.create_connection((address.host, address.port), timeout=PATIENCE)
    except OSError as error:
        raise LinkError(f"wire '{url}': cannot connect: {error.strerror or error}") from error
    try:
        if codec.name:
            _check(_first_line(connection, url), codec, clock, url)
    except LinkError:
        connection.close()
        raise
    return TcpWire(connection, codec, f"wire '{url}'")


def _first_line(connection: socket.socket, url: str) -> bytes:
    line = b""
    try:
        while not line.endswith(b"\n") and len(line) < GREETING:
            some = connection.recv(1)  # not a byte of what follows
            if not some:
                raise LinkError(f"wire '{url}': closed without a greeting")
            line += some
    except OSError as error:
        raise LinkError(f"wire '{url}': no greeting in {PATIENCE:g} s; is it serving another client?") from error
    return line


def _check(line: bytes, codec: Codec, clock: Clock, url: str) -> None:
    try:
        told = json.loads(line)
        name, version, now = told["ross_wire"], told["version"], float(told["now"])
    except (ValueError, TypeError, KeyError) as error:
        raise LinkError(f"wire '{url}': no greeting of a device: {line[:40]!r}") from error
    if (name, version) != (codec.name, VERSION):
        raise LinkError(f"wire '{url}': expected {codec.name} version {VERSION}, got {name} version {version}")
    if not math.fabs(clock.now() - now) < SAME_CLOCK:
        raise LinkError(f"wire '{url}': it uses a different clock; the device must run on this machine")
