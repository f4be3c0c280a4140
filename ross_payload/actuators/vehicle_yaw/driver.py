"""A multicopter that its autopilot yaws: the joint angle is the yaw of the vehicle, counter-clockwise from north.

A goal becomes a trapezoid, and the trapezoid set-points a little ahead of the vehicle: when the payload dies, the
vehicle goes to the last one and its autopilot holds it there. Only the attitude tells where it is.

The vehicle is the pilot's. It is turned only for a task, while it flies, armed and in the mode for it; the yaw stick or
another mode ends a turn, and nothing begins it again but an operator. A stop is the autopilot's own: it holds its yaw.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from ross_payload.actuators.driver_shell import (
    TIME_TOLERANCE_S,
    Driver,
    DriverBackend,
    DriverShell,
    Move,
    Request,
    capabilities_of,
)
from ross_payload.actuators.mavlink_gimbal.component_port import ReceivedPacket
from ross_payload.actuators.mavlink_gimbal.feedback import GimbalFeedback
from ross_payload.actuators.mavlink_gimbal.set_points import FRESH_S, YawSetPoints
from ross_payload.actuators.vehicle_yaw import diagnostics
from ross_payload.actuators.vehicle_yaw.flight_watch import FlightWatch
from ross_payload.actuators.vehicle_yaw.options import Options
from ross_payload.actuators.vehicle_yaw.yaw_commands import YawCommands, commands_of
from ross_payload.interfaces import ActuatorState, Clock, Feedback, Port
from ross_protocols.mavlink import vehicle, vehicle_control
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.gimbal_messages import GimbalAttitude
from ross_protocols.mavlink.vehicle import AUTOPILOT, VehicleAttitude

STILL_RAD_S = math.radians(5)  # with which a vehicle that holds its yaw in wind swings
ASTRAY = math.radians(5), 0.4  # farther from its plan than an autopilot lags that shapes what it is told [rad], [s]
FASTEST_RAD_S = math.radians(120)  # at which no payload turns a vehicle; a pilot may, a little faster
ASKING_S = 2.0  # in which an autopilot must tell what it was asked for
ASKING_PERIOD_S = 0.2  # between two times that it is asked to hold its yaw
STOP_PERIOD_S = 0.1  # between two stops, until the vehicle stands
TELLING_S = 0.4  # in which an autopilot that has just been found tells whether it may be turned; a probe waits 0.5
REMIND_PERIOD_S = 1.0  # between set-points of a vehicle that is not yet at its goal after its time


class VehicleYaw(Driver):
    """The driver: sans I/O over a port that carries messages.

    Raises
    ------
    ConfigError
        When nobody has said that the vehicle may be turned.
    """

    def __init__(self, options: Options) -> None:
        options.check_consent()
        self._options = options
        self._port: Port
        able = capabilities_of(options, math.radians(options.resolution_deg), Feedback.MEASURED)
        self.capabilities = replace(able, disturbance=diagnostics.MAX_LAG_RAD)
        self._watch = FlightWatch(options)
        self._feedback = GimbalFeedback(self.capabilities.lower, self.capabilities.upper, FASTEST_RAD_S, cable=False)
        free = replace(able, lower=-math.inf, upper=math.inf)  # others turn it anywhere: it stays there, and comes back
        self._plan = YawSetPoints(free, still=STILL_RAD_S, astray=ASTRAY)
        self._commands: YawCommands | None = None
        self._held = False  # somebody holds it for a task: only then it matters whether it may be turned
        self._held_at = -math.inf  # since when [s]
        self._pending: Move | None = None  # waits until all is known
        self._stopping = -math.inf  # when the last stop was sent [s]; minus infinity: none is under way
        self._yielded = False  # since the last goal the vehicle was left to others
        self._turning = False  # a goal was given, and is not reached yet
        self._ended = ""  # why a turn has ended this moment
        self._objection_heard = ""  # the first since the last poll: what is over by now ends a turn, too
        self._stands = False  # and stands since then
        self._near = -math.inf  # when it was about where it should be last [s]
        self._us: ComponentId | None = None
        self._found_at = math.inf  # when the autopilot was found [s]
        self._may = ""  # whether it may be turned, in words; empty while the autopilot may still tell
        self._asked_at = -math.inf  # since when the autopilot is asked to hold its yaw before a turn [s]
        self._repeated_at = -math.inf  # when it was asked last [s]
        self._accepted_at = -math.inf  # when it has accepted something last [s]
        self._fault = ""
        self._settled = False  # as last published

    @property
    def identity(self) -> str:
        """Which autopilot it is, and whether it may be turned now."""
        kinds = {vehicle_control.ARDUPILOT: "ArduCopter", vehicle_control.PX4: "PX4"}
        whom, may = self._watch.whom, self._may
        return f"{kinds.get(self._watch.kind, 'autopilot')}, system {whom.system}; {may}" if whom and may else ""

    def open(self, port: Port, now: float) -> None:
        """Look for the autopilot; nothing is turned."""
        self._port = port
        self._feedback.forget()
        self._fault, self._held, self._pending, self._plan.motion = "", False, None, None
        self._yielded = self._turning = False

    def read(self, now: float) -> None:
        """Take in what has arrived."""
        self._watch.on_read(now)
        for received in self._port.receive():
            self._on_packet(received, now)
        if self._watch.mode != self._watch.wanted_mode:
            self._plan.motion = None  # when that mode begins the vehicle shall stay as it is
        if self._plan.motion is None and not self._inside(self._feedback.angle):
            self._feedback.recount_turns()  # others have turned it round
        seen = self._feedback
        ours = not (self._yielded or self._objection_heard)
        known = ours and not diagnostics.contradiction(seen) and now - seen.time <= FRESH_S
        if not self._stopping > -math.inf:
            self._plan.go_on(seen if known else None, now)
        self._plan.look_again(seen, now, believed=not diagnostics.contradiction(seen))

    def obey(self, request: Move | Request, now: float) -> None:
        """Plan, hold it for a task or not; a release is a stop: a vehicle in the air lets nothing go."""
        if request is Request.HOME:
            self._fault = ""
            self._feedback.clear_doubts()
            self._feedback.trust_clock()
        if isinstance(request, Move) or request is Request.TAKE_CONTROL:
            self._held_at = self._held_at if self._held else now
            self._held = True
        elif request is Request.RELEASE_CONTROL:
            self._held = False
        if isinstance(request, Move) and not self._fault:
            self._pending = request
        elif request in (Request.HALT, Request.RELEASE, Request.HOME):
            self._pending = None
            if self._plan.motion is not None and self._turning:
                self._stop(now)

    def write(self, now: float) -> None:
        """Ask for messages that are due, and send the set-point that is due while the vehicle may be turned."""
        for message in self._watch.due(now):
            self._port.send(message)
        commands = self._commands
        if commands is None:
            return
        commands.look(now)
        heard, self._objection_heard = self._objection_heard, ""
        why = (self._fault or heard or self._objection(now)) if self._matters else ""
        self._ended = ""
        if why:
            self._ended = why if self._turning or self._pending is not None else ""
            self._yield(commands, now, told=bool(heard) and not commands.confirmed)
        if self._pending is not None and not self._ignorance(now):
            self._begin(self._pending, commands, now)
        if self._pending is None:
            self._asked_at = self._repeated_at = -math.inf
        self._look_whether_it_follows(commands, now)
        if self._stopping > -math.inf:
            self._go_on_stopping(commands, now)
        elif self._asked_at == -math.inf:  # nothing else may be acknowledged meanwhile
            self._send_set_point(commands, now)
        if not (self._held or self._turning or commands.streams) and self._settled:
            self._plan.motion = None  # the autopilot holds it, until somebody turns it

    def snapshot(self, now: float) -> ActuatorState:
        """Return the state at ``now`` [s]; a compass knows its zero."""
        seen, trouble = self._feedback, self._trouble(now)
        rate, resting = self._plan.rest(seen, self.capabilities.resolution, now)
        rested = resting >= self._options.settle_ms * 1e-3 - TIME_TOLERANCE_S
        self._settled = rested and self._pending is None and not trouble and not self._stopping > -math.inf
        self._turning = self._turning and not self._settled
        self._may = self._permission(now)
        return ActuatorState(
            seen.angle, rate, self._settled, homed=True, healthy=not trouble, time=seen.time, fault=trouble
        )

    def leave(self, clock: Clock) -> tuple[()]:
        """Leave the yaw to the autopilot: a turn that is under way ends, unless nobody knows where to end it."""
        now, commands = clock.now(), self._commands
        self.read(now)
        if self._objection_heard or self._watch.objection():  # it is the pilot's by now
            self._plan.motion = None
        known = now - self._feedback.time <= FRESH_S or (commands is not None and commands.confirmed)
        if self._plan.motion is not None and self._turning and known:
            self._stop(now)
            if commands is not None:
                self._go_on_stopping(commands, now)
        return ()

    def close(self) -> None:
        """Give the wire back."""
        self._port.close()
        self._plan.motion, self._stopping = None, -math.inf

    # ------------------------------------------------------------------------------------------ what is heard

    def _on_packet(self, received: ReceivedPacket, now: float) -> None:
        packet, self._us = received.packet, received.us
        self._watch.on_packet(packet, now)
        if self._matters:
            self._objection_heard = self._objection_heard or self._watch.objection()
        if self._watch.whom is not None:
            self._found_at = min(self._found_at, now)
        if self._commands is None and packet.name == "HEARTBEAT":
            self._commands = commands_of(self._watch)
            self._plan.ahead = self._commands.period if self._commands is not None else self._plan.ahead
        if packet.component_id != AUTOPILOT:
            return
        if packet.name == "COMMAND_ACK":
            self._on_answer(packet.message, now)
        attitude = vehicle.read(packet.message) or vehicle_control.attitude_quaternion(packet.message)
        if isinstance(attitude, VehicleAttitude) and packet.name.startswith("ATTITUDE"):
            report = GimbalAttitude(attitude.boot, attitude.yaw, attitude.yaw_rate, False, 0, 0)
            self._feedback.on_report(report, now, own=True)

    def _on_answer(self, answer: object, now: float) -> None:
        """Take in that the autopilot holds its yaw, or refuses to turn."""
        command, result = getattr(answer, "command", -1), getattr(answer, "result", 0)
        ours = (getattr(answer, "target_system", 0), getattr(answer, "target_component", 0)) in (self._us, (0, 0))
        turns = command in (vehicle_control.CONDITION_YAW, vehicle_control.DO_REPOSITION)
        if not (turns and ours):
            return
        if result == common.MAV_RESULT_ACCEPTED:
            self._accepted_at = now
        elif self._plan.motion is not None or self._asked_at > -math.inf:
            self._fault = diagnostics.refusal(command, result) or self._fault

    # ------------------------------------------------------------------------------------------ what is sent

    def _begin(self, move: Move, commands: YawCommands, now: float) -> None:
        """Go to a goal from where the plan is, or the vehicle if there is none."""
        from_rest = self._stopping > -math.inf or self._settled or self._asked_at > -math.inf
        motion = None if from_rest else self._plan.motion
        if motion is None and not self._prepared(commands, now):
            return
        self._pending, self._yielded, self._turning = None, False, True
        if motion is None:
            self._stopping = -math.inf
            self._plan.resume(self._feedback, move, now)
        else:
            self._plan.turn(move, *motion.at(now), now)

    def _prepared(self, commands: YawCommands, now: float) -> bool:
        """Send what comes before a turn, and again until it is acknowledged where it must be; tell whether it is."""
        if not commands.confirmed:
            self._send(commands.begin(now))
            return True
        if self._asked_at == -math.inf:
            self._asked_at = now
        elif self._accepted_at > self._asked_at:
            return True
        if now - self._asked_at > ASKING_S:
            self._fault = "the autopilot does not acknowledge CONDITION_YAW; home and rearm"
        elif now - self._repeated_at >= ASKING_PERIOD_S - TIME_TOLERANCE_S:
            self._repeated_at = now
            self._send(commands.begin(now))
        return False

    def _send_set_point(self, commands: YawCommands, now: float) -> None:
        if commands.streams:
            self._stay(commands, now)
        motion = self._plan.motion
        if motion is None:
            return
        late = now > motion.end + 2 * commands.period
        if late and not (self._turning or commands.streams):
            return  # it was there: its autopilot holds it, in gusts, too, and at the height that it was given since
        period = REMIND_PERIOD_S if late and not commands.streams else commands.period
        due = self._plan.due(motion, period, now)
        if due is not None:
            rate = max(abs(motion.at(now)[1]), abs(motion.at(now + commands.period)[1]))
            self._send(commands.point(due, rate, now))

    def _stay(self, commands: YawCommands, now: float) -> None:
        """Where no turn is under way, stay as the vehicle is; but nowhere while that is not known."""
        known = now - self._feedback.time <= FRESH_S and not commands.missing(now)
        if self._plan.motion is None and known:
            sent = self._plan.sent
            self._plan.hold(self._feedback.angle, now)
            self._plan.sent = sent  # a stream has its rhythm

    def _send(self, messages: list[Any]) -> None:
        for message in messages:
            self._port.send(message)

    def _stop(self, now: float) -> None:
        """Have the autopilot end the turn, and expect the vehicle at rest soon."""
        self._brake(now)
        self._stopping = now - STOP_PERIOD_S

    def _look_whether_it_follows(self, commands: YawCommands, now: float) -> None:
        motion, seen = self._plan.motion, self._feedback
        if motion is None or self._stopping > -math.inf:
            return
        if self._yielded:  # a stream goes on from where the vehicle has come to
            known = now - seen.time <= FRESH_S and not seen.jumps
            if known and now > motion.end and abs(seen.rate) < STILL_RAD_S and not self._stands:
                self._stands = True
                self._plan.hold(seen.angle, now)
            return
        if abs(motion.at(seen.time)[0] - seen.angle) <= 2 * self.capabilities.resolution:
            self._near = seen.time
        fault = diagnostics.following_error(seen, motion, self._near, now)
        if fault:
            self._fault = self._fault or fault
            self._yield(commands, now)

    def _brake(self, now: float) -> None:
        """Expect the vehicle to brake from where it is; from where it should be when nobody knows that."""
        if now - self._feedback.time <= FRESH_S:
            self._plan.resume(self._feedback, None, now)
        else:
            self._plan.halt(now)

    def _go_on_stopping(self, commands: YawCommands, now: float) -> None:
        """Repeat a stop until the vehicle stands."""
        motion = self._plan.motion
        if motion is None:
            self._stopping = -math.inf
        elif now > motion.end and abs(self._feedback.rate) < STILL_RAD_S and self._feedback.time > motion.begin:
            self._stopping = -math.inf
            if not commands.streams:
                self._plan.motion = None
        elif now - self._stopping >= STOP_PERIOD_S - TIME_TOLERANCE_S:
            self._stopping = now
            self._send(commands.stop(motion.plan.goal, now))

    def _yield(self, commands: YawCommands, now: float, *, told: bool = False) -> None:
        """End a turn: in another mode it has ended by itself; else the autopilot is told once that it has.

        Unless somebody has ``told`` it something else meanwhile, or it does not fly: an order to PX4 would bring back
        the old height, too.
        """
        self._pending = None
        if self._yielded:
            return
        self._yielded, self._stands, self._stopping = True, False, -math.inf
        self._turning = False
        motion, settled = self._plan.motion, self._settled
        if motion is None:
            return
        self._brake(now)
        obeys = self._watch.armed and self._watch.mode == self._watch.wanted_mode and not self._watch.grounded
        if obeys and not (settled or told):
            self._send(commands.stop(self._plan.motion.plan.goal if self._plan.motion else motion.plan.goal, now))
        if not commands.streams:
            self._plan.motion = None

    # ------------------------------------------------------------------------------------------ what is wrong

    def _objection(self, now: float) -> str:
        seen = self._feedback
        why = self._watch.missing() or self._watch.objection()
        why = why or diagnostics.silence(seen, now) or diagnostics.contradiction(seen)
        waits = self._plan.motion is None and now - self._held_at < ASKING_S
        return why or ("" if waits else self._ignorance(now))

    def _ignorance(self, now: float) -> str:
        """Say what has not been told that must be known in a turn; the autopilot has just been asked for it."""
        begins = self._pending is not None or self._plan.motion is None  # in a turn its place and height are known
        unknown = self._commands.missing(now) if self._commands is not None and begins else ""
        return self._watch.ignorance(now) or unknown

    def _trouble(self, now: float) -> str:
        """Say what is wrong; whether it may be turned matters to a task only."""
        unknown = self._watch.missing() or self._fault or self._ended or diagnostics.contradiction(self._feedback)
        return unknown or (self._objection(now) if self._matters else diagnostics.silence(self._feedback, now))

    def _permission(self, now: float) -> str:
        """Say whether it may be turned, or why not; empty while the autopilot may still tell."""
        why = self._watch.missing() or self._watch.objection()
        unknown = "" if why else self._ignorance(now)
        return "" if unknown and now - self._found_at < TELLING_S else why or unknown or "it may be turned"

    @property
    def _matters(self) -> bool:
        """Whether it matters that the vehicle may be turned: to a task, and to a turn that outlasts its task."""
        return self._held or self._turning or self._pending is not None

    def _inside(self, angle: float) -> bool:
        able, margin = self.capabilities, self.capabilities.resolution
        return able.lower - margin <= angle <= able.upper + margin


class SharedVehicle(DriverShell):
    """The shell of a vehicle that is its pilot's while nobody here holds it."""

    def take_control(self) -> None:
        """Begin a task: from now on it matters whether the vehicle may be turned."""
        self._requests.put(Request.TAKE_CONTROL)

    def release_control(self) -> bool:
        """End a task; there is always somebody else who may turn a vehicle."""
        self._requests.put(Request.RELEASE_CONTROL)
        return True

    def brake(self) -> None:
        """Do nothing: a vehicle that others turn is theirs."""


backend = DriverBackend(
    "The vehicle itself, a multicopter that flies: ArduCopter yaws it in Guided, PX4 in Hold or Offboard.",
    Options,
    VehicleYaw,
    SharedVehicle,
)
