"""Attitudes of the recent past: audio is read late, and asks where the base pointed when it was captured."""

from __future__ import annotations

from bisect import bisect_right

from ross_payload.angles import wrap
from ross_payload.interfaces import Attitude
from ross_protocols.vehicle import VehicleAttitude

AHEAD = 0.1  # [s] beyond the newest report that its rate is trusted
MOST = 5000  # reports kept at least, of the newest: 100 s at 50 Hz


class AttitudeHistory:
    """The latest reports of a vehicle; written by the pump, read by the mission's thread.

    Parameters
    ----------
    fresh
        An attitude whose latest report is older than this [s] is not known.
    """

    def __init__(self, fresh: float) -> None:
        self._fresh = fresh
        self._kept: tuple[list[float], list[VehicleAttitude]] = ([], [])  # times [s] and reports; only appended to

    def note(self, time: float, report: VehicleAttitude) -> None:
        """Keep a report of ``time`` [s]; one that is not newer than the last one is dropped."""
        times, reports = self._kept
        if times and time <= times[-1]:
            return
        if len(times) >= 2 * MOST:  # others may be reading the old lists
            self._kept = times, reports = times[-MOST:], reports[-MOST:]
        reports.append(report)
        times.append(time)

    def newest(self) -> float | None:
        """Return the time of the latest report [s]."""
        times, _ = self._kept
        return times[-1] if times else None

    def at(self, time: float) -> Attitude:
        """Return the attitude at ``time`` [s]: interpolated, or a little ahead of the newest report.

        ``age`` is that of the last report before; ``sigma`` is what the rate may have changed by since, no more: what
        the compass is worth nobody knows here. Not known means yaw 0, the frame of the mount.
        """
        times, reports = self._kept
        count = len(times)
        after = bisect_right(times, time, 0, count)
        if after == 0 or time - times[after - 1] > self._fresh:
            return Attitude(0.0, age=time - times[after - 1] if after else float("inf"), known=False)
        last, age = reports[after - 1], time - times[after - 1]
        if after < count and times[after] - times[after - 1] <= self._fresh:
            return _between(last, reports[after], age / (times[after] - times[after - 1]), age)
        yaw = wrap(last.yaw + last.yaw_rate * min(age, AHEAD))
        return Attitude(yaw, last.pitch, last.roll, sigma=abs(last.yaw_rate) * age, age=age)


def _between(one: VehicleAttitude, other: VehicleAttitude, share: float, age: float) -> Attitude:
    yaw, pitch, roll = (
        wrap(a + share * wrap(b - a))
        for a, b in ((one.yaw, other.yaw), (one.pitch, other.pitch), (one.roll, other.roll))
    )
    return Attitude(yaw, pitch, roll, age=age)
