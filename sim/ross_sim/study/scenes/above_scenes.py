"""Scenes from above: K talkers on the ground below a vehicle, heard at nine headings among its rotors.

Everybody stands, or walks to and fro, 3 to 8 m from the point below the array, all equally loud at their mouths: the
higher the vehicle flies, the steeper are they below it, and the less do delays differ. The ground reflects every voice.
The rotors go on without a break as in `noise_scenes`; their level is such that all talkers together have the asked
ratio to them at microphone 1, whatever the height.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import oaconvolve

from ross_payload.interfaces import Real, Samples
from ross_sim.acoustics.near_field import NearField
from ross_sim.scenario import MOUTH
from ross_sim.study.scenes.exploration import UNIT
from ross_sim.study.scenes.mixtures import LEAD_IN, RATE, expect_sound, spread
from ross_sim.study.scenes.noise_scenes import HEADINGS, LEVEL, SENSOR_DB, Noise, noise_of
from ross_sim.study.scenes.room_settings import SPACING, SPEED_OF_SOUND

RING = (3.0, 8.0)  # from the point below the array to a talker [m]
APART = math.radians(25.0)  # between two talkers
TURN_S = 1.0  # from one heading to the next
STROLL_M = 2.0  # that who walks goes before turning back
PIECE_S = 0.05  # of a walk in which nobody moves
TAPS = 2**11  # of a voice and its reflection


@dataclass(frozen=True, slots=True, eq=False)
class Walks:
    """Where everybody is: to and fro on straight lines through their places."""

    places: Real  # on the ground [m], the point below the array being 0, (k, 2)
    towards: Real  # unit vectors, (k, 2)
    phases: Real  # where the walk begins, as a share of the way there and back, (k,)
    height: float  # of the array above the mouths [m]
    speed: float  # 0: everybody stands [m/s]

    def at(self, time: float) -> Real:
        """Places relative to the array [m], (k, 3)."""
        share = (self.phases + self.speed * time / (2 * STROLL_M)) % 1.0
        along = STROLL_M * (np.abs(2 * share - 1) - 0.5) * (self.speed > 0)
        ground = self.places + along[:, None] * self.towards
        return np.column_stack([ground, np.full(len(ground), -self.height)])

    def azimuths(self, time: float) -> Real:
        """Azimuths [rad], (k,)."""
        x, y, _ = self.at(time).T
        return np.asarray(np.arctan2(y, x))

    def elevations(self, time: float) -> Real:
        """Elevations as seen from the array [rad], negative, (k,)."""
        x, y, z = self.at(time).T
        return np.asarray(np.arctan2(z, np.hypot(x, y)))


@dataclass(frozen=True, slots=True, eq=False)
class AboveScene:
    """What is heard at every heading, and who is where."""

    walks: Walks
    voices: tuple[Samples, ...]
    ground: float  # reflection coefficient
    lead_in: Samples  # (2, n), at the first heading
    heard: Samples  # (n_headings, 2, n)

    @property
    def end(self) -> float:
        """When the last heading has been heard [s]."""
        return len(HEADINGS) * UNIT + (len(HEADINGS) - 1) * TURN_S


def walks_of(k: int, height: float, speed: float, rng: np.random.Generator) -> Walks:
    """Put ``k`` talkers on the ground, at least 25 degrees apart where they turn back half of the way."""
    azimuths, away, towards = spread(k, rng, APART), rng.uniform(*RING, k), rng.uniform(-np.pi, np.pi, k)
    places = away[:, None] * np.column_stack([np.cos(azimuths), np.sin(azimuths)])
    return Walks(places, np.column_stack([np.cos(towards), np.sin(towards)]), rng.uniform(size=k), height, speed)


def responses(places: Real, heading: float, ground: float) -> Real:
    """Of every talker and the ground below, (2, k, TAPS), without the delay from the talker to the array.

    The reflection comes from as far below the ground as the mouth is above it.
    """
    mirrored = places - [0.0, 0.0, 2 * MOUTH]
    direct, reflected = (
        NearField(tuple(map(tuple, each.tolist())), SPACING, RATE, SPEED_OF_SOUND, delayed=False).at(heading)
        for each in (places, mirrored)
    )
    found = np.zeros((2, len(places), TAPS))
    found[..., : direct.shape[-1]] = direct
    later = np.linalg.norm(mirrored, axis=1) - np.linalg.norm(places, axis=1)
    for k, samples in enumerate(np.round(later / SPEED_OF_SOUND * RATE).astype(int)):
        end = min(TAPS, samples + reflected.shape[-1])
        found[:, k, samples:end] += ground * reflected[:, k, : end - samples]
    return found


def images_of(voices: Sequence[Real], walks: Walks, heading: float, ground: float, begin: float = 0.0) -> Real:
    """Every talker alone at both microphones, (k, 2, n), from ``begin`` [s] on; who walks does so in small pieces."""
    n = voices[0].size
    speech = np.stack(voices).astype(float)
    if not walks.speed:
        heard = oaconvolve(speech[:, None], responses(walks.at(begin), heading, ground).swapaxes(0, 1), axes=-1)
        return np.asarray(heard[..., :n])
    step = round(PIECE_S * RATE)
    window = 0.5 - 0.5 * np.cos(np.pi * np.arange(2 * step) / step)  # two neighbours add up to 1
    padded = np.pad(speech, ((0, 0), (step, 2 * step)))
    heard = np.zeros((len(speech), 2, padded.shape[1] + TAPS))
    for first in range(0, n + step, step):
        piece = padded[:, first : first + 2 * step] * window
        there = responses(walks.at(begin + first / RATE), heading, ground).swapaxes(0, 1)
        heard[..., first : first + 2 * step + TAPS - 1] += oaconvolve(piece[:, None], there, axes=-1)
    return heard[..., step : step + n]


def scene(
    k: int, height: float, snr_db: float | None, voices: Sequence[Samples], *,
    clips: Sequence[Samples] = (), speed: float = 0.0, ground: float = 0.5, key: Sequence[int],
) -> AboveScene:  # fmt: skip
    """Make a scene; ``key`` seeds it, whatever height and ratio. Without a ratio the rotors are off."""
    rng = np.random.default_rng(key)
    walks = walks_of(k, height, speed, rng)
    chosen = tuple(voices[index] for index in rng.permutation(len(voices))[:k])
    unit, n = round(UNIT * RATE), round(UNIT * RATE) * len(HEADINGS)
    speech = [np.resize(np.roll(v, -int(rng.integers(len(v)))), n).astype(float) for v in chosen]
    expect_sound(speech, RATE)
    speech = [each / np.sqrt(np.mean(each**2)) for each in speech]
    heard = np.stack([
        images_of([each[r * unit : (r + 1) * unit] for each in speech], walks, float(h), ground, r * (UNIT + TURN_S))
        for r, h in enumerate(HEADINGS)
    ]).sum(axis=1)  # fmt: skip
    noise = noise_of(rotors_of(clips), LEAD_IN + UNIT * len(HEADINGS), clips, rng)
    lead_in, heard = among(noise, heard, list(HEADINGS), snr_db, rng)
    scale = LEVEL / np.sqrt(np.mean(heard**2))
    return AboveScene(walks, chosen, ground, (scale * lead_in).astype(np.float32), (scale * heard).astype(np.float32))


def rotors_of(clips: Sequence[Samples]) -> str:
    """Recorded rotors where there are recordings, else made ones."""
    return "recorded" if clips else "synthetic"


def among(
    noise: Noise, heard: Real, headings: Sequence[float], snr_db: float | None, rng: np.random.Generator
) -> tuple[Real, Real]:
    """A lead-in (2, n) at the first heading, and talkers (n_headings, 2, n) among the noise that goes on from there."""
    first, unit = round(LEAD_IN * RATE), heard.shape[-1]
    talk = float(np.mean(heard[:, 0] ** 2))
    lead_in, rest = np.zeros((2, first)), np.zeros_like(heard)
    if snr_db is not None:
        starts = [first + r * unit for r in range(len(headings))]
        rest = np.stack([noise.at(float(h), s, s + unit) for h, s in zip(headings, starts, strict=True)])
        gain = np.sqrt(talk / np.mean(rest[:, 0] ** 2)) * 10 ** (-snr_db / 20)
        lead_in, rest = gain * noise.at(float(HEADINGS[0]), 0, first), gain * rest
    sensor = np.sqrt(talk) * 10 ** (SENSOR_DB / 20)
    return (
        lead_in + sensor * rng.standard_normal(lead_in.shape),
        heard + rest + sensor * rng.standard_normal(heard.shape),
    )
