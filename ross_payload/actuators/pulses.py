"""The pulse wire: what crosses between a step-and-direction driver and whatever times its edges.

Python cannot time steps, so the driver computes every edge in advance and hands them over in short segments.
"""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ross_payload.actuators.wires import connect
from ross_payload.errors import ConfigError, LinkError
from ross_payload.interfaces import Clock, Port

KEPT = 4096  # segments that a recording port remembers at least, of the newest
MOST_EDGES = 1_000_000  # of one segment on a wire

EDGE = np.dtype([("time", np.float64), ("line", np.uint8), ("level", np.bool_)])
Edges = NDArray[np.void]  # of dtype EDGE, sorted by time


class Line(IntEnum):
    """The three opto inputs of a stepper module."""

    STEP = 0
    DIRECTION = 1
    ENABLE = 2


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """A stretch of edges, handed over as one; consecutive segments of one move leave no gap."""

    start: float  # on the Clock [s]
    duration: float  # [s]
    edges: Edges  # times since ``start`` [s], 0 <= time <= duration, read-only, (n,)

    @property
    def end(self) -> float:
        """When the next segment may begin, on the Clock [s]."""
        return self.start + self.duration


@dataclass(frozen=True, slots=True)
class Played:
    """A report: every edge of every segment that ends by ``end`` is out."""

    end: float  # on the Clock [s]


class RecordingPulses:
    """A pulse port that keeps everything sent, and plays it when told the time.

    Parameters
    ----------
    now : callable, optional
        The time [s]; without it somebody else (a far end, a test) calls `play`.
    """

    def __init__(self, now: Callable[[], float] | None = None) -> None:
        self._now = now
        self._waiting: deque[Segment] = deque()
        self._reports: list[Played] = []
        self.sent: list[Segment] = []  # the newest
        self.n_sent = 0

    def send(self, frame: Any) -> None:
        """Queue one Segment."""
        if len(self.sent) >= 2 * KEPT:
            self.sent = self.sent[-KEPT:]
        self.sent.append(frame)
        self.n_sent += 1
        self._waiting.append(frame)

    def receive(self) -> list[Any]:
        """Return the reports since the last call."""
        if self._now is not None:
            self.play(self._now())
        reports, self._reports = self._reports, []
        return reports

    def play(self, now: float) -> None:
        """Report the segments that have ended by ``now`` [s]."""
        while self._waiting and self._waiting[0].end <= now + 1e-9:
            self._reports.append(Played(self._waiting.popleft().end))

    def close(self) -> None:
        """Return at once; what was sent plays to its end, so that a motor is never left at speed."""


class PulseCodec:
    """Segments and reports as bytes: a tag, a fixed head, and 10 bytes per edge; little-endian, all that arrives exact.

    >>> codec = PulseCodec()
    >>> [codec.feed(bytes([byte])) for byte in codec.pack(Played(0.25))][-1]
    [Played(end=0.25)]
    """

    name = "pulses"
    _SEGMENT = struct.Struct("<cddI")  # tag, start [s], duration [s], number of edges
    _PLAYED = struct.Struct("<cd")  # tag, end [s]
    _EDGE = EDGE.newbyteorder("<")

    def __init__(self) -> None:
        self._held = b""

    def pack(self, frame: Any) -> bytes:
        """Turn a Segment or a Played into bytes."""
        if isinstance(frame, Played):
            return self._PLAYED.pack(b"P", frame.end)
        head = self._SEGMENT.pack(b"S", frame.start, frame.duration, len(frame.edges))
        return head + bytes(frame.edges.astype(self._EDGE).tobytes())

    def feed(self, data: bytes) -> list[Segment | Played]:
        """Return the frames that are complete.

        Raises
        ------
        LinkError
            When the bytes are no frame.
        """
        self._held += data
        frames: list[Segment | Played] = []
        while (found := self._first()) is not None:
            frame, size = found
            frames.append(frame)
            self._held = self._held[size:]
        return frames

    def _first(self) -> tuple[Segment | Played, int] | None:
        tag, held = self._held[:1], len(self._held)
        if tag not in (b"", b"P", b"S"):
            raise LinkError(f"not a frame of pulses: {self._held[:8]!r}")
        if held < (self._PLAYED.size if tag == b"P" else self._SEGMENT.size):
            return None
        if tag == b"P":
            return Played(self._PLAYED.unpack_from(self._held)[1]), self._PLAYED.size
        _, start, duration, n = self._SEGMENT.unpack_from(self._held)
        if n > MOST_EDGES:
            raise LinkError(f"not a frame of pulses: {n} edges")
        size = self._SEGMENT.size + n * self._EDGE.itemsize
        if held < size:
            return None
        edges = np.frombuffer(self._held, self._EDGE, n, self._SEGMENT.size).astype(EDGE)
        edges.setflags(write=False)
        return Segment(start, duration, edges), size


class PulseWire:
    """The scheme ``pulses``."""

    def open(self, url: str, clock: Clock) -> Port:
        """Open a port for edges.

        Raises
        ------
        ConfigError
            When the URL names none that exists.
        """
        if url == "pulses:recording":
            return RecordingPulses(clock.now)
        if url.startswith("pulses:tcp:"):
            return connect(url, PulseCodec(), clock)
        raise ConfigError(f"pulse port '{url}' is unknown; there are: pulses:recording, pulses:tcp:HOST:PORT")


wire = PulseWire()
