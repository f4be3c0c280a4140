"""A simulated gimbal on a link of its own at a simulated autopilot that manages it."""

from __future__ import annotations

import math
from collections.abc import Callable

from ross_payload.interfaces import Clock
from ross_protocols.mavlink import gimbal_messages
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.component_id import ComponentId
from ross_sim.devices.far_end import End, wire
from ross_sim.devices.gimbal_device import STEP, Device, Servo
from ross_sim.devices.gimbal_manager import ArduPilot

TICK = 2 * STEP  # [s] in which it lives
LATENCY, JITTER = 0.001, 0.002  # of the line between gimbal and autopilot [s]
SERVO = Servo(
    lower=math.radians(-202), upper=math.radians(202), max_speed=math.radians(108), max_acceleration=math.radians(225)
)  # a little more than the driver's defaults ask for


class CarriedGimbal:
    """A gimbal device (component 154), its line to the autopilot, and the autopilot's gimbal manager.

    Parameters
    ----------
    clock
        Tells when frames arrive.
    system_id
        Of the vehicle.
    vehicle
        Yaw of the vehicle [rad] at a time [s], counter-clockwise from north.
    up
        For how long the autopilot has been on when the life of the gimbal begins [s].
    """

    def __init__(self, clock: Clock, system_id: int, vehicle: Callable[[float], float], up: float) -> None:
        address = ComponentId(system_id, gimbal_messages.COMPONENTS[0])
        self.device = Device(address, SERVO, vehicle, earth=False)
        self.manager = ArduPilot(ComponentId(system_id, 1), address, SERVO, vehicle, up=up)
        self.port: End
        self.port, self._line = wire(clock, LATENCY, JITTER, seed=0)
        self._encoder, self._decoder = Encoder(*address), Decoder()
        self._ticks = 0

    def advance(self, now: float) -> None:
        """Let the gimbal hear, move and speak until ``now`` [s]."""
        for data in self._line.receive():
            for packet in self._decoder.feed(data):
                self._send(self.device.on_packet(packet, self._ticks * TICK))
        while (self._ticks + 1) * TICK <= now:
            self._ticks += 1
            self.device.move(self._ticks * TICK)
            self._send(self.device.live(self._ticks * TICK))

    def _send(self, messages: list[object]) -> None:
        for message in messages:
            self._line.send(self._encoder.encode(message))
