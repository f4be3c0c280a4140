"""A mission among fakes: explorer and separator that know, a voice print with moods, an ideal turntable."""

from dataclasses import dataclass, field

import numpy as np

from ross_payload.alignment.plan import plan
from ross_payload.dsp.stft import Stft
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.interfaces import Attitude, AudioBlock, Groups, Input, Observation, Score, VoicePrint
from ross_payload.mission.mission_sequence import mission
from ross_payload.mission.settings import Settings, Tools
from ross_payload.pointing import Pointing

RATE, HOP = 8000, 80
SETTINGS = Settings(
    rate=RATE,
    spacing=0.05,
    speed_of_sound=343.0,
    lead_in=0.1,
    unit=0.7,
    rotation=np.deg2rad(15),
    min_rotations=2,
    max_rotations=4,
    pipelined=False,
    check=0.5,
    run=1.5,
    runs=1,
    criterion=0.0,
    max_restarts=1,
    lower=-3.5,
    upper=3.5,
    seed=0,
)


@dataclass
class ThreeTalkers:
    """An explorer that believes in three talkers once it has heard three orientations."""

    name: str = "fixed"
    azimuths: tuple[float, ...] = (170, 70, -50)
    certain: bool = True
    patience: int = 3  # orientations before it believes anything

    def observe(self, spectrogram, frequencies, heading, noise_psd, *, frame_period=None):
        return Observation(heading, np.zeros(1), np.ones(1), 1.0)

    def estimate(self, observations):
        if len(observations) < self.patience:
            return Estimate(())
        sources = tuple(SourceEstimate(float(np.deg2rad(a)), 0.01, 0.9, True) for a in self.azimuths)
        return Estimate(sources, certain=self.certain)


@dataclass
class Counting(ThreeTalkers):
    """An explorer that counts how often it starts again."""

    explorations: int = 0

    def estimate(self, observations):
        self.explorations += len(observations) == 1
        return super().estimate(observations)


class OneGroupEach:
    """A separator whose group k is the mixture times k + 1, so that a voice print can tell them apart."""

    name = "numbered"

    def batch(self, spectrogram, scene):
        count = scene.n_sources
        signals = np.stack([spectrogram[0] * (k + 1) for k in range(count)])
        return Groups(signals, tuple((k,) for k in range(count)), self.name)


SURE = 5.0  # [nat]
RECALLED, CHECKED, RUN = "recalled", "checked", "run"


def occasion(voice):
    """Tell by its length what was heard last: up to four periods of T_unit, then T_check, then T_run, all joined."""
    tenths = round(len(voice) / RATE * 10)
    periods = next(n for n in range(5) if (tenths - 7 * n) % 5 == 0)
    return (RECALLED, CHECKED, CHECKED, RUN)[min((tenths - 7 * periods) // 5, 3)]


@dataclass
class Likes(VoicePrint):
    """A voice print that accepts the group with one number; ``mood`` overrides its score on an occasion.

    Scores are multiples of `SURE` [nat], which leaves no doubt.
    """

    number: int
    mood: dict = field(default_factory=dict)
    heard: list = field(default_factory=list)

    @staticmethod
    def who(voice):
        """Which group of `OneGroupEach` a voice is."""
        return round(float(np.abs(voice).max() / 0.1)) - 1

    def score(self, voice, rate):
        number, when = self.who(voice), occasion(voice)
        self.heard.append(when)
        mine = self.mood.get(when, 1.0)
        mine = mine(self.heard.count(when)) if callable(mine) else mine
        value = SURE * (mine if number == self.number else -1.0)
        return Score(value, value > 0)


@dataclass
class Rig:
    """Obeys Outputs like an ideal turntable that needs three hops for any turn."""

    brain: object
    joint: float = 0.0
    goal: float = 0.0
    moving: int = 0
    hops: int = 0
    events: list = field(default_factory=list)
    outputs: list = field(default_factory=list)

    def run(self, on_hop=None, limit=20000):
        output = next(self.brain)
        try:
            for _ in range(limit):
                self._obey(output)
                heard = self._hear()
                if on_hop is not None:
                    heard = on_hop(self, heard) or heard
                output = self.brain.send(heard)
        except StopIteration as end:
            return end.value
        raise AssertionError("the mission does not end")

    def _obey(self, output):
        self.outputs.append(output)
        self.events += output.events
        if output.goal is not None:
            self.goal, self.moving = output.goal, 3
        if output.stop:
            self.goal, self.moving = self.joint, 0

    def _hear(self):
        was = self.moving
        if self.moving:
            self.moving -= 1
            self.joint = self.goal if not self.moving else self.joint
        two = np.float32([[0.1, -0.1, 0.1, -0.1], [0.1, -0.1, 0.1, -0.09]])  # microphones
        block = AudioBlock(np.tile(two, HOP // 4), self.hops * HOP, self.hops * HOP / RATE)
        self.hops += 1
        return Input(block, self.joint, Pointing(joint=self.joint), was == 0, Attitude(0.0, known=False))

    def said(self, kind):
        return [event for event in self.events if isinstance(event, kind)]


def rig(
    likes=1, settings=SETTINGS, explorer=None, voiceprint=None, separator=None, *, planner=plan, again=None, **told
):
    stft, voiceprint = Stft(RATE, 512, 128), voiceprint or Likes(likes)
    explorer = explorer or ThreeTalkers()
    tools = Tools(explorer, stft, separator or OneGroupEach(), stft, voiceprint, planner, reconsidering=again)
    return Rig(mission(settings, tools, **told))
