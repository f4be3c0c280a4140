"""The pulse wire: what crosses between a step-and-direction driver and whatever times its edges.

Python cannot time steps, so the driver computes every edge in advance and hands them over in short segments.
"""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import IntEnum
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ross_payload.errors import LinkError

MIN_RECORDED_SEGMENTS = 4096  # segments that a recording port remembers at least, of the newest
RECORDING = "pulses:recording"  # the URL of a wire that ends in memory
MAX_EDGES = 1_000_000  # of one segment on a wire

EDGE = np.dtype([("time", np.float64), ("line", np.uint8), ("level", np.bool_)])
Edges = NDArray[np.void]  # of dtype EDGE, sorted by time


class PulseLine(IntEnum):
    """The three opto inputs of a stepper module, and the switch at the array's home."""

    STEP = 0
    DIRECTION = 1
    ENABLE = 2
    HOME = 3  # an input of ours: its level is reported


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


def takes_steps(segment: Segment) -> bool:
    """Whether any edge of a segment is a step: only then can the position be lost when it comes too late."""
    return bool(((segment.edges["line"] == PulseLine.STEP) & segment.edges["level"]).any())


def without_steps(segment: Segment) -> Segment:
    """Return what is left of a segment that came too late: every level that it sets, and no new step."""
    edges = segment.edges
    return replace(segment, edges=edges[(edges["line"] != PulseLine.STEP) | ~edges["level"]])


@dataclass(frozen=True, slots=True)
class Played:
    """A report: every edge of every segment that ends by ``end`` is out."""

    end: float  # on the Clock [s]


@dataclass(frozen=True, slots=True)
class RanOut:
    """A report: of the segment that ends at ``end`` no step went out; it came when nothing was left to play."""

    end: float  # on the Clock [s]


@dataclass(frozen=True, slots=True)
class Level:
    """A report: the level of an input."""

    line: PulseLine
    level: bool  # high or low
    time: float  # on the Clock [s]


Report = Played | RanOut | Level


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
        self._reports: list[Report] = []
        self.sent: list[Segment] = []  # the newest
        self.n_sent = 0
        self.mute = False  # what is played is not reported, until it may be again

    def send(self, frame: Any) -> None:
        """Queue one Segment."""
        if len(self.sent) >= 2 * MIN_RECORDED_SEGMENTS:
            self.sent = self.sent[-MIN_RECORDED_SEGMENTS:]
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
        while not self.mute and self._waiting and self._waiting[0].end <= now + 1e-9:
            self._reports.append(Played(self._waiting.popleft().end))

    def report(self, report: Report) -> None:
        """Leave a report for the next `receive`."""
        self._reports.append(report)

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
    _END = struct.Struct("<cd")  # tag, end [s]
    _LEVEL = struct.Struct("<cB?d")  # tag, line, level, time [s]
    _HEADS = MappingProxyType({b"S": _SEGMENT, b"P": _END, b"R": _END, b"L": _LEVEL})
    _EDGE = EDGE.newbyteorder("<")

    def __init__(self) -> None:
        self._held = b""

    def pack(self, frame: Any) -> bytes:
        """Turn a Segment or a report into bytes."""
        if isinstance(frame, Level):
            return self._LEVEL.pack(b"L", frame.line, frame.level, frame.time)
        if isinstance(frame, Played | RanOut):
            return self._END.pack(b"P" if isinstance(frame, Played) else b"R", frame.end)
        head = self._SEGMENT.pack(b"S", frame.start, frame.duration, len(frame.edges))
        return head + bytes(frame.edges.astype(self._EDGE).tobytes())

    def feed(self, data: bytes) -> list[Segment | Report]:
        """Return the frames that are complete.

        Raises
        ------
        LinkError
            When the bytes are no frame.
        """
        self._held += data
        frames: list[Segment | Report] = []
        while (found := self._first()) is not None:
            frame, size = found
            frames.append(frame)
            self._held = self._held[size:]
        return frames

    def _first(self) -> tuple[Segment | Report, int] | None:
        tag = self._held[:1]
        head = self._HEADS.get(tag)
        if head is None:
            if tag:
                raise LinkError(f"not a frame of pulses: {self._held[:8]!r}")
            return None
        if len(self._held) < head.size:
            return None
        _, *values = head.unpack_from(self._held)
        if tag == b"S":
            return self._segment(*values)
        return self._report(tag, values), head.size

    def _report(self, tag: bytes, values: list[Any]) -> Report:
        if tag != b"L":
            return Played(*values) if tag == b"P" else RanOut(*values)
        line, level, time = values
        if line not in tuple(PulseLine):
            raise LinkError(f"not a frame of pulses: line {line}")
        return Level(PulseLine(line), level, time)

    def _segment(self, start: float, duration: float, n: int) -> tuple[Segment, int] | None:
        if n > MAX_EDGES:
            raise LinkError(f"not a frame of pulses: {n} edges")
        size = self._SEGMENT.size + n * self._EDGE.itemsize
        if len(self._held) < size:
            return None
        edges = np.frombuffer(self._held, self._EDGE, n, self._SEGMENT.size).astype(EDGE)
        edges.setflags(write=False)
        return Segment(start, duration, edges), size
