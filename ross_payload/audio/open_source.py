"""From [audio] to the source it names: a sound card, a file or TCP."""

from __future__ import annotations

from pathlib import Path

from ross_payload.audio.channel_map import ChannelMap
from ross_payload.audio.file_source import FileSource
from ross_payload.audio.live_source import LiveSource
from ross_payload.audio.pcm_client import PcmClient
from ross_payload.audio.sound_card import SETTLING, SoundCard
from ross_payload.clock import RetryingOpener
from ross_payload.config import Config
from ross_payload.interfaces import Clock


def open_source(config: Config, clock: Clock, timeout: float = 0.0) -> LiveSource | FileSource:
    """Make the source that [audio] names; enter it to open it. A server of PCM may come ``timeout`` [s] later.

    Raises
    ------
    ConfigError
        When the channels do not fit together.
    """
    audio = config.audio
    wiring, rate = ChannelMap.of(audio), audio.rate_hz
    kind, _, rest = audio.source.partition(":")
    if kind == "file":
        return FileSource(Path(rest).expanduser(), rate, wiring, clock)
    if kind == "tcp":
        client = RetryingOpener(PcmClient(rest, rate, wiring), clock, timeout)
        return LiveSource(client, rate, wiring, audio.buffer_s, clock)
    card = SoundCard(rest, audio, wiring)
    return LiveSource(card, rate, wiring, audio.buffer_s, clock, settling=SETTLING)
