"""A session with a scripted ear, a turntable that needs three hops for any turn, and an operator with a list."""

from dataclasses import replace

import numpy as np

from ross_payload.config import Config
from ross_payload.dsp.stft import Stft
from ross_payload.events import (
    Answer,
    Answered,
    Estimate,
    SourceEstimate,
    StateChanged,
)
from ross_payload.interfaces import Attitude, AudioBlock, Groups, Input, Observation, Score, VoicePrint
from ross_payload.mission.live_session import Kit, LiveSession
from ross_payload.mission.settings import Settings, Tools
from ross_payload.pointing import Pointing

RATE, HOP = 8000, 80

AZIMUTHS = (170, 70, -50)


def estimate():
    return Estimate(tuple(SourceEstimate(float(np.deg2rad(a)), 0.01, 0.9, True) for a in AZIMUTHS), certain=True)


class Believer:
    """An explorer that knows after three orientations."""

    name = "believer"

    def observe(self, spectrogram, frequencies, heading, noise_psd, *, frame_period=None):
        return Observation(heading, np.zeros(1), np.ones(1), 1.0)

    def estimate(self, observations):
        return estimate() if len(observations) > 2 else Estimate(())


class Numbered:
    """A separator whose group k is the mixture times k + 1."""

    name = "numbered"

    def batch(self, spectrogram, scene):
        signals = np.stack([spectrogram[0] * (k + 1) for k in range(scene.n_sources)])
        return Groups(signals, tuple((k,) for k in range(scene.n_sources)), self.name)


class Likes(VoicePrint):
    """A voice print that accepts one group."""

    def __init__(self, number):
        self.number = number

    def score(self, voice, rate):
        value = 1.0 if round(float(np.abs(voice).max() / 0.1)) - 1 == self.number else -1.0
        return Score(value, value > 0)


def make(config):
    explore, exploit = config.explore, config.exploit
    settings = Settings(
        rate=RATE, spacing=0.05, speed_of_sound=343.0, lead_in=0.1, unit=explore.unit_s / 10, rotation=np.deg2rad(15),
        min_rotations=2, max_rotations=4, pipelined=False, check=0.2, run=0.4, runs=exploit.runs, criterion=0.0,
        max_restarts=1, lower=-3.5, upper=3.5, seed=0, park=0.3,
    )  # fmt: skip
    stft = Stft(RATE, 256, 64)
    return Kit(settings, Tools(Believer(), stft, Numbered(), stft, Likes(1)))


def nobody(config):
    kit = make(config)
    return Kit(kit.settings, replace(kit.tools, voiceprint=None))


class Bench:
    """A turntable that needs three hops for any turn, a guard that latches stops, and an operator with a list."""

    def __init__(self, config=None, make=make, memory=None, first=None):
        self.session = LiveSession(config or Config(), make, memory)
        self.brain = self.session.mission(first)
        self.joint = self.goal = 0.0
        self.moving = self.hops = 0
        self.stopped = self.homed = False
        self.fault = self.lasting = ""  # one that homing clears, and one that it does not
        self.known = False
        self.factors = np.ones((2, 1), np.float32)  # of what both microphones give
        self.events, self.goals = [], []
        self.output = next(self.brain)
        self.result = None

    def obey(self, output):
        self.events += output.events
        if output.stop or output.halt:
            self.goal, self.moving, self.stopped = self.joint, 0, self.stopped or output.stop
        if output.rearm:
            self.stopped = False
            if self.homed:
                self.fault = ""
        if output.home:
            self.homed, self.moving = True, 3
        if output.goal is not None:
            assert not self.stopped
            self.goals.append(output.goal)
            self.goal, self.moving = output.goal, 3

    def hop(self, *orders):
        self.obey(self.output)
        begin, self.moving = self.joint, max(self.moving - 1, 0)
        if not self.moving:
            self.joint = self.goal
        samples = np.tile(np.float32([0.1, -0.1]), (2, HOP // 2))
        block = AudioBlock(samples * self.factors, self.hops * HOP, self.hops * HOP / RATE)
        self.hops += 1
        heard = Input(
            block,
            begin,
            Pointing(joint=self.joint, earth=self.known),
            self.moving == 0 and not (self.fault or self.lasting),
            Attitude(0.0, known=self.known),
            self.fault or self.lasting,
            orders,
        )
        try:
            self.output = self.brain.send(heard)
        except StopIteration as end:
            self.result = end.value

    def hops_until(self, wanted, limit=3000):
        """Hop until an event of this kind (or for which the function is true) is said."""
        true = (lambda event: isinstance(event, wanted)) if isinstance(wanted, type) else wanted
        for _ in range(limit):
            before = len(self.events)
            self.hop()
            found = [event for event in self.events[before:] if true(event)]
            if found:
                return found[0]
        raise AssertionError("it never came")

    def answers(self, number):
        return [e.answer for e in self.events if isinstance(e, Answered) and e.order == number]

    def reason(self, number):
        return [e.reason for e in self.events if isinstance(e, Answered) and e.order == number][-1]

    def state(self):
        return [e.state for e in self.events if isinstance(e, StateChanged)][-1]

    def over(self, number):
        ends = (Answer.DONE, Answer.FAILED, Answer.CANCELLED, Answer.REFUSED)
        return self.hops_until(lambda e: isinstance(e, Answered) and e.order == number and e.answer in ends)
