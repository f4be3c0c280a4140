"""A payload that somebody may point by hand: the real session, runner and guard, an ideal turntable, simulated time."""

import math

import numpy as np

from ross_payload.actuators.registry import open_actuator
from ross_payload.config import Config
from ross_payload.events import Answered, StateChanged
from ross_payload.interfaces import Attitude, AudioBlock, Services
from ross_payload.mission.live_session import LiveSession
from ross_payload.mission.tasks import Memory
from ross_payload.orders import Shutdown
from ross_payload.service.payload import maker
from ross_payload.service.runner import Runner
from ross_sim.clock import SimClock
from ross_sim.devices.far_end import far_end_of


class Microphones:
    """A little noise, read in lock-step with the clock."""

    rate = 16000

    def __init__(self, clock):
        self.clock = clock
        self.index = 0
        self.noise = np.random.default_rng(0)

    def read(self, n):
        time = self.clock.now()
        self.clock.sleep(n / self.rate)
        self.index += n
        return AudioBlock(self.noise.normal(0, 0.01, (2, n)).astype(np.float32), self.index - n, time)


class Base:
    """A base that turns as it is told; ``yaw`` None: nobody knows how it lies."""

    def __init__(self, yaw=None, rate=0.0):
        self.yaw, self.rate = yaw, rate

    def attitude(self, time):
        known = self.yaw is not None
        return Attitude(yaw=self.yaw + self.rate * time if known else 0.0, known=known)


class HandBench:
    """Lives through a script: calls at times [s]; keeps what happened."""

    def __init__(self, stack, base=None, **config):
        self.config = Config.model_validate({"actuator": {"kind": "ideal"}} | config)
        self.clock, self.base = SimClock(), base or Base()
        self.far_end = far_end_of(self.config)
        self.clock.before_calls(self.far_end.advance)
        services = Services(self.clock, lambda url: self.far_end.port)
        self.actuator = stack.enter_context(open_actuator(self.config, services))
        session = LiveSession(self.config, maker(self.actuator, None), Memory())
        self.runner = Runner(
            session.mission(), Microphones(self.clock), self.actuator, self.base, config=self.config, clock=self.clock
        )
        self.clock.every(0.01, self.runner.poll)
        self.clock.sleep(0.05)
        self.runner.observers = [self]
        self.events, self.trace, self._script = [], [], []

    def live(self, seconds, *script):
        """Live so long [s]; ``script``: (time [s], what to call then)."""
        self._script = sorted([*script, (seconds, lambda: self.runner.order(Shutdown()))], key=lambda step: step[0])
        return self.runner.run()

    def order(self, time, *orders):
        """A step of a script: give orders."""
        return time, lambda: [self.runner.order(order) for order in orders]

    def on_input(self, heard):
        self.trace.append((self.clock.now(), self.far_end.angle(), heard))
        while self._script and self._script[0][0] <= self.clock.now():
            self._script.pop(0)[1]()

    def on_event(self, event, heard):
        self.events.append(event)

    def angle(self, time):
        """Where the array truly was [deg], joint angle."""
        return math.degrees(next(angle for at, angle, _ in self.trace if at >= time - 1e-9))

    def heading(self, time):
        """Where the array truly pointed [deg], counter-clockwise."""
        return self.angle(time) + math.degrees(self.base.attitude(time).yaw) + self.config.array.offset_deg

    def speed(self, time):
        """How fast it truly turned [deg/s] in the 0.2 s before."""
        return (self.angle(time) - self.angle(time - 0.2)) / 0.2

    def answers(self, number):
        return [event.answer for event in self.events if isinstance(event, Answered) and event.order == number]

    def states(self):
        return [(event.state, event.detail) for event in self.events if isinstance(event, StateChanged)]
