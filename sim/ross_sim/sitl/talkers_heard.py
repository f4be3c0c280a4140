"""From a scenario with voices to what is heard of every talker, at rest or on a path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from ross_payload.errors import ConfigError
from ross_sim.acoustics.impulse_responses import Responses
from ross_sim.acoustics.moving_talker import MixedTalkers, MovingTalker
from ross_sim.acoustics.render import HeadingSignals, TalkerSignals, gains
from ross_sim.acoustics.room import n_taps
from ross_sim.scenario import Scenario
from ross_sim.talkers.speech import TalkerVoice
from ross_sim.talkers.timeline import Timeline

LEVEL = 0.03  # root mean square of the mixture when everyone talks, re full scale: -30 dB, headroom for speech


def talkers_heard(scenario: Scenario, voices: Sequence[TalkerVoice], cache: Path | None) -> HeadingSignals:
    """Give every talker a voice, a loudness and a place.

    The loudness is set for where a talker is at the beginning: who comes nearer becomes louder.

    Parameters
    ----------
    scenario
        Who talks where and when.
    voices
        One per talker, in their order.
    cache
        Folder of the room cache; None: see ``cache_folder``.

    Raises
    ------
    ConfigError
        When there is not one voice per talker, or at another rate.
    """
    rate = scenario.payload.audio.rate_hz
    if len(voices) != len(scenario.talkers):
        raise ConfigError(f"expected one voice for each of {len(scenario.talkers)} talkers, got {len(voices)}")
    wrong = next((voice for voice in voices if voice.rate != rate), None)
    if wrong is not None:
        raise ConfigError(f"voice '{wrong.name}': expected {rate} Hz, as the payload has, got {wrong.rate} Hz")
    responses = Responses(scenario.spec(), cache)
    levels = [talker.level_db for talker in scenario.talkers]
    loudness = gains([voice.speech for voice in voices], levels, responses.at(scenario.offset), LEVEL)
    timelines = [
        Timeline.of(voice.speech, rate, scenario.start(talker), talker.end_s, talker.pauses)
        for voice, talker in zip(voices, scenario.talkers, strict=True)
    ]
    if not any(walk.moves for walk in scenario.walks()):
        return TalkerSignals(timelines, loudness, responses, rate)
    return _some_walking(scenario, timelines, loudness, cache)


def _some_walking(
    scenario: Scenario, timelines: Sequence[Timeline], loudness: Sequence[float], cache: Path | None
) -> MixedTalkers:
    rate, spec, walks = scenario.payload.audio.rate_hz, scenario.spec(), scenario.walks()
    resting = [index for index, walk in enumerate(walks) if not walk.moves]
    walking = [index for index, walk in enumerate(walks) if walk.moves]
    responses = Responses(replace(spec, sources=tuple(spec.sources[i] for i in resting)), cache)
    still = TalkerSignals([timelines[i] for i in resting], [loudness[i] for i in resting], responses, rate)
    moving = [
        MovingTalker(
            timelines[i],
            loudness[i],
            walks[i],
            partial(scenario.spec_of, walks[i]),
            n_taps=n_taps(scenario.spec_of(walks[i])),
            rate=rate,
            cache=cache,
        )
        for i in walking
    ]
    return MixedTalkers(still, moving, walking)
