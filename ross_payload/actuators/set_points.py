"""The plan that a device follows by set-points, each a little ahead of it, and how it goes on when they come late."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator

from ross_payload.actuators.driver_shell import TIME_TOLERANCE_S, Move
from ross_payload.actuators.motion import Motion, Trapezoid
from ross_payload.interfaces import Capabilities

SET_POINT_PERIOD_S = 0.02  # between set-points [s]
UNSEEN_S = 0.15  # longer between two reports, and the device may have got no set-points either [s]
UNUSUAL, N_GAPS, OUTAGES = 2.5, 9, 2  # times the longest of the last so many gaps but two, which may be outages
ASTRAY_RAD, ASTRAY_S = math.radians(2), 0.05  # farther from its plan than the lag of a gimbal or servo [rad], [s]
TRAILING_S = 0.3  # by so much what follows may be late, with its report [s]
SLOWEST_S, PACE_DECAY = 0.1, 0.8  # of the pace that a plan keeps to [s]; of a slower one from one set-point to the next


class ReportGaps:
    """What is a gap between reports: much longer than is usual of this device.

    >>> gaps = ReportGaps()
    >>> for gap in 0.1, 0.9, 0.1, 0.9, 0.1, 0.9, 0.1, 0.9, 0.1:  # of two that come once a second
    ...     gaps.note(gap)
    >>> gaps.unusual()
    2.25
    """

    def __init__(self) -> None:
        self._last: deque[float] = deque(maxlen=N_GAPS)

    def note(self, gap: float) -> None:
        """Take in the time from one report to the next [s]."""
        if 0.0 < gap < math.inf:
            self._last.append(gap)

    def unusual(self, least: float = UNSEEN_S) -> float:
        """Return the time that no two reports are apart [s], which is ``least`` or more."""
        usual = sorted(self._last)[-OUTAGES - 1] if len(self._last) > OUTAGES else 0.0
        return max(least, UNUSUAL * usual)


class SetPoints:
    """What is sent while the device is ours: positions on the way of ``motion``.

    They come at the pace of the polls. A late poll delays the plan, and after a pause it starts again from where the
    device has come to rest: no set-point asks for more of the plan than has passed since the one before.

    Parameters
    ----------
    capabilities
        Travel and acceleration.
    ahead
        How far ahead of the plan a set-point is [s]: until the next one comes.
    lag
        Of the device behind its set-points, which lead by as much more [s].
    pause
        Longer without the next set-point, and the device has come to rest at the last one [s].
    """

    def __init__(
        self, capabilities: Capabilities, *, ahead: float = SET_POINT_PERIOD_S, lag: float = 0.0, pause: float
    ) -> None:
        self._able = capabilities
        self.ahead = ahead
        self._lag = lag
        self._pause = pause
        self.motion: Motion | None = None  # None: not in control
        self._before: deque[tuple[float, Motion]] = deque(maxlen=32)  # motions that it has left, when [s]
        self._turning = False  # the motion leads to a goal; else it brakes, or stays
        self.sent = -math.inf  # when the last set-point went out [s]
        self.pace = ahead  # in which set-points go out lately [s]
        self._led = math.inf  # which time of the plan the last set-point was of [s]; infinity: there was none
        self._asked: float | None = None  # the last set-point [rad]; None: none since it began from rest
        self._again = math.nan  # where this turn was begun again last [rad]
        self.supposed = False  # it began, unseen, at the last set-point before a pause, which may not have arrived
        self.obeyed = False  # the device has rested at the end of the motion

    def turn(self, move: Move, position: float, velocity: float, now: float) -> None:
        """Go to a goal from ``position`` [rad] with ``velocity`` [rad/s]."""
        self._go(Trapezoid(position, move.goal, move.rate, self._able.max_acceleration, velocity), now)
        self._turning, self._again = True, math.nan

    def turn_again(self, position: float, velocity: float, now: float) -> None:
        """Begin a turn again from where an outage has left the device [rad], unless it did so there before.

        One that is jammed has to be found behind its plan.
        """
        motion = self.motion
        if motion is not None and not abs(position - self._again) <= ASTRAY_RAD:
            self.turn(Move(motion.plan.goal, motion.plan.speed), position, velocity, now)
            self._again = position

    def halt(self, now: float) -> None:
        """Decelerate from the last set-point."""
        self._turning = False  # nor does it go on, where the plan is over and the device is not there
        if self.motion is None:
            return
        position, velocity = self.motion.at(now)
        if velocity:
            self._go(self._to_rest(position, velocity), now)
        elif position != self.motion.plan.goal:  # a goal that was given in this very moment
            supposed = self.supposed
            self._go(Trapezoid.still(position), now)
            self.supposed = supposed

    def hold(self, angle: float, now: float) -> None:
        """Stay at an angle [rad]."""
        self._go(Trapezoid.still(self._within(angle)), now)

    def settle(self, position: float, velocity: float, now: float) -> None:
        """Come to rest from ``position`` [rad] with ``velocity`` [rad/s]."""
        if velocity:
            self._go(self._to_rest(position, velocity), now)
        else:
            self.hold(position, now)

    def late(self, motion: Motion | None, now: float) -> float:
        """How late the next set-point of a motion is [s]; 0 when it is not, or the last one was the end."""
        if motion is None:
            return 0.0
        last = max(self.sent, motion.begin)
        late = now - last - max(self.ahead, self.pace)
        return late if late > self.ahead / 2 + TIME_TOLERANCE_S and motion.end > last else 0.0

    def catch_up(self, now: float, seen: tuple[float, float] | None = None) -> None:
        """Start again after a pause in the middle of a motion.

        A turn goes on to its goal; what was to brake stays where it has come to rest. A short delay delays the plan.

        Parameters
        ----------
        now
            [s].
        seen
            Where the device is [rad] and how fast it turns [rad/s]; None: at rest at the last set-point.
        """
        motion, late = self.motion, self.late(self.motion, now)
        if motion is None or not late:
            return
        position, velocity = seen or (motion.plan.start if self._asked is None else self._asked, 0.0)
        if late <= self._pause:
            self.motion = Motion(motion.plan, motion.begin + late)
            return
        if self._turning:
            self.turn(Move(motion.plan.goal, motion.plan.speed), position, velocity, now)
        else:
            self.settle(position, velocity, now)
        self.supposed = seen is None

    def brakes_after(self, time: float) -> bool:
        """Tell whether it brakes, or was to brake, later than ``time`` [s]."""
        return self.motion is not None and not self._turning and self.motion.end > time

    @property
    def may_be_unheard(self) -> bool:
        """Whether it was to brake or to stay, and the device has not been seen to do so: it may get no set-points."""
        return self.motion is not None and not (self._turning or self.obeyed)

    def lately(self, now: float) -> Iterator[tuple[float, float]]:
        """Yield where the device was to be in the last `TRAILING_S` [rad], and how fast [rad/s], the latest first."""
        for step in range(round(TRAILING_S / ASTRAY_S) + 1):
            time = now - step * ASTRAY_S
            motion = next((left for until, left in self._before if time < until), self.motion)
            if motion is not None:
                yield motion.at(time)

    def due(self, motion: Motion, period: float, now: float) -> float | None:
        """Return the set-point that is due [rad]: where it should be when the next one comes; None: not yet."""
        if now - self.sent < period - TIME_TOLERANCE_S:
            return None
        gap = now - max(self.sent, motion.begin)
        self.pace = max(self.ahead, min(gap, SLOWEST_S), PACE_DECAY * self.pace)
        self.sent = now
        if motion is self.motion:
            motion = self._slowed(motion, gap, now)
        begin = motion.plan.start  # from beyond the travel it may come back, and nothing goes farther
        ahead = motion.at(now + self.pace + self._lag)[0]
        self._asked = min(max(ahead, min(self._able.lower, begin)), max(self._able.upper, begin))
        return self._asked

    def _slowed(self, motion: Motion, gap: float, now: float) -> Motion:
        """Return the motion, delayed where it would go on for longer than the gap since the last set-point."""
        time = now + self.pace - motion.begin
        if time > self._led + gap + TIME_TOLERANCE_S:
            self.motion = motion = Motion(motion.plan, motion.begin + time - self._led - gap)
            time = self._led + gap
        self._led = time
        return motion

    def _to_rest(self, position: float, velocity: float) -> Trapezoid:
        """Brake; where that would end beyond the travel, come back to its end."""
        plan = Trapezoid.to_rest(position, velocity, self._able.max_acceleration)
        end = self._within(plan.goal)
        return plan if end == plan.goal else Trapezoid(position, end, plan.speed, plan.acceleration, velocity)

    def _within(self, angle: float) -> float:
        return min(max(angle, self._able.lower), self._able.upper)

    def _go(self, plan: Trapezoid, now: float) -> None:
        if self.motion is not None:
            self._before.append((now, self.motion))
        self.motion, self._turning, self._led = Motion(plan, now), False, math.inf
        self.supposed = self.obeyed = False
        if not plan.velocity:  # a device that follows set-points would see a jump in their rhythm as one of speed
            self.sent, self.pace, self._asked = -math.inf, self.ahead, None
