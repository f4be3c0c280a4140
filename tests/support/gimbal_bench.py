"""The payload of `hand_bench` with its gimbal component on links whose far ends a test holds in its hands."""

import math
from types import SimpleNamespace

from hand_bench import HandBench
from links_bench import Wire
from ross_payload.config import Link
from ross_payload.mavlink import Router
from ross_payload.mavlink.gimbal import Gimbal
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.vehicle import quaternion

GROUND, AUTOPILOT = "udpout:ground:1", "udpout:autopilot:1"
LONG = common.MAVLink_command_long_message
REQUEST, INTERVAL, POINT, CONFIGURE = 512, 511, 1000, 1001
ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED = 0, 1, 2, 3
NAN = math.nan
TAKE, GIVE = (-2, -2, -1, -1), (-3, -3, -1, -1)
READY = 3.0  # [s]: by then it speaks
FOLLOW, LOCK = 32, 16 | 64


def deg(angle):
    return math.radians(angle)


def pitchyaw(yaw=NAN, rate=NAN, flags=FOLLOW, device=1):
    """GIMBAL_MANAGER_SET_PITCHYAW; clockwise [rad]."""
    return common.MAVLink_gimbal_manager_set_pitchyaw_message(1, 154, flags, device, 0.0, yaw, NAN, rate)


def set_attitude(yaw=NAN, rate=NAN, flags=0, target=(1, 154)):
    """GIMBAL_DEVICE_SET_ATTITUDE; clockwise [rad]."""
    q = quaternion(yaw, 0.0, 0.0) if math.isfinite(yaw) else (NAN,) * 4
    return common.MAVLink_gimbal_device_set_attitude_message(*target, flags, q, NAN, NAN, rate)


class Station:
    """Somebody on a link: what it says, and what it hears."""

    def __init__(self, bench, url, system, component):
        self._bench, self._encoder = bench, Encoder(system, component)
        self._wire = bench.wires[url]

    def say(self, time, *messages):
        """A step of a script: say something."""
        return time, lambda: self._wire.coming.extend(self._encoder.encode(message) for message in messages)

    def command(self, time, number, *values, component=154):
        """A step of a script: command."""
        values = [float(value) for value in (*values, *[0] * (7 - len(values)))]
        return self.say(time, LONG(1, component, number, 0, *values))

    def stream(self, begin, end, message, period=0.02):
        """Steps of a script: say the same again and again."""
        return [self.say(begin + period * step, message) for step in range(round((end - begin) / period))]


class TimedWire(Wire):
    """Remembers when a frame was sent."""

    def __init__(self, clock):
        super().__init__()
        self._clock, self._ear, self.heard = clock, Decoder(), []

    def send(self, frame):
        self.heard += [(self._clock.now(), packet) for packet in self._ear.feed(frame)]


class GimbalBench(HandBench):
    """A payload with two links, one to a ground station and one to an autopilot."""

    def __init__(self, stack, mode, base=None, *, accept=(), bytes_s=0, **config):
        gimbal = {"mode": mode} | config.pop("gimbal", {})
        super().__init__(stack, base, **{"gimbal": gimbal} | config)
        links = stack.enter_context(Router(self.clock, 1))
        self.links = links
        self.wires = {url: TimedWire(self.clock) for url in (GROUND, AUTOPILOT)}
        links.attach(Link(url=GROUND, accept=accept, max_bytes_s=bytes_s), self.wires[GROUND])
        links.attach(Link(url=AUTOPILOT, role="autopilot"), self.wires[AUTOPILOT])
        self.clock.every(0.01, links.poll)
        gimbal = Gimbal(self.config, self.clock, links, self.actuator, self.base, give=self.runner.order)
        self.runner.observers.append(stack.enter_context(gimbal))
        self.ground, self.other = Station(self, GROUND, 255, 190), Station(self, GROUND, 254, 190)
        self.autopilot = Station(self, AUTOPILOT, 1, 1)

    def told(self, name, url=GROUND, begin=0.0, end=1e9):
        """What the gimbal has said on a link: messages, each with its time."""
        said = [(time, packet) for time, packet in self.wires[url].heard if packet.name == name]
        return [
            SimpleNamespace(at=time, sender=packet.component_id, **packet.message.to_dict())
            for time, packet in said
            if begin <= time <= end
        ]

    def results(self, number):
        """The results of the commands with this number, in order."""
        return [ack.result for ack in self.told("COMMAND_ACK") if ack.command == number]

    def status(self, time):
        """The manager's status at a time."""
        return self.told("GIMBAL_MANAGER_STATUS", end=time)[-1]

    def attitude(self, time, url=GROUND):
        """The device's attitude at a time."""
        return self.told("GIMBAL_DEVICE_ATTITUDE_STATUS", url, end=time)[-1]

    def primary(self, time):
        status = self.status(time)
        return status.primary_control_sysid, status.primary_control_compid
