"""A guarded driver of a DroneCAN servo, its simulated servo, and everything that the driver has sent."""

import math

from ross_payload.actuators.registry import checked_options, open_actuator
from ross_payload.config import Config
from ross_payload.interfaces import Services
from ross_protocols.dronecan.gimbal_messages import AngularCommand
from ross_protocols.dronecan.messages import ArrayCommand
from ross_protocols.dronecan.node_messages import Decoder, Encoder
from ross_sim.clock import QUANTUM, SimClock
from ross_sim.devices.dronecan_far_end import far_end

OWN, SERVO = 121, 50


class Rig:
    """All of it in simulated time; `wrap` may put something between the driver and its bus."""

    def __init__(self, guard=None, drive=None, wrap=lambda port: port, **options):
        config = Config.model_validate(
            {"actuator": {"kind": "dronecan_servo", "options": options}, "guard": guard or {}}
        )
        self.options = checked_options(config)
        self.clock = SimClock()
        self.far_end = far_end.make(self.options, drive)
        self.node = self.far_end.node
        self.heard, self._assembler = [], Decoder(0)
        self.passes = lambda frame: True  # whether the bus takes a frame of the driver
        self.clock.before_calls(self._advance)
        self.actuator = open_actuator(config, Services(self.clock, lambda url: wrap(self.far_end.port)))
        self.hang = self.clock.every(QUANTUM, lambda: self.actuator.poll(self.clock.now()))
        self.actuator.__enter__()
        self.clock.sleep(0.2)

    def _advance(self, now):
        self.far_end.port.sent = list(filter(self.passes, self.far_end.port.sent))
        for frame in self.far_end.port.sent:
            if received := self._assembler.feed(frame):
                self.heard.append((now, received.message))
        self.far_end.advance(now)

    def say(self, node, message):
        self.far_end.port.arrived += Encoder(node).broadcast(message)

    def go(self, degrees, seconds=0.0):
        self.actuator.command(math.radians(degrees))
        self.clock.sleep(seconds)

    @property
    def state(self):
        return self.actuator.state()

    @property
    def true_deg(self):
        return math.degrees(self.far_end.angle())

    def values(self):
        """Everything that was commanded, as it was sent; of gimbals the yaw [rad]."""
        return [value for _, message in self.heard for value in _values(message)]


def _values(message):
    if isinstance(message, AngularCommand):
        return [message.yaw]
    return [command.value for command in message.commands] if isinstance(message, ArrayCommand) else []
