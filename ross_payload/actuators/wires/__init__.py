"""The wires of actuators by URL, and one that leads over TCP to a device in another process.

A scheme is an entry point in ``ross_payload.wires``. Over TCP the device listens: it greets with one JSON line that
names the protocol and tells its clock (but for raw bytes, as devices of others send them), then frames cross both ways.
"""

from __future__ import annotations

import json
import math
import socket
from contextlib import suppress
from typing import Any, Protocol

from ross_payload import plugins
from ross_payload.errors import LinkError, reason, refused_as
from ross_payload.interfaces import Clock, Port
from ross_payload.transport.byte_stream import Handle, Stream
from ross_payload.transport.link_url import tcp_endpoint
from ross_payload.transport.tcp import prepared

GROUP = "ross_payload.wires"
VERSION = 1
ANSWER_TIMEOUT_S = 2.0  # with a connection, a greeting, a last frame [s]
MAX_READ_BYTES = 65536  # of one look at a stream, of which there may be many
MAX_CLOCK_DIFFERENCE_S = 1.0  # two processes of one machine tell the same time, but for the way of the greeting [s]
MAX_GREETING_BYTES = 200


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


def served_at(url: str) -> tuple[str, int]:
    """Read SCHEME:tcp:HOST:PORT.

    Raises
    ------
    ConfigError
        When it is something else.
    """
    return tcp_endpoint(url.partition(":")[2], f"wire '{url}'")


class StreamWire:
    """A wire over a byte stream. What was sent to a device that has gone is lost; `receive` says so.

    Parameters
    ----------
    handle
        Open; over TCP connected and greeted.
    codec
        Of this end.
    name
        Of the other end, for messages.
    """

    empty_is_end = True
    max_waiting_bytes = 4_000_000
    backlog = "the other side does not read"

    def __init__(self, handle: Handle, codec: Codec, name: str) -> None:
        self._stream = Stream(handle, self.empty_is_end)
        self._codec = codec
        self._name = name
        self.gone = ""  # why, in words

    def fileno(self) -> int:
        """Return the descriptor of the stream, for who waits for it."""
        return self._stream.fileno()

    def send(self, frame: Any) -> None:
        """Send one frame; what the stream does not take now goes later."""
        if not self.gone:
            self._flush(self._codec.pack(frame))

    def receive(self) -> list[Any]:
        """Return the frames that have arrived.

        Raises
        ------
        LinkError
            When the other end has gone, after its last frame.
        """
        self._flush()
        frames = self._codec.feed(self._arrived())
        if self.gone and not frames:
            raise LinkError(f"{self._name}: {self.gone}")
        return frames

    def close(self) -> None:
        """Close the stream; idempotent."""
        self.gone = self.gone or "closed"
        self._stream.close()

    def _flush(self, data: bytes = b"") -> None:
        if self.gone:
            return
        try:
            self._stream.append(data)
        except OSError as error:
            self.gone = reason(error)
        else:
            self.gone = self.backlog if len(self._stream.waiting) > self.max_waiting_bytes else ""

    def _arrived(self) -> bytes:
        data = bytearray()
        try:
            while not self.gone and (some := self._stream.read(MAX_READ_BYTES)):
                data += some
        except OSError as error:
            self.gone = reason(error)
        return bytes(data)


class TcpWire(StreamWire):
    """A wire over a connected socket."""

    def __init__(self, connection: socket.socket, codec: Codec, name: str) -> None:
        super().__init__(prepared(connection), codec, name)
        self._connection = connection

    def close(self) -> None:
        """Hand over what still waits, for a while at most, and close; idempotent."""
        with suppress(OSError):  # it has gone, or was closed before
            self._connection.settimeout(ANSWER_TIMEOUT_S)
            self._connection.sendall(self._stream.waiting)
        super().close()


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
    with refused_as(LinkError, f"wire '{url}': cannot connect"):
        connection = socket.create_connection(address, timeout=ANSWER_TIMEOUT_S)
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
        while not line.endswith(b"\n") and len(line) < MAX_GREETING_BYTES:
            some = connection.recv(1)  # not a byte of what follows
            if not some:
                raise LinkError(f"wire '{url}': closed without a greeting")
            line += some
    except OSError as error:
        raise LinkError(
            f"wire '{url}': no greeting in {ANSWER_TIMEOUT_S:g} s; is it serving another client?"
        ) from error
    return line


def _check(line: bytes, codec: Codec, clock: Clock, url: str) -> None:
    try:
        told = json.loads(line)
        name, version, now = told["ross_wire"], told["version"], float(told["now"])
    except (ValueError, TypeError, KeyError) as error:
        raise LinkError(f"wire '{url}': no greeting of a device: {line[:40]!r}") from error
    if (name, version) != (codec.name, VERSION):
        raise LinkError(f"wire '{url}': expected {codec.name} version {VERSION}, got {name} version {version}")
    if not math.fabs(clock.now() - now) < MAX_CLOCK_DIFFERENCE_S:
        raise LinkError(f"wire '{url}': it uses a different clock; the device must run on this machine")
