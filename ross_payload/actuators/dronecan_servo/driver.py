"""A servo on a CAN bus that speaks DroneCAN: set-points of our own trapezoid at 50 Hz, position from its Status.

A goal becomes a trapezoid; where it is *now* goes out as a position, a unitless value, a pulse width or the attitude of
a gimbal for as long as a goal is held. Nothing but positions is ever sent, so a program that dies leaves a servo that
stops at the last one.

Only the servo's own reports make it settled. A servo whose Status has no position is driven by a model: its place is
known after `home` has sent it to joint angle 0.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import replace

from ross_payload.actuators.driver_shell import TIME_TOLERANCE_S, Driver, DriverBackend, Move, Request, capabilities_of
from ross_payload.actuators.dronecan_servo.diagnostics import MAX_NOISE_RAD, PositionNoise
from ross_payload.actuators.dronecan_servo.options import Options
from ross_payload.actuators.dronecan_servo.servo_client import PositionReport, ServoClient
from ross_payload.actuators.motion import Motion, Trapezoid
from ross_payload.errors import LinkError
from ross_payload.interfaces import ActuatorState, Clock, Feedback, Port

SET_POINT_PERIOD_S = 0.020  # [s] between two set-points
PACE_DECAY = 0.8  # from one set-point to the next, of a pace that was slower
SET_POINT_GAP_S = 5 * SET_POINT_PERIOD_S  # without a set-point, and the servo has come to rest at the last one [s]


class DronecanServo(Driver):
    """The driver: sans I/O over a port of CAN frames."""

    def __init__(self, options: Options) -> None:
        self._options = options
        self._measured = options.feedback == "measured"
        self._lag = options.lag_ms * 1e-3  # of the servo behind its set-points [s]
        self._client: ServoClient
        self._motion: Motion | None = None  # None: nothing is sent
        self._turning = False  # the motion leads to a goal; else it brakes, or stays
        self._reports: deque[PositionReport] = deque()  # of the last settle_ms
        self._angle = 0.0  # last published [rad]
        self._homed = False  # of a model
        self._home_until = math.inf  # a model's homing is over [s]
        self._noise = PositionNoise()
        self._behind = 0  # reports in a row that were too far behind
        self._due = -math.inf  # the next set-point [s]
        self._sent = -math.inf  # the last one [s]
        self._pace = SET_POINT_PERIOD_S  # in which set-points come lately [s]
        self._led: tuple[Trapezoid | None, float] = (None, math.inf)  # which time of which plan it was led to last [s]
        self._fault = ""
        self.capabilities = capabilities_of(options, options.resolution, Feedback(options.feedback))

    @property
    def identity(self) -> str:
        """Name and versions, as the servo tells them."""
        return self._client.identity

    def open(self, port: Port, now: float) -> None:
        """Join the bus and listen."""
        self._client = ServoClient(self._options, port, now)
        self._reports.clear()

    def read(self, now: float) -> None:
        """Read the bus; remember the newest place; latch what is wrong with it or with the bus."""
        self._go_on(now)
        client = self._client
        client.read(now)
        if client.event:
            self._latch(client.event)
        if client.lost:
            self._let_go()
        client.event, client.lost = "", False
        report = client.report
        if self._measured and report.time > (self._reports[-1].time if self._reports else -math.inf):
            self._reports.append(self._believed(report))
            self._check_lag(self._reports[-1].joint, now)
        while len(self._reports) > 1 and self._reports[1].time <= now - self._options.settle_ms * 1e-3:
            self._reports.popleft()

    def obey(self, request: Move | Request, now: float) -> None:
        """Plan; a release sends no more set-points: a servo that gives up without them lets go, any other holds."""
        if isinstance(request, Move):
            if not self._fault:
                self._go(request, now)
        elif request is Request.RELEASE:
            self._let_go()
        elif request is Request.HALT:
            self._brake(now)
        else:
            self._home(now)

    def link_lost(self, error: LinkError) -> bool:
        """Latch it and plan nothing: whoever comes back to the bus must ask again."""
        self._latch(str(error))
        self._let_go()
        return True

    def leave(self, clock: Clock) -> Iterator[None]:
        """Decelerate along the trapezoid, which takes its time."""
        self._go_on(clock.now())
        self.obey(Request.HALT, clock.now())
        yield
        while self._motion is not None and clock.now() <= self._motion.end + SET_POINT_PERIOD_S:
            yield

    def close(self) -> None:
        """Leave the bus."""
        self._motion = None
        self._client.close()

    # ------------------------------------------------------------------------------------------ what is heard

    def _believed(self, report: PositionReport) -> PositionReport:
        """Return a place, without its angle when that cannot be; latch why."""
        margin = math.radians(self._options.max_lag_deg)
        if math.isnan(report.joint):
            self._latch("the servo reports no position; set feedback = 'model' if it has no sensor")
        elif not self.capabilities.lower - margin <= report.joint <= self.capabilities.upper + margin:
            self._latch(f"the servo reports {math.degrees(report.joint):.6g} deg, which is outside its travel")
            return replace(report, joint=math.nan)
        elif self._noise.update(report.joint, report.count) > max(MAX_NOISE_RAD, 1.2 * self.capabilities.resolution):
            self._latch("the reported position of the servo is noisy: check its encoder and its cables")
        return report

    def _check_lag(self, joint: float, now: float) -> None:
        """Latch that the servo does not follow, and hold where it is; one report alone may be a stranger's."""
        if self._motion is None or self._fault:
            return
        ahead = self._motion.at(now + self._pace - SET_POINT_PERIOD_S)[0]  # it may be where it was told to be already
        low, high = sorted((self._motion.at(now)[0], ahead))
        wanted = min(max(joint, low), high)
        behind = abs(joint - wanted) > math.radians(self._options.max_lag_deg)
        self._behind = self._behind + 1 if behind else 0
        if self._behind >= 2:
            here, there = math.degrees(joint), math.degrees(wanted)
            self._latch(f"the servo does not follow: at {here:.1f} deg, commanded {there:.1f} deg")
            self._hold(joint, now)

    def _latch(self, fault: str) -> None:
        self._fault = self._fault or fault

    def _let_go(self) -> None:
        """Send no more set-points; the place of a model is not known any more."""
        self._motion, self._homed, self._home_until = None, False, math.inf

    # ------------------------------------------------------------------------------------------ plans

    def _go(self, move: Move, now: float) -> None:
        position, velocity = self._motion.at(now) if self._motion is not None else (self._angle, 0.0)
        self._motion = Motion(
            Trapezoid(position, move.goal, move.rate, self.capabilities.max_acceleration, velocity), now
        )
        self._turning = True
        if not velocity:
            self._due = now  # at once
            self._sent, self._pace = now - SET_POINT_PERIOD_S, SET_POINT_PERIOD_S

    def _slow(self, motion: Motion, gap: float, now: float) -> None:
        """Delay the plan where it would go on for longer than the gap since the last set-point."""
        plan, led = self._led
        time = now + self._pace - motion.begin
        if plan is motion.plan and time > led + gap + TIME_TOLERANCE_S:
            self._motion = Motion(motion.plan, motion.begin + time - led - gap)
            time = led + gap
        self._led = motion.plan, time

    def _go_on(self, now: float) -> None:
        """Begin anew after a gap in the set-points, in which the servo has come to rest at the last one.

        A turn goes on to its goal; what was to brake stays. A short delay delays the plan.
        """
        motion, led_until = self._motion, self._due - SET_POINT_PERIOD_S + self._pace
        late = now - led_until
        if motion is None or late <= SET_POINT_PERIOD_S / 2 + TIME_TOLERANCE_S or motion.end <= led_until:
            return
        if late <= SET_POINT_GAP_S:
            self._motion = Motion(motion.plan, motion.begin + late)
            return
        there, plan = motion.at(led_until + self._lag)[0], motion.plan
        self._due, self._sent, self._pace = now, now - SET_POINT_PERIOD_S, SET_POINT_PERIOD_S
        if self._turning:
            self._motion = Motion(Trapezoid(there, plan.goal, plan.speed, plan.acceleration), now)
        else:
            self._hold(there, now)

    def _home(self, now: float) -> None:
        self._fault, self._homed = "", False
        if not self._measured:
            self._hold(0.0, now)
            travel = self.capabilities.upper - self.capabilities.lower
            self._home_until = now + travel / self.capabilities.max_speed
        elif self._motion is not None and self._reports:
            if math.isnan(self._reports[-1].joint):
                self._let_go()
            elif self._motion.at(now)[1]:
                self._brake(now)
            else:
                self._hold(self._reports[-1].joint, now)

    def _hold(self, joint: float, now: float) -> None:
        here = min(max(joint, self.capabilities.lower), self.capabilities.upper)
        self._motion, self._turning = Motion(Trapezoid.still(here), now), False

    def _brake(self, now: float) -> None:
        if self._motion is not None:
            self._motion, self._turning = self._motion.braked(now, self.capabilities.max_acceleration), False

    # ------------------------------------------------------------------------------------------ out

    def write(self, now: float) -> None:
        """Send the set-point that is due."""
        if self._motion is not None and now >= self._due - TIME_TOLERANCE_S:
            gap, self._sent = now - self._sent, now
            self._pace = max(SET_POINT_PERIOD_S, min(gap, SET_POINT_GAP_S), PACE_DECAY * self._pace)
            self._due = (self._due if now - self._due < SET_POINT_PERIOD_S else now) + SET_POINT_PERIOD_S
            self._slow(self._motion, gap, now)
            ahead = self._pace + self._lag  # where it should be when the next one comes, had it no lag
            self._client.command(self._motion.at(now + ahead)[0])

    def snapshot(self, now: float) -> ActuatorState:
        """Return the state at ``now`` [s]; a model's is the plan."""
        client = self._client
        if now >= self._home_until:
            self._homed, self._home_until = True, math.inf
        wanted, rate = self._motion.at(now) if self._motion is not None else (self._angle, 0.0)
        known = bool(self._reports) and math.isfinite(self._reports[-1].joint)
        angle = self._reports[-1].joint if known else self._angle if self._measured else wanted
        fault = self._fault or client.nameless or client.condition or (client.missing(now) if self._measured else "")
        self._angle = angle
        return ActuatorState(
            angle=angle,
            rate=rate,
            settled=not fault and self._still() and self._arrived(angle, now),
            homed=known if self._measured else self._homed,
            healthy=not fault,
            time=client.report.time if self._measured else client.heard_at,
            fault=fault,
        )

    def _arrived(self, angle: float, now: float) -> bool:
        """Whether the plan is over and the servo is at its end, as near as it comes to what it was told."""
        if self._motion is None:
            return True
        over = now >= self._motion.end + self._options.settle_ms * 1e-3 - TIME_TOLERANCE_S
        goal = self._options.quantised(self._motion.plan.goal)
        return over and (not self._measured or abs(angle - goal) <= self.capabilities.resolution)

    def _still(self) -> bool:
        """Whether all reports of the last settle_ms are of one place."""
        if not self._measured:
            return self._homed
        joints = [report.joint for report in self._reports]
        return bool(joints) and max(joints) - min(joints) <= self.capabilities.resolution


backend = DriverBackend(
    "Servo on a CAN bus that speaks DroneCAN: commands at 50 Hz, position from its Status.", Options, DronecanServo
)
