"""The pulse wire: what crosses between a step-and-direction driver and whatever times its edges.

Python cannot time steps, so the driver computes every edge in advance and hands them over in short segments.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Port

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
        self.sent: list[Segment] = []

    def send(self, frame: Any) -> None:
        """Queue one Segment."""
        self.sent.append(frame)
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


def open_pulses(url: str, now: Callable[[], float]) -> Port:
    """Open a pulse port from its URL.

    Raises
    ------
    ConfigError
        When the URL names none that exists.
    """
    if url == "pulses:recording":
        return RecordingPulses(now)
    raise ConfigError(f"pulse port '{url}' is unknown; there are: pulses:recording")
