"""A grbl driver and an emulated board at the other end of its line, in simulated time."""

from __future__ import annotations

import math

from rigs import CuttableWire
from ross_payload.actuators.grbl.driver import backend
from ross_payload.actuators.grbl.options import Options
from ross_payload.errors import LinkError
from ross_payload.interfaces import Services
from ross_sim.clock import QUANTUM, SimClock
from ross_sim.devices.grbl_far_end import far_end

TURN = math.radians(60)


class Bench:
    """A driver without its guard, and its controller."""

    def __init__(self, settings=None, **options):
        self.options = Options(**options)
        self.clock = SimClock()
        self.end = far_end.make(self.options, settings=settings)
        self.firmware = self.end.firmware
        self.clock.before_calls(self.end.advance)
        self.wire = CuttableWire(self.end.port)
        self.actuator = backend.open(self.options, Services(self.clock, lambda url: self.wire))
        self.failures = []
        self.clock.every(QUANTUM, self.poll)

    def poll(self):
        try:
            self.actuator.poll(self.clock.now())
        except LinkError as error:
            self.failures.append(str(error))

    def open(self, seconds=0.3):
        self.actuator.__enter__()
        self.clock.sleep(seconds)
        return self

    @property
    def state(self):
        return self.actuator.state()

    def go(self, angle, within=5.0):
        self.actuator.command(angle)
        self.until(lambda: self.state.settled, within)

    def until(self, true, within=5.0):
        end = self.clock.now() + within
        while not true():
            assert self.clock.now() < end, self.state
            self.clock.sleep(QUANTUM)

    def homed(self):
        self.actuator.home()
        self.until(lambda: self.state.homed and self.state.settled, within=40.0)
        return self
