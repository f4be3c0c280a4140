"""A servo on a CAN bus that speaks DroneCAN: set-points of our own trapezoid at 50 Hz, position from its Status.

A goal becomes a trapezoid; where it is *now* goes out as a position, a unitless value, a pulse width or the attitude of
a gimbal for as long as a goal is held. Nothing but positions is ever sent, so a program that dies leaves a servo that
stops at the last one.

Only the servo's own reports make it settled. A servo whose Status has no position is driven by a model: its place is
known after `home` has sent it to joint angle 0.

Only the pump (`poll`) plans; the other methods leave a request in a queue.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from types import TracebackType
from typing import Any, Self

from ross_payload.actuators.dronecan_servo.node import Place, ServoClient
from ross_payload.actuators.dronecan_servo.options import Options
from ross_payload.actuators.dronecan_servo.watch import TREMBLE, Tremble
from ross_payload.actuators.motion import Trapezoid
from ross_payload.actuators.requests import Ask, Motion, Move, Requests
from ross_payload.errors import ActuatorFault, LimitError, LinkError, NotHomed
from ross_payload.interfaces import Actuator, ActuatorState, Capabilities, Feedback, Services

PERIOD = 0.020  # [s] between two set-points
EARLY = 1e-6  # so much before its time something is due [s]
GAP = 5 * PERIOD  # without a set-point, and the servo has come to rest at the last one [s]


class DronecanServo:
    """The driver: sans I/O over a port of CAN frames."""

    def __init__(self, options: Options, services: Services) -> None:
        self._options = options
        self._services = services
        self._measured = options.feedback == "measured"
        self._lag = options.lag_ms * 1e-3  # of the servo behind its set-points [s]
        self._requests = Requests()
        self._client: ServoClient | None = None
        self._motion: Motion | None = None  # None: nothing is sent
        self._places: deque[Place] = deque()  # of the last settle_ms
        self._homed = False  # of a model
        self._home_until = math.inf  # a model's homing is over [s]
        self._tremble = Tremble()
        self._behind = 0  # reports in a row that were too far behind
        self._due = -math.inf  # the next set-point [s]
        self._fault = ""
        self._state = ActuatorState(0.0, 0.0, settled=False, homed=False, healthy=True, time=-math.inf)
        self.capabilities = Capabilities(
            lower=math.radians(options.lower_deg),
            upper=math.radians(options.upper_deg),
            max_speed=math.radians(options.max_speed_deg_s),
            max_acceleration=math.radians(options.max_acceleration_deg_s2),
            resolution=options.resolution,
            continuous=False,
            feedback=Feedback(options.feedback),
        )

    @property
    def identity(self) -> str:
        """Name and versions, as the servo tells them."""
        return self._client.identity if self._client is not None else ""

    def command(self, angle: float, rate: float | None = None) -> None:
        """Go to a joint angle [rad], at most at ``rate`` [rad/s]; replaces the goal."""
        if not self.capabilities.lower <= angle <= self.capabilities.upper:
            raise LimitError(f"goal {math.degrees(angle):.2f} deg is outside the travel of the servo")
        if self._fault:
            raise ActuatorFault(self._fault)
        if not self._state.homed:
            raise NotHomed("the servo's position is not known: home first")
        self._requests.put(Move(angle, min(rate or math.inf, self.capabilities.max_speed)))

    def state(self) -> ActuatorState:
        """Return the state at the last poll; not settled while a request waits."""
        return self._state if self._requests.empty else replace(self._state, settled=False)

    def stop(self) -> None:
        """Decelerate along the trapezoid and hold."""
        self._requests.put(Ask.HALT)

    def home(self) -> None:
        """Forget a fault; a servo without position goes to joint angle 0, as fast as it likes."""
        self._homed = False
        self._requests.put(Ask.HOME)

    def release(self) -> None:
        """Send no more set-points: a servo that gives up without them lets go, any other holds."""
        self._requests.put(Ask.RELEASE)

    def poll(self, now: float) -> None:
        """Read the bus, obey requests, send the set-point that is due, publish the state at ``now`` [s]."""
        if self._client is None:
            return
        try:
            self._client.take_in(now)
            self._look(self._client, now)
            for request in self._requests.taken():
                self._obey(request, now)
            self._stream(self._client, now)
        except LinkError as error:  # whoever comes back to the bus must ask again
            self._latch(str(error))
            self._let_go()
            list(self._requests.taken())
        self._publish(self._client, now)

    def __enter__(self) -> Self:
        """Join the bus and listen."""
        port = self._services.open_port(self._options.port)
        self._client = ServoClient(self._options, port, self._services.clock.now())
        self._state = replace(self._state, settled=False, time=-math.inf)
        self._places.clear()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Decelerate along the trapezoid, which takes its time, and leave the bus."""
        if self._client is None:
            return
        clock = self._services.clock
        self.stop()
        self.poll(clock.now())
        while self._motion is not None and clock.now() <= self._motion.end + PERIOD:
            clock.sleep(PERIOD / 2)
            self.poll(clock.now())
        self._motion = None
        self._client.close()
        self._client = None

    # ------------------------------------------------------------------------------------------ what is heard

    def _look(self, client: ServoClient, now: float) -> None:
        """Remember the newest place; latch what is wrong with it or with the bus."""
        if client.event:
            self._latch(client.event)
        if client.lost:
            self._let_go()
        client.event, client.lost = "", False
        place = client.place
        if self._measured and place.time > (self._places[-1].time if self._places else -math.inf):
            self._places.append(self._believed(place))
            self._check_lag(self._places[-1].joint, now)
        while len(self._places) > 1 and self._places[1].time <= now - self._options.settle_ms * 1e-3:
            self._places.popleft()

    def _believed(self, place: Place) -> Place:
        """Return a place, without its angle when that cannot be; latch why."""
        margin = math.radians(self._options.max_lag_deg)
        if math.isnan(place.joint):
            self._latch("the servo reports no position; set feedback = 'model' if it has no sensor")
        elif not self.capabilities.lower - margin <= place.joint <= self.capabilities.upper + margin:
            self._latch(f"the servo reports {math.degrees(place.joint):.6g} deg, which is outside its travel")
            return replace(place, joint=math.nan)
        elif self._tremble.fed(place.joint, place.count) > max(TREMBLE, 1.2 * self.capabilities.resolution):
            self._latch("the reported position of the servo is noisy: check its encoder and its cables")
        return place

    def _check_lag(self, joint: float, now: float) -> None:
        """Latch that the servo does not follow, and hold where it is; one report alone may be a stranger's."""
        if self._motion is None or self._fault:
            return
        wanted = self._motion.at(now)[0]
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

    # ------------------------------------------------------------------------------------------ requests

    def _obey(self, request: Move | Ask, now: float) -> None:
        if isinstance(request, Move):
            if not self._fault:
                self._go(request, now)
        elif request is Ask.RELEASE:
            self._let_go()
        elif request is Ask.HALT:
            if self._motion is not None:
                self._motion = Motion(Trapezoid.to_rest(*self._motion.at(now), self._acceleration), now)
        else:
            self._home(now)

    def _go(self, move: Move, now: float) -> None:
        position, velocity = self._motion.at(now) if self._motion is not None else (self._state.angle, 0.0)
        self._motion = Motion(Trapezoid(position, move.goal, move.rate, self._acceleration, velocity), now)
        if not velocity:
            self._due = min(self._due, now)  # at once

    def _home(self, now: float) -> None:
        self._fault = ""
        if not self._measured:
            self._hold(0.0, now)
            travel = self.capabilities.upper - self.capabilities.lower
            self._home_until = now + travel / self.capabilities.max_speed
        elif self._motion is not None and self._places:
            if math.isnan(self._places[-1].joint):
                self._let_go()
            elif self._motion.at(now)[1]:
                self._motion = Motion(Trapezoid.to_rest(*self._motion.at(now), self._acceleration), now)
            else:
                self._hold(self._places[-1].joint, now)

    def _hold(self, joint: float, now: float) -> None:
        here = min(max(joint, self.capabilities.lower), self.capabilities.upper)
        self._motion = Motion(Trapezoid(here, here, 1.0, 1.0), now)

    @property
    def _acceleration(self) -> float:
        return self.capabilities.max_acceleration

    # ------------------------------------------------------------------------------------------ out

    def _stream(self, client: ServoClient, now: float) -> None:
        """Send the set-point that is due; after a gap the servo is at rest, so that the plan begins anew from there."""
        if self._motion is not None and now >= self._due - EARLY:
            if now - self._due > GAP and (motion := self._motion).end > self._due:
                plan = motion.plan
                there = motion.at(self._due + self._lag)[0]
                self._motion = Motion(Trapezoid(there, plan.goal, plan.speed, plan.acceleration), now)
            self._due = (self._due if now - self._due < PERIOD else now) + PERIOD
            ahead = PERIOD + self._lag  # where it should be when the next one comes, had it no lag
            client.command(self._motion.at(now + ahead)[0])

    def _publish(self, client: ServoClient, now: float) -> None:
        if now >= self._home_until:
            self._homed, self._home_until = True, math.inf
        wanted, rate = self._motion.at(now) if self._motion is not None else (self._state.angle, 0.0)
        known = bool(self._places) and math.isfinite(self._places[-1].joint)
        angle = self._places[-1].joint if known else self._state.angle if self._measured else wanted
        fault = self._fault or client.nameless or client.condition or (client.missing(now) if self._measured else "")
        self._state = ActuatorState(
            angle=angle,
            rate=rate,
            settled=not fault and self._still(now) and self._arrived(angle, now),
            homed=known if self._measured else self._homed,
            healthy=not fault,
            time=client.place.time if self._measured else client.heard,
            fault=fault,
        )

    def _arrived(self, angle: float, now: float) -> bool:
        """Whether the plan is over and the servo is at its end, as near as it comes to what it was told."""
        if self._motion is None:
            return True
        over = now >= self._motion.end + self._options.settle_ms * 1e-3 - EARLY
        goal = self._options.told(self._motion.plan.goal)
        return over and (not self._measured or abs(angle - goal) <= self.capabilities.resolution)

    def _still(self, now: float) -> bool:
        """Whether all reports of the last settle_ms are of one place."""
        if not self._measured:
            return self._homed
        joints = [place.joint for place in self._places]
        return bool(joints) and max(joints) - min(joints) <= self.capabilities.resolution


class DronecanServoBackend:
    """Servo on a CAN bus that speaks DroneCAN: commands at 50 Hz, position from its Status."""

    Config: type[Any] = Options

    def open(self, config: Options, services: Services) -> Actuator:
        """Make the driver."""
        return DronecanServo(config, services)


backend = DronecanServoBackend()
