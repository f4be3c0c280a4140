"""From a command line to a scenario with voices, and the voice print of its target."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

from ross_payload.audio.sinks import checked_options
from ross_payload.config import Informed, Link, Listening, Stream, as_in_paper, validated
from ross_payload.errors import ConfigError, refused_as, unknown
from ross_payload.interfaces import VoicePrint
from ross_payload.listening.observers import check_listening
from ross_payload.named_paths import nearest_there
from ross_payload.voiceprint import BuiltInModel, EmbeddingPrint, VoiceModel, VoiceStore, enrol
from ross_payload.voiceprint.model_folder import ModelFolder
from ross_sim.scenario import Scenario, load
from ross_sim.talkers.speech import TalkerVoice
from ross_sim.talkers.synthetic_prints import synthetic_print
from ross_sim.talkers.synthetic_voices import voices_of


@dataclass(frozen=True, slots=True)
class TalkerSelection:
    """The voices to cast from, and the one to look for."""

    voices: tuple[TalkerVoice, ...]
    target: str
    voiceprint: VoicePrint
    synthetic: EmbeddingPrint | None = None  # the same, of a target that is no person


def directed(scenario: str, changes: Mapping[str, Any]) -> Scenario:
    """Load a scenario and apply what the command line asks for instead.

    Raises
    ------
    ConfigError
        When the scenario or a change is wrong, or a stream of live listening cannot be.
    """
    loaded = load(scenario)
    payload = as_in_paper(loaded.payload) if changes["paper"] else loaded.payload
    if changes["actuator"] and changes["actuator"] != payload.actuator.kind:
        payload = _with(payload, actuator=type(payload.actuator)(kind=changes["actuator"]))
    if changes["separator"]:
        payload = _with(payload, exploit=_with(payload.exploit, separator=changes["separator"]))
    if changes["urls"]:
        payload = _with(payload, links=tuple(Link(url=url) for url in changes["urls"]))
    if changes["informed"]:
        payload = _with(payload, informed=informed_by(loaded))
    if changes.get("listen") is not None:
        payload = _with(payload, listening=listening_into(changes["listen"], payload.listening))
    if changes["seed"] is not None:
        payload = _with(payload, seed=changes["seed"])
    if changes["target"]:
        loaded = _with(loaded, target=0)  # whoever the file names is not asked for
    try:
        check_listening(payload)
    except ConfigError as error:
        raise type(error)(f"payload.{error}") from error
    changed: Scenario = _with(loaded, payload=payload)
    return changed


def listening_into(path: Path, listening: Listening) -> Listening:
    """Have the target's voice written into a new file; its folder is made when it begins.

    Raises
    ------
    ConfigError
        When its name is not that of a track, it is there already, or its folder cannot be made or written to.
    """
    checked_options("file", {"path": str(path)}, "--listen")
    with refused_as(ConfigError, f"--listen {path}: cannot be written"):
        TemporaryFile(dir=nearest_there(path.parent)).close()  # what cannot be is told before all is simulated
    if os.path.lexists(path):
        raise ConfigError(f"--listen: {path} is there already: delete it, or give another name")
    stream = Stream(sink="file", options={"path": str(path) if path.parent != Path() else f"./{path}"})
    changed: Listening = _with(listening, streams=(*listening.streams, stream))
    return changed


def informed_by(scenario: Scenario) -> Informed:
    """What somebody who sees every talker would tell the mission.

    Raises
    ------
    ConfigError
        When there is nobody to tell of, or more than can be told.
    """
    if not scenario.talkers:
        raise ConfigError("--informed: expected a scenario with talkers, got one without")
    values = {"azimuths_deg": [round(math.degrees(azimuth), 6) for azimuth in scenario.azimuths()]}
    if len(scenario.room.size_m) == 3:
        values["elevations_deg"] = [round(math.degrees(elevation), 6) for elevation in scenario.elevations()]
    return validated(Informed, values, "--informed")


def talkers_of(scenario: Scenario, speech: Path | None, target: str | None) -> TalkerSelection:
    """Load the voices and enrol the target: a talker's name, a voice not in the room, or one enrolled before.

    A target that is asked for by name is the first to be given a part.

    Raises
    ------
    ConfigError
        When there are too few voices, or nobody knows the target.
    """
    rate = scenario.payload.audio.rate_hz
    voices, model = voices_of(speech, rate), ModelFolder.default().in_use(scenario.payload.voice_print.model)
    if target is None:
        voice = scenario.cast(voices).target
    else:
        found = next((voice for voice in voices if voice.name == target), None)
        if found is None:
            return TalkerSelection(voices, target, _enrolled(target, voices, model))
        voice = found
        voices = (voice, *(other for other in voices if other is not voice))
    if speech is not None:
        return TalkerSelection(voices, voice.name, enrol(voice.enrolment, voice.rate, model))
    if isinstance(model, BuiltInModel):
        voiceprint = synthetic_print(voice, model)
    else:  # of a network nothing is kept in the cache
        voiceprint = enrol(voice.enrolment, voice.rate, model)
    return TalkerSelection(voices, voice.name, voiceprint, voiceprint)


def _enrolled(target: str, voices: tuple[TalkerVoice, ...], model: VoiceModel) -> VoicePrint:
    store = VoiceStore.default()
    if target not in store.names():
        known = sorted({voice.name for voice in voices} | set(store.names()))
        raise ConfigError(f"--target: {unknown('voice', target, known)}")
    return store.load(target, model)


def _with(model: Any, **changes: Any) -> Any:
    return model.model_copy(update=changes)
