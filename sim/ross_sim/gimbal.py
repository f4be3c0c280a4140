"""The far end of ``mavlink_gimbal``: a gimbal device with a servo loop, and an autopilot that manages it.

Everything crosses the wire as bytes. The manager behaves as an ArduPilot does: it acknowledges whatever it is told,
takes set-points from any sender, ignores angles that come with rates, and lets rates run for ever.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

from ross_payload.actuators.mavlink_gimbal_options import Options
from ross_payload.actuators.mavlink_port import Arrived
from ross_protocols import gimbal
from ross_protocols.codec import Decoder, Encoder, Packet
from ross_protocols.dialect import common
from ross_protocols.gimbal import Address
from ross_sim.far_end import Fault, checked
from ross_sim.gimbal_device import Device, Servo
from ross_sim.gimbal_manager import ArduPilot

SYSTEM = 1
PAYLOAD: Address = (SYSTEM, 191)
STATION: Address = (255, 190)
MARGIN = math.radians(2)  # between the travel that is asked for and the stops [rad]


class Station(Protocol):
    """A component on the far end's bus."""

    address: Address

    def hear(self, packet: Packet, now: float) -> list[Any]:
        """Take in a packet that somebody else has sent; return the answers."""

    def live(self, now: float) -> list[Any]:
        """Return what is due at ``now`` [s]."""


class Wire:
    """The payload's end: messages become frames, frames become what a hub of links gives."""

    def __init__(self) -> None:
        self._encoder = Encoder(*PAYLOAD)
        self._decoder = Decoder()
        self.sent: list[bytes] = []
        self.arrived: list[bytes] = []

    def send(self, frame: Any) -> None:
        """Send one of pymavlink's messages."""
        self.sent.append(self._encoder.encode(frame))

    def receive(self) -> list[Any]:
        """Return the packets that have arrived."""
        data, self.arrived = b"".join(self.arrived), []
        return [Arrived(packet, PAYLOAD) for packet in self._decoder.feed(data)]

    def close(self) -> None:
        """Return at once: an in-process wire holds nothing."""


@dataclass(slots=True)
class _Plug:
    station: Station
    encoder: Encoder
    decoder: Decoder = field(default_factory=Decoder)


class GimbalFarEnd:
    """A bus on which the payload, the device and perhaps an autopilot hear each other.

    Parameters
    ----------
    servo
        How the device moves.
    autopilot
        Whether one manages the device.
    earth
        The device tells its yaw from north.
    vehicle
        Yaw of the vehicle [rad] at a time [s], counter-clockwise from north.
    """

    def __init__(
        self, servo: Servo, *, autopilot: bool, earth: bool = False, vehicle: Callable[[float], float] = lambda now: 0.0
    ) -> None:
        self.port = Wire()
        self.device = Device((SYSTEM, gimbal.COMPONENTS[0]), servo, vehicle, earth=earth)
        self.autopilot = ArduPilot((SYSTEM, 1), self.device.address, servo, vehicle) if autopilot else None
        alone = {Fault.STUCK, Fault.SILENT, Fault.REBOOT}
        self.faults = frozenset(alone | {Fault.TAKEN} if autopilot else alone)
        self.words: list[str] = []
        stations: list[Station] = [self.device] if self.autopilot is None else [self.device, self.autopilot]
        self._plugs = [_Plug(station, Encoder(*station.address)) for station in stations]
        self._ear = Decoder()

    def advance(self, now: float) -> None:
        """Deliver what was sent, let everybody speak, and let the device move until ``now`` [s]."""
        frames, self.port.sent = self.port.sent, []
        for packet in self._ear.feed(b"".join(frames)):
            self._inspect(packet)
        self._spread(frames, None, now)
        self.device.move(now)
        for plug in self._plugs:
            self._spread([plug.encoder.encode(message) for message in plug.station.live(now)], plug, now)

    def angle(self) -> float:
        """Return the true joint angle [rad]."""
        return self.device.angle

    def afflict(self, fault: Fault, on: bool = True) -> None:
        """Jam, fall silent, restart, or be taken by a ground station."""
        match checked(fault, self.faults):
            case Fault.STUCK:
                self.device.stuck = on
            case Fault.SILENT:
                self.device.mute = on
            case Fault.REBOOT if on:
                self.device.restart()
            case Fault.TAKEN if self.autopilot is not None:
                self.autopilot.take_control(STATION if on else (0, 0))

    def complaints(self) -> list[str]:
        """Return what the payload has sent that receivers read differently, or that could run away."""
        stops = [f"the device ran into its stop {self.device.bumps} times"] if self.device.bumps else []
        return [*dict.fromkeys(self.words), *stops]

    def _spread(self, frames: list[bytes], sender: _Plug | None, now: float) -> None:
        """Give frames to everybody but their sender; what is answered is spread in turn."""
        if not frames:
            return
        if sender is not None:
            self.port.arrived += frames
        for plug in self._plugs:
            if plug is not sender:
                packets = plug.decoder.feed(b"".join(frames))
                answers = [answer for packet in packets for answer in plug.station.hear(packet, now)]
                self._spread([plug.encoder.encode(answer) for answer in answers], plug, now)

    def _inspect(self, packet: Packet) -> None:
        message = packet.message
        if packet.name not in ("GIMBAL_MANAGER_SET_PITCHYAW", "GIMBAL_DEVICE_SET_ATTITUDE"):
            return
        frames = message.flags & (gimbal.VEHICLE_FRAME | gimbal.EARTH_FRAME)
        if frames not in (gimbal.VEHICLE_FRAME, gimbal.EARTH_FRAME) or message.flags in (gimbal.EARTH_FRAME, 48):
            self.words.append(f"{packet.name} with the flags {message.flags}")
        rates = (
            (message.pitch_rate, message.yaw_rate)
            if isinstance(message, common.MAVLink_gimbal_manager_set_pitchyaw_message)
            else (message.angular_velocity_y, message.angular_velocity_z)
        )
        if any(map(math.isfinite, rates)):
            self.words.append(f"{packet.name} with rates, which nobody stops")


class GimbalFarEndPlugin:
    """The gimbal, and unless the payload manages it the autopilot, behind ``mavlink_gimbal``."""

    def make(self, config: Options) -> GimbalFarEnd:
        """Make a gimbal that can do a little more than the options ask for, at joint angle 0."""
        servo = Servo(
            lower=math.radians(config.lower_deg) - MARGIN,
            upper=math.radians(config.upper_deg) + MARGIN,
            max_speed=1.2 * math.radians(config.max_speed_deg_s),
            max_acceleration=2 * math.radians(config.max_acceleration_deg_s2),
        )
        return GimbalFarEnd(servo, autopilot=config.role != "manager")


far_end = GimbalFarEndPlugin()
