"""The far end of ``vehicle_yaw``: an autopilot that flies a multicopter, its pilot, a ground station that interferes.

Everything crosses the wire as bytes.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ross_payload.actuators.vehicle_yaw.options import Options
from ross_protocols.mavlink import vehicle_control
from ross_protocols.mavlink.codec import Decoder, Encoder, Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.vehicle_control import IN_AIR, OFFBOARD
from ross_sim.autopilot.flight_modes import CENTRE, Copter, Px4
from ross_sim.autopilot.flying_autopilot import FlyingAutopilot
from ross_sim.autopilot.yaw_dynamics import Airframe, Wind, YawDynamics
from ross_sim.devices.far_end import OF_VEHICLES, Fault, WireEnd, checked
from ross_sim.devices.gimbal_far_end import AGAIN, STATION, SYSTEM, CrowdedLine, MavlinkEnd

NOTICE_S = 1.5  # in which it is known that a vehicle is disarmed, from heartbeats, or on the ground
PUSH_US, PUSH_S = 200.0, 0.5  # how far, and for how long, a pilot pushes the yaw stick
ON_GROUND = common.MAV_LANDED_STATE_ON_GROUND
TREMBLE = math.radians(4)  # of a compass that is broken, standard deviation [rad]
TURN = math.radians(60)  # from where the vehicle points to where a ground station wants it [rad]
TORQUE = math.radians(300)  # of propellers that are slow about the yaw axis, as an acceleration [rad/s^2]
SPARE_SPEED, SPARE_ACCELERATION = 1.2, 1.1  # times what is asked of it can an airframe do
LEAST_S = 1.0  # in which it reaches the speed that is asked of it, however gently it is to be turned
FAULTS = OF_VEHICLES | {Fault.STALL, Fault.NOISY, Fault.SILENT, Fault.SATURATED, Fault.CORRUPT}


class VehicleFarEnd:
    """A wire on which the payload and the autopilot hear each other.

    Parameters
    ----------
    modes
        What steers the yaw of the vehicle.
    offboard
        The pilot chooses Offboard as soon as PX4 grants it.
    latency
        Of the wire, each way [s].
    """

    def __init__(self, modes: Copter | Px4, *, offboard: bool = False, latency: float = 0.0) -> None:
        self.port: WireEnd = MavlinkEnd()
        self.modes = modes
        self.autopilot = FlyingAutopilot(ComponentId(SYSTEM, 1), modes)
        self._automatic = modes.mode  # the flight mode that the pilot comes back to
        self._offboard, self._by_hand = offboard, False
        self.faults = FAULTS if offboard else FAULTS | {Fault.TAKEN}  # what others say does not matter in Offboard
        self._encoder, self._decoder = Encoder(*self.autopilot.address), Decoder()
        self._station = Encoder(*STATION)
        self._rival: float | None = None  # the yaw that a ground station wants [rad]
        self._rival_due = 0.0  # [s]
        self._damaged = False
        self._grounded = 0.0  # since when it may not be turned, disarmed or on the ground [s]
        self._released = math.inf  # when the pilot lets go of the stick [s]
        self._chance = np.random.default_rng(0)
        self._up, self._down = (CrowdedLine(self._chance, latency=latency) for _ in range(2))
        self._now = 0.0
        self.lost = 0  # so many of the next orders to turn or to stop do not arrive
        self.orders: list[tuple[float, str]] = []  # to turn or to stop: when they came [s], which
        self._words: list[str] = []

    def blow(self, wind: Wind, chance: np.random.Generator) -> None:
        """Let a wind blow."""
        self.modes.body.wind, self.modes.body.chance = wind, chance

    def delay(self, latency: float) -> None:
        """Let the wire take its time [s], each way."""
        self._up.latency = self._down.latency = latency

    def push(self, deflection: float) -> None:
        """Move the pilot's yaw stick [us]; to 0 he lets go of it."""
        self.modes.stick, self._released = CENTRE + deflection, math.inf

    def advance(self, now: float) -> None:
        """Deliver what was sent, and fly until ``now`` [s]."""
        self._now = now
        frames, self.port.sent = self.port.sent, []
        answers: list[Any] = []
        for packet in self._decoder.feed(b"".join(self._up.pass_on(frames, now))):
            if not self._loses(packet):
                self._inspect(packet)
                answers += self.autopilot.on_packet(packet, now)
        if self._rival is not None and now >= self._rival_due:
            self._interfere(self._rival, now)
        if now >= self._released:
            self.push(0.0)
        if self._offboard and not self._by_hand and self.modes.stick == CENTRE:
            self.modes.enter(OFFBOARD, now)
        self.autopilot.move(now)
        said = [self._encoder.encode(message) for message in [*answers, *self.autopilot.live(now)]]
        if self._damaged:
            said = [frame[:-1] + bytes([frame[-1] ^ 0x55]) for frame in said]
        self.port.arrived += self._down.pass_on(said, now)

    def angle(self) -> float:
        """Return the true yaw [rad], counter-clockwise from north."""
        return self.autopilot.yaw

    def afflict(self, fault: Fault, on: bool = True) -> None:
        """Let the vehicle, its link or its pilot do what they may."""
        match checked(fault, self.faults):
            case Fault.STALL:
                self.modes.body.limp = on
            case Fault.NOISY:
                self.autopilot.trembling = (lambda: TREMBLE * self._chance.standard_normal()) if on else None
            case Fault.SILENT:
                self.autopilot.mute = on
            case Fault.TAKEN:
                self._rival = self.angle() + TURN if on else None
            case Fault.SATURATED:
                self._up.crowded = self._down.crowded = on
            case Fault.CORRUPT:
                self._damaged = on
            case Fault.PILOT:
                self.push(PUSH_US * on)
                self._released = self._now + PUSH_S
            case Fault.MODE:
                self._by_hand = on
                if on:
                    self.autopilot.fly_by_hand(self._now)
                else:
                    self.modes.enter(self._automatic, self._now)
            case Fault.DISARMED:
                self.autopilot.armed, self._grounded = not on, self._now
            case Fault.LANDED:
                self.autopilot.landed, self._grounded = ON_GROUND if on else IN_AIR, self._now

    def complaints(self) -> list[str]:
        """Return which orders to turn came while the vehicle was not the payload's."""
        return list(dict.fromkeys(self._words))

    def _interfere(self, away: float, now: float) -> None:
        """Let a ground station turn the vehicle elsewhere, and insist."""
        self._rival_due = now + AGAIN
        whom = self.autopilot.address
        message = vehicle_control.turn_to(whom, away, 1.0)
        if isinstance(self.modes, Px4):
            message = vehicle_control.reposition(whom, away, self.modes.altitude)
        for packet in Decoder().feed(self._station.encode(message)):
            self.autopilot.on_packet(packet, now)

    def _loses(self, packet: Packet) -> bool:
        """Tell whether an order does not arrive."""
        loses = self.lost > 0 and _turns(packet)
        self.lost -= loses
        return loses

    def _inspect(self, packet: Packet) -> None:
        """Note orders; one to turn a vehicle that has been disarmed or on the ground for a while is worth a word."""
        message = packet.message
        if not _turns(packet):
            return
        stops = message.command == vehicle_control.CONDITION_YAW and bool(message.param4)
        self.orders.append((self._now, "stop" if stops else "turn"))
        if self.autopilot.landed_state == ON_GROUND and self._now - self._grounded > NOTICE_S:
            where = "on the ground" if self.autopilot.armed else "not armed"
            self._words.append(f"an order to turn a vehicle that is {where}")

    @classmethod
    def make(cls, config: Options) -> VehicleFarEnd:
        """Make a vehicle that can do a little more than the options ask for, pointing north: PX4 for Offboard.

        Turned gently it is no weaker: the acceleration of an autopilot is not that of a payload's plan.
        """
        speed, acceleration = math.radians(config.max_speed_deg_s), math.radians(config.max_acceleration_deg_s2)
        body = YawDynamics(
            Airframe(
                SPARE_SPEED * speed,
                max(SPARE_ACCELERATION * acceleration, speed / LEAST_S),
                max(4 * acceleration, TORQUE),
            )
        )
        if config.px4_mode == "offboard":
            return cls(Px4(body), offboard=True)
        return cls(Copter(body))


def _turns(packet: Packet) -> bool:
    """Tell whether a packet is an order to turn or to stop."""
    turns = vehicle_control.CONDITION_YAW, vehicle_control.DO_REPOSITION
    return packet.name in ("COMMAND_LONG", "COMMAND_INT") and packet.message.command in turns


far_end = VehicleFarEnd
