"""What grbl's reports say about the turn: where it is, how fast, since when at rest, and whether it is our move."""

from __future__ import annotations

import math
from collections import deque

from ross_protocols.grbl.protocol import Report, State

SPEED_LEAD_S = 0.045  # the speed in a report is that of the motor so much later: grbl prepares its steps [s]
MOVING = (State.JOG, State.RUN, State.HOLD, State.HOME)
# of the highest speed; farther than needed to brake [rad], [s]
SLOWED_SHARE, BRAKING_MARGIN_RAD, REPORT_DELAY_S = 0.9, math.radians(1), 0.15
MIN_STRANGE_REPORTS = 3  # reports in a row: one may be damaged
TOLERANCE_STEPS = 2  # steps by which a report may be off without being impossible


class PositionTracker:
    """Follows the reports of one axis.

    Parameters
    ----------
    index
        Of the axis.
    resolution
        One step [rad].
    """

    def __init__(self, index: int, resolution: float) -> None:
        self._index = index
        self._resolution = resolution
        self._speeds: deque[tuple[float, float]] = deque(maxlen=8)  # time [s], [rad/s]
        self._nearest = math.inf  # to the goal so far [steps]
        self._peak = 0.0  # highest speed of the jog so far [rad/s]
        self.acceleration = math.inf  # grbl's [rad/s^2]
        self._doubts = 0  # strange reports in a row
        self._rest: int | None = None  # the counter where it is to stay [steps]
        self.count: int | None = None  # grbl's counter
        self.direction = 1
        self.rate = 0.0  # [rad/s]
        self.goal: int | None = None  # of a jog that is to arrive [steps]
        self.ours = True  # whether what moves is our doing
        self.still_since = math.inf  # [s]

    def possible(self, report: Report, elapsed: float, fastest: float) -> bool:
        """Whether the axis can be there, after ``elapsed`` [s] at ``fastest`` [rad/s] at most."""
        count = self.count_of(report)
        if count is None or self.count is None:
            return count is not None
        return abs(count - self.count) * self._resolution <= fastest * elapsed + TOLERANCE_STEPS * self._resolution

    def count_of(self, report: Report) -> int | None:
        """Return the counter that a report tells; None when it tells none of this axis."""
        if report.machine is None or len(report.machine) <= self._index:
            return None
        return round(report.machine[self._index] / self._resolution)

    def on_report(self, report: Report, time: float) -> str:
        """Take in a report made at ``time`` [s]; say what is strange about it."""
        count, before = self.count_of(report), self.count
        if count is None:
            return "grbl reports no machine position of this axis"
        moved = 0 if before is None else count - before
        if moved:
            self.direction = 1 if moved > 0 else -1
        at_rest = report.state not in MOVING
        if not at_rest or moved:
            self.still_since = math.inf
        elif math.isinf(self.still_since):
            self.still_since = time
        self.count = count
        if not at_rest:
            self._speeds.append((time, report.speed or 0.0))
        self.rate = 0.0 if at_rest else self.direction * self._speed(time - SPEED_LEAD_S)
        strange = self._strange(report)
        self._doubts = self._doubts + 1 if strange else 0
        return strange if self._doubts >= MIN_STRANGE_REPORTS else ""

    def begin(self, goal: int, now: float) -> None:
        """Expect a jog of ours to ``goal`` [steps]; it is prepared at once, and so is told to be fast at once."""
        here = goal if self.count is None else self.count
        self.goal, self._nearest, self.still_since, self.ours = goal, abs(goal - here), math.inf, True
        self._peak = 0.0
        self.direction = 1 if goal >= here else -1
        self._speeds.clear()
        self._speeds.append((now - SPEED_LEAD_S, 0.0))

    def _speed(self, time: float) -> float:
        """Return the speed told at ``time`` [s], between two reports where it must be [rad/s]."""
        later = self._speeds[0]
        if time <= later[0]:
            return later[1]
        for earlier, later in zip(self._speeds, list(self._speeds)[1:], strict=False):
            if time <= later[0]:
                part = (time - earlier[0]) / (later[0] - earlier[0])
                return earlier[1] + part * (later[1] - earlier[1])
        return later[1]

    def rest(self) -> None:
        """Expect nothing to move any more."""
        self.goal, self.ours, self._rest = None, False, self.count

    def _strange(self, report: Report) -> str:
        if report.state in (State.RUN, State.CHECK):
            return f"another controller runs a program: grbl reports {report.state}"
        if report.state in (State.HOLD, State.DOOR):
            return f"grbl has stopped: {report.doing}"
        if not self.ours and (report.state is State.JOG or self.count != self._rest):
            return "another controller moves grbl"
        if self.goal is None or self.count is None:
            return ""
        away = abs(self.goal - self.count)
        if away > self._nearest + TOLERANCE_STEPS:
            return "another controller moves grbl: away from the goal"
        self._nearest = min(self._nearest, away)
        return self._misses(report.speed or 0.0, away * self._resolution)

    def _misses(self, speed: float, away: float) -> str:
        """Say when it brakes ``away`` [rad] from the goal, farther than it needs to, or not although it should."""
        self._peak = max(self._peak, speed)
        braking = speed**2 / (2 * self.acceleration) + BRAKING_MARGIN_RAD
        if braking > away + 2 * BRAKING_MARGIN_RAD:
            return "grbl does not brake before the goal: it was told another one"
        needed = braking + REPORT_DELAY_S * speed
        if speed < SLOWED_SHARE * self._peak and away > needed:
            return f"another controller slows grbl down, {math.degrees(away):.1f} deg before the goal"
        return ""
