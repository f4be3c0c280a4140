"""Where a MAVLink gimbal says it is, as a joint angle."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

from ross_payload.actuators.mavlink_gimbal.sender_clock import SenderClock, Verdict
from ross_payload.angles import wrap
from ross_protocols.mavlink.gimbal_messages import GimbalAttitude
from ross_protocols.mavlink.vehicle import VehicleAttitude

VEHICLE_TIMEOUT_S = 0.5  # [s]: a vehicle's attitude that is older turns no yaw into a joint angle
# [s] after a report of the device itself in which its manager's prove nothing: for 1 s they repeat it
OWN_REPORT_S = 2.0
JUMP_RAD, OVERSPEED = math.radians(2), 1.5  # no gimbal turns farther between two reports, nor faster than this share
RATE_MARGIN_RAD_S = math.radians(20)  # by which a reported rate may be farther than itself from how angles change
LEAST_S, CHANGE_S = 0.015, 0.1  # over which it is told how they do: what reports in pairs does not turn in between [s]
MARGIN_RAD = math.radians(5)  # by which a gimbal at an end of its travel may seem to be beyond it
JUMP_WEIGHT, MAX_JUMPS = 6, 12  # of a jump against a report without one, and the balance that is no accident


@dataclass(slots=True)
class GimbalFeedback:
    """The latest report. Yaws wrap, joint angles do not: each report continues the last one on the shorter way."""

    lower: float  # travel [rad]
    upper: float
    max_speed: float  # [rad/s]
    cable: bool = True  # turns count, since a cable ends them, and others may turn it
    angle: float = 0.0  # joint angle [rad]
    rate: float = 0.0  # [rad/s]
    change: float = 0.0  # how fast its angle has changed in the last CHANGE_S [rad/s]
    tells_rate: bool = False  # it has told one that was not zero
    time: float = -math.inf  # when it was there [s]; minus infinity: none yet
    arrived_at: float = -math.inf  # when that was told [s]
    failures: int = 0  # flags
    restarted: bool = False  # since somebody looked
    duplicated: bool = False  # two devices report as one
    unseen: bool = False  # it may have turned round while nothing was heard, and its yaw fits two turns of the travel
    lost_vehicle: bool = False  # a yaw from north came and nobody told where the vehicle points
    _clock: SenderClock = field(default_factory=SenderClock)
    _own: float = -math.inf  # when the device itself reported last [s]
    _by_itself: bool = True  # the latest report came from the device, not from its manager
    _jumps: int = 0
    _vehicle: tuple[float, VehicleAttitude] | None = None
    _known: bool = False  # a turn was chosen
    _track: deque[tuple[float, float]] = field(default_factory=deque)  # of the last CHANGE_S: [s], [rad]
    _ends: tuple[float, float] = (math.nan, math.nan)  # between which it can turn [rad]

    def __post_init__(self) -> None:
        """Take it for one that turns as far as is asked for."""
        self.reach(self.lower, self.upper)

    @property
    def jumps(self) -> bool:
        """Whether its angles contradict one another."""
        return self._jumps > MAX_JUMPS

    @property
    def steady(self) -> bool:
        """Whether it has not jumped lately."""
        return self._jumps == 0

    def on_vehicle(self, vehicle: VehicleAttitude, now: float) -> None:
        """Remember where the vehicle points."""
        self._vehicle = now, vehicle

    def on_report(self, attitude: GimbalAttitude, now: float, *, own: bool) -> None:
        """Take in a report of the device itself (``own``) or of its manager; one that is not newer proves nothing."""
        if not own and now - self._own < OWN_REPORT_S:
            return
        if own != self._by_itself:
            self._clock, self._by_itself = SenderClock(), own  # another sender
        verdict = self._clock.judge(attitude.boot, now)
        self.duplicated = self.duplicated or verdict is Verdict.TWO
        if verdict in (Verdict.OLD, Verdict.TWO):
            return
        self.restarted = self.restarted or verdict is Verdict.RESTARTED
        base = self._base(now) if attitude.earth else (0.0, 0.0)
        self.lost_vehicle, self.failures = base is None, attitude.failures
        self._own = now if own else self._own
        if base is not None:
            late = self._clock.lateness(attitude.boot, now)
            self._update(attitude.yaw - base[0], None if attitude.rate is None else attitude.rate - base[1], now - late)
            self.arrived_at = now

    def forget(self) -> None:
        """Believe no report that came before."""
        self.time = self.arrived_at = self._own = -math.inf
        self._clock = SenderClock()
        self.clear_doubts()
        self.lost_vehicle = False
        self._track.clear()

    def recount_turns(self) -> None:
        """Choose the turn inside the travel again."""
        self.angle = self._first(wrap(self.angle))
        self._track.clear()

    def reach(self, lower: float, upper: float) -> None:
        """Learn how far it can turn [rad], where that is farther than we ask for; NaN: not known."""
        self._ends = min(self.lower, lower), max(self.upper, upper)

    def trust_turn(self) -> None:
        """Believe that it has not turned round unseen, as somebody says."""
        self.unseen = False

    def trust_clock(self) -> None:
        """Believe that the next report is not late, as somebody says."""
        self._clock.forget_lateness()

    def clear_doubts(self) -> None:
        """Forget what contradicted."""
        self.restarted = self.duplicated = False
        self._jumps = 0

    def _base(self, now: float) -> tuple[float, float] | None:
        """Yaw [rad] and its rate [rad/s] of the vehicle at ``now`` [s]; None when nobody knows."""
        if self._vehicle is None or now - self._vehicle[0] > VEHICLE_TIMEOUT_S:
            return None
        time, vehicle = self._vehicle
        return vehicle.yaw + vehicle.yaw_rate * (now - time), vehicle.yaw_rate

    def _update(self, yaw: float, rate: float | None, time: float) -> None:
        passed = time - self.time
        half = self.cable and math.pi / self.max_speed < passed < math.inf  # long enough for half a turn
        doubtful, turns = self._known and (half or self.unseen), self._turns(wrap(yaw), *self._ends, MARGIN_RAD)
        self.unseen = doubtful and len(turns) > 1
        goes_on = self._known and (self.unseen or not (doubtful and turns))
        first = turns[0] if doubtful and turns else self._first(wrap(yaw))
        angle = self.angle + wrap(yaw - self.angle) if goes_on else first
        if not goes_on:
            self._track.clear()
        step = (angle - self.angle) / passed if 0 < passed < VEHICLE_TIMEOUT_S else 0.0
        self.rate = self._rate_of(rate, step, angle, time)
        self.tells_rate = self.tells_rate or bool(rate)
        jumped = goes_on and abs(angle - self.angle) > JUMP_RAD + OVERSPEED * self.max_speed * max(passed, 0.0)
        self._jumps = min(self._jumps + JUMP_WEIGHT, 2 * MAX_JUMPS) if jumped else max(self._jumps - 1, 0)
        self.angle, self.time, self._known = angle, time, True

    def _rate_of(self, rate: float | None, step: float, angle: float, time: float) -> float:
        """Return a reported rate [rad/s], or how fast the angle changes where that contradicts it.

        A brake is planned with it: one in degrees per second, say, would lead on to the end of the travel. Where it is
        missing the latest ``step`` counts [rad/s].
        """
        change = self._change(angle, time)
        self.change = step if change is None else change
        if rate is None:
            return step
        if change is not None and abs(rate - change) > abs(change) + RATE_MARGIN_RAD_S:
            return change
        fastest = OVERSPEED * self.max_speed
        return min(max(rate, -fastest), fastest) if change is None else rate

    def _change(self, angle: float, time: float) -> float | None:
        """Return how fast the angle has changed in the last `CHANGE_S` [rad/s]; None: that is not known."""
        while self._track and time - self._track[0][0] >= VEHICLE_TIMEOUT_S:
            self._track.popleft()
        while len(self._track) > 1 and time - self._track[1][0] >= CHANGE_S:
            self._track.popleft()
        begin, before = self._track[0] if self._track else (time, angle)
        self._track.append((time, angle))
        return (angle - before) / (time - begin) if time - begin >= LEAST_S else None

    def _first(self, yaw: float) -> float:
        """Choose a turn inside the travel; where two are, the one near zero."""
        return next(iter(self._turns(yaw, self.lower, self.upper)), yaw)

    def _turns(self, yaw: float, lower: float, upper: float, margin: float = 0.0) -> list[float]:
        """Return the joint angles inside a travel that have a yaw, the one near zero first."""
        turns = (yaw, yaw - 2 * math.pi, yaw + 2 * math.pi)
        return [turn for turn in turns if lower - margin <= turn <= upper + margin]
