"""Make the recorded mission again, of either kind."""

from __future__ import annotations

import math

from ross_payload.config import Config
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Attitude, Mission, VoicePrint
from ross_payload.mission.session import Kit
from ross_payload.mission.session import Session as LiveSession
from ross_payload.mission.supervise import mission
from ross_payload.mission.tasks import Memory
from ross_payload.recording.session import Session
from ross_payload.service.assemble import informed_of, settings_of, tools_of
from ross_payload.service.payload import FIRST


def mission_of(session: Session, recorded: Config, config: Config, voiceprint: VoicePrint | None) -> Mission:
    """Make the mission of a session in a configuration, begun as in the recorded one.

    Raises
    ------
    ConfigError
        When the kind of session is unknown, or what it knew cannot be read.
    """
    if session.manifest.kind == "mission":
        return _single(session, config, voiceprint)
    if session.manifest.kind == "session":
        return _live(session, recorded, config, voiceprint)
    raise ConfigError(f"session.json: kind: expected 'mission' or 'session', got '{session.manifest.kind}'")


def _single(session: Session, config: Config, voiceprint: VoicePrint | None) -> Mission:
    kit, told = _kit(session, config, voiceprint), config.informed
    informed = informed_of(config, Attitude(session.manifest.yaw))
    return mission(kit.settings, kit.tools, informed, None if told is None else told.target)


def _live(session: Session, recorded: Config, config: Config, voiceprint: VoicePrint | None) -> Mission:
    memory = session.memory(Memory) or Memory()
    begins = recorded.service.autostart if memory.samples == 0 or memory.pending else "nothing"
    task = FIRST[begins]
    live = LiveSession(config, lambda settings: _kit(session, settings, voiceprint), memory)
    return live.mission(None if task is None else task())


def _kit(session: Session, config: Config, voiceprint: VoicePrint | None) -> Kit:
    """The travel is the recorded one, narrowed by what the configuration allows."""
    lower = max(session.manifest.lower, math.radians(config.guard.lower_deg))
    upper = min(session.manifest.upper, math.radians(config.guard.upper_deg))
    return Kit(settings_of(config, lower, upper), tools_of(config, voiceprint))
