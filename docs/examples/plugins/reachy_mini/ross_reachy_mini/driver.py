"""The head of a Reachy Mini as an actuator: its yaw is the joint angle.

The daemon takes set-points (``/api/move/ws/set_target``) and jumps to them. So the driver plans the motion and sends
where the head shall be, 50 times a second while something moves; at rest it sends nothing, and others may move the
robot. When this program was held up, the plan goes on from where the head is.
Feedback is the measured pose of the head (``/api/state/ws/full``). A program that dies leaves the head where the last
set-point was: a fiftieth of a second of travel.

Frames to the port are the JSON that the daemon takes: a FullBodyTarget, or ``{"motors": MODE}``. Those from it are
FullState.
"""

import math
from typing import Annotated

from pydantic import Field, model_validator

from ross_payload.actuators.driver_shell import TIME_TOLERANCE_S, Driver, DriverBackend, Move, Request, capabilities_of
from ross_payload.actuators.set_points import SET_POINT_PERIOD_S, SetPoints
from ross_payload.config import Degrees, Positive, Table
from ross_payload.interfaces import ActuatorState, Feedback

PAUSE_S = 0.1  # without a set-point, and the head rests at the last one
FRESH_S = 0.3  # a report that is older proves nothing
STILL_RAD_S = math.radians(0.5)  # slower is at rest
ENABLING_S = 2.0  # that the motors may take until they hold
BEHIND = math.radians(15)  # that the head may be away from its set-point ...
BEHIND_S = 1.0  # ... for so long
UPRIGHT = math.radians(20)  # by which the head may nod or tilt; asleep it hangs
BODY_TRAVEL_DEG, HEAD_TRAVEL_DEG = 160.0, 65.0  # of the body, and of the head against the body, by the maker's manual


class Options(Table):
    """[actuator.options] of ``reachy_mini``; the guard lowers the two caps to its own."""

    port: str = "reachy_mini:localhost:8000"
    body_follows: bool = True  # the body turns with the head; False: it stays, and the travel is 65 deg to both sides
    lower_deg: Annotated[Degrees, Field(le=0)] = -BODY_TRAVEL_DEG
    upper_deg: Annotated[Degrees, Field(ge=0)] = BODY_TRAVEL_DEG
    max_speed_deg_s: Positive = 90.0  # no figure is published: chosen low
    max_acceleration_deg_s2: Positive = 112.5
    resolution_deg: Annotated[float, Field(gt=0, le=5)] = 1.0  # settled within this of the goal
    settle_ms: Annotated[float, Field(ge=0, le=5000)] = 100.0  # at rest at the goal, before that is said

    @model_validator(mode="after")
    def _reaches(self):
        most = BODY_TRAVEL_DEG if self.body_follows else HEAD_TRAVEL_DEG
        if not -most <= self.lower_deg < self.upper_deg <= most:
            limits = f"{self.lower_deg:g} and {self.upper_deg:g}"
            raise ValueError(f"expected lower_deg below upper_deg, within -{most:g} to {most:g}, got {limits}")
        return self


class ReachyMini(Driver):
    """The driver: sans I/O over a port of JSON."""

    def __init__(self, options):
        self._options = options
        self.capabilities = capabilities_of(options, math.radians(options.resolution_deg), Feedback.MEASURED)
        self._angle, self._rate = 0.0, 0.0  # measured
        self._plan = SetPoints(self.capabilities, pause=PAUSE_S)
        self._forget()

    @property
    def identity(self):
        return "Reachy Mini" if self._pose else ""

    def open(self, port, now):
        self._port = port
        self._forget()

    def read(self, now):
        for state in self._port.receive():
            self._on_state(state, now)
        self._plan.catch_up(now, (self._angle, 0.0) if now - self._time <= FRESH_S else None)

    def obey(self, request, now):
        self._restless = now
        if isinstance(request, Move):
            self._go(request, now)
        elif request is Request.HALT:
            self._halt(now)
        elif request is Request.RELEASE:
            self._plan.motion = self._waiting = None
            self._port.send({"motors": "disabled"})
        elif request is Request.HOME:
            self._fault, self._plan.motion, self._waiting = "", None, None

    def write(self, now):
        if self._waiting and self._mode == "enabled":
            move, self._waiting = self._waiting[0], None
            self._start(move, self._angle, 0.0, now)
        elif self._waiting and now > self._waiting[1]:
            self._fail(f"the motors stay {self._mode or 'silent'}: expected enabled")
        motion = self._plan.motion
        due = None if motion is None else self._plan.due(motion, SET_POINT_PERIOD_S, now)
        if due is None:
            return
        self._send(due)
        if abs(due - self._angle) < BEHIND:
            self._followed = now
        if now - self._followed > BEHIND_S:
            self._fail("the head does not follow: does another program move it, or is it blocked?")
        elif now > motion.end and self._settled(now):
            self._plan.motion = None  # the daemon keeps the last target

    def snapshot(self, now):
        return ActuatorState(
            angle=self._angle,
            rate=self._rate,
            settled=not self._fault and self._waiting is None and self._settled(now),
            homed=self._pose is not None,
            healthy=not self._fault,
            time=self._time,
            fault=self._fault,
        )

    def link_lost(self, error):
        self._forget()
        self._fault = str(error)
        return False

    def leave(self, clock):
        self.read(clock.now())
        self._halt(clock.now())
        until = clock.now() + self.capabilities.max_speed / self.capabilities.max_acceleration + 1.0
        yield
        while self._plan.motion is not None and clock.now() < until:
            yield

    def close(self):
        self._port.close()

    # ------------------------------------------------------------------------------------------ reports

    def _forget(self):
        self._pose, self._body, self._mode = None, 0.0, ""
        self._time = self._stamp = -math.inf  # of the last report: here, and when it changed [s]
        self._plan.motion, self._waiting, self._fault = None, None, ""
        self._goal = None
        self._restless = self._followed = -math.inf

    def _on_state(self, state, now):
        try:
            pose = {key: float(state["head_pose"][key]) for key in ("x", "y", "z", "roll", "pitch", "yaw")}
            body, mode = float(state["body_yaw"]), str(state["control_mode"])
        except (KeyError, TypeError, ValueError):
            self._fail(f"the daemon says {str(state)[:60]}")
            return
        if not all(map(math.isfinite, (*pose.values(), body))):
            self._fail("the daemon reports a pose that is no number")
            return
        if self._pose is not None and now > self._time:
            rate = (pose["yaw"] - self._angle) / (now - self._time)
            self._rate = rate if abs(rate) >= STILL_RAD_S else 0.0
        self._pose, self._body, self._mode = pose, body, mode
        self._angle, self._time = pose["yaw"], now
        moving = self._plan.motion is not None and now <= self._plan.motion.end
        away = self._goal is not None and abs(self._angle - self._goal) > self.capabilities.resolution
        if self._rate or moving or away:
            self._restless = now
        if self._plan.motion is not None and mode != "enabled":
            self._fail(f"the motors are {mode}: expected enabled")

    def _settled(self, now):
        still = self._time - self._restless >= self._options.settle_ms * 1e-3 - TIME_TOLERANCE_S
        return still and now - self._time <= FRESH_S

    def _fail(self, why):
        self._fault = self._fault or why
        self._plan.motion = self._waiting = self._goal = None

    # ------------------------------------------------------------------------------------------ motion

    def _go(self, move, now):
        if self._fault:
            return
        if self._pose is None or now - self._time > FRESH_S:
            self._fail("the daemon does not tell where the head is")
        elif max(abs(self._pose["roll"]), abs(self._pose["pitch"])) > UPRIGHT:
            self._fail("the head is not upright: wake the robot up first")
        elif self._plan.motion is not None:
            self._start(move, *self._plan.motion.at(now), now)
        elif self._mode == "enabled":
            self._start(move, self._angle, 0.0, now)
        else:
            self._held, self._base = self._pose, self._body
            self._send(self._angle)  # first, so that motors which come on stay where they are
            self._port.send({"motors": "enabled"})
            self._waiting = (move, now + ENABLING_S)

    def _start(self, move, position, velocity, now):
        if self._plan.motion is None:
            self._held, self._base = self._pose, self._body
        self._plan.turn(move, position, velocity, now)
        self._goal, self._followed = move.goal, now

    def _halt(self, now):
        self._waiting = self._goal = None
        self._plan.halt(now)

    def _send(self, yaw):
        """Send a set-point; all but the yaw stays as it was measured when the turn began."""
        body = yaw if self._options.body_follows else self._base
        self._port.send({"target_head_pose": self._held | {"yaw": yaw}, "target_body_yaw": body})


backend = DriverBackend("Head of a Reachy Mini, through its daemon.", Options, ReachyMini)
