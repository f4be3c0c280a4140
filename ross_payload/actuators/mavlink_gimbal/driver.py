"""A gimbal that speaks MAVLink gimbal protocol v2, behind an autopilot or alone.

A goal becomes a trapezoid, and the trapezoid a stream of set-points of the yaw from the vehicle's nose: angles, never
rates, so that a gimbal whose driver has died goes to the last set-point and stands. Only the gimbal's own attitude
status tells where it is; acknowledgements prove nothing.

Behind an autopilot it is in control only while somebody holds it: from `take_control` or the first goal until
`release_control`. In between it sends no set-points, and follows what others do with the gimbal.
"""

from __future__ import annotations

import math

from ross_payload.actuators.driver_shell import (
    TIME_TOLERANCE_S,
    Driver,
    DriverBackend,
    DriverShell,
    Move,
    Request,
    capabilities_of,
)
from ross_payload.actuators.mavlink_gimbal import diagnostics
from ross_payload.actuators.mavlink_gimbal.component_port import ReceivedPacket
from ross_payload.actuators.mavlink_gimbal.feedback import GimbalFeedback
from ross_payload.actuators.mavlink_gimbal.gimbal_device_client import GimbalDeviceClient, PeerSearch
from ross_payload.actuators.mavlink_gimbal.gimbal_manager_client import GimbalManagerClient
from ross_payload.actuators.mavlink_gimbal.options import Options
from ross_payload.actuators.mavlink_gimbal.set_points import YawSetPoints
from ross_payload.actuators.motion import Motion
from ross_payload.actuators.set_points import SET_POINT_PERIOD_S
from ross_payload.interfaces import ActuatorState, Clock, Feedback, Port, Services
from ross_protocols.mavlink import gimbal_messages, vehicle
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.gimbal_messages import GimbalAttitude
from ross_protocols.mavlink.vehicle import AUTOPILOT, VehicleAttitude

# between those of a gimbal that rests at its goal [s]; a device gives up a manager silent for about 1 s
HOLD_PERIOD_S = 0.1
RESUME_S = 0.1  # [s] after a silence in which reports that have waited on their way arrive all at once
GONE_S = 3.0  # [s] without a word, and it may have been without power, and not be where it was
SETTLE_TIMEOUT_S = 1.0  # [s] at most after the end of a motion, until control is released


class MavlinkGimbal(Driver):
    """The driver: sans I/O over a port that carries messages."""

    def __init__(self, options: Options) -> None:
        self._options = options
        self._port: Port
        self._peer: GimbalManagerClient | GimbalDeviceClient | None = None
        self._search = PeerSearch(options.role, options.device_id)
        self._held = False  # somebody holds it for a task: only then others are kept from turning it
        self._pending: Move | None = None  # waits until we are in control
        self._blind = False  # it has not reported for a while, so that nobody knows whether it got the set-points
        self._cut_off = False  # meanwhile nothing came over the link at all
        self._gone = False  # meanwhile it said nothing at all for so long that it may have been without power
        self._spoke_at = -math.inf  # when it said anything last [s]
        self._stale_at = -math.inf  # when it had not reported for a while last [s]
        self._found_at = -math.inf  # when the gimbal was found [s]
        self._led_since = -math.inf  # without a pause of this program that the gimbal has outlasted at rest [s]
        self._read_at = math.inf  # [s]
        self._known = False  # the latest report tells where it is
        self._fault = ""
        self._settled = False  # as last published
        self.capabilities = capabilities_of(options, math.radians(options.resolution_deg), Feedback.MEASURED)
        self._plan = YawSetPoints(self.capabilities)
        self._feedback = GimbalFeedback(self.capabilities.lower, self.capabilities.upper, self.capabilities.max_speed)

    @property
    def identity(self) -> str:
        """Vendor, model and firmware, as the gimbal tells them."""
        return self._peer.identity if self._peer is not None else ""

    @property
    def is_shared(self) -> bool:
        """Whether there can be others that turn the gimbal."""
        return not isinstance(self._peer, GimbalDeviceClient)

    def open(self, port: Port, now: float) -> None:
        """Look for the gimbal; it is not turned."""
        self._port = port
        self._feedback.forget()
        self._fault, self._held, self._pending, self._plan.braking = "", False, None, None

    def read(self, now: float) -> None:
        """Take in what has arrived."""
        if self._settled and now - self._read_at > diagnostics.STALE_REPORT_S:
            self._led_since = now
        self._read_at = now
        for received in self._port.receive():
            self._on_packet(received, now)
        if isinstance(self._peer, GimbalManagerClient):
            self._peer.read_at = now
        self._plan.forget_late_brake(now)
        seen, self._known = self._feedback, False
        fresh = now - seen.time <= diagnostics.STALE_REPORT_S
        if not (seen.restarted and fresh):  # that is a fault of the motion under way
            known = fresh and not (self._blind or diagnostics.contradiction(seen))
            self._plan.go_on(seen if known else None, now)
            self._plan.look_again(seen, now, believed=known)
            self._known = known and seen.steady
            if self._known:
                self._plan.brake_where_it_is(seen, now)

    def obey(self, request: Move | Request, now: float) -> None:
        """Plan, claim control or give it back; a release decelerates: the protocol switches no motors off."""
        if request is Request.HOME:
            self._fault = ""
            self._feedback.clear_doubts()
            self._feedback.trust_clock()
            self._feedback.trust_turn()
            if self._peer is not None:
                self._peer.claim_control(now)
        if isinstance(request, Move) or request in (Request.HOME, Request.TAKE_CONTROL, Request.RELEASE_CONTROL):
            self._held = request is not Request.RELEASE_CONTROL
        if request is Request.BRAKE:
            self._brake(now)
        if self._fault or request in (Request.TAKE_CONTROL, Request.RELEASE_CONTROL, Request.BRAKE):
            return
        if not isinstance(request, Move):
            self._pending = None
            self._halt(now)
        elif self._plan.motion is None or self._blind:
            self._pending = request
        else:
            self._plan.turn(request, *self._plan.motion.at(now), now)

    def write(self, now: float) -> None:
        """Ask what is due, and send the set-point that is due while the gimbal is ours and reports."""
        peer = self._peer
        if peer is None:
            return
        if self._held:
            peer.want_control(now)
        for message in peer.due(now):
            self._port.send(message)
        if self._found_at == -math.inf and peer.travel is not None:
            self._found_at = now
            self._feedback.reach(peer.travel.lower, peer.travel.upper)
        if not peer.ready or peer.trouble() or self._options.travel_trouble(peer.travel):
            self._stand_aside(peer, now)
            return
        if now - self._feedback.time > diagnostics.STALE_REPORT_S:
            self._blind, self._stale_at = True, now
            self._cut_off = self._cut_off or self._hears_nobody(peer, now)
            self._gone = self._gone or now - max(self._spoke_at, self._feedback.time) > GONE_S
        elif self._blind and now - self._stale_at < RESUME_S:
            return  # where it is now, the latest report will tell
        elif self._blind or self._plan.motion is None:
            self._begin(now)
        self._look_whether_it_follows(now)
        motion = self._plan.motion
        if motion is None:  # it has not been heard since we are in control
            if not (self._held or self._hears_nobody(peer, now)):
                self._pending = None
                peer.release_control()
            return
        unled = self._blind and self._may_be_unled(motion, now)  # the first set-point would lead it on unheard
        due = None if unled else self._plan.due(motion, HOLD_PERIOD_S if self._settled else SET_POINT_PERIOD_S, now)
        if due is not None:
            self._port.send(peer.point(due))
        if not self._held and isinstance(peer, GimbalManagerClient) and not (unled and self._hears_nobody(peer, now)):
            self._give_back(peer, motion, now, unled=unled)

    def snapshot(self, now: float) -> ActuatorState:
        """Return the state at ``now`` [s]; its encoder knows its zero."""
        seen, trouble = self._feedback, self._trouble(now)
        rate, resting = self._plan.rest(seen, self.capabilities.resolution, now)
        rested = resting >= self._options.settle_ms * 1e-3 - TIME_TOLERANCE_S
        settled = rested and now - seen.time <= diagnostics.STALE_REPORT_S and not trouble
        ours = self._plan.motion is not None or not self._held  # it is not settled before we control it
        self._settled = settled and ours and self._pending is None
        return ActuatorState(
            seen.angle, rate, self._settled, homed=True, healthy=not trouble, time=seen.time, fault=trouble
        )

    def leave(self, clock: Clock) -> tuple[()]:
        """Send the end of the deceleration as the last set-point, where it is known, and give control back."""
        now = clock.now()
        self.read(now)
        known = not self._blind and now - self._feedback.time <= diagnostics.STALE_REPORT_S
        if self._plan.motion is not None and self._peer is not None and self._peer.ready and known:
            self._halt(now)
            self._port.send(self._peer.point(self._plan.motion.plan.goal))
        for message in self._peer.leave() if self._peer is not None else ():
            self._port.send(message)
        return ()

    def close(self) -> None:
        """Give the wire back."""
        self._port.close()
        self._plan.motion = self._plan.braking = None

    # ------------------------------------------------------------------------------------------ what is heard

    def _on_packet(self, received: ReceivedPacket, now: float) -> None:
        packet = received.packet
        sender = packet.sender
        if packet.name == "HEARTBEAT":
            found = self._search.on_heartbeat(packet.message, sender, now)
            if found is not self._peer:
                self._feedback.cable = found is not None and not isinstance(found, GimbalDeviceClient)
                self._peer, self._plan.motion, self._found_at = found, None, -math.inf
        if self._peer is None:
            return
        self._spoke_at = now if sender == self._peer.device else self._spoke_at
        self._peer.on_packet(received, now)
        message = gimbal_messages.read(packet.message)
        if isinstance(message, GimbalAttitude):
            self._on_attitude(self._peer, message, sender, now)
        elif packet.component_id == AUTOPILOT:
            attitude = vehicle.read(packet.message)
            if isinstance(attitude, VehicleAttitude):
                self._feedback.on_vehicle(attitude, now)

    def _on_attitude(
        self, peer: GimbalManagerClient | GimbalDeviceClient, message: GimbalAttitude, sender: ComponentId, now: float
    ) -> None:
        own = sender == peer.device
        if own or (isinstance(peer, GimbalManagerClient) and sender == peer.manager and peer.relays(message.device_id)):
            peer.queries.reports += 1
            self._feedback.on_report(message, now, own=own)

    def _brake(self, now: float) -> None:
        """Brake what somebody else turns, without taking control from them."""
        peer = self._peer
        others = self._plan.motion is None and isinstance(peer, GimbalManagerClient) and peer.travel is not None
        if others and now - self._feedback.time <= diagnostics.STALE_REPORT_S:
            self._plan.brake(self._feedback, now)

    # ------------------------------------------------------------------------------------------ leading

    def _halt(self, now: float) -> None:
        """Brake, from where it is seen if it gets no set-points."""
        self._plan.halt(now)
        if self._known:
            self._plan.brake_where_it_is(self._feedback, now)

    def _begin(self, now: float) -> None:
        """We are in control, or see the gimbal again."""
        self._feedback.clear_doubts()
        if self._pending is not None or not self._plan.rests_sooner_as_planned(self._feedback, now):
            self._plan.resume(self._feedback, self._pending, now)
        self._pending, self._blind, self._cut_off, self._gone = None, False, False, False

    def _give_back(self, peer: GimbalManagerClient, motion: Motion, now: float, *, unled: bool) -> None:
        """Release control when the gimbal rests, or is led no more; its manager keeps it at the last set-point."""
        if unled or (now >= motion.end and (self._settled or now >= motion.end + SETTLE_TIMEOUT_S)):
            if not unled:
                self._port.send(peer.point(motion.plan.goal))
            peer.release_control()
            self._plan.motion = None
            for message in peer.due(now):
                self._port.send(message)

    def _hears_nobody(self, peer: GimbalManagerClient | GimbalDeviceClient, now: float) -> bool:
        told_at = peer.heard_at if isinstance(peer, GimbalManagerClient) else -math.inf
        return now - max(self._feedback.arrived_at, told_at) > diagnostics.STALE_REPORT_S

    def _may_be_unled(self, motion: Motion, now: float) -> bool:
        """Tell whether it moved unheard to the end of its plan, may be at rest before it, or been turned by hand."""
        seen_at = self._feedback.time
        brakes = self._cut_off and self._plan.brakes_after(seen_at)
        return brakes or seen_at < motion.end < now - HOLD_PERIOD_S or self._gone

    def _stand_aside(self, peer: GimbalManagerClient | GimbalDeviceClient, now: float) -> None:
        """Send no set-points but those that brake, on a stop, what somebody else turns."""
        self._plan.motion = None
        if peer.trouble():
            self._pending = None
        if not self._held and not peer.idle:
            peer.release_control()
        braking = self._plan.braking
        due = None if braking is None else self._plan.due(braking, SET_POINT_PERIOD_S, now)
        if braking is not None and due is not None:
            self._port.send(peer.point(due))
            self._plan.braking = braking if now < braking.end else None

    def _look_whether_it_follows(self, now: float) -> None:
        """Decelerate when nobody knows where the gimbal is; hold it where it is when it does not follow."""
        if self._plan.motion is None or self._fault:
            return
        self._fault = diagnostics.contradiction(self._feedback)
        if self._fault:
            self._plan.halt(now)
            return
        self._fault = diagnostics.following_error(self._feedback, self._plan.motion, now)
        self._feedback.restarted = False
        if self._fault:
            self._plan.hold(self._feedback.angle, now)

    def _trouble(self, now: float) -> str:
        """Say what is wrong; empty when all is well."""
        peer, seen = self._peer, self._feedback
        if peer is None:
            return self._search.missing()
        return (
            self._fault
            or peer.trouble()
            or peer.missing(now)
            or self._options.travel_trouble(peer.travel)
            or diagnostics.silence(seen, now, peer.heard_at if isinstance(peer, GimbalManagerClient) else None)
            or diagnostics.lost_turn(seen)
            or diagnostics.failures(seen, now - max(self._found_at, self._led_since))
        )


class SharedGimbal(DriverShell):
    """The shell of a gimbal that others may turn while nobody here holds it."""

    def __init__(self, driver: MavlinkGimbal, services: Services, url: str) -> None:
        super().__init__(driver, services, url)
        self._gimbal = driver

    def brake(self) -> None:
        """Bring to rest what others turn, from where it is, without taking control from them."""
        self._requests.put(Request.BRAKE)

    def take_control(self) -> None:
        """Take control where an autopilot manages the gimbal, and hold the gimbal where it is."""
        self._requests.put(Request.TAKE_CONTROL)

    def release_control(self) -> bool:
        """Let others turn the gimbal once it is at rest; tell whether there can be others."""
        if self._gimbal.is_shared:
            self._requests.put(Request.RELEASE_CONTROL)
        return self._gimbal.is_shared


backend = DriverBackend(
    "Gimbal on MAVLink (protocol v2): client of an autopilot that manages it, or manager of a bare device.",
    Options,
    MavlinkGimbal,
    SharedGimbal,
)
