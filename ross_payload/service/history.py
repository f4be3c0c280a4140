"""Where the array pointed while the audio was captured: audio is read late, so the past must be kept."""

from __future__ import annotations

from bisect import bisect_left, bisect_right

from ross_payload.interfaces import ActuatorState

AHEAD = 0.1  # [s] beyond the newest report that its rate is trusted
MOST = 20_000  # reports kept at least, of the newest: more than three minutes of the pump


class JointHistory:
    """The latest reports of an actuator; written by the pump, read by the mission's thread.

    >>> history = JointHistory()
    >>> for time, angle in ((0.0, 0.0), (1.0, 0.5)):
    ...     history.note(ActuatorState(angle, 0.5, settled=False, homed=True, healthy=True, time=time))
    >>> history.angle(0.5), history.angle(1.1)
    (0.25, 0.55)
    """

    def __init__(self) -> None:
        self._kept: tuple[list[float], list[ActuatorState]] = ([], [])  # times [s] and reports; only ever appended to

    def note(self, report: ActuatorState) -> None:
        """Keep a report; one of the same time as the last one takes its place."""
        times, reports = self._kept
        if times and report.time <= times[-1]:
            reports[-1] = report
            return
        if len(times) >= 2 * MOST:  # others may be reading the old lists
            self._kept = times, reports = times[-MOST:], reports[-MOST:]
        reports.append(report)
        times.append(report.time)

    def angle(self, time: float) -> float | None:
        """Return the joint angle [rad] at ``time`` [s], interpolated; None when nothing was ever reported."""
        times, reports = self._kept
        count = len(times)
        if not count:
            return None
        after = bisect_right(times, time, 0, count)
        if after == count:
            newest = reports[count - 1]
            return newest.angle + newest.rate * min(time - times[count - 1], AHEAD)
        if after == 0:
            return reports[0].angle
        share = (time - times[after - 1]) / (times[after] - times[after - 1])
        return reports[after - 1].angle + share * (reports[after].angle - reports[after - 1].angle)

    def settled(self, begin: float, end: float) -> bool:
        """Tell whether all reports from ``begin`` to ``end`` [s], and the last one before, say settled."""
        times, reports = self._kept
        count = len(times)
        first = max(bisect_right(times, begin, 0, count) - 1, 0)
        last = bisect_left(times, end, 0, count)
        return count > 0 and all(report.settled for report in reports[first : max(last, first + 1)])
