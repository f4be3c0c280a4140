"""One bus for everybody in this program who names the same URL.

Frames are copied to all, and a bus that fails is opened again behind their backs. What one user sends the others do not
hear: they are one node on the bus.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from typing import Any

from ross_payload.dronecan.node import Node
from ross_payload.errors import LinkError, RossError
from ross_payload.interfaces import Clock, Port
from ross_payload.transport.async_task import Backoff, begin

SCHEME = "can:"
MOST_WAITING = 4000  # frames that a user has not taken yet; then the oldest go

OpenPort = Callable[[str], Port]


class SharedBuses:
    """Opens CAN buses, each once.

    >>> from ross_payload.clock import SystemClock
    >>> class Wire:
    ...     def receive(self): return ["frame"]
    ...     def close(self): print("closed")
    >>> buses = SharedBuses(lambda url: Wire(), SystemClock())
    >>> one, other = buses.open("can:x:y"), buses.open("can:x:y")
    >>> one.receive(), other.receive()
    (['frame'], ['frame', 'frame'])
    >>> one.close(); other.close()
    closed
    """

    def __init__(self, open_port: OpenPort, clock: Clock) -> None:
        self._open_port = open_port
        self._clock = clock
        self._buses: dict[str, Bus] = {}

    def open(self, url: str) -> Port:
        """Open a wire; one that is no CAN bus belongs to one user alone.

        Raises
        ------
        RossError
            When it cannot be opened.
        """
        if not url.startswith(SCHEME):
            return self._open_port(url)
        bus = self._buses.get(url)
        if bus is None or not bus.taps:
            bus = self._buses[url] = Bus(lambda: self._open_port(url), self._clock)
        return SharedBusPort(bus)


class Bus:
    """A bus that several use; all calls belong to the pump."""

    def __init__(self, open_port: Callable[[], Port], clock: Clock) -> None:
        self._open_port = open_port
        self._clock = clock
        self._port: Port | None = open_port()
        self._down = ""  # why, in words
        self._coming: Future[Port] | None = None
        self._retry_at = 0.0  # [s]
        self._backoff = Backoff()
        self.taps: list[SharedBusPort] = []
        self.node: Node | None = None

    def send(self, frame: Any) -> None:
        """Send a frame.

        Raises
        ------
        LinkError
            When the bus is down.
        """
        if self._port is None:
            raise LinkError(self._down)
        try:
            self._port.send(frame)
        except LinkError as error:
            self._fall(error)
            raise

    def pull(self) -> None:
        """Hand out what has arrived.

        Raises
        ------
        LinkError
            When the bus is down.
        """
        if self._port is None:
            self._port = self._again()
        try:
            arrived = self._port.receive()
        except LinkError as error:
            self._fall(error)
            raise
        if arrived:
            self._backoff.reset()
        for tap in self.taps:
            tap.waiting.extend(arrived)

    def leave(self, tap: SharedBusPort) -> None:
        """Let one user go; the last one closes the bus."""
        if tap in self.taps:
            self.taps.remove(tap)
        if self.taps:
            return
        if self._port is not None:
            self._port.close()
        if self._coming is not None:
            self._coming.add_done_callback(_close_late)
        self._port, self._coming, self.node = None, None, None

    def _fall(self, error: LinkError) -> None:
        """Give the port back, and open it again after a while."""
        self._down = str(error)
        self._retry_at = self._clock.now() + self._backoff.wait()
        port, self._port = self._port, None
        if port is not None:
            with suppress(RossError):
                port.close()

    def _again(self) -> Port:
        """Return the port that was opened on a thread of its own: that may take seconds."""
        if self._coming is None and self._clock.now() >= self._retry_at:
            self._coming = begin(self._open_port)
        if self._coming is None or not self._coming.done():
            raise LinkError(self._down)
        coming, self._coming = self._coming, None
        try:
            return coming.result()
        except (RossError, OSError) as error:
            self._retry_at = self._clock.now() + self._backoff.wait()
            raise LinkError(self._down) from error  # the first cause, not a new one every time


def _close_late(coming: Future[Port]) -> None:
    if coming.exception() is None:
        coming.result().close()


class SharedBusPort:
    """One user's end of a bus."""

    def __init__(self, bus: Bus) -> None:
        self.bus = bus
        self.waiting: deque[Any] = deque(maxlen=MOST_WAITING)
        bus.taps.append(self)

    def send(self, frame: Any) -> None:
        """Send a frame.

        Raises
        ------
        LinkError
            When the bus is down.
        """
        self.bus.send(frame)

    def receive(self) -> list[Any]:
        """Return what has arrived since the last call.

        Raises
        ------
        LinkError
            When the bus is down.
        """
        self.bus.pull()
        arrived = list(self.waiting)
        self.waiting.clear()
        return arrived

    def close(self) -> None:
        """Leave the bus; idempotent."""
        self.bus.leave(self)


def node_of(port: Port) -> Node | None:
    """Return the node of this program that lives on the bus of a port; None: there is none."""
    return port.bus.node if isinstance(port, SharedBusPort) else None
