"""The guarded driver of a MAVLink gimbal in simulated time, its far end, and a ground station on the same wire."""

import math

from ross_payload.actuators.registry import open_actuator
from ross_payload.config import Config
from ross_payload.interfaces import Services
from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.dialect import common
from ross_sim.clock import SimClock
from ross_sim.devices.gimbal_device import Servo
from ross_sim.devices.gimbal_far_end import GimbalFarEnd

SERVO = Servo(math.radians(-202), math.radians(202), max_speed=2.0, max_acceleration=4.0)
STATION = Encoder(255, 190)
FREE, PAYLOAD, GROUND = (0, 0), (1, 191), (255, 190)
ITSELF, NOBODY = -2.0, -3.0
SET_POINT, CONFIGURE = "GIMBAL_MANAGER_SET_PITCHYAW", "COMMAND_LONG 1001"


class Bench:
    """A guarded driver in simulated time, and what crosses its wire."""

    def __init__(self, role="discover", servo=SERVO, *, autopilot=True, opened=True, options=None, **far_end):
        told = {"role": role} | (options or {})
        config = Config.model_validate({"actuator": {"kind": "mavlink_gimbal", "options": told}})
        self.clock = SimClock()
        self.far_end = GimbalFarEnd(servo, autopilot=autopilot, **far_end)
        self.clock.before_calls(self.far_end.advance)
        self.actuator = open_actuator(config, Services(self.clock, lambda url: self.far_end.port))
        self.cancel = self.clock.every(0.01, lambda: self.actuator.poll(self.clock.now()))
        if opened:
            self.actuator.__enter__()
            self.clock.sleep(0.5)

    @property
    def device(self):
        return self.far_end.device

    @property
    def state(self):
        return self.actuator.state()

    def settle(self, within=5.0):
        end = self.clock.now() + within
        while not self.state.settled and self.clock.now() < end:
            self.clock.sleep(0.01)
        assert self.state.settled, self.state

    def detect(self, within):
        """Wait for a fault; return how long that took [s]."""
        begin = self.clock.now()
        while self.state.healthy and self.clock.now() < begin + within:
            assert not self.state.settled
            self.clock.sleep(0.01)
        assert not self.state.healthy
        return self.clock.now() - begin

    def pilot(self, *messages):
        """Let a ground station say something to everybody on the wire."""
        self.far_end.port.sent += [STATION.encode(message) for message in messages]

    def point(self, yaw_deg):
        """Let the ground station have the autopilot point the gimbal, clockwise from the nose."""
        self.pilot(_command(1000, 0.0, yaw_deg, math.nan, math.nan, 12.0))

    def configure(self, control):
        """Let the ground station take control (-2) or release it (-3)."""
        self.pilot(_command(1001, control, control, -1.0, -1.0))

    @property
    def primary(self):
        return self.far_end.autopilot.primary

    @property
    def true_deg(self):
        """Where the gimbal points, clockwise from the nose."""
        return -math.degrees(self.far_end.angle())

    def sent(self, seconds):
        """The names of what the driver says to the autopilot in the time to come, with the numbers of commands."""
        wire, names = self.far_end.port, []
        send = wire.send

        def noted(message):
            names.append(f"{message.get_type()} {getattr(message, 'command', '')}".strip())
            send(message)

        wire.send = noted
        self.clock.sleep(seconds)
        wire.send = send
        return names


def _command(number, *values):
    return common.MAVLink_command_long_message(1, 1, number, 0, *values, *[0.0] * (7 - len(values)))


def after_a_task(rig):
    """The same bench when a task has turned the gimbal and is over."""
    rig.actuator.take_control()
    rig.actuator.command(0.4)
    rig.settle()
    rig.actuator.release_control()
    rig.clock.sleep(0.5)
    return rig
