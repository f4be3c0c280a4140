"""Where a drive said it was, lately: whether it is still, and whether that can be true."""

from __future__ import annotations

import math
from collections import deque

from ross_payload.actuators.driver_shell import TIME_TOLERANCE_S

REPORT_JITTER_S = 0.04  # by which reports may be late or come together [s]
MAX_JUMP_RAD = math.radians(2)  # more than this between two reports, and the speed does not explain it, is none [rad]


class PositionFilter:
    """Joint angles of the last moments.

    Parameters
    ----------
    settle : float
        For so long it must have been in one place to be still [s].
    top, acceleration : float
        The highest that can be true [rad/s], [rad/s^2].

    Examples
    --------
    >>> positions = PositionFilter(settle=0.1, top=4.0, acceleration=2.0)
    >>> positions.update(0.0, 0.0, 1.00, 0.98), positions.update(0.01, 0.5, 1.02, 1.00)
    ('', '')
    >>> positions.update(0.51, 0.5, 1.04, 1.02)
    'jumps by 28.6 deg at 28.6 deg/s'
    """

    def __init__(self, settle: float, top: float, acceleration: float) -> None:
        self._settle, self._top, self._acceleration = settle, top, acceleration
        self.joint = 0.0  # the last that can be true [rad]
        self._positions: deque[tuple[float, float]] = deque()  # time [s], joint angle [rad]
        self._since = -math.inf  # of the last one [s]

    def clear(self) -> None:
        """Forget all."""
        self._positions.clear()

    def update(self, joint: float, rate: float, now: float, since: float) -> str:
        """Take a report of angle and speed that was sent after ``since`` [s]; say what cannot be true about it."""
        fault = self._doubt(joint, rate, now)
        self._since = since
        self.joint = self.joint if fault else joint
        self._positions.append((now, joint))
        while len(self._positions) > 1 and self._positions[1][0] <= now - self._settle:
            self._positions.popleft()
        return fault

    def still(self, within: float) -> bool:
        """Whether all places of that time are one [rad]; not as long as they are of less."""
        if not self._positions or self._positions[-1][0] - self._positions[0][0] < self._settle - TIME_TOLERANCE_S:
            return False
        joints = [joint for _, joint in self._positions]
        return max(joints) - min(joints) <= within

    def _doubt(self, joint: float, rate: float, now: float) -> str:
        if not self._positions:
            return ""
        _, before = self._positions[-1]
        passed = now - self._since + REPORT_JITTER_S
        way, most = abs(joint - before), abs(rate) * passed + self._acceleration * passed**2 / 2 + MAX_JUMP_RAD
        if abs(rate) > self._top or way > most:
            return f"jumps by {math.degrees(way):.1f} deg at {math.degrees(abs(rate)):.1f} deg/s"
        return ""
