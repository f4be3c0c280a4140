"""What is heard with: audio sources are plug-ins, entry points in ``ross_payload.audio_sources``, built-ins included.

``[audio] source`` is ``NAME:ADDRESS``. A plug-in is a function ``open(address, services)`` that makes the `AudioSource`
of an address; nothing is opened before that is entered. What is heard live, from a device or a network, is best made
with `SourceServices.live`, which finds gaps, measures drift and opens again what has gone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from ross_payload import plugins
from ross_payload.audio.channel_map import ChannelMap
from ross_payload.audio.checked_source import SOURCE_METHODS, CheckedSource
from ross_payload.audio.live_source import LiveSource, Opener
from ross_payload.clock import RetryingOpener
from ross_payload.config import Audio, Config
from ross_payload.errors import PLUGIN_RAISES, PluginError, RossError, near, shown
from ross_payload.interfaces import AudioSource, Clock
from ross_payload.plugin_calls import called

GROUP = "ross_payload.audio_sources"


@dataclass(frozen=True, slots=True)
class SourceServices:
    """What an audio source is given when it is made."""

    clock: Clock
    audio: Audio  # all of [audio]: rate_hz, hop_ms, latency_ms, buffer_s ...
    wiring: ChannelMap  # which channels are microphones 1 and 2, their gain, polarity and roll-off
    connect_timeout: float = 0.0  # by which a server that refuses connections may come later [s]

    def live(self, opener: Opener, *, settling: float = 0.0) -> LiveSource:
        """Make a source in real time of what hands on frames of all its channels.

        Parameters
        ----------
        opener
            Called with what takes frames, float32 (n, n_channels) within -1 to 1; opens the `Feed` that hands them on.
            It raises `AudioError` when it cannot; a refused connection is tried again for ``connect_timeout``.
        settling
            Not heard at the start [s].
        """
        patient = RetryingOpener(opener, self.clock, self.connect_timeout) if self.connect_timeout else opener
        return LiveSource(patient, self.audio.rate_hz, self.wiring, self.audio.buffer_s, self.clock, settling=settling)


class SourcePlugin(Protocol):
    """The function behind an entry point in ``ross_payload.audio_sources``."""

    def __call__(self, address: str, services: SourceServices) -> AudioSource:
        """Make the source; nothing is opened before it is entered.

        Raises
        ------
        ConfigError
            When the address is none; says what was expected.
        """


def open_source(config: Config, clock: Clock, timeout: float = 0.0) -> CheckedSource:
    """Make the source that [audio] names; enter it to open it. A server may come ``timeout`` [s] later.

    Raises
    ------
    ConfigError
        When there is no such source (lists those that exist), its address is none, or the channels do not fit together.
    """
    audio = config.audio
    name, _, address = audio.source.partition(":")
    plugin = load_source(name)
    services = SourceServices(clock, audio, ChannelMap.of(audio), timeout)
    try:
        source = called(f"audio source '{name}'", "open", lambda: plugin(address, services))
    except RossError:
        raise
    except PLUGIN_RAISES as error:  # of others: it may raise anything
        raise PluginError(f"audio source '{name}': open raised {type(error).__name__}: {error}") from error
    lacking = [method for method in SOURCE_METHODS if not callable(getattr(type(source), method, None))]
    if lacking:
        raise PluginError(
            f"audio source '{name}': expected open() to return an AudioSource, got one without {lacking[0]}"
        )
    if (rate := getattr(source, "rate", None)) != audio.rate_hz:
        raise PluginError(f"audio source '{name}': expected a rate of {audio.rate_hz} Hz (audio.rate_hz), got {rate!r}")
    return CheckedSource(name, source)


def load_source(name: str) -> SourcePlugin:
    """Import one audio source.

    Raises
    ------
    PluginError
        When there is none of that name, it cannot be imported, or it is no function of an address and services.
    """
    known = plugins.available(GROUP)
    if name not in known:
        there = f"there are: {', '.join(known) or 'none'}{near(name, known)}"
        more = f"others come with their packages: {plugins.pip()} install PACKAGE"
        raise PluginError(f"audio.source: audio source {shown(name)} is unknown; {there}; {more}")
    plugin = plugins.load(GROUP, name)
    if not callable(plugin) or isinstance(plugin, type):
        raise PluginError(f"audio source '{name}': expected a function open(address, services), got {plugin!r}")
    return plugin  # type: ignore[no-any-return]
