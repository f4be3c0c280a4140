"""The plan that a gimbal, or a vehicle that yaws, follows, and the set-points that are due of it."""

from __future__ import annotations

import math

from ross_payload.actuators.driver_shell import Move
from ross_payload.actuators.mavlink_gimbal.feedback import GimbalFeedback
from ross_payload.actuators.motion import Motion, Trapezoid
from ross_payload.interfaces import Capabilities

SET_POINT_PERIOD_S = 0.02  # between set-points [s]
PAUSE_S = 0.25  # longer without the next set-point, and what follows them has come to rest at the last one [s]
SLOWEST_S, PACE_DECAY = 0.1, 0.8  # of the pace that a plan keeps to [s]; of a slower one from one set-point to the next
ROUNDING_S = 1e-9  # [s], of rounding
STILL_RAD_S = math.radians(0.5)  # what a gimbal at rest trembles with [rad/s]


class SetPoints:
    """What is sent while the gimbal is ours (``motion``), or while a turn of somebody else is braked (``braking``).

    Parameters
    ----------
    capabilities
        Travel and acceleration.
    ahead
        How far ahead of the plan a set-point is [s]: until the next one comes.
    still
        What it trembles with at rest [rad/s].
    """

    def __init__(
        self, capabilities: Capabilities, *, ahead: float = SET_POINT_PERIOD_S, still: float = STILL_RAD_S
    ) -> None:
        self._able = capabilities
        self.ahead = ahead
        self._still = still
        self.motion: Motion | None = None  # None: not in control
        self._turning = False  # the motion leads to a goal; else it brakes, or stays
        self.braking: Motion | None = None
        self.sent = -math.inf  # when the last set-point went out [s]
        self._pace = ahead  # in which set-points go out lately [s]
        self._led = math.inf  # which time of the plan the last set-point was of [s]; infinity: there was none
        self.restless = math.inf  # when the gimbal was last seen away from its goal [s]

    def turn(self, move: Move, position: float, velocity: float, now: float) -> None:
        """Go to a goal from ``position`` [rad] with ``velocity`` [rad/s]."""
        self._go(Trapezoid(position, move.goal, move.rate, self._able.max_acceleration, velocity), now)
        self._turning = True

    def halt(self, now: float) -> None:
        """Decelerate from the last set-point."""
        if self.motion is None:
            return
        position, velocity = self.motion.at(now)
        if velocity:
            self._go(self._to_rest(position, velocity), now)
        elif position != self.motion.plan.goal:  # a goal that was given in this very moment
            self._go(Trapezoid.still(position), now)

    def hold(self, angle: float, now: float) -> None:
        """Stay at an angle [rad]."""
        self._go(Trapezoid.still(self._within(angle)), now)

    def resume(self, seen: GimbalFeedback, move: Move | None, now: float) -> None:
        """Go on from wherever the gimbal is seen and however fast it turns: to a goal, or to rest."""
        position, rate = self._there(seen, now)
        self.braking = None
        if move is not None:
            self.turn(move, position, rate, now)
        elif rate:
            self._go(self._to_rest(position, rate), now)
        else:
            self.hold(position, now)

    def go_on(self, seen: GimbalFeedback, now: float) -> None:
        """Begin anew from where it is seen, if this program was held up in the middle of a motion.

        A turn goes on to its goal; what was to brake stays where it has come to rest. A short delay delays the plan.
        """
        motion = self.motion
        late = self._late(motion, now)
        if motion is None or not late:
            return
        if late <= PAUSE_S:
            self.motion = Motion(motion.plan, motion.begin + late)
        elif self._turning:
            plan = motion.plan
            self.turn(Move(plan.goal, plan.speed), *self._there(seen, now), now)
        else:
            self.resume(seen, None, now)

    def forget_late_brake(self, now: float) -> None:
        """Brake no more what somebody else turned, if this program was held up: they may have turned it since."""
        if self._late(self.braking, now) > PAUSE_S:
            self.braking = None

    def _late(self, motion: Motion | None, now: float) -> float:
        """How late the next set-point of a motion is [s]; 0 when it is not, or the last one was the end."""
        if motion is None:
            return 0.0
        last = max(self.sent, motion.begin)
        late = now - last - max(self.ahead, self._pace)
        return late if late > self.ahead / 2 + ROUNDING_S and motion.end > last else 0.0

    def brake(self, seen: GimbalFeedback, now: float) -> None:
        """Brake what somebody else turns."""
        position, rate = self._there(seen, now)
        if rate:
            self.braking = Motion(self._to_rest(position, rate), now)

    def due(self, motion: Motion, period: float, now: float) -> float | None:
        """Return the set-point that is due [rad]: where it should be when the next one comes; None: not yet."""
        if now - self.sent < period - ROUNDING_S:
            return None
        gap = now - max(self.sent, motion.begin)
        self._pace = max(self.ahead, min(gap, SLOWEST_S), PACE_DECAY * self._pace)
        self.sent = now
        if motion is self.motion:
            motion = self._slowed(motion, gap, now)
        begin = motion.plan.start  # from beyond the travel it may come back, and nothing goes farther
        return min(max(motion.at(now + self._pace)[0], min(self._able.lower, begin)), max(self._able.upper, begin))

    def _slowed(self, motion: Motion, gap: float, now: float) -> Motion:
        """Return the motion, delayed where it would go on for longer than the gap since the last set-point."""
        time = now + self._pace - motion.begin
        if time > self._led + gap + ROUNDING_S:
            self.motion = motion = Motion(motion.plan, motion.begin + time - self._led - gap)
            time = self._led + gap
        self._led = time
        return motion

    def rest(self, seen: GimbalFeedback, resolution: float, now: float) -> tuple[float, float]:
        """Return the rate [rad/s], 0 while it only trembles, and for how long it has rested where it should be [s]."""
        motion = self.motion
        over = motion is None or now >= motion.end
        rate = 0.0 if over and abs(seen.rate) < self._still else seen.rate
        there = motion is None or abs(seen.angle - motion.plan.goal) <= resolution
        if not (over and there and rate == 0.0) or self.restless == math.inf:
            self.restless = now
        return rate, now - self.restless

    def _to_rest(self, position: float, velocity: float) -> Trapezoid:
        """Brake; where that would end beyond the travel, come back to its end."""
        plan = Trapezoid.to_rest(position, velocity, self._able.max_acceleration)
        end = self._within(plan.goal)
        return plan if end == plan.goal else Trapezoid(position, end, plan.speed, plan.acceleration, velocity)

    def _there(self, seen: GimbalFeedback, now: float) -> tuple[float, float]:
        rate = seen.rate if abs(seen.rate) >= self._still else 0.0
        return self._within(seen.angle + rate * (now - seen.time)), rate

    def _within(self, angle: float) -> float:
        return min(max(angle, self._able.lower), self._able.upper)

    def _go(self, plan: Trapezoid, now: float) -> None:
        self.motion, self.restless, self._turning, self._led = Motion(plan, now), now, False, math.inf
        if not plan.velocity:  # a gimbal that follows set-points would see a jump in their rhythm as one of speed
            self.sent, self._pace = -math.inf, self.ahead
