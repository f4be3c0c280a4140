"""From the noise sources of a scenario to what is heard of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real, Samples
from ross_sim.acoustics import far_noise
from ross_sim.acoustics.fan_noise import fan
from ross_sim.acoustics.impulse_responses import Responses
from ross_sim.acoustics.near_field import NearField
from ross_sim.acoustics.render import HeadingResponses, TalkerSignals, gains
from ross_sim.acoustics.repeated_sounds import Passing, Repeated
from ross_sim.acoustics.rotor_noise import rotor
from ross_sim.acoustics.wind_noise import wind
from ross_sim.noise_tables import FAN, NoiseSource
from ross_sim.scenario import Scenario
from ross_sim.talkers.speech import SUFFIXES, read
from ross_sim.talkers.timeline import Timeline

Seeds = np.random.SeedSequence


@dataclass(frozen=True, slots=True, eq=False)
class NoiseHeard:
    """What is heard beside the talkers, by the frame that it stands in."""

    room: tuple[TalkerSignals, ...]  # asked with the heading in the frame of the room, as talkers are
    vehicle: tuple[TalkerSignals, ...]  # asked with the heading in the frame of the vehicle
    microphones: tuple[Samples, ...]  # of each microphone on its own, repeated, (2, n)
    rotor_speeds: tuple[Real, ...] = ()  # of every rotor that is made [1/s], at every sample, repeated

    def at_microphones(self, first: int, last: int) -> Samples | float:
        """What either microphone hears on its own from sample ``first`` to before ``last``, (2, last - first)."""
        index = np.arange(first, last)
        return sum((sound[:, index % sound.shape[1]] for sound in self.microphones), start=0.0)


def noise_heard(scenario: Scenario, reference: float, seeds: Seeds, cache: Path | None) -> NoiseHeard:
    """Give every noise source its sound, its loudness and its place.

    Parameters
    ----------
    scenario
        What sounds where.
    reference
        Root mean square over which a source of 0 dB would be as loud [re full scale].
    seeds
        Of what is made rather than recorded; every source has its own.
    cache
        Folder of the room cache; None: see ``cache_folder``.

    Raises
    ------
    ConfigError
        When a recording cannot be read.
    """
    made = list(zip(scenario.noise.sources, seeds.spawn(len(scenario.noise.sources)), strict=True))
    places = [(source, seed) for source, seed in made if source.kind == "place"]
    room = [_places(scenario, places, reference, cache)] if places else []
    vehicle, microphones, speeds = [], [], []
    for source, seed in made:
        rng = np.random.Generator(np.random.PCG64(seed))
        rms = reference * 10 ** (-source.snr_db / 20)
        if source.kind == "rotor":
            sounds, turning = _rotors(scenario, source, rng)
            vehicle.append(_as_loud(scenario, sounds, source.rotors_m, rms))
            speeds += turning
        elif source.kind == "wind":
            microphones.append(np.asarray(rms * _wind(source, scenario.payload.audio.rate_hz, rng), dtype=np.float32))
        elif source.kind == "babble":
            room.append(_babble(scenario, source, rms, rng))
        elif source.kind == "passing_car":
            room.append(_car(scenario, source, rms, rng))
    return NoiseHeard(tuple(room), tuple(vehicle), tuple(microphones), tuple(speeds))


def _places(
    scenario: Scenario, made: Sequence[tuple[NoiseSource, Seeds]], reference: float, cache: Path | None
) -> TalkerSignals:
    rate = scenario.payload.audio.rate_hz
    sounds = [_of_place(source, rate, seed) for source, seed in made]
    responses = Responses(scenario.spec_of_noise(), cache)
    response = responses.at(scenario.offset)
    loudness = [
        gains([sound], [0.0], response[:, [index]], reference * 10 ** (-source.snr_db / 20))[0]
        for index, ((source, _), sound) in enumerate(zip(made, sounds, strict=True))
    ]
    return TalkerSignals([Timeline.of(sound, rate) for sound in sounds], loudness, responses, rate)


def _of_place(source: NoiseSource, rate: int, seed: Seeds) -> Samples:
    if source.sound in ("", FAN):
        return fan(rate, np.random.Generator(np.random.PCG64(seed)))
    return _recordings(source, rate, "'fan' or ")[0]


def _rotors(scenario: Scenario, source: NoiseSource, rng: np.random.Generator) -> tuple[list[Samples], list[Real]]:
    """Sound of every rotor, and how fast those that are made turn [1/s].

    Recordings are shared out, each rotor from a moment of its own; nobody knows their speeds.
    """
    rate = scenario.payload.audio.rate_hz
    if source.sound:
        clips = _recordings(source, rate)
        turns = [clips[index % len(clips)] for index in range(len(source.rotors_m))]
        return [_unit(np.roll(clip, int(rng.integers(clip.size)))) for clip in turns], []
    made = [rotor(rate, source.rpm, source.blades, rng) for _ in source.rotors_m]
    return [each.sound for each in made], [each.speed for each in made]


def _wind(source: NoiseSource, rate: int, rng: np.random.Generator) -> Samples:
    clip = _recordings(source, rate)[0] if source.sound else None
    return wind(rate, rng, gusts=source.gusts, windscreen=source.windscreen, recording=clip)


def _babble(scenario: Scenario, source: NoiseSource, rms: float, rng: np.random.Generator) -> TalkerSignals:
    rate = scenario.payload.audio.rate_hz
    voices = far_noise.babble(rate, rng, _recordings(source, rate)[0] if source.sound else None)
    return _as_loud(scenario, voices, far_noise.babble_places(source.away), rms)


def _car(scenario: Scenario, source: NoiseSource, rms: float, rng: np.random.Generator) -> TalkerSignals:
    """A car; its waves reach the array without a delay of their way, which would only shift the time of its passing."""
    rate = scenario.payload.audio.rate_hz
    sound = _recordings(source, rate)[0] if source.sound else far_noise.tyres(rate, rng)
    places, along = far_noise.car_way(math.radians(source.azimuth_deg or 0.0), source.away)
    responses = _in_the_open(scenario, places, delayed=False)
    nearest = len(places) // 2
    loudness = gains([sound], [0.0], responses.at(scenario.offset)[:, [nearest]], rms)[0]
    speed, first, every = source.speed_m_s / rate, source.at_s * rate, source.every_s * rate
    heard = [Passing(sound, along, here, speed, first, every) for here in range(len(places))]
    return TalkerSignals(heard, [loudness] * len(places), responses, rate)


def _as_loud(
    scenario: Scenario, sounds: Sequence[Samples], places: Sequence[far_noise.Place], rms: float
) -> TalkerSignals:
    """Sources of one strength in the open that together have ``rms`` at microphone 1, joint angle 0."""
    responses = _in_the_open(scenario, places)
    response = responses.at(scenario.offset)
    each = [gains([sound], [0.0], response[:, [k]], 1.0)[0] ** -2 for k, sound in enumerate(sounds)]
    loudness = [rms / math.sqrt(sum(each))] * len(sounds)
    return TalkerSignals([Repeated(sound) for sound in sounds], loudness, responses, scenario.payload.audio.rate_hz)


def _in_the_open(scenario: Scenario, places: Sequence[far_noise.Place], *, delayed: bool = True) -> HeadingResponses:
    speed = scenario.payload.array.speed_of_sound_m_s
    return NearField(tuple(places), scenario.spacing, scenario.payload.audio.rate_hz, speed, delayed=delayed)


def _recordings(source: NoiseSource, rate: int, other: str = "") -> list[Samples]:
    """The recording that a source names, or those of the folder, in order of their names."""
    path = Path(source.sound)
    paths = sorted(each for each in path.iterdir() if each.suffix.lower() in SUFFIXES) if path.is_dir() else [path]
    try:
        if not paths:
            raise ConfigError(f"{path}: holds no recording")
        return [read(each, rate) for each in paths]
    except ConfigError as error:
        raise ConfigError(f"noise source '{source.name}': expected {other}a recording: {error}") from error


def _unit(sound: Samples) -> Samples:
    return np.asarray(sound / np.sqrt(np.mean(sound.astype(float) ** 2)), dtype=np.float32)
