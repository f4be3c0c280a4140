"""A payload's mount, and a simulated autopilot that tells it where the vehicle points and how high it is."""

import math

from ross_payload.config import Config, Link
from ross_payload.mavlink import Router
from ross_payload.mount import mount_of
from ross_payload.timebase import Timebase
from ross_protocols.mavlink.vehicle import VehicleAttitude
from ross_sim.autopilot.simulated_autopilot import Autopilot
from ross_sim.autopilot.yaw import Yaw
from ross_sim.clock import SimClock
from ross_sim.devices.far_end import wire

SWINGING = Yaw(mean=1.0, amplitude=math.radians(15), speed=math.radians(10))
CONFIG = Config.model_validate({"mount": {"source": "autopilot"}})


class Drone:
    """A payload's mount, and the autopilot at the other end of a slow wire."""

    def __init__(self, yaw=SWINGING, latency=0.04, jitter=0.02, role="autopilot", config=CONFIG, **autopilot):
        self.clock = SimClock()
        self.links = Router.open((), self.clock, system_id=config.telemetry.system_id)
        ours, self.other = wire(self.clock, latency, jitter, seed=1)
        self.links.attach(Link(url="udpin:autopilot:1", role=role), ours)
        self.yaw = yaw
        self.autopilot = Autopilot(yaw, **autopilot)
        self.autopilot.plug("payload", self.other)
        self.timebase = Timebase(self.clock)
        self.timebase.attach(self.links.component(191))
        self.clock.every(0.01, lambda: self.autopilot.advance(self.clock.now()))
        self.clock.every(0.01, self.links.poll)
        self.mount = mount_of(config, self.clock, self.links, self.timebase)

    def error(self, late):
        """How wrong the yaw is [rad] when it is asked for `late` [s] after the fact."""
        time = self.clock.now() - late
        return abs(self.mount.attitude(time).yaw - self.yaw.at(time))


def report(boot, yaw, rate=0.0):
    return VehicleAttitude(boot, yaw, 0.0, 0.0, rate)
