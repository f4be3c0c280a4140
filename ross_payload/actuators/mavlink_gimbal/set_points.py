"""The plan that a gimbal, or a vehicle that yaws, follows, between what its reports tell and what others do with it."""

from __future__ import annotations

import math

from ross_payload.actuators.driver_shell import Move
from ross_payload.actuators.mavlink_gimbal.feedback import GimbalFeedback
from ross_payload.actuators.motion import Motion, Trapezoid
from ross_payload.actuators.set_points import ASTRAY_RAD, ASTRAY_S, UNSEEN_S, ReportGaps, SetPoints
from ross_payload.interfaces import Capabilities

PAUSE_S = 0.25  # longer without the next set-point, and what follows them has come to rest at the last one [s]
FRESH_S = 0.1  # a report that is older is no place to brake from [s]
STILL_RAD_S = math.radians(0.5)  # what a gimbal at rest trembles with [rad/s]
RESTED_S = 0.3  # at rest where it should be for as long, it has obeyed a stop [s]


class YawSetPoints(SetPoints):
    """What is sent while the yaw is ours (``motion``), or while a turn of somebody else is braked (``braking``).

    Parameters
    ----------
    capabilities
        Travel and acceleration.
    still
        What it trembles with at rest [rad/s].
    astray
        What is farther from its plan than this [rad], and this many [s] more, does not only lag.
    """

    def __init__(
        self,
        capabilities: Capabilities,
        *,
        still: float = STILL_RAD_S,
        astray: tuple[float, float] = (ASTRAY_RAD, ASTRAY_S),
    ) -> None:
        super().__init__(capabilities, pause=PAUSE_S)
        self._still, self._astray = still, astray
        self._gaps = ReportGaps()
        self.braking: Motion | None = None
        self.restless = math.inf  # when it was last seen away from its goal [s]
        self._seen_at = -math.inf  # [s]

    def hold(self, angle: float, now: float) -> None:
        """Stay at an angle [rad], also where somebody else has turned it beyond the travel that we keep to."""
        self._go(Trapezoid.still(angle), now)

    def resume(self, seen: GimbalFeedback, move: Move | None, now: float) -> None:
        """Go on from wherever it is seen and however fast it turns: to a goal, or to rest."""
        position, rate = self._there(seen, now)
        self.braking = None
        if move is not None:
            self.turn(move, position, rate, now)
        else:
            self.settle(position, rate, now)

    def go_on(self, seen: GimbalFeedback | None, now: float) -> None:
        """Start again from where it is seen, or was sent last, if this program paused in the middle of a motion."""
        self.catch_up(now, None if seen is None else self._there(seen, now))

    def look_again(self, seen: GimbalFeedback, now: float, *, believed: bool) -> None:
        """Go on from where it is seen after a while without reports: it may have got no set-points either.

        Then it has come to rest at the last one, and the plan has gone on. What was to brake brakes from there, where
        reports come as seldom as this only if it is far from its plan and so rests sooner; a turn that is far from its
        plan begins again, unless reports come as seldom as this. Nobody goes on from where it is not ``believed`` to
        be.
        """
        if now - seen.time > FRESH_S or seen.time <= self._seen_at:
            return
        gap, before, self._seen_at = seen.time - self._seen_at, self._seen_at, seen.time
        unusual = self._gaps.unusual()
        self._gaps.note(gap)
        motion = self.motion
        if motion is None or not believed or motion.end <= before:
            return
        (angle, rate), (far, lag) = motion.at(seen.time), self._astray
        astray = abs(angle - seen.angle) > far + lag * abs(rate)
        sooner = gap > UNSEEN_S and astray and self._rests_sooner(seen, motion, now)
        if not self._turning and (gap > unusual or sooner):
            self.resume(seen, None, now)
        elif self._turning and gap > unusual and astray:
            self.braking = None
            self.turn_again(*self._there(seen, now), now)

    def brake_where_it_is(self, seen: GimbalFeedback, now: float) -> None:
        """Brake from where it is seen what was to brake, or to stay, and gets no set-points though it is heard.

        It is far from its plan then, and slower than half of it, and was not told to be so lately: once it gets
        set-points again, those of the plan would lead it on at its own speed. What has once obeyed stays where it was
        told to.
        """
        motion = self.motion
        if motion is None or not self.may_be_unheard or now - seen.time > FRESH_S:
            return
        (angle, rate), (far, lag) = motion.at(seen.time), self._astray
        slow = self._slower(seen, rate) if rate else abs(_rate(seen)) < self._still
        if slow and abs(angle - seen.angle) > far + lag * abs(rate) and not self._trails(seen):
            position, velocity = self._there(seen, now)
            self.settle(position, velocity if velocity * rate > 0.0 or not rate else 0.0, now)

    def _trails(self, seen: GimbalFeedback) -> bool:
        """Tell whether it is, late, where and as fast as it was told to be."""
        far, lag = self._astray
        return any(
            abs(angle - seen.angle) <= far + lag * abs(rate) and not self._slower(seen, rate)
            for angle, rate in self.lately(seen.time)
        )

    @staticmethod
    def _slower(seen: GimbalFeedback, rate: float) -> bool:
        """Tell whether it turns less than half as fast as told [rad/s]; what swings back comes to rest by itself."""
        return _rate(seen) * rate < rate**2 / 2

    def forget_late_brake(self, now: float) -> None:
        """Brake no more what somebody else turned, if this program was held up: they may have turned it since."""
        if self.late(self.braking, now) > PAUSE_S:
            self.braking = None

    def brake(self, seen: GimbalFeedback, now: float) -> None:
        """Brake what somebody else turns."""
        position, rate = self._there(seen, now)
        if rate:
            self.braking = Motion(self._to_rest(position, rate), now)

    def rest(self, seen: GimbalFeedback, resolution: float, now: float) -> tuple[float, float]:
        """Return the rate [rad/s], 0 while it only trembles, and for how long it has rested where it should be [s]."""
        motion = self.motion
        over = motion is None or now >= motion.end
        rate = 0.0 if over and abs(seen.rate) < self._still else seen.rate
        there = motion is None or abs(seen.angle - motion.plan.goal) <= resolution
        if not (over and there and rate == 0.0) or self.restless == math.inf:
            self.restless = now
        self.obeyed = self.obeyed or now - self.restless >= RESTED_S
        return rate, now - self.restless

    def rests_sooner_as_planned(self, seen: GimbalFeedback, now: float) -> bool:
        """Tell whether what brakes turns less when it goes on as planned than when it brakes from where it is seen."""
        motion = self.motion
        return motion is not None and self.brakes_after(seen.time) and not self._rests_sooner(seen, motion, now)

    def _rests_sooner(self, seen: GimbalFeedback, motion: Motion, now: float) -> bool:
        """Tell whether it turns less when it brakes from where it is seen than when it follows its plan."""
        position, rate = self._there(seen, now)
        return abs(self._to_rest(position, rate).goal - position) < abs(motion.plan.goal - position)

    def _there(self, seen: GimbalFeedback, now: float) -> tuple[float, float]:
        rate = seen.rate if abs(seen.rate) >= self._still else 0.0
        return seen.angle + rate * (now - seen.time), rate

    def _go(self, plan: Trapezoid, now: float) -> None:
        super()._go(plan, now)
        self.restless = now


def _rate(seen: GimbalFeedback) -> float:
    return seen.rate if seen.tells_rate else seen.change
