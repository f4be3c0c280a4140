"""A listening stage with a separator that numbers its groups, sinks that remember, and a mission that is scripted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ross_payload.audio.sinks import SinkInfo
from ross_payload.config import Config
from ross_payload.dsp.streaming_stft import transform_for
from ross_payload.errors import PluginError
from ross_payload.events import (
    AlignmentCandidate,
    AlignmentPlanned,
    Estimate,
    SourceEstimate,
    SourcesEstimated,
    State,
    StateChanged,
    TurnStarted,
)
from ross_payload.interfaces import Attitude, AudioBlock, Groups, Input
from ross_payload.listening.learning import ImmediateLearner
from ross_payload.listening.stage import ListeningStage
from ross_payload.listening.stream import StreamSettings
from ross_payload.listening.voice_separation import VoiceSeparation
from ross_payload.pointing import Pointing
from ross_payload.streams import Selection, What

RATE, HOP = 16000, 160
AZIMUTHS = (170, 70, -50)
MIXTURE, TARGET = Selection(What.MIXTURE), Selection(What.TARGET)
NOISE = 0.05 * np.random.default_rng(0).standard_normal(20 * RATE)


def noise(index):
    """The sample of both microphones at an index."""
    return NOISE[index % len(NOISE)]


def source(number):
    return Selection(What.SOURCE, source=number)


def azimuth(degrees):
    return Selection(What.AZIMUTH, azimuth=float(np.deg2rad(degrees)))


def estimate(azimuths=AZIMUTHS):
    return Estimate(tuple(SourceEstimate(float(np.deg2rad(a)), 0.01, 0.9, True) for a in azimuths), certain=True)


class Numbering:
    """A live separator whose group k is the mixture times 2 (k + 1), a frame late; knows what it was asked."""

    name = "numbering"
    lookahead = 1

    def __init__(self):
        self.starts, self.lessons, self.renewals = [], [], []
        self.fault = ""

    def start(self, scene):
        self.starts.append(scene)
        return np.zeros((2, scene.frequencies.size), np.complex64)

    def step(self, state, frame, scene):
        if self.fault:
            raise PluginError(self.fault)
        signals = np.stack([2 * (k + 1) * state[0] for k in range(scene.n_sources)])[..., None]
        return frame, Groups(signals, tuple((k,) for k in range(scene.n_sources)), self.name)

    def learn(self, window, scene, before=None):
        self.lessons.append((window.shape[2], before))
        return len(self.lessons)

    def renewed(self, state, learnt):
        self.renewals.append(learnt)
        return state


class Kept:
    """Takes the place of a sink and what drives it: keeps every block."""

    def __init__(self, settings):
        self.settings = settings
        self.blocks, self.closed = [], False
        self.fault, self.lost, self.info = "", 0, SinkInfo("memory")

    def write(self, block):
        assert not self.closed
        self.blocks.append(block)

    def close(self):
        self.closed = True

    def wait(self):
        assert self.closed

    @property
    def samples(self):
        return np.concatenate([block.samples for block in self.blocks])

    @property
    def first(self):
        return self.blocks[0].index


class Bench:
    """A stage in its own time; ``sound`` is a function of the index of samples."""

    def __init__(self, streams, sound=None, separator=None, **listening):
        self.config = Config.model_validate({"listening": listening})
        self.separator = separator or Numbering()
        self.sound = sound or (lambda index: 0.1 * np.sin(2 * np.pi * 440 / RATE * index))
        self.transform, _ = transform_for(RATE, self.config.listening.latency_ms / 1000)
        separation = VoiceSeparation(self.separator, ImmediateLearner(self.separator), self.transform.stft, self.config)
        self.kept = {}
        self.stage = ListeningStage(self.config, separation, self._open, None)
        self.wanted = {number: StreamSettings(number, "memory", stream) for number, stream in streams.items()}
        self.stage.want(self.wanted)
        self.index = 0
        self.heading = 0.0
        self.gains = np.ones((2, 1), np.float32)  # of the microphones

    def _open(self, settings):
        self.kept[settings.number] = Kept(settings)
        return self.kept[settings.number]

    def want(self, number, **changes):
        self.wanted[number] = replace(self.wanted[number], **changes)
        self.stage.want(self.wanted)

    def hear(self, seconds, *, settled=True):
        for _ in range(round(seconds * RATE / HOP)):
            index = np.arange(self.index, self.index + HOP)
            one = self.sound(index).astype(np.float32)
            block = AudioBlock(self.gains * np.stack([one, one]), self.index, 5.0 + self.index / RATE)
            self.index += HOP
            self.stage.hear(block, Pointing(joint=self.heading), settled=settled)

    def say(self, *events):
        for event in events:
            self.stage.on_event(event, earth=False)

    def know(self, azimuths=AZIMUTHS):
        self.say(SourcesEstimated(0.0, estimate(azimuths), rotations=3, final=True))

    def listen_to(self, number):
        """The mission turns to the alignment of a source, and listens."""
        candidates = tuple(AlignmentCandidate(k, 0.1 * k, 0.1 * k, 1e-5, "gain") for k in range(len(AZIMUTHS)))
        self.say(
            AlignmentPlanned(0.0, candidates, np.zeros(1), np.zeros((3, 1))),
            StateChanged(0.0, State.ALIGN_TURN),
            TurnStarted(0.0, 0.1 * number, 0.1 * number, "alignment"),
            StateChanged(0.0, State.RUN),
        )

    def factor(self, number, last=0.1):
        """By how much the end of a stream is louder than the mixture."""
        kept = self.kept[number]
        n = round(last * RATE)
        end = kept.blocks[-1].index + len(kept.blocks[-1].samples)
        mixture = self.sound(np.arange(end - n, end))
        return round(float(np.sqrt(np.mean(kept.samples[-n:] ** 2) / np.mean(mixture**2))), 3)

    def status(self, number):
        return next(status for status in self.stage.streams if status.number == number)


def inputs(bench_or_samples, earth=False):
    """Inputs of a mission from samples (2, n)."""
    for index in range(0, bench_or_samples.shape[1] - HOP + 1, HOP):
        block = AudioBlock(bench_or_samples[:, index : index + HOP], index, index / RATE)
        yield Input(block, 0.0, Pointing(earth=earth), True, Attitude(0.0, known=earth))
