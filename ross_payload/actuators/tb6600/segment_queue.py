"""Hands a train of edges to a pulse port a little ahead of time, and knows what is out and what is still open."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from ross_payload.actuators.motion import Trapezoid
from ross_payload.actuators.tb6600.pulse_segments import EDGE, Edges, Level, Played, PulseLine, RanOut, Segment
from ross_payload.actuators.tb6600.step_edges import EdgeTrain, LineState, PulseTiming, Signs, after, train
from ross_payload.errors import LinkError
from ross_payload.interfaces import Port, Real

MIN_SEGMENT_S = 0.001  # of a segment that is not the last [s]
REPORT_TIMEOUT_S = 0.020  # how late a report may be before what is known counts as old [s]
MAX_RECENT_SEGMENTS = 256  # segments handed over whose steps are kept, to tell where the counter was: over a second


@dataclass(frozen=True, slots=True)
class _Steps:
    """The steps of one segment, at least one."""

    first: float  # [s]
    last: float  # [s]
    sum: int
    times: Real
    signs: Signs

    def after(self, time: float) -> int:
        """Sum of those later than ``time`` [s].

        >>> steps = _Steps(1.0, 2.0, 2, np.array([1.0, 2.0]), np.array([1, 1]))
        >>> [steps.after(time) for time in (0.5, 1.0, 1.5, 2.0)]
        [2, 1, 1, 0]
        """
        if self.first > time:
            return self.sum
        return int(self.signs[np.searchsorted(self.times, time, side="right") :].sum())


class SegmentQueue:
    """Segments up to ``ahead`` [s] beyond the present; the future is open from `committed` on.

    Parameters
    ----------
    timing : PulseTiming
        Timing and polarity of the edges.
    resolution : float
        One step [rad].
    ahead : float
        So far ahead of time edges are handed over [s].
    """

    def __init__(self, timing: PulseTiming, resolution: float, ahead: float) -> None:
        self._timing = timing
        self._resolution = resolution
        self._ahead = ahead
        self._port: Port | None = None
        self._line_state = LineState()
        self._rest = EdgeTrain(np.empty(0, EDGE), np.empty(0), np.empty(0, np.int64), -math.inf)
        self._outstanding: deque[float] = deque()  # ends of segments not yet reported [s]
        self._recent: deque[_Steps] = deque(maxlen=MAX_RECENT_SEGMENTS)  # handed over
        self.committed = -math.inf  # end of the last segment handed over [s]

    @property
    def pending(self) -> bool:
        """Whether some of the train has not been handed over."""
        return self._rest.end > self.committed

    @property
    def all_reported(self) -> bool:
        """Whether the port has reported every segment."""
        return not self._outstanding

    @property
    def position(self) -> float:
        """Where the counter is when all that was handed over is out [rad]."""
        return self._line_state.count * self._resolution

    def open(self, port: Port) -> None:
        """Use a port; nobody knows the level of its DIRECTION."""
        self._port = port
        self._line_state = replace(self._line_state, direction=0)
        self._outstanding.clear()

    def close(self) -> None:
        """Hand over the whole train and give the port back, also when it does not take the train."""
        port = self._port
        if port is None:
            return
        try:
            self.flush()
        finally:
            self._outstanding.clear()
            self._port = None
            port.close()

    def receive(self) -> list[Level | RanOut]:
        """Take in what has been played; return the other reports that have arrived."""
        others: list[Level | RanOut] = []
        for report in self._port.receive() if self._port is not None else ():
            if not isinstance(report, Played):
                others.append(report)
                continue
            while self._outstanding and self._outstanding[0] <= report.end + 1e-9:
                self._outstanding.popleft()
        return others

    def load(self, plan: Trapezoid, begin: float) -> None:
        """Replace what has not been handed over by a plan that begins at ``begin`` >= `committed` [s]."""
        self.committed = begin
        self._rest = train(plan, begin, self._line_state, self._timing, self._resolution)

    def top_up(self, now: float) -> None:
        """Hand over what comes next, up to ``ahead`` after ``now`` [s]; reports come too late to wait for them."""
        if self.pending and now + self._ahead - self.committed >= MIN_SEGMENT_S:
            self._hand_over(now + self._ahead)

    def flush(self) -> None:
        """Hand over all the rest at once."""
        if self.pending:
            self._hand_over(math.inf)

    def switch(self, line: PulseLine, level: bool, begin: float, duration: float) -> None:
        """Hand over one edge at ``begin`` [s], and let nothing follow for ``duration`` [s]."""
        self.committed = begin
        self._send(np.array([(0.0, line, level)], dtype=EDGE), duration)

    def shift(self, n_steps: int) -> None:
        """Call the place where the counter is by another number, ``n_steps`` more."""
        self._line_state = replace(self._line_state, count=self._line_state.count + n_steps)

    def angle(self, time: float) -> float:
        """The counter at ``time`` [s], up to a second ago, in radians: steps handed over whose time has come."""
        ahead = 0
        for steps in reversed(self._recent):
            if steps.first > time:
                ahead += steps.sum
            elif steps.last > time:
                ahead += steps.after(time)
            else:
                break
        return (self._line_state.count - ahead) * self._resolution

    def known(self, now: float) -> float:
        """Until when the port's reports vouch for the model [s]: ``now``, or less when a report is overdue."""
        oldest = self._outstanding[0] if self._outstanding else now
        return now if oldest + REPORT_TIMEOUT_S >= now else oldest

    def _hand_over(self, until: float) -> None:
        """Cut what comes before ``until`` [s] off the train and send it."""
        rest, start = self._rest, self.committed
        last = rest.end <= until
        end = rest.end if last else until
        n_edges = len(rest.edges) if last else int(np.searchsorted(rest.edges["time"], end))
        n_steps = len(rest.steps) if last else int(np.searchsorted(rest.steps, end))
        edges, steps, signs = rest.edges[:n_edges], rest.steps[:n_steps], rest.signs[:n_steps]
        relative = edges.copy()
        relative["time"] -= start
        self._send(relative, end - start)
        self._line_state = after(self._line_state, edges, steps, signs, self._timing)
        if n_steps:
            self._recent.append(_Steps(float(steps[0]), float(steps[-1]), int(signs.sum()), steps, signs))
        end = self.committed if last else rest.end
        self._rest = EdgeTrain(rest.edges[n_edges:], rest.steps[n_steps:], rest.signs[n_steps:], end)

    def _send(self, edges: Edges, duration: float) -> None:
        if self._port is None:
            raise LinkError("the pulse port is closed")
        edges.setflags(write=False)
        segment = Segment(self.committed, duration, edges)
        self._port.send(segment)
        self._outstanding.append(segment.end)
        self.committed = segment.end
