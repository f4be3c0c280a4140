"""What both microphones hear while the array turns, rendered as the simulator does (`acoustics.render`)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ross_payload.actuators.motion import Trapezoid
from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Observation, Real, Samples, TurningExplorer
from ross_payload.localization.turning import BEFORE_S, Turned, observe
from ross_sim.acoustics.render import Microphones, TalkerSignals
from ross_sim.clock import QUANTUM
from ross_sim.study.scenes.exploration import BEFORE
from ross_sim.study.scenes.mixtures import RATE, SNR_DB, expect_sound
from ross_sim.study.scenes.room_settings import SPACING, Setting

SETTLING_S = 0.13  # from the end of a turn until a mission listens or turns on: of the stepper in `ross sitl` [s]
N_HALF = 36  # headings in half a turn: the grid of the simulator's microphones at this spacing
GRID = np.pi / N_HALF * np.arange(N_HALF)  # [rad]


@dataclass(frozen=True, slots=True)
class Turning:
    """How the array turns: from rest back and forth, as a mission turns it within the limits of its joint."""

    rate: float = math.radians(20.0)  # [rad/s]
    acceleration: float = math.radians(112.5)  # [rad/s^2]
    span: float = math.pi  # to one side, and back [rad]
    settling: float = SETTLING_S  # [s] at rest before it turns back

    def headings(self, seconds: float) -> Real:
        """Headings [rad] from 0 on, at both ends of every quantum, (n_quanta + 1,)."""
        there, back = (Trapezoid(a, b, self.rate, self.acceleration) for a, b in ((0, self.span), (self.span, 0)))
        times = QUANTUM * np.arange(round(seconds / QUANTUM) + 1)
        period = there.duration + self.settling
        legs = [(there, back)[int(time // period) % 2] for time in times]
        return np.array([leg.at(time % period)[0] for leg, time in zip(legs, times, strict=True)])


@dataclass(frozen=True, slots=True, eq=False)
class HalfTurn:
    """Responses on the grid of half a turn (n_half, 2, n_sources, n_taps): half a turn on, microphones are swapped."""

    responses: Samples

    @property
    def n_taps(self) -> int:
        """Taps of a response."""
        return int(self.responses.shape[-1])

    def at(self, heading: float) -> Samples:
        """Return the responses at a heading of the grid [rad], (2, n_sources, n_taps)."""
        node = round(heading / (np.pi / N_HALF))
        response = self.responses[node % N_HALF]
        return np.asarray(response[::-1] if node // N_HALF % 2 else response)


@dataclass(frozen=True, slots=True, eq=False)
class Speech:
    """What a talker says: samples from ``before`` samples before the first one on."""

    samples: Samples  # (n,)
    before: int

    def between(self, first: int, last: int) -> Samples:
        """Return the samples from ``first`` to before ``last``; silence where there are none."""
        said = self.samples[max(first + self.before, 0) : max(last + self.before, 0)]
        ahead = min(max(-first - self.before, 0), last - first)
        return np.pad(said, (ahead, last - first - ahead - len(said)))


def images(speech: Sequence[Speech], responses: Samples, headings: Real, rate: int) -> Real:
    """Every talker alone while the array turns, (n_sources, 2, n).

    Parameters
    ----------
    speech
        Of every talker, as long as the turn.
    responses
        On `GRID`, (n_half, 2, n_sources, n_taps).
    headings
        At both ends of every quantum [rad], (n_quanta + 1,); the first is on the grid.
    rate
        [Hz].
    """
    quantum = round(QUANTUM * rate)
    signals = TalkerSignals(speech, [1.0] * len(speech), HalfTurn(responses), rate)
    microphones = Microphones(signals, SPACING, float(headings[0]))
    heard = [
        microphones.render(index * quantum, (index + 1) * quantum, float(begin), float(end))
        for index, (begin, end) in enumerate(pairwise(headings))
    ]
    return np.concatenate(heard, axis=-1).swapaxes(0, 1).astype(float)


def render_turning(
    voices: Sequence[Samples],
    azimuths: Real,
    setting: Setting,
    headings: Real,
    rng: np.random.Generator,
    *,
    rate: int = RATE,
) -> Real:
    """What both microphones hear while the array turns, (2, n): the talkers and the noise of `exploration.render`.

    ``headings`` [rad] are those at both ends of every quantum, (n_quanta + 1,).

    Raises
    ------
    ConfigError
        When a talker is silent all the time.
    """
    n, before = (len(headings) - 1) * round(QUANTUM * rate), round(BEFORE * rate)
    places = setting.places(azimuths, np.random.default_rng(np.abs(azimuths * 1e6).astype(int)))
    responses = setting.responses(places, (headings[0] + GRID).tolist(), rate)
    speech = [Speech(np.resize(np.roll(voice, -int(rng.integers(len(voice)))), n + before), before) for voice in voices]
    expect_sound([each.samples for each in speech], rate)
    received = images(speech, responses, headings - headings[0], rate)
    received = (received / np.sqrt(np.mean(received[:, :1] ** 2, axis=-1, keepdims=True))).sum(axis=0)
    noise = np.sqrt(np.mean(received[0] ** 2)) * 10 ** (-SNR_DB / 20)
    mixture = received + noise * rng.standard_normal(received.shape)
    return np.asarray(0.05 / np.sqrt(np.mean(mixture**2)) * mixture)


def observed_turning(
    explorer: TurningExplorer, stft: Stft, received: Samples, headings: Real, unit: float
) -> Iterator[Observation]:
    """What an explorer, whom nobody tells the noise, observes of every T_unit ``unit`` [s] of (2, n) samples."""
    quanta, quantum = round(unit / QUANTUM), round(QUANTUM * stft.rate)
    middles = (headings[1:] + headings[:-1]) / 2
    for first in range(0, len(middles) - quanta + 1, quanta):
        begin = max(first - round(BEFORE_S / QUANTUM), 0)
        samples = received[:, begin * quantum : (first + quanta) * quantum].astype(np.float32)
        turned = Turned(samples, middles[begin : first + quanta], (first - begin) * quantum)
        yield observe(explorer, stft, turned, None)
