"""Scenes in the noise of a vehicle: K talkers 2.5 m away in the open, and rotors or wind, heard at nine headings.

The noise goes on without a break from a lead-in of 2 s at the first heading through 3 s at every heading, and, where
somebody is separated, through a lead-in and a run at the heading of the target. Its level is such that the talkers
together have the asked ratio to it at microphone 1, over all headings. Sensor noise is 25 dB below the talkers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import oaconvolve

from ross_payload.dsp.rotors import Rotors
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real, Samples
from ross_sim.acoustics.near_field import NearField
from ross_sim.acoustics.rotor_noise import rotor
from ross_sim.acoustics.wind_noise import gust_levels, wind
from ross_sim.noise_tables import QUADROTOR
from ross_sim.study.scenes.exploration import STEP, UNIT
from ross_sim.study.scenes.mixtures import LEAD_IN, RATE, spread
from ross_sim.study.scenes.room_settings import DISTANCE, SPACING, SPEED_OF_SOUND
from ross_sim.talkers.speech import SUFFIXES, read

HEADINGS = STEP * np.arange(9)
SENSOR_DB = -25.0  # of the talkers
SLOWEST, FASTEST = 4000.0, 8000.0  # rotors of a scene [1/min]
BLADES = 2
THROTTLE = 0.6  # of the gusts of wind: how far the level of every rotor drifts, where it does
LEVEL = 0.05  # root mean square of what is heard, of full scale
ROTORS = Rotors(QUADROTOR, SPACING, SPEED_OF_SOUND)
NEAR = NearField(QUADROTOR, SPACING, RATE, SPEED_OF_SOUND)
KINDS = ("synthetic", "drifting", "recorded", "wind")


@dataclass(frozen=True, slots=True, eq=False)
class Noise:
    """Noise that goes on: of every rotor alone, (4, n); or of wind at both microphones, (2, n)."""

    kind: str
    sounds: Real
    speeds: Real | None = None  # of rotors that are made [1/s], (4, n); None: not known

    def at(self, heading: float, begin: int, end: int) -> Real:
        """What both microphones hear at a heading [rad] between two samples, (2, end - begin)."""
        if self.kind == "wind":
            return self.sounds[:, begin:end]
        before = min(begin, NEAR.n_taps)
        piece = self.sounds[:, begin - before : end]
        heard = oaconvolve(piece[None], NEAR.at(heading), axes=-1).sum(axis=1)
        return np.asarray(heard[:, before : before + end - begin])


@dataclass(frozen=True, slots=True, eq=False)
class NoiseScene:
    """What is heard at every heading, and who talks."""

    name: str
    azimuths: Real  # [rad], (k,)
    voices: tuple[Samples, ...]
    lead_in: Samples  # (2, n), at the first heading
    heard: Samples  # (n_headings, 2, n)
    noise: Noise


def recordings(folder: Path) -> list[Samples]:
    """Propellers of a folder: recordings that have "prop" in their names, but not "no_prop", at `RATE`.

    Raises
    ------
    ConfigError
        When there is none.
    """
    paths = sorted(path for path in folder.glob("*") if path.suffix.lower() in SUFFIXES)
    found = [read(path, RATE) for path in paths if "prop" in path.stem and "no_prop" not in path.stem]
    if not found:
        raise ConfigError(f"{folder}: expected recordings with 'prop' in their names, got none")
    return found


def noise_of(kind: str, seconds: float, clips: Sequence[Samples], rng: np.random.Generator) -> Noise:
    """Noise of a kind for some seconds; recorded rotors begin anywhere in one of the clips."""
    n = round(seconds * RATE)
    if kind == "wind":
        return Noise(kind, np.asarray(wind(RATE, rng, seconds=seconds), dtype=float))
    speeds = None
    if kind == "recorded":
        clip = clips[int(rng.integers(len(clips)))]
        sounds = [np.resize(np.roll(clip, -int(rng.integers(clip.size))), n).astype(float) for _ in QUADROTOR]
    else:
        rpm = rng.uniform(SLOWEST, FASTEST)
        made = [rotor(RATE, rpm, BLADES, rng, seconds) for _ in QUADROTOR]
        sounds, speeds = [each.sound.astype(float) for each in made], np.stack([each.speed for each in made])
    if kind == "drifting":
        sounds = [sound * 10 ** (THROTTLE * gust_levels(n, rng) / 20) for sound in sounds]
    return Noise(kind, np.stack([sound / np.sqrt(np.mean(sound**2)) for sound in sounds]), speeds)


def images_of(voices: Sequence[Real], azimuths: Real, heading: float) -> Real:
    """Every talker alone at both microphones, of unit power at microphone 1, (k, 2, n)."""
    places = tuple((DISTANCE * float(np.cos(a)), DISTANCE * float(np.sin(a)), 0.0) for a in azimuths)
    responses = NearField(places, SPACING, RATE, SPEED_OF_SOUND, delayed=False).at(heading)
    heard = [oaconvolve(voice[None], responses[:, k], axes=-1)[:, : voice.size] for k, voice in enumerate(voices)]
    return np.stack([image / np.sqrt(np.mean(image[0] ** 2)) for image in heard])


def scene(
    k: int, snr_db: float, kind: str, voices: Sequence[Samples], *, clips: Sequence[Samples] = (), key: Sequence[int]
) -> NoiseScene:
    """Make a scene; ``key`` seeds it, whatever the ratio. Without talkers the ratio says nothing."""
    rng = np.random.default_rng(key)
    azimuths = spread(k, rng) if k else np.zeros(0)
    chosen = tuple(voices[index] for index in rng.permutation(len(voices))[:k])
    first, unit = round(LEAD_IN * RATE), round(UNIT * RATE)
    starts = [int(rng.integers(len(voice))) for voice in chosen]
    noise = noise_of(kind, LEAD_IN + UNIT * len(HEADINGS), clips, rng)
    heard = np.zeros((len(HEADINGS), 2, unit))
    if k:
        speech = [
            np.resize(np.roll(v, -s), unit * len(HEADINGS)).astype(float) for v, s in zip(chosen, starts, strict=True)
        ]
        for r, heading in enumerate(HEADINGS):
            pieces = [each[r * unit : (r + 1) * unit] + 1e-9 for each in speech]
            heard[r] = images_of(pieces, azimuths, float(heading)).sum(axis=0)
    lead_in = noise.at(float(HEADINGS[0]), 0, first)
    rest = np.stack([noise.at(float(h), first + r * unit, first + (r + 1) * unit) for r, h in enumerate(HEADINGS)])
    talk = float(np.mean(heard[:, 0] ** 2)) or 1.0
    gain = np.sqrt(talk / np.mean(rest[:, 0] ** 2)) * 10 ** (-snr_db / 20)
    sensor = np.sqrt(talk) * 10 ** (SENSOR_DB / 20)
    heard += gain * rest + sensor * rng.standard_normal(heard.shape)
    lead_in = gain * lead_in + sensor * rng.standard_normal(lead_in.shape)
    scale = LEVEL / np.sqrt(np.mean(heard**2))
    name = f"{kind}-{k}-{snr_db:g}-{'-'.join(map(str, key))}"
    lead_in, heard = (scale * lead_in).astype(np.float32), (scale * heard).astype(np.float32)
    return NoiseScene(name, azimuths, chosen, lead_in, heard, noise)
