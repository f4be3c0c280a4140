"""A servo on a CAN bus that speaks DroneCAN: set-points of our own trapezoid at 50 Hz, position from its Status.

A goal becomes a trapezoid; where it is *now* goes out as a position, a unitless value, a pulse width or the attitude of
a gimbal for as long as a goal is held. Nothing but positions is ever sent, so a program that dies leaves a servo that
stops at the last one.

Only the servo's own reports make it settled. A servo whose Status has no position is driven by a model: its place is
known after `home` has sent it to joint angle 0: as fast as the servo itself can, from where nobody knows.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import replace

from ross_payload.actuators.driver_shell import (
    HELD_UP_S,
    TIME_TOLERANCE_S,
    Driver,
    DriverBackend,
    Move,
    Request,
    capabilities_of,
)
from ross_payload.actuators.dronecan_servo.diagnostics import LATE_REPORT_S, MAX_NOISE_RAD, PositionNoise
from ross_payload.actuators.dronecan_servo.options import Options
from ross_payload.actuators.dronecan_servo.servo_client import ALIVE_TIMEOUT_S, PositionReport, ServoClient
from ross_payload.actuators.set_points import (
    ASTRAY_RAD,
    ASTRAY_S,
    SET_POINT_PERIOD_S,
    UNSEEN_S,
    ReportGaps,
    SetPoints,
)
from ross_payload.errors import LinkError
from ross_payload.interfaces import ActuatorState, Clock, Feedback, Port

PAUSE_S = 0.1  # longer without the next set-point, and the servo has come to rest at the last one [s]
TRAILING_S = 0.2  # one that reports seldom may be where it was told to be so long ago: its report is late [s]


class DronecanServo(Driver):
    """The driver: sans I/O over a port of CAN frames."""

    def __init__(self, options: Options) -> None:
        self._options = options
        self._measured = options.feedback == "measured"
        self._client: ServoClient
        self._reports: deque[PositionReport] = deque()  # of the last settle_ms
        self._angle = 0.0  # last published [rad]
        self._homed = False  # of a model
        self._home_until = math.inf  # a model's homing is over [s]
        self._noise = PositionNoise()
        self._read_at = math.inf  # the bus, last [s]
        self._silence = 0.0  # for so long it was listened to without a word of the servo [s]
        self._gaps = ReportGaps()  # in what is heard of the servo
        self._told: deque[tuple[float, float]] = deque()  # set-points of the last TRAILING_S: [s], [rad]
        self._behind = 0  # reports in a row that were too far behind
        self._fault = ""
        self.capabilities = capabilities_of(options, options.resolution, Feedback(options.feedback))
        self._plan = SetPoints(self.capabilities, lag=options.lag_ms * 1e-3, pause=PAUSE_S)

    @property
    def identity(self) -> str:
        """Name and versions, as the servo tells them."""
        return self._client.identity

    def open(self, port: Port, now: float) -> None:
        """Join the bus and listen."""
        self._client = ServoClient(self._options, port, now, self._angle)
        self._reports.clear()
        self._told.clear()
        self._read_at, self._silence = now, 0.0

    def read(self, now: float) -> None:
        """Read the bus; remember the newest place; latch what is wrong with it or with the bus."""
        self._plan.catch_up(now)  # from the last set-point, where the servo stands
        client, heard_at = self._client, self._heard_at
        client.read(now)
        self._look_for_silence(heard_at, now)
        if client.event:
            self._latch(client.event)
        if client.lost:
            self._let_go()
        client.event, client.lost = "", False
        report, before = client.report, self._reports[-1].time if self._reports else -math.inf
        if self._measured and report.time > before:
            self._reports.append(self._believed(report))
            if report.time - before > UNSEEN_S:
                self._look_again(self._reports[-1].joint, before, now)
            self._stay_where_it_rests(now)
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
            self._halt(now)
        else:
            self._home(now)

    def link_lost(self, error: LinkError) -> bool:
        """Latch it and plan nothing: whoever comes back to the bus must ask again."""
        self._latch(str(error))
        self._let_go()
        return True

    def leave(self, clock: Clock) -> Iterator[None]:
        """Decelerate along the trapezoid, which takes its time."""
        self._plan.catch_up(clock.now())
        self.obey(Request.HALT, clock.now())
        yield
        while self._plan.motion is not None and clock.now() <= self._plan.motion.end + SET_POINT_PERIOD_S:
            yield

    def close(self) -> None:
        """Leave the bus."""
        self._plan.motion = None
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
        motion = self._plan.motion
        if motion is None or self._fault:
            return
        ahead = motion.at(now + self._plan.pace - SET_POINT_PERIOD_S)[0]  # it may be where it was told to be already
        low, high = sorted((motion.at(now)[0], ahead))
        wanted = min(max(joint, low), high)
        behind = abs(joint - wanted) > math.radians(self._options.max_lag_deg)
        self._behind = self._behind + 1 if behind else 0
        if self._behind >= 2:
            here, there = math.degrees(joint), math.degrees(wanted)
            self._latch(f"the servo does not follow: at {here:.1f} deg, commanded {there:.1f} deg")
            self._plan.hold(joint, now)

    @property
    def _heard_at(self) -> float:
        """When the servo told last where it is, or, if it never does, anything [s]."""
        return self._client.report.time if self._measured else self._client.heard_at

    def _look_for_silence(self, heard_at: float, now: float) -> None:
        """Note for how long nothing was heard, not counting a pause of this program.

        A model that was to brake meanwhile has come to rest where its last set-point came.
        """
        listened, self._read_at = min(now - self._read_at, HELD_UP_S), now
        heard = self._heard_at > heard_at
        if heard and not self._measured and self._is_unled(heard_at) and self._plan.brakes_after(heard_at):
            self._lose()
        if heard:
            self._gaps.note(self._heard_at - heard_at)
        self._silence = 0.0 if heard else self._silence + listened

    def _is_unled(self, heard_at: float) -> bool:
        """Tell whether it was to move, and was not heard since ``heard_at`` [s]: nor were we, maybe."""
        motion, supposed = self._plan.motion, self._plan.supposed
        moved = motion is not None and (motion.plan.duration > 0.0 or supposed) and motion.end > heard_at
        late = ALIVE_TIMEOUT_S if self._client.only_beats else self._gaps.unusual(LATE_REPORT_S)
        return moved and self._silence > late

    def _lose(self) -> None:
        self._latch("the servo was to stop while nothing was heard of it: its position is uncertain; home and rearm")
        self._let_go()

    def _look_again(self, joint: float, before: float, now: float) -> None:
        """Go on from where a servo has come to rest that was not heard since ``before`` [s], and got no set-points.

        What was to brake and is not where it should be stays there; a turn that is far from its plan begins again,
        unless reports come as seldom as this.
        """
        motion = self._plan.motion
        if motion is None or motion.end <= before or not math.isfinite(joint):
            return
        angle, rate = motion.at(now)
        behind, unusual = abs(joint - angle), now - before > self._gaps.unusual()
        if self._plan.brakes_after(before):
            told = (angle,) if unusual else (angle, *(asked for time, asked in self._told if time > now - TRAILING_S))
            trails = min(max(joint, min(told)), max(told))
            if abs(joint - trails) > ASTRAY_RAD + ASTRAY_S * abs(rate):
                self._plan.hold(joint, now)
        elif unusual and behind > math.radians(self._options.max_lag_deg):
            self._plan.turn_again(joint, 0.0, now)

    def _stay_where_it_rests(self, now: float) -> None:
        """Let stay where it is seen at rest what was to brake, or to stay, and gets no set-points though it reports.

        Once it gets them again, those of the plan would lead it on at its own speed.
        """
        motion = self._plan.motion
        if motion is None or len(self._reports) < 2 or not (self._plan.may_be_unheard and self._still()):
            return
        joint, (angle, rate) = self._reports[-1].joint, motion.at(now)
        rested = any(not speed and abs(joint - told) <= ASTRAY_RAD for told, speed in self._plan.lately(now))
        if abs(joint - angle) > ASTRAY_RAD + ASTRAY_S * abs(rate) and not rested:  # else its report is late
            self._plan.hold(joint, now)

    def _latch(self, fault: str) -> None:
        self._fault = self._fault or fault

    def _let_go(self) -> None:
        """Send no more set-points; the place of a model is not known any more."""
        self._plan.motion = None
        self._homed, self._home_until = False, math.inf

    # ------------------------------------------------------------------------------------------ plans

    def _go(self, move: Move, now: float) -> None:
        motion = self._plan.motion
        position, velocity = motion.at(now) if motion is not None else (self._angle, 0.0)
        self._plan.turn(move, position, velocity, now)

    def _halt(self, now: float) -> None:
        """Brake; to one that is lost no set-point is sent any more."""
        if not self._measured and self._is_unled(self._heard_at):
            self._lose()
        else:
            self._plan.halt(now)
            self._stay_where_it_rests(now)

    def _home(self, now: float) -> None:
        self._fault, self._homed = "", False
        motion = self._plan.motion
        if not self._measured:
            able = self.capabilities
            if motion is None:
                self._plan.hold(0.0, now)
            else:  # from the last set-point, where it is held
                self._plan.turn(Move(0.0, able.max_speed), *motion.at(now), now)
            self._home_until = now + (able.upper - able.lower) / able.max_speed
        elif motion is not None and self._reports:
            if math.isnan(self._reports[-1].joint):
                self._let_go()
            elif motion.at(now)[1]:
                self._plan.halt(now)
            else:
                self._plan.hold(self._reports[-1].joint, now)

    # ------------------------------------------------------------------------------------------ out

    def write(self, now: float) -> None:
        """Send the set-point that is due, but none that would lead a servo on which has to be heard first."""
        motion = self._plan.motion
        due = None if motion is None else self._plan.due(motion, SET_POINT_PERIOD_S, now)
        if motion is None or due is None:
            return
        ends = self._plan.brakes_after(self._heard_at) or now > motion.end + SET_POINT_PERIOD_S
        if not (ends and self._is_unled(self._heard_at)):
            self._client.command(due)
            self._told.append((now, due))
        while self._told and self._told[0][0] <= now - TRAILING_S:
            self._told.popleft()

    def snapshot(self, now: float) -> ActuatorState:
        """Return the state at ``now`` [s]; a model's is the plan."""
        client = self._client
        motion = self._plan.motion
        if now >= self._home_until and (motion is None or now >= motion.end):
            self._homed, self._home_until = True, math.inf
        wanted, rate = motion.at(now) if motion is not None else (self._angle, 0.0)
        known = bool(self._reports) and math.isfinite(self._reports[-1].joint)
        angle = self._reports[-1].joint if known else self._angle if self._measured else wanted
        arrived = self._still() and self._arrived(angle, now)
        self._plan.obeyed = self._plan.obeyed or arrived
        fault = self._fault or client.nameless or client.condition or (client.missing(now) if self._measured else "")
        self._angle = angle
        return ActuatorState(
            angle=angle,
            rate=rate,
            settled=arrived and not fault,
            homed=known if self._measured else self._homed,
            healthy=not fault,
            time=client.report.time if self._measured else client.heard_at,
            fault=fault,
        )

    def _arrived(self, angle: float, now: float) -> bool:
        """Whether the plan is over and the servo is at its end, as near as it comes to what it was told."""
        motion = self._plan.motion
        if motion is None:
            return True
        over = now >= motion.end + self._options.settle_ms * 1e-3 - TIME_TOLERANCE_S
        goal = self._options.quantised(motion.plan.goal)
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
