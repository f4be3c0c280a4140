"""The far end of an actuator for a payload in another process: a TCP server on a thread of its own.

The world computes a little behind the clock, so that what a payload sends has time to arrive. Edges carry the time at
which they are due and are reported when the *clock* has passed it, as a pulse generator would; the motor follows when
the world gets there. What carries no time takes effect when it arrived.
"""

from __future__ import annotations

import json
import select
import socket
import threading
from abc import ABC, abstractmethod
from contextlib import suppress
from dataclasses import asdict, replace
from queue import SimpleQueue
from typing import Any, Protocol, Self

from ross_payload import plugins
from ross_payload.actuators.tb6600.pulse_segments import Level, PulseCodec, RanOut, RecordingPulses, Segment
from ross_payload.actuators.wires import Codec, TcpWire, connect, greeting, served_at
from ross_payload.actuators.wires.codecs import CanCodec, RawCodec
from ross_payload.errors import LinkError, refused_as
from ross_payload.interfaces import Clock, Port
from ross_payload.transport.async_task import drained
from ross_payload.transport.link_url import host_and_port
from ross_sim.devices.ideal import Goal, Halt, Report

TICK = 0.002  # [s] between two looks at the wire
IDLE = 0.1  # [s] between two looks for a payload
GROUP = "ross_sim.wires"
FRAMES = {"goal": Goal, "halt": Halt, "report": Report}


class IdealCodec:
    """Goals, halts and reports, one JSON line each; times in reports are on the Clock of both processes.

    >>> IdealCodec().feed(IdealCodec().pack(Halt(2.0)))
    [Halt(acceleration=2.0)]
    """

    name = "ideal"

    def __init__(self) -> None:
        self._held = b""

    def pack(self, frame: Any) -> bytes:
        """Turn a frame into a line."""
        return json.dumps({type(frame).__name__.lower(): asdict(frame)}).encode() + b"\n"

    def feed(self, data: bytes) -> list[Any]:
        """Return the frames of all whole lines."""
        *lines, self._held = (self._held + data).split(b"\n")
        return [_frame(line) for line in lines]


class IdealWire:
    """The scheme ``ideal``."""

    def open(self, url: str, clock: Clock) -> Port:
        """Connect to a device in another process."""
        return connect(url, IdealCodec(), clock)

    def check(self, url: str) -> None:
        """Refuse what is no place of a device in another process."""
        served_at(url)


class Side(Protocol):
    """Couples a wire to a far end; `arrived` and `due` belong to the wire's thread, `exchange` to the world's."""

    codec: type[Codec]

    def arrived(self, frame: Any, now: float) -> None:
        """Take a frame from the payload at ``now`` on the Clock [s]."""

    def due(self, now: float) -> list[Any]:
        """Return what is to be sent to the payload at ``now`` on the Clock [s]."""

    def exchange(self, begin: float) -> None:
        """Before a quantum that begins at ``begin`` [s of the world]: give to the far end, take from it."""


class PulseSide:
    """Plays edges by the clock and hands them to the module; ``epoch`` is the world's time 0 on the Clock [s]."""

    codec = PulseCodec

    def __init__(self, port: Port, epoch: float) -> None:
        self._port = port
        self._epoch = epoch
        self._player = RecordingPulses()
        self._inbox: SimpleQueue[Segment] = SimpleQueue()
        self._noticed: SimpleQueue[Level | RanOut] = SimpleQueue()

    def arrived(self, frame: Any, now: float) -> None:
        """Queue a segment for its time."""
        self._player.send(frame)
        self._inbox.put(replace(frame, start=frame.start - self._epoch))

    def due(self, now: float) -> list[Any]:
        """Return reports of the segments that have ended, and what the module has noticed."""
        self._player.play(now)
        return [*self._player.receive(), *drained(self._noticed)]

    def exchange(self, begin: float) -> None:
        """Give the module all that has arrived; what it says of segments played comes too late for a payload.

        One that is mute is so here, too.
        """
        self._player.mute = getattr(self._port, "mute", False)
        for segment in drained(self._inbox):
            self._port.send(segment)
        for report in self._port.receive():
            if isinstance(report, Level):
                self._noticed.put(replace(report, time=report.time + self._epoch))
            elif isinstance(report, RanOut):
                self._noticed.put(replace(report, end=report.end + self._epoch))


class FrameSide:
    """Lets frames take effect when they arrived, and hands on what the device says.

    ``epoch`` is the world's time 0 on the Clock [s].
    """

    codec: type[Codec]

    def __init__(self, port: Port, epoch: float) -> None:
        self._port = port
        self._epoch = epoch
        self._inbox: SimpleQueue[tuple[float, Any]] = SimpleQueue()
        self._outbox: SimpleQueue[Any] = SimpleQueue()
        self._waiting: list[tuple[float, Any]] = []

    def arrived(self, frame: Any, now: float) -> None:
        """Keep a frame with the world's time of its arrival."""
        self._inbox.put((now - self._epoch, frame))

    def due(self, now: float) -> list[Any]:
        """Return what the device has said."""
        return list(drained(self._outbox))

    def exchange(self, begin: float) -> None:
        """Give the device what has arrived by then, and take what it says."""
        self._waiting += drained(self._inbox)
        while self._waiting and self._waiting[0][0] <= begin:
            self._port.send(self._waiting.pop(0)[1])
        for frame in self._port.receive():
            self._outbox.put(self._dated(frame))

    def _dated(self, frame: Any) -> Any:
        """Return a frame of the device with its times on the Clock; most carry none."""
        return frame


class IdealSide(FrameSide):
    """The scheme ``ideal``: reports tell where the device was a moment ago."""

    codec = IdealCodec

    def _dated(self, frame: Report) -> Report:
        return replace(frame, time=frame.time + self._epoch)


class SerialSide(FrameSide):
    """The scheme ``serial``: bytes, in whatever pieces they come."""

    codec = RawCodec


class CanSide(FrameSide):
    """The scheme ``can``: the frames of a bus."""

    codec = CanCodec


def side_of(scheme: str, port: Port, epoch: float) -> Side:
    """Make the side that fits a scheme of actuator wires.

    Raises
    ------
    PluginError
        When devices of that scheme cannot be served to another process.
    """
    made: Side = plugins.load(GROUP, scheme)(port, epoch)
    return made


class Served(ABC):
    """What serves a payload on a thread of its own until it is left; a context manager."""

    def __init__(self, side: Side, clock: Clock, name: str) -> None:
        self._side = side
        self._clock = clock
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._serve, name=name)

    @abstractmethod
    def _serve(self) -> None:
        """Serve until `_stopping` is set."""

    @abstractmethod
    def _close(self) -> None:
        """Give back what is open."""

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._stopping.set()
        self._thread.join()
        self._close()


class WireServer(Served):
    """Serves one payload at a time; the next one waits until it leaves.

    Raises
    ------
    LinkError
        When the address cannot be listened on.
    """

    def __init__(self, host: str, port: int, side: Side, clock: Clock) -> None:
        super().__init__(side, clock, "wire")
        self.used = False  # whether a payload was ever connected
        self._listener = listen(host, port)
        self.port: int = self._listener.getsockname()[1]

    def _close(self) -> None:
        self._listener.close()

    def _serve(self) -> None:
        while not self._stopping.is_set():
            self._side.due(self._clock.now())  # nobody is there to hear it
            if select.select([self._listener], [], [], IDLE)[0]:
                with self._listener.accept()[0] as connection, suppress(OSError, LinkError):
                    self._attend(connection)  # until the payload leaves; what it sent is played to its end

    def _attend(self, connection: socket.socket) -> None:
        codec = self._side.codec()
        connection.sendall(greeting(codec, self._clock))
        wire = TcpWire(connection, codec, "payload")
        self.used = True
        while not self._stopping.is_set():
            select.select([wire], [], [], TICK)
            now = self._clock.now()
            for frame in wire.receive():
                self._side.arrived(frame, now)
            for frame in self._side.due(now):
                wire.send(frame)


def listen(host: str, port: int) -> socket.socket:
    """Listen on a TCP port; 0: one that is free.

    Raises
    ------
    LinkError
        When that is not possible.
    """
    with refused_as(LinkError, f"tcp:{host_and_port(host, port)}: cannot listen"):
        return socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET)


def _frame(line: bytes) -> Any:
    try:
        ((name, values),) = json.loads(line).items()
        return FRAMES[name](**values)
    except (ValueError, TypeError, AttributeError, KeyError) as error:
        raise LinkError(f"not a frame of an ideal actuator: {line[:40]!r}") from error


ideal = IdealWire()
