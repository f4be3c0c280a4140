"""Byte streams in which frames are never cut, and which are opened again when they are lost."""

from __future__ import annotations

import os
import select
import socket
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Protocol

from ross_payload.errors import reason
from ross_payload.transport import ports
from ross_payload.transport.async_task import Backoff


class Handle(Protocol):
    """An open socket or serial device that does not block."""

    def fileno(self) -> int:
        """Return its file descriptor."""

    def close(self) -> None:
        """Close it."""


class Stream:
    """One connection: a frame that is begun is finished before the next one is. A lost one raises OSError."""

    def __init__(self, handle: Handle, empty_is_end: bool) -> None:
        self._handle = handle
        self._empty_is_end = empty_is_end  # reading nothing: TCP is over, serial is silent
        self.waiting = bytearray()  # what the system has not taken yet

    def fileno(self) -> int:
        """Return the file descriptor."""
        return self._handle.fileno()

    @property
    def host(self) -> str:
        """The address of the other side; empty: it has none, as on a serial line."""
        with suppress(OSError):
            return str(self._handle.getpeername()[0]) if isinstance(self._handle, socket.socket) else ""
        return ""

    def send(self, frame: bytes) -> bool:
        """Send one frame, or none of it while an earlier one waits; tell whether the stream took it."""
        self.flush()
        if self.waiting:
            return False
        self.append(frame)
        return True

    def append(self, data: bytes) -> None:
        """Send bytes behind what waits."""
        self.waiting += data
        self.flush()

    def flush(self) -> None:
        """Go on with what waits."""
        write_waiting(self.fileno(), self.waiting)

    def read(self, most: int) -> bytes:
        """Return what has arrived."""
        try:
            data = os.read(self.fileno(), most)
        except BlockingIOError:
            return b""
        if not data and self._empty_is_end:
            raise ConnectionResetError(0, "the other side closed the connection")
        if not data and hung_up(self.fileno()):
            raise ConnectionResetError(0, "the device was disconnected")
        return data

    def close(self) -> None:
        """Close the handle."""
        self._handle.close()


def write_waiting(descriptor: int, waiting: bytearray) -> None:
    """Write what the system takes now, and remove it; OSError: nobody reads any more."""
    try:
        while waiting:
            del waiting[: os.write(descriptor, waiting)]
    except BlockingIOError:
        return


def hung_up(descriptor: int) -> bool:
    """Tell whether nobody is at the other end of a device or a terminal any more."""
    poll = select.poll()
    poll.register(descriptor, 0)
    return bool(poll.poll(0))


class Opener(Protocol):
    """Opens a connection step by step."""

    empty_is_end: bool
    baud: int

    @property
    def progress(self) -> str:
        """What it is doing, in words, where that takes long."""

    def poll(self, now: float) -> Handle | None:
        """Return the handle when it is open, None while that takes longer; OSError or ValueError when it failed."""

    def close(self) -> None:
        """Give up what is half open."""


class ReconnectingStream:
    """A TCP connection or a serial line, opened again, after a pause, whenever it is lost.

    Parameters
    ----------
    opener
        Opens it, as often as needed.
    now
        Tells the time [s].
    handle
        What is open already.
    options
        How long the pauses between two attempts are.
    """

    def __init__(
        self,
        opener: Opener,
        now: Callable[[], float],
        handle: Handle | None = None,
        options: ports.PortOptions = ports.DEFAULTS,
    ) -> None:
        self._opener = opener
        self._now = now
        self._backoff = Backoff(options.first_pause_s, options.longest_pause_s)
        self._retry_at = now()
        self._stream: Stream | None = None
        self._opened = 0
        self._events = select.epoll()
        self.counts = ports.Counts(up=False)
        if handle is not None:
            self._begin(handle)

    def fileno(self) -> int:
        """Return a descriptor that is readable when something has arrived, on this connection and on the next ones."""
        return self._events.fileno()

    def host_of(self, peer: ports.Peer) -> str:
        """Return the address of the other side; empty: it has none, or is gone."""
        return "" if self._stream is None else self._stream.host

    def send(self, frame: bytes) -> None:
        """Send one frame, or drop it when the stream is busy or gone."""
        if self._stream is None:
            self.counts = replace(self.counts, failed=self.counts.failed + 1)
            return
        try:
            taken = self._stream.send(frame)
        except OSError as error:
            self._lose(error)
            return
        self.counts = ports.with_outcome(self.counts, taken)

    def receive(self) -> list[bytes]:
        """Return what has arrived, finish the frame that is begun, and see to the connection."""
        if self._stream is None:
            self._open(self._now())
        if self._stream is None:
            return []
        try:
            self._stream.flush()
            data = self._stream.read(ports.MAX_READ_BYTES) if self._events.poll(0) else b""
        except OSError as error:
            self._lose(error)
            return []
        if not data:
            return []
        self._backoff.reset()
        self.counts = replace(self.counts, received=self.counts.received + len(data))
        return [data]

    def close(self) -> None:
        """Close the stream for good."""
        self._opener.close()
        if self._stream is not None:
            self._stream.close()
            self._stream = None
        self._events.close()

    def _open(self, now: float) -> None:
        if self._events.closed or now < self._retry_at:
            return
        try:
            handle = self._opener.poll(now)
        except (OSError, ValueError) as error:  # a ValueError: a name or a rate that the system cannot take
            self._fail(error)
            return
        if handle is not None:
            self._begin(handle)
        elif self._opener.progress:
            self.counts = replace(self.counts, trouble=self._opener.progress)

    def _begin(self, handle: Handle) -> None:
        self._stream = Stream(handle, self._opener.empty_is_end)
        self._events.register(handle.fileno(), select.EPOLLIN)
        self._opened += 1
        baud = self._opener.baud
        self.counts = replace(self.counts, up=True, reconnects=self._opened - 1, baud=baud, trouble="")

    def _lose(self, error: OSError) -> None:
        if self._stream is not None:
            self._events.unregister(self._stream.fileno())
            self._stream.close()
            self._stream = None
        self._fail(error)

    def _fail(self, error: Exception) -> None:
        self.counts = replace(ports.with_failure(self.counts, error), up=False, error=reason(error))
        self._retry_at = self._now() + self._backoff.wait()
