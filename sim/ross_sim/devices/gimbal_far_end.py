"""The far end of ``mavlink_gimbal``: a gimbal device with a servo loop, and an autopilot that manages it.

Everything crosses the wire as bytes. The manager behaves as an ArduPilot does: it acknowledges whatever it is told,
takes set-points from any sender, ignores angles that come with rates, and lets rates run for ever.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.random import Generator

from ross_payload.actuators.mavlink_gimbal.component_port import ReceivedPacket
from ross_payload.actuators.mavlink_gimbal.options import Options
from ross_protocols.mavlink import gimbal_messages
from ross_protocols.mavlink.codec import Decoder, Encoder, Packet
from ross_protocols.mavlink.component_id import NOBODY, ComponentId
from ross_protocols.mavlink.dialect import common
from ross_sim.devices.far_end import OF_DEVICES, SLIP, Fault, WireEnd, checked
from ross_sim.devices.gimbal_device import EARLY, Device, Servo
from ross_sim.devices.gimbal_manager import ArduPilot

SYSTEM = 1
PAYLOAD = ComponentId(SYSTEM, 191)
STATION = ComponentId(255, 190)
UP = 37.0  # for how long a second gimbal was on before it came onto the bus [s]
DELAY, LOSS = 0.6, 0.3  # [s] on a line that others fill, and the share of frames that it drops
AGAIN = 0.1  # [s] between two set-points of a rival
MARGIN = math.radians(2)  # between the travel that is asked for and the stops [rad]


class MavlinkNode(Protocol):
    """A component on the far end's bus."""

    address: ComponentId

    def on_packet(self, packet: Packet, now: float) -> list[Any]:
        """Take in a packet that somebody else has sent; return the answers."""

    def live(self, now: float) -> list[Any]:
        """Return what is due at ``now`` [s]."""


class MavlinkEnd(WireEnd):
    """The payload's end: messages become frames, frames become what the links give."""

    def __init__(self) -> None:
        super().__init__()
        self._encoder = Encoder(*PAYLOAD)
        self._decoder = Decoder()

    def send(self, frame: Any) -> None:
        """Send one of pymavlink's messages."""
        self.sent.append(self._encoder.encode(frame))

    def receive(self) -> list[Any]:
        """Return the packets that have arrived."""
        return [ReceivedPacket(packet, PAYLOAD) for packet in self._decoder.feed(b"".join(super().receive()))]


@dataclass(slots=True)
class _Plug:
    station: MavlinkNode
    encoder: Encoder
    decoder: Decoder = field(default_factory=Decoder)
    damaged: bool = False  # what it says

    def frames(self, messages: list[Any]) -> list[bytes]:
        """Encode what the station says."""
        frames = [self.encoder.encode(message) for message in messages]
        return [frame[:-1] + bytes([frame[-1] ^ 0x55]) for frame in frames] if self.damaged else frames


def _plugged(station: MavlinkNode) -> _Plug:
    return _Plug(station, Encoder(*station.address))


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
        self.port = MavlinkEnd()
        self.device = Device(ComponentId(SYSTEM, gimbal_messages.COMPONENTS[0]), servo, vehicle, earth=earth)
        self.autopilot = ArduPilot(ComponentId(SYSTEM, 1), self.device.address, servo, vehicle) if autopilot else None
        self.faults = OF_DEVICES
        self.words: list[str] = []
        stations: list[MavlinkNode] = [self.device] if self.autopilot is None else [self.device, self.autopilot]
        self._plugs = [_plugged(station) for station in stations]
        self._guests: dict[Fault, _Plug] = {}  # who comes with a fault
        self._chance = np.random.default_rng(0)
        self._up, self._down = CrowdedLine(self._chance), CrowdedLine(self._chance)
        self._outgoing: list[bytes] = []  # on their way to the payload
        self._slipped = 0.0  # what the device carries, on its platform [rad]
        self._now = 0.0
        self._ear = Decoder()

    def advance(self, now: float) -> None:
        """Deliver what was sent, let everybody speak, and let the devices move until ``now`` [s]."""
        self._now = now
        frames, self.port.sent = self.port.sent, []
        for packet in self._ear.feed(b"".join(frames)):
            self._inspect(packet)
        self._spread(self._up.pass_on(frames, now), None, now)
        for plug in self._everybody():
            if isinstance(plug.station, Device):
                plug.station.move(now)
        for plug in self._everybody():
            self._spread(plug.frames(plug.station.live(now)), plug, now)
        said, self._outgoing = self._outgoing, []
        self.port.arrived += self._down.pass_on(said, now)

    def angle(self) -> float:
        """Return the true joint angle [rad]."""
        return self.device.angle + self._slipped

    def afflict(self, fault: Fault, on: bool = True) -> None:
        """Let the device, its bus or somebody on it fail."""
        match checked(fault, self.faults):
            case Fault.STALL:
                self.device.limp = on
            case Fault.STUCK:
                self.device.stuck = on
            case Fault.SLIP:
                self._slipped += SLIP * on  # its own sensor turns with its platform
            case Fault.NOISY:
                self.device.trembling = self._chance if on else None
            case Fault.SILENT:
                self.device.mute = on
            case Fault.REBOOT if on:
                self.device.restart()
            case Fault.SATURATED:
                self._up.crowded = self._down.crowded = on
            case Fault.CORRUPT:
                self._plugs[0].damaged = on
            case Fault.TAKEN | Fault.DUPLICATE:
                self._guests.pop(fault, None)
                if on:
                    self._guests[fault] = _plugged(self._rival() if fault is Fault.TAKEN else self._twin())
                elif fault is Fault.TAKEN and self.autopilot is not None:
                    self.autopilot.take_control(NOBODY)

    def complaints(self) -> list[str]:
        """Return what the payload has sent that receivers read differently, or that could run away."""
        stops = [f"the device ran into its stop {self.device.bumps} times"] if self.device.bumps else []
        return [*dict.fromkeys(self.words), *stops]

    def _spread(self, frames: list[bytes], sender: _Plug | None, now: float) -> None:
        """Give frames to everybody but their sender; what is answered is spread in turn."""
        if not frames:
            return
        if sender is not None:
            self._outgoing += frames
        for plug in self._everybody():
            if plug is not sender:
                packets = plug.decoder.feed(b"".join(frames))
                answers = [answer for packet in packets for answer in plug.station.on_packet(packet, now)]
                self._spread(plug.frames(answers), plug, now)

    def _everybody(self) -> list[_Plug]:
        return [*self._plugs, *self._guests.values()]

    def _rival(self) -> RivalController:
        """A ground station that takes control of the gimbal, or a second manager that wants it where it is."""
        if self.autopilot is not None:
            return RivalController(STATION, self.autopilot.address, None)
        return RivalController(STATION, self.device.address, self.device.angle)

    def _twin(self) -> Device:
        """A second gimbal with the same ids, at joint angle 0."""
        first = self.device
        return Device(first.address, first.servo, lambda now: 0.0, earth=False, now=self._now, up=self._now + UP)

    def _inspect(self, packet: Packet) -> None:
        message = packet.message
        if packet.name not in ("GIMBAL_MANAGER_SET_PITCHYAW", "GIMBAL_DEVICE_SET_ATTITUDE"):
            return
        frames = message.flags & (gimbal_messages.VEHICLE_FRAME | gimbal_messages.EARTH_FRAME)
        if frames not in (gimbal_messages.VEHICLE_FRAME, gimbal_messages.EARTH_FRAME) or message.flags in (
            gimbal_messages.EARTH_FRAME,
            48,
        ):
            self.words.append(f"{packet.name} with the flags {message.flags}")
        rates = (
            (message.pitch_rate, message.yaw_rate)
            if isinstance(message, common.MAVLink_gimbal_manager_set_pitchyaw_message)
            else (message.angular_velocity_y, message.angular_velocity_z)
        )
        if any(map(math.isfinite, rates)):
            self.words.append(f"{packet.name} with rates, which never end")

    @classmethod
    def make(cls, config: Options) -> GimbalFarEnd:
        """Make a gimbal that can do a little more than the options ask for, at joint angle 0."""
        servo = Servo(
            lower=math.radians(config.lower_deg) - MARGIN,
            upper=math.radians(config.upper_deg) + MARGIN,
            max_speed=1.2 * math.radians(config.max_speed_deg_s),
            max_acceleration=2 * math.radians(config.max_acceleration_deg_s2),
        )
        return cls(servo, autopilot=config.role != "manager")


@dataclass(slots=True)
class CrowdedLine:
    """One direction of a wire; frames keep their order."""

    chance: Generator
    crowded: bool = False
    latency: float = 0.0  # of a line that nobody fills [s]
    _under_way: deque[tuple[float, bytes]] = field(default_factory=deque)

    def pass_on(self, frames: list[bytes], now: float) -> list[bytes]:
        """Take frames in; return those that have arrived by ``now`` [s]."""
        for frame in frames:
            if not (self.crowded and self.chance.random() < LOSS):
                self._under_way.append((now + self.latency + DELAY * self.crowded, frame))
        arrived = []
        while self._under_way and self._under_way[0][0] <= now + EARLY:
            arrived.append(self._under_way.popleft()[1])
        return arrived


@dataclass(slots=True)
class RivalController:
    """A station that takes control from a manager, or points a device that another one manages."""

    address: ComponentId  # its own
    whom: ComponentId  # the manager or the device
    at: float | None  # joint angle [rad] to which it points a device; None: ``whom`` is a manager
    _due: float = 0.0

    def on_packet(self, packet: Packet, now: float) -> list[Any]:
        """Care for nobody."""
        return []

    def live(self, now: float) -> list[Any]:
        """Return what is due at ``now`` [s]."""
        if now < self._due:
            return []
        if self.at is not None:
            self._due = now + AGAIN
            return [gimbal_messages.point_device(self.whom, self.at)]
        self._due = float("inf")
        return [gimbal_messages.configure(self.whom, 0, gimbal_messages.ITSELF)]


far_end = GimbalFarEnd
