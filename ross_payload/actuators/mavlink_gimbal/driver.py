"""A gimbal that speaks MAVLink gimbal protocol v2, behind an autopilot or alone.

A goal becomes a trapezoid, and the trapezoid a stream of set-points of the yaw from the vehicle's nose: angles, never
rates, so that a gimbal whose driver has died goes to the last set-point and stands. Only the gimbal's own attitude
status tells where it is; acknowledgements prove nothing.

Behind an autopilot it is in control only while somebody holds it: from `take_control` or the first goal until
`release_control`. In between it sends no set-points, and follows what others do with the gimbal.

Only the pump (`poll`) plans and sends; the other methods leave a request in a queue.
"""

from __future__ import annotations

import math
from dataclasses import replace
from types import TracebackType
from typing import Any, Self

from ross_payload.actuators.mavlink_gimbal.feedback import GimbalFeedback
from ross_payload.actuators.mavlink_gimbal.gimbal_client import Client
from ross_payload.actuators.mavlink_gimbal.options import Options
from ross_payload.actuators.mavlink_gimbal.peer import Manager, Search
from ross_payload.actuators.mavlink_gimbal.port import Arrived
from ross_payload.actuators.mavlink_gimbal.set_points import EARLY, PERIOD, SetPoints
from ross_payload.actuators.mavlink_gimbal.watch import (
    STALE,
    contradiction,
    failures,
    silence,
    straying,
    travel_trouble,
)
from ross_payload.actuators.requests import Ask, Motion, Move, Requests
from ross_payload.errors import ActuatorFault, LimitError
from ross_payload.interfaces import Actuator, ActuatorState, Capabilities, Port, Services
from ross_payload.interfaces import Feedback as FeedbackKind
from ross_protocols import gimbal, vehicle
from ross_protocols.gimbal import Address, GimbalAttitude
from ross_protocols.vehicle import AUTOPILOT, VehicleAttitude

HOLD = 0.1  # between those of a gimbal that rests at its goal [s]; a device gives up a manager silent for about 1 s
PARTING = 1.0  # [s] at most after the end of a motion, until control is released


class MavlinkGimbal:
    """The driver: sans I/O over a port that carries messages."""

    def __init__(self, options: Options, services: Services) -> None:
        self._options = options
        self._services = services
        self._port: Port | None = None
        self._requests = Requests()
        self._peer: Client | Manager | None = None
        self._search = Search(options.role, options.device_id)
        self._held = False  # somebody holds it for a task: only then others are kept from turning it
        self._pending: Move | None = None  # waits until we are in control
        self._blind = False  # it has not reported for a while, so that nobody knows whether it got the set-points
        self._led = -math.inf  # when the gimbal was found [s]
        self._fault = ""
        self.capabilities = Capabilities(
            lower=math.radians(options.lower_deg),
            upper=math.radians(options.upper_deg),
            max_speed=math.radians(options.max_speed_deg_s),
            max_acceleration=math.radians(options.max_acceleration_deg_s2),
            resolution=math.radians(options.resolution_deg),
            continuous=False,
            feedback=FeedbackKind.MEASURED,
        )
        self._plan = SetPoints(self.capabilities)
        self._feedback = GimbalFeedback(self.capabilities.lower, self.capabilities.upper, self.capabilities.max_speed)
        self._state = ActuatorState(0.0, 0.0, False, homed=True, healthy=False, time=-math.inf)

    @property
    def identity(self) -> str:
        """Vendor, model and firmware, as the gimbal tells them."""
        return self._peer.identity if self._peer is not None else ""

    def command(self, angle: float, rate: float | None = None) -> None:
        """Go to a joint angle [rad], at most at ``rate`` [rad/s]; replaces the goal."""
        if not self.capabilities.lower <= angle <= self.capabilities.upper:  # NaN is not either
            raise LimitError(f"goal {angle} rad is not within the travel")
        if not self._state.healthy:
            raise ActuatorFault(self._state.fault or "the gimbal has not reported yet")
        self._requests.put(Move(angle, min(rate or math.inf, self.capabilities.max_speed)))

    def state(self) -> ActuatorState:
        """Return the state at the last poll; not settled while a request waits."""
        return self._state if self._requests.empty else replace(self._state, settled=False)

    def brake(self) -> None:
        """Bring to rest what others turn, from where it is, without taking control from them."""
        self._requests.put(Ask.BRAKE)

    def stop(self) -> None:
        """Decelerate from the last set-point."""
        self._requests.put(Ask.HALT)

    def take_control(self) -> None:
        """Take control where an autopilot manages the gimbal, and hold the gimbal where it is."""
        self._requests.put(Ask.TAKE_CONTROL)

    def release_control(self) -> bool:
        """Let others turn the gimbal once it is at rest; tell whether there can be others."""
        if isinstance(self._peer, Manager):
            return False
        self._requests.put(Ask.RELEASE_CONTROL)
        return True

    def home(self) -> None:
        """Decelerate, take control again and forget a fault; the gimbal's encoder knows its zero."""
        self._requests.put(Ask.HOME)

    def release(self) -> None:
        """Decelerate: the protocol has no way to switch a gimbal's motors off."""
        self.stop()

    def poll(self, now: float) -> None:
        """Take in what has arrived, obey requests, ask and point as is due, publish the state at ``now`` [s]."""
        if self._port is not None:
            for arrived in self._port.receive():
                self._hear(arrived, now)
            for request in self._requests.taken():
                self._obey(request, now)
            self._lead(now)
        self._publish(now)

    def __enter__(self) -> Self:
        """Open the wire; the gimbal is looked for, and not turned."""
        self._port = self._services.open_port(self._options.port)
        self._feedback.forget()
        self._fault, self._held, self._pending, self._plan.braking = "", False, None, None
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Send the end of the deceleration as the last set-point, give control back and close."""
        if self._port is None:
            return
        if self._plan.motion is not None and self._peer is not None and self._peer.ready:
            self._plan.halt(self._services.clock.now())
            self._port.send(self._peer.point(self._plan.motion.plan.goal))
        for message in self._peer.leave() if self._peer is not None else ():
            self._port.send(message)
        self._port.close()
        self._port = self._plan.motion = self._plan.braking = None

    # ------------------------------------------------------------------------------------------ what is heard

    def _hear(self, arrived: Arrived, now: float) -> None:
        packet = arrived.packet
        sender = packet.system_id, packet.component_id
        if packet.name == "HEARTBEAT":
            found = self._search.met(packet.message, sender, now)
            if found is not self._peer:
                self._peer, self._plan.motion, self._led = found, None, -math.inf
        if self._peer is None:
            return
        self._peer.heard(arrived, now)
        said = gimbal.read(packet.message)
        if isinstance(said, GimbalAttitude):
            self._report(self._peer, said, sender, now)
        elif packet.component_id == AUTOPILOT:
            attitude = vehicle.read(packet.message)
            if isinstance(attitude, VehicleAttitude):
                self._feedback.turned(attitude, now)

    def _report(self, peer: Client | Manager, said: GimbalAttitude, sender: Address, now: float) -> None:
        own = sender == peer.device
        if own or (isinstance(peer, Client) and sender == peer.manager and peer.relays(said.device_id)):
            peer.asking.reports += 1
            self._feedback.report(said, now, own=own)

    # ------------------------------------------------------------------------------------------ requests

    def _obey(self, request: Move | Ask, now: float) -> None:
        if request is Ask.HOME:
            self._fault = ""
            self._feedback.pardon()
            if self._peer is not None:
                self._peer.claim(now)
        if isinstance(request, Move) or request in (Ask.HOME, Ask.TAKE_CONTROL, Ask.RELEASE_CONTROL):
            self._held = request is not Ask.RELEASE_CONTROL
        if request is Ask.BRAKE:
            self._brake(now)
        if self._fault or request in (Ask.TAKE_CONTROL, Ask.RELEASE_CONTROL, Ask.BRAKE):
            return
        if not isinstance(request, Move):
            self._pending = None
            self._plan.halt(now)
        elif self._plan.motion is None:
            self._pending = request
        else:
            self._plan.turn(request, *self._plan.motion.at(now), now)

    def _brake(self, now: float) -> None:
        """Brake what somebody else turns, without taking control from them."""
        peer = self._peer
        others = self._plan.motion is None and isinstance(peer, Client) and peer.travel is not None
        if others and now - self._feedback.time <= STALE:
            self._plan.brake(self._feedback, now)

    # ------------------------------------------------------------------------------------------ leading

    def _lead(self, now: float) -> None:
        """Ask what is due, and send the set-point that is due while the gimbal is ours and reports."""
        peer = self._peer
        if peer is None or self._port is None:
            return
        if self._held:
            peer.take(now)
        for message in peer.due(now):
            self._port.send(message)
        if self._led == -math.inf and peer.travel is not None:
            self._led = now
        if not peer.ready or peer.trouble() or travel_trouble(peer.travel, self._options):
            self._stand_aside(peer, self._port, now)
            return
        stale = now - self._feedback.time > STALE
        self._blind = self._blind or stale
        if not stale and (self._blind or self._plan.motion is None):
            self._begin(now)
        self._look_whether_it_follows(now)
        motion = self._plan.motion
        if motion is None:
            return
        due = self._plan.due(motion, HOLD if self._state.settled else PERIOD, now)
        if due is not None:
            self._port.send(peer.point(due))
        if not self._held and isinstance(peer, Client):
            self._let_go(peer, self._port, motion, now)

    def _begin(self, now: float) -> None:
        """We are in control, or see the gimbal again."""
        self._feedback.pardon()
        self._plan.resume(self._feedback, self._pending, now)
        self._pending, self._blind = None, False

    def _let_go(self, peer: Client, port: Port, motion: Motion, now: float) -> None:
        """Release control when the gimbal rests; its manager keeps it at the last set-point."""
        if now >= motion.end and (self._state.settled or now >= motion.end + PARTING):
            port.send(peer.point(motion.plan.goal))
            peer.release()
            self._plan.motion = None
            for message in peer.due(now):
                port.send(message)

    def _stand_aside(self, peer: Client | Manager, port: Port, now: float) -> None:
        """Send no set-points but those that brake, on a stop, what somebody else turns."""
        self._plan.motion = None
        if peer.trouble():
            self._pending = None
        if not self._held and not peer.idle:
            peer.release()
        braking = self._plan.braking
        due = None if braking is None else self._plan.due(braking, PERIOD, now)
        if braking is not None and due is not None:
            port.send(peer.point(due))
            self._plan.braking = braking if now < braking.end else None

    def _look_whether_it_follows(self, now: float) -> None:
        """Decelerate when nobody knows where the gimbal is; hold it where it is when it does not follow."""
        if self._plan.motion is None or self._fault:
            return
        self._fault = contradiction(self._feedback)
        if self._fault:
            self._plan.halt(now)
            return
        self._fault = straying(self._feedback, self._plan.motion, now)
        self._feedback.restarted = False
        if self._fault:
            self._plan.hold(self._feedback.angle, now)

    # ------------------------------------------------------------------------------------------ the state

    def _publish(self, now: float) -> None:
        seen, motion, trouble = self._feedback, self._plan.motion, self._trouble(now)
        rate, resting = self._plan.rest(seen, self.capabilities.resolution, now)
        settled = resting >= self._options.settle_ms * 1e-3 - EARLY and now - seen.time <= STALE and not trouble
        settled = settled and (motion is not None or not self._held)  # not before we are in control of what we hold
        self._state = ActuatorState(
            seen.angle, rate, settled, homed=True, healthy=not trouble, time=seen.time, fault=trouble
        )

    def _trouble(self, now: float) -> str:
        """Say what is wrong; empty when all is well."""
        peer, seen = self._peer, self._feedback
        if peer is None:
            return self._search.missing()
        return (
            self._fault
            or peer.trouble()
            or peer.missing(now)
            or travel_trouble(peer.travel, self._options)
            or silence(seen, now, peer.heard_at if isinstance(peer, Client) else None)
            or failures(seen, now - self._led)
        )


class MavlinkGimbalBackend:
    """Gimbal on MAVLink (protocol v2): client of an autopilot that manages it, or manager of a bare device."""

    Config: type[Any] = Options

    def open(self, config: Options, services: Services) -> Actuator:
        """Make the driver."""
        return MavlinkGimbal(config, services)


backend = MavlinkGimbalBackend()
