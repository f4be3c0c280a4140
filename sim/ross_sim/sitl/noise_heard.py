"""From the noise sources of a scenario to what is heard of them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Samples
from ross_sim.acoustics.fan_noise import fan
from ross_sim.acoustics.impulse_responses import Responses
from ross_sim.acoustics.render import TalkerSignals, gains
from ross_sim.noise_tables import FAN, NoiseSource
from ross_sim.scenario import Scenario
from ross_sim.talkers.speech import read
from ross_sim.talkers.timeline import Timeline


def noise_heard(
    scenario: Scenario, reference: float, seeds: np.random.SeedSequence, cache: Path | None
) -> TalkerSignals | None:
    """Give every noise source of the room its sound, its loudness and its place; None when there is none.

    What is returned is asked with the heading in the frame of the room, as talkers are. A source that turns with what
    carries the array would be asked with the joint angle instead.

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
    sources, rate = scenario.noise.sources, scenario.payload.audio.rate_hz
    if not sources:
        return None
    sounds = [_sound(source, rate, seed) for source, seed in zip(sources, seeds.spawn(len(sources)), strict=True)]
    responses = Responses(scenario.spec_of_noise(), cache)
    loudness = _gains(sources, sounds, responses.at(scenario.offset), reference)
    return TalkerSignals([Timeline.of(sound, rate) for sound in sounds], loudness, responses, rate)


def _gains(sources: Sequence[NoiseSource], sounds: Sequence[Samples], response: Samples, rms: float) -> list[float]:
    """Gains that make every source as loud at microphone 1 as it asks for, each on its own."""
    return [
        gains([sound], [0.0], response[:, [index]], rms * 10 ** (-source.snr_db / 20))[0]
        for index, (source, sound) in enumerate(zip(sources, sounds, strict=True))
    ]


def _sound(source: NoiseSource, rate: int, seed: np.random.SeedSequence) -> Samples:
    if source.sound == FAN:
        return fan(rate, np.random.Generator(np.random.PCG64(seed)))
    try:
        return read(Path(source.sound), rate)
    except ConfigError as error:
        raise ConfigError(f"noise source '{source.name}': expected 'fan' or a recording: {error}") from error
