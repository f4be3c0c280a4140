"""A payload's command server on the pump, and a real session on the mission's side; a ground station calls it."""

from dataclasses import replace

import numpy as np
import pytest

from ross_payload.config import Config
from ross_payload.dsp.stft import Stft
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.interfaces import Attitude, AudioBlock, Input, Observation
from ross_payload.mavlink.message_requests import MessageRequests
from ross_payload.mavlink.mission_commands import MissionCommands
from ross_payload.mission.live_session import Kit, LiveSession
from ross_payload.mission.settings import Tools
from ross_payload.orders import Stop
from ross_payload.pointing import Pointing
from ross_payload.service.assemble import settings_of

RATE, HOP = 16000, 160
EXPLORE, LISTEN, INFORM, TURN, STOP, CANCEL, PARK, NOISE, RECORD, REARM, HOME = range(54000, 54011)
ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED, FAILED, IN_PROGRESS, CANCELLED, LONG_ONLY = range(8)


class Believer:
    """An explorer that knows two sources after three orientations."""

    name = "believer"

    def observe(self, spectrogram, frequencies, heading, noise_psd, *, frame_period=None):
        return Observation(heading, np.zeros(1), np.ones(1), 1.0)

    def estimate(self, observations):
        sources = tuple(SourceEstimate(azimuth, 0.01, 0.9, True) for azimuth in (1.0, -1.0))
        return Estimate(sources if len(observations) > 2 else (), certain=len(observations) > 2)


def kit(config):
    stft = Stft(RATE, 1024, 256)
    numbers = replace(settings_of(config, -3.5, 3.5), lead_in=0.1, unit=0.1, min_rotations=2, max_rotations=4)
    return Kit(numbers, Tools(Believer(), stft, None, stft, None))


class Streams:
    """Nothing is streamed."""

    def request(self, link, message_id):
        return False

    def period(self, link, message_id):
        return None

    def set_period(self, link, message_id, period):
        return False


class Payload:
    """Server, session and a turntable of 1 rad/s whose guard latches stops; time moves in hops of 10 ms."""

    def __init__(self, sky, latch=None):
        self.clock, self.links, self.ground = sky.clock, sky.links, sky.ground
        self.given, self.recorded, self.streamed, self.texts, self.waiting = [], [], [], [], []
        self.why_not = ""  # the listening stage refuses
        self.disk_full = self.computing = self.stopped = False
        self.fault, self.joint, self.goal, self.hops = "", 0.0, None, 0
        component = self.links.component(191)
        self.server = MissionCommands(
            component,
            self.give,
            self.record,
            self.say,
            MessageRequests(component, Streams()),
            stream=self.stream,
            latch=latch,
        )
        self.mission = LiveSession(Config(), kit).mission()
        self.output = next(self.mission)

    def give(self, order):
        self.given.append(order)
        self.waiting.append(order)
        if isinstance(order, Stop):
            self.stopped, self.goal = True, None

    def record(self, on):
        self.recorded.append(on)
        return "the disk is full" if self.disk_full else ""

    def stream(self, order):
        self.streamed.append(order)
        return self.why_not

    def say(self, severity, text):
        self.texts.append(text)

    def wait(self, seconds):
        """Let time pass; return what the ground station hears meanwhile."""
        heard = []
        for _ in range(round(seconds * 100)):
            self.step()
            heard += self.ground.listen()
        return heard

    def step(self):
        """Let 10 ms pass."""
        self.clock.advance()
        self.links.poll()
        self.server.tick(self.clock.now())
        if not self.computing:
            self.hop()

    def hop(self):
        output = self.output
        for event in output.events:
            self.server.on_event(event)
        self.stopped = (self.stopped or output.stop) and not output.rearm
        if output.goal is not None:
            self.goal = output.goal
        if output.stop or output.halt or self.stopped:
            self.goal = None
        begin, step = self.joint, 0.01
        if self.goal is not None:
            self.joint += float(np.clip(self.goal - self.joint, -step, step))
        block = AudioBlock(np.zeros((2, HOP), np.float32), self.hops * HOP, self.hops * HOP / RATE)
        self.hops += 1
        settled = self.goal is None or abs(self.goal - self.joint) < 1e-9
        orders, self.waiting = tuple(self.waiting), []
        heard = Input(block, begin, Pointing(joint=self.joint, earth=True), settled, Attitude(0.0), self.fault, orders)
        self.output = self.mission.send(heard)

    def results(self, number, seconds=3.0):
        """The results of a command that come within some seconds, without repetitions in a row."""
        acks = [m for m in self.wait(seconds) if m.get_type() == "COMMAND_ACK" and m.command == number]
        found = [ack.result for ack in acks]
        return [result for place, result in enumerate(found) if place == 0 or found[place - 1] != result]

    def command(self, number, *numbers, seconds=3.0, **how):
        self.ground.long(number, *numbers, **how)
        return self.results(number, seconds)


def near(given, order):
    """Whether an order is another one, up to rounding."""
    numbers = {name: getattr(given, name) for name in order.__dataclass_fields__ if name != "number"}
    wanted = {name: getattr(order, name) for name in numbers}
    return type(given) is type(order) and all(numbers[n] == pytest.approx(wanted[n]) for n in numbers)
