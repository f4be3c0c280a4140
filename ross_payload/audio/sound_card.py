"""A sound card as a feed: PortAudio calls back in a thread of its own, and the callback only copies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ross_payload.audio.channel_map import ChannelMap
from ross_payload.audio.live_source import LiveSource, OnSamples
from ross_payload.audio.open_source import SourceServices
from ross_payload.audio.shared_portaudio import OpenStream, shared
from ross_payload.audio.sound_devices import Device, device_named, portaudio
from ross_payload.config import Audio
from ross_payload.errors import AudioError
from ross_payload.interfaces import Real

TOLERANCE = 0.01  # share by which the rate that a card says it has may differ; a crystal is better by far

SETTLING_S = 0.3  # [s] in which a card that was switched on pops


class SoundCard:
    """Opens the device that a configuration names, each time it is called.

    Parameters
    ----------
    name
        As in ``device_named``.
    audio
        Rate and latency.
    wiring
        How many channels to open.
    module
        The binding to PortAudio; None: sounddevice, imported when it is needed.
    """

    def __init__(self, name: str, audio: Audio, wiring: ChannelMap, module: Any = None) -> None:
        self._name = name
        self._audio = audio
        self._wiring = wiring
        self._module = module
        self._was_opened = False  # what was opened may have another number when it is back

    def __call__(self, on_samples: OnSamples) -> SoundCardStream:
        """Open the device.

        Raises
        ------
        AudioError
            When it is not there, busy, or lacks the channels or the rate.
        """
        module = self._module = self._module or portaudio()
        try:
            again, self._was_opened = self._was_opened, True
            with shared(module).listed(ends_others=again) as started:
                device = device_named(module, self._name)
                return SoundCardStream(module, self._settings(module, device), on_samples, started)
        except module.PortAudioError as error:
            raise AudioError(f"the microphones '{self._name}' cannot be opened: {_first_line(error)}") from error

    def _settings(self, module: Any, device: Device) -> dict[str, Any]:
        if device.channels < self._wiring.needed:
            raise AudioError(f"audio.channels: {device} has no channel {self._wiring.needed - 1} (they count from 0)")
        wanted = {"device": device.number, "channels": self._wiring.needed, "dtype": "float32"}
        rate = self._audio.rate_hz
        try:
            module.check_input_settings(samplerate=rate, **wanted)
        except module.PortAudioError as error:
            hint = f"; its own rate is {device.default_rate:g} Hz" if device.default_rate != rate else ""
            said = f"{device} does not record {self._wiring.needed} channels at {rate} Hz: {_first_line(error)}"
            raise AudioError(said + hint) from error
        return {**wanted, "samplerate": rate, "latency": self._audio.latency_ms / 1000}


class SoundCardStream:
    """An open stream."""

    def __init__(
        self, module: Any, settings: dict[str, Any], on_samples: OnSamples, started: Callable[[Any], OpenStream]
    ) -> None:
        self._over = False

        def callback(frames: Real, _count: int, _times: Any, _flags: Any) -> None:
            on_samples(frames)

        def finished() -> None:
            self._over = True

        stream = module.InputStream(callback=callback, finished_callback=finished, **settings)
        actual, asked = stream.samplerate, settings["samplerate"]
        if abs(actual / asked - 1) > TOLERANCE:
            stream.close(ignore_errors=True)
            raise AudioError(f"sound card: expected it to open at {asked} Hz, got {actual:g} Hz")
        self._stream = started(stream)

    @property
    def alive(self) -> bool:
        """Whether frames may still come."""
        return not self._over and self._stream.active

    def close(self) -> None:
        """Give the device back; idempotent."""
        self._stream.close()


def audio_source(address: str, services: SourceServices) -> LiveSource:
    """Make the source ``device:NAME``."""
    return services.live(SoundCard(address, services.audio, services.wiring), settling=SETTLING_S)


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0]
