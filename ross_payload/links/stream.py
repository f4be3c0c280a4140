"""Byte streams in which frames are never cut, and which are opened again when they are lost."""

from __future__ import annotations

import os
import select
from dataclasses import replace
from typing import Protocol

from ross_payload.interfaces import Clock
from ross_payload.links.background import Backoff
from ross_payload.links.ports import MOST, Counts, noted


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
        self._rest = b""
        self._news = select.poll()
        self._news.register(handle.fileno(), select.POLLIN)

    def send(self, frame: bytes) -> bool:
        """Send one frame; tell whether the stream took it."""
        self.flush()
        if self._rest:
            return False
        self._rest = frame
        self.flush()
        return True

    def flush(self) -> None:
        """Go on with the frame that is begun."""
        if self._rest:
            try:
                self._rest = self._rest[os.write(self._handle.fileno(), self._rest) :]
            except BlockingIOError:
                return

    def read(self, most: int) -> bytes:
        """Return what has arrived."""
        news = self._news.poll(0)
        if not news:
            return b""
        try:
            data = os.read(self._handle.fileno(), most)
        except BlockingIOError:
            return b""
        if not data and (self._empty_is_end or news[0][1] & (select.POLLHUP | select.POLLERR)):
            raise ConnectionResetError(0, "the other side closed the connection")
        return data

    def close(self) -> None:
        """Close the handle."""
        self._handle.close()


class Opener(Protocol):
    """Opens a connection step by step."""

    empty_is_end: bool
    baud: int

    def poll(self, now: float) -> Handle | None:
        """Return the handle when it is open, None while that takes longer; OSError when it failed."""

    def close(self) -> None:
        """Give up what is half open."""


class StreamPort:
    """A TCP connection or a serial line, opened again, after a pause, whenever it is lost."""

    def __init__(self, opener: Opener, clock: Clock, handle: Handle | None = None) -> None:
        self._opener = opener
        self._clock = clock
        self._backoff = Backoff()
        self._next = clock.now()
        self._stream: Stream | None = None
        self._opened = 0
        self._closed = False
        self.counts = Counts(up=False)
        if handle is not None:
            self._begin(handle)

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
        field = "sent" if taken else "dropped"
        self.counts = replace(self.counts, **{field: getattr(self.counts, field) + 1})

    def receive(self) -> list[bytes]:
        """Return what has arrived, finish the frame that is begun, and see to the connection."""
        if self._stream is None:
            self._open(self._clock.now())
        if self._stream is None:
            return []
        try:
            self._stream.flush()
            data = self._stream.read(MOST)
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
        self._closed = True
        self._opener.close()
        if self._stream is not None:
            self._stream.close()
            self._stream = None

    def _open(self, now: float) -> None:
        if self._closed or now < self._next:
            return
        try:
            handle = self._opener.poll(now)
        except OSError as error:
            self.counts = replace(noted(self.counts, error), error=error.strerror or str(error))
            self._next = now + self._backoff.wait()
            return
        if handle is not None:
            self._begin(handle)

    def _begin(self, handle: Handle) -> None:
        self._stream = Stream(handle, self._opener.empty_is_end)
        self._opened += 1
        self.counts = replace(self.counts, up=True, reconnects=self._opened - 1, baud=self._opener.baud)

    def _lose(self, error: OSError) -> None:
        self.counts = replace(noted(self.counts, error), up=False, error=error.strerror or str(error))
        if self._stream is not None:
            self._stream.close()
            self._stream = None
        self._next = self._clock.now() + self._backoff.wait()
