"""Live listening beside a mission: what hears the audio, and what takes the voices."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path

from ross_payload.audio.live_source import Watched
from ross_payload.audio.shared_source import SharedSource
from ross_payload.config import Config
from ross_payload.errors import AudioError
from ross_payload.interfaces import AudioSource, Clock
from ross_payload.listening.observers import Listening, LiveListening, LockstepListening, RecordingVoices
from ross_payload.service.runner import Runner
from ross_payload.sessions.recorder import RecordedVoice, Recorder

log = logging.getLogger(__name__)


def source_of(config: Config, source: AudioSource, watched: Watched | None, *, live: bool) -> AudioSource:
    """Have the audio read on a thread of its own when time is real, so that no computing holds up who listens."""
    return SharedSource(source, config.hop, config.audio.buffer_s, watched) if live else source


def listening_of(
    config: Config, clock: Clock, runner: Runner, recorder: Recorder | None, *, live: bool = False
) -> Listening:
    """Make what listens beside the mission: on a thread of its own when time is real, else with the mission.

    Raises
    ------
    ConfigError
        When the separator is none.
    """
    folder = Path() if recorder is None else recorder.folder
    recording = None if recorder is None else RecordingVoices(recorder.recording, partial(RecordedVoice, recorder))
    if live:
        return LiveListening(config, clock, folder, recording, locate=runner.located)
    return LockstepListening(config, clock, folder, recording)


@contextmanager
def attached(listening: Listening, source: AudioSource) -> Iterator[None]:
    """Let a live listener have every block of a shared source at once, until the end."""
    with listening:
        if not (isinstance(source, SharedSource) and isinstance(listening, LiveListening)):
            yield
            return
        source.listeners.append(listening.hear)
        try:
            yield
        finally:
            source.listeners.remove(listening.hear)


@contextmanager
def described(listening: Listening, config: Config) -> Iterator[None]:
    """Serve the session descriptions of the streams where the configuration says so; without them all else goes on."""
    asked = config.listening
    with ExitStack() as stack:
        if asked.sdp_port:
            from ross_payload.audio.sinks.sdp_server import SdpServer  # noqa: PLC0415  HTTP and TLS, for few

            try:
                stack.enter_context(SdpServer(listening.descriptions, asked.sdp_port, asked.sdp_address))
            except AudioError as error:
                log.warning("%s; they are offered over MAVLink FTP only", error)
        yield
