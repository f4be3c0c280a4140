"""The sink ``tcp``: PCM to whoever connects, or to a named address; see `ross_protocols.audio.pcm`.

Nothing waits: what a listener does not take at once is kept for a moment, and a listener that keeps up no more is
disconnected, so that what it hears later is not old.
"""

from __future__ import annotations

import contextlib
import logging
import socket
from dataclasses import dataclass, field
from typing import Annotated, Literal, Self

from pydantic import Field

from ross_payload.audio.sinks import BuiltInSink, SinkInfo, SinkServices
from ross_payload.config.table import Table
from ross_payload.errors import AudioError, reason, refused_as
from ross_payload.interfaces import VoiceBlock
from ross_payload.transport.async_task import Backoff
from ross_payload.transport.byte_stream import Stream
from ross_payload.transport.link_url import LOOPBACK, Tcp, host_and_port
from ross_payload.transport.ports import MAX_READ_BYTES
from ross_payload.transport.tcp import TcpOpener, open_listeners, prepared
from ross_protocols.audio.pcm import WIDTHS, Header, encode, encode_header

MAX_LISTENERS = 8
KEPT_S = 1.0  # of audio that waits for one listener; beyond that it is disconnected
SEND_BUFFER = 32_768  # [bytes] that the system keeps besides, of which it takes twice as much

log = logging.getLogger(__name__)


class TcpOptions(Table):
    """[listening.streams.options] of ``tcp``."""

    mode: Literal["listen", "connect"] = "listen"  # listen: wait for listeners; connect: to one
    address: Annotated[str, Field(min_length=1)] = LOOPBACK  # to listen on, or to connect to
    port: Annotated[int, Field(ge=1, le=65535)]  # TCP port
    codec: Literal["s16le", "s24le", "f32le"] = "s24le"  # samples on the wire


@dataclass(slots=True, eq=False)
class Listener:
    """One connection, and what waits for it."""

    stream: Stream
    name: str
    over: str = field(default="")  # why it has ended


class TcpSink:
    """An AudioSink that speaks to any number of listeners, each at its own pace.

    Parameters
    ----------
    options
        Where, and which samples.
    services
        Rate and Clock.
    """

    def __init__(self, options: TcpOptions, services: SinkServices) -> None:
        self._options = options
        self._clock = services.clock
        self._rate = services.rate
        self._where = f"tcp:{host_and_port(options.address, options.port)}"
        self._header = encode_header(Header(services.rate, 1, options.codec))
        self._most = round(KEPT_S * services.rate) * WIDTHS[options.codec] + len(self._header)
        self._doors: list[socket.socket] = []
        self._opener: TcpOpener | None = None
        self._backoff, self._due = Backoff(), 0.0
        self._listeners: list[Listener] = []
        self.fault = ""
        self.lost = 0

    @property
    def info(self) -> SinkInfo:
        """Where it is heard, and by how many."""
        return SinkInfo(self._options.address, self._options.port, "pcm", listeners=len(self._listeners))

    def write(self, block: VoiceBlock) -> None:
        """Give samples to every listener."""
        self._meet()
        if self._opener is not None and not self._listeners:
            self.lost += len(block.samples)
        data = encode(block.samples[:, None], self._options.codec)
        for listener in self._listeners:
            self._send(listener, data)
        self._listeners = [listener for listener in self._listeners if not listener.over]

    def __enter__(self) -> Self:
        """Listen, or begin to connect.

        Raises
        ------
        AudioError
            When the port is in use, or the address is none of this computer.
        """
        address = Tcp(self._options.address, self._options.port, self._options.mode == "listen")
        self.fault = ""
        if not address.listen:
            self._opener = TcpOpener(address)
            return self
        with refused_as(AudioError, f"{self._where}: cannot listen"):
            self._doors = open_listeners(address)
        return self

    def __exit__(self, *exception: object) -> None:
        """Send what the system takes at once, and hang up."""
        for listener in self._listeners:
            with contextlib.suppress(OSError):
                listener.stream.flush()
            listener.stream.close()
        for door in self._doors:
            door.close()
        if self._opener is not None:
            self._opener.close()
        self._doors, self._opener, self._listeners = [], None, []

    def _meet(self) -> None:
        """Let in who has come, or go on connecting."""
        for door in self._doors:
            with contextlib.suppress(OSError):  # nobody there, or gone again
                while True:
                    connection, (host, port, *_) = door.accept()
                    self._admit(connection, host_and_port(host, port))
        if self._opener is not None and not self._listeners and self._clock.now() >= self._due:
            self._connect(self._opener)

    def _connect(self, opener: TcpOpener) -> None:
        now = self._clock.now()
        try:
            connection = opener.poll(now)
        except OSError as error:
            self._due = now + self._backoff.wait()
            self.fault = f"{self._where}: no listener: {reason(error)}"
            return
        if connection is not None:
            self.fault = ""
            self._backoff.reset()
            self._admit(connection, self._where)

    def _admit(self, connection: socket.socket, name: str) -> None:
        if len(self._listeners) >= MAX_LISTENERS:
            log.warning("%s: %s turned away: %d listeners are there already", self._where, name, MAX_LISTENERS)
            connection.close()
            return
        with contextlib.suppress(OSError):
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
        listener = Listener(Stream(prepared(connection), empty_is_end=True), name)
        self._listeners.append(listener)
        log.info("%s: %s listens", self._where, name)
        self._send(listener, self._header)

    def _send(self, listener: Listener, data: bytes) -> None:
        """Send behind what waits; one that is too far behind, or has hung up, is over."""
        stream = listener.stream
        try:
            stream.read(MAX_READ_BYTES)  # what a listener says does not matter, however much it is
            stream.append(data)
        except OSError as error:
            self._lose(listener, reason(error))
            return
        if len(stream.waiting) > self._most:
            self._lose(listener, f"it is more than {KEPT_S:g} s behind")

    def _lose(self, listener: Listener, why: str) -> None:
        self.lost += len(listener.stream.waiting) // WIDTHS[self._options.codec]
        listener.over = why
        listener.stream.close()
        log.info("%s: %s listens no more: %s", self._where, listener.name, why)
        if self._opener is not None:
            self._due = self._clock.now() + self._backoff.wait()
            self.fault = f"{self._where}: the listener is gone: {why}"


sink = BuiltInSink(TcpOptions, TcpSink)
