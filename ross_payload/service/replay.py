"""One replay from a session folder to its results."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any

from ross_payload.computing import computing
from ross_payload.config import Config, load
from ross_payload.errors import ConfigError
from ross_payload.events import Estimate, Separated
from ross_payload.interfaces import Attitude, Mission, VoicePrint
from ross_payload.json_values import are_finite
from ross_payload.mission.live_session import Kit, LiveSession
from ross_payload.mission.mission_sequence import mission
from ross_payload.mission.tasks import Memory
from ross_payload.service.assemble import informed_of, settings_of, tools_of
from ross_payload.service.payload import FIRST
from ross_payload.sessions import config_changes, replay_results
from ross_payload.sessions.divergence import Divergence, Replayed, replay, turns_of
from ross_payload.sessions.recorded_voiceprint import target_voice
from ross_payload.sessions.session_reader import RecordedSession
from ross_payload.voiceprint import VoiceStore
from ross_payload.voiceprint.model_folder import ModelFolder
from ross_protocols.angle_text import bearings


def perform(path: Path, out: Path | None, file: Path | None, settings: tuple[str, ...]) -> dict[str, Any]:
    """Replay a session and write its results; return them.

    Raises
    ------
    RossError
        When the session or the configuration does not serve, or the results cannot be written.
    """
    session = RecordedSession.open(path)
    recorded = _recorded(session, file)
    config = config_changes.changed(recorded, file, settings)
    differing = config_changes.differences(recorded, config)
    with replay_results.prepared(out) if out is not None else nullcontext():
        told, facts = _played(session, recorded, config, tuple(differing))
        facts |= {
            "changes": differing,
            "without_effect": list(config_changes.without_effect(recorded, config)),
            "notes": [*session.contents().notes, *(_softer(told) if out is not None else ())],
        }
        values = replay_results.report(session, told, config.audio.rate_hz) | facts
        if out is not None:
            replay_results.write(out, values, told, config.audio.rate_hz)
    return values


def _recorded(session: RecordedSession, file: Path | None) -> Config:
    """The recorded configuration; when it cannot be read, a file that is given stands for it."""
    try:
        return session.configuration()
    except ConfigError as error:
        if file is None:
            raise ConfigError(f"{error}; --config FILE can replace it") from error
        return load(file)


def _played(
    session: RecordedSession, recorded: Config, config: Config, differing: tuple[str, ...]
) -> tuple[Replayed, dict[str, Any]]:
    """Replay a session in a configuration; return what it brought, whom it looked for and where it parted."""
    rate, memory = config.audio.rate_hz, _memory_of(session)
    told = Replayed(start=memory.samples / rate)
    course = Divergence(turns_of(session.events()), early=config.audio.hop_ms / 2000)
    same = not config_changes.matters(differing)
    model = partial(ModelFolder.default().in_use, config.voice_print.model)
    who = target_voice(session, VoiceStore.default(), lambda: told.inputs, same=same, model=model)
    wiring_differs = any(key.startswith(("audio.gain_db", "audio.invert", "audio.roll_off_hz")) for key in differing)
    with computing():
        inputs = session.inputs(config.audio, wire_everywhere=wiring_differs)
        replay(mission_of(session, recorded, config, who.voiceprint), inputs, course, rate, told)
    if not told.inputs:
        raise ConfigError(f"{session.path}: expected at least one complete Input to replay, got none")
    return told, {"voice": who.how, "parted": course.parted}


def _softer(told: Replayed) -> Iterator[str]:
    """Say so when voices exceed full scale."""
    softer = replay_results.softer_by(replay_results.latest(told, Separated))
    if softer:
        yield f"the separated voices exceed full scale: files of --out are {softer:.1f} dB softer"


def in_words(values: dict[str, Any]) -> Iterator[str]:
    """Say how a replay went, line by line."""
    yield from (f"note: {note}" for note in values["notes"])
    if values["without_effect"]:
        yield f"no effect in a replay, the recorded value is used: {', '.join(values['without_effect'])}"
    if values["voice"]:
        yield f"target voice {values['voice']}"
    if values["parted"]:
        yield f"the replay diverges from the recording: {values['parted']}"
    if values["ended_early"]:
        yield f"ended after {values['replayed_s']:.2f} s: {values['ended_early']}"
    elif values["outcome"] is None:
        yield "the recording ends here; the mission would have continued"
    else:
        yield f"{values['outcome'].replace('_', ' ')}: {values['reason']}"
    azimuths = (math.radians(source["azimuth_deg"]) for source in values["sources"])
    found = bearings(azimuths, earth=values["frame"] == "earth")
    yield f"replayed {values['replayed_s']:.2f} s, {values['events']} events; sources: {found or 'none'}"
    yield from _compared(values)


def _compared(values: dict[str, Any]) -> Iterator[str]:
    first, was, now = values["first_difference"], values["recorded"]["versions"], values["versions"]
    others = [f"{name} {was.get(name, 'unknown')}, not {now[name]}" for name in now if was.get(name) != now[name]]
    if others and not values["identical"]:
        yield f"recorded with {'; '.join(others)}"
    if values["identical"]:
        yield "identical to the recorded mission"
    elif first is None:
        yield "the same events as recorded, as far as both go"
    else:
        yield f"first difference: event {first['line']}, recorded {first['recorded']}, replayed {first['replayed']}"


def mission_of(session: RecordedSession, recorded: Config, config: Config, voiceprint: VoicePrint | None) -> Mission:
    """Make the mission of a session in a configuration, begun as in the recorded one.

    Raises
    ------
    ConfigError
        When the kind of session is unknown, or what it knew cannot be read.
    """
    if session.manifest.kind == "mission":
        kit, told = _kit(session, config, voiceprint), config.informed
        informed = informed_of(config, Attitude(session.manifest.yaw))
        return mission(kit.settings, kit.tools, informed, None if told is None else told.target)
    if session.manifest.kind == "session":
        return _live(session, recorded, config, voiceprint)
    raise ConfigError(f"session.json: kind: expected 'mission' or 'session', got '{session.manifest.kind}'")


def _live(session: RecordedSession, recorded: Config, config: Config, voiceprint: VoicePrint | None) -> Mission:
    memory = _memory_of(session)
    begins = recorded.service.autostart if memory.samples == 0 or memory.pending else "nothing"
    task = FIRST[begins]
    live = LiveSession(config, lambda settings: _kit(session, settings, voiceprint), memory)
    return live.mission(None if task is None else task())


def _memory_of(session: RecordedSession) -> Memory:
    """What the session knew from earlier tasks."""
    memory = session.memory(Memory) or Memory()
    for name, leading in (("noise", (2,)), ("noise_speeds", None)):
        found = getattr(memory, name)
        if found is not None and (found.ndim != 2 or leading not in (None, found.shape[:1])):
            raise ConfigError(f"{session.path}/memory.npz: damaged: {name} has the shape {found.shape}")
    if not are_finite(memory.samples, memory.noise_aboard, *_angles(memory.estimate)):
        raise ConfigError(f"{session.path}/memory.npz: damaged: expected finite numbers")
    return memory


def _angles(estimate: Estimate | None) -> Iterator[float]:
    """Where the sources of an estimate are, and those of its rivals [rad]."""
    while estimate is not None:
        yield from (angle for each in estimate.sources for angle in (each.azimuth, each.elevation) if angle is not None)
        estimate = estimate.rival


def _kit(session: RecordedSession, config: Config, voiceprint: VoicePrint | None) -> Kit:
    """The travel is the recorded one, narrowed by what the configuration allows."""
    lower = max(session.manifest.lower, math.radians(config.guard.lower_deg))
    upper = min(session.manifest.upper, math.radians(config.guard.upper_deg))
    return Kit(settings_of(config, lower, upper), tools_of(config, voiceprint))
