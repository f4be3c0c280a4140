"""The sink ``device``: headphones on a bench, or a virtual microphone through PulseAudio or PipeWire.

The card plays at the pace of its own crystal: the ring between it and the voice is kept near its usual filling by one
sample more or less in a block, interpolated. A device that is gone is opened again as soon as it is back.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field

from ross_payload.audio.reconnecting_feed import CLOSE_TIMEOUT_S, Worker, in_thread
from ross_payload.audio.shared_portaudio import OpenStream, shared
from ross_payload.audio.sinks import BuiltInSink, SinkInfo, SinkServices
from ross_payload.audio.sound_devices import device_named, portaudio
from ross_payload.config.table import Table
from ross_payload.errors import AudioError, RossError
from ross_payload.interfaces import Clock, Real, Samples, VoiceBlock

RETRY_S = 1.0  # between two attempts to open a device that is gone
RING_S = 1.0  # of audio that can wait
NEAR = 0.5  # share of the wanted filling by which the ring may differ before it is corrected
LATE = 2.0  # times the wanted filling, beyond which the oldest is left out when the card begins to play
LATE_S = 0.2  # beyond the wanted filling, from which on the oldest is left out while it plays: a card had stopped


class DeviceOptions(Table):
    """[listening.streams.options] of ``device``."""

    device: Annotated[str, Field(min_length=1)] = "default"  # part of its name, see `ross devices`
    latency_ms: Annotated[float, Field(gt=0, le=1000)] = 60.0  # audio buffered for the card, and its latency


class PlaybackRing:
    """Samples between the thread that writes and the callback that plays: one writer, one reader, no lock.

    It plays when it has been filled to ``wanted`` samples, and again after it has run dry. More than ``most`` do not
    wait long: the oldest are left out, so that what a card did not take in time is no delay for good.
    """

    def __init__(self, capacity: int, wanted: int, most: int) -> None:
        self._samples = np.zeros(capacity, np.float32)
        self._wanted, self._most = wanted, most
        self._written = self._played = 0
        self._flowing = False
        self.underrun = 0  # samples of silence played because there was nothing
        self.skipped = 0  # samples left out because there were too many

    @property
    def waiting(self) -> int:
        """Samples that wait."""
        return self._written - self._played

    def write(self, samples: Samples) -> int:
        """Keep what there is room for; return how many samples there was none for."""
        fitted = samples[: len(self._samples) - self.waiting]
        places = (self._written + np.arange(len(fitted))) % len(self._samples)
        self._samples[places] = fitted
        self._written += len(fitted)
        return len(samples) - len(fitted)

    def play(self, out: Real) -> None:
        """Fill frames (n, n_channels) with the next samples, and with silence where there are none."""
        if not self._flowing and self.waiting < self._wanted:
            out[:] = 0
            return
        if self.waiting > (self._most if self._flowing else LATE * self._wanted):
            self.skipped += self.waiting - self._wanted
            self._played = self._written - self._wanted
        count = min(len(out), self.waiting)
        places = (self._played + np.arange(count)) % len(self._samples)
        out[:count] = self._samples[places, None]
        out[count:] = 0
        self._played += count
        self._flowing = count == len(out)
        self.underrun += len(out) - count

    def fitted(self, samples: Samples) -> Samples:
        """Return a block with one sample more or less when the ring fills or empties: two clocks are never equal."""
        off = self.waiting - self._wanted
        if not self._flowing or abs(off) <= NEAR * self._wanted or len(samples) < 2:
            return samples
        places = np.linspace(0, len(samples) - 1, len(samples) - int(np.sign(off)))
        return np.interp(places, np.arange(len(samples)), samples).astype(np.float32)


class DeviceSink:
    """An AudioSink that plays.

    Parameters
    ----------
    options
        Which device.
    services
        Rate and Clock.
    module
        The binding to PortAudio; None: sounddevice, imported when it is needed.
    start
        Runs the attempts to open the device again: opening can take seconds.
    """

    def __init__(
        self,
        options: DeviceOptions,
        services: SinkServices,
        module: Any = None,
        start: Callable[[Callable[[], None]], Worker] = in_thread,
    ) -> None:
        self._options = options
        self._rate = services.rate
        self._clock: Clock = services.clock
        self._module = module
        self._start = start
        self._ring = self._new_ring()
        self._stream: OpenStream | None = None
        self._name = options.device
        self._due = 0.0
        self._busy = threading.Event()
        self._worker: Worker | None = None
        self._lost = 0
        self.fault = ""

    @property
    def lost(self) -> int:
        """Samples that found no room or were left out, and moments of silence because the next ones came too late."""
        return self._lost + self._ring.underrun + self._ring.skipped

    @property
    def info(self) -> SinkInfo:
        """Which device it is."""
        return SinkInfo(self._name, codec="pcm", listeners=int(self._alive()))

    def write(self, block: VoiceBlock) -> None:
        """Have samples played."""
        if self._alive():
            self._lost += self._ring.write(self._ring.fitted(block.samples))
            return
        self._lost += len(block.samples)
        self._revive()

    def __enter__(self) -> Self:
        """Open the device.

        Raises
        ------
        AudioError
            When it is not there, busy, or has not the rate.
        ConfigError
            When the binding to PortAudio is not installed.
        """
        self._open()
        return self

    def __exit__(self, *exception: object) -> None:
        """Stop playing."""
        if self._worker is not None:
            self._worker.join(CLOSE_TIMEOUT_S)
        self._close()

    def _alive(self) -> bool:
        return self._stream is not None and not self._busy.is_set() and self._stream.active

    def _open(self) -> None:
        module = self._module = self._module or portaudio()
        self._ring = self._new_ring()
        try:
            with shared(module).listed(ends_others=False) as started:
                device = device_named(module, self._options.device, "output")
                stream = module.OutputStream(
                    device=device.number,
                    samplerate=self._rate,
                    channels=min(device.channels, 2),
                    dtype="float32",
                    latency=self._options.latency_ms / 1000,
                    callback=self._callback(self._ring),
                )
                self._stream = started(stream)
        except module.PortAudioError as error:
            why = str(error).partition("\n")[0]
            raise AudioError(f"the sound output '{self._options.device}' cannot be opened: {why}") from error
        self._name, self.fault = device.name, ""

    def _new_ring(self) -> PlaybackRing:
        wanted = round(self._options.latency_ms / 1000 * self._rate)
        return PlaybackRing(wanted + round(RING_S * self._rate), wanted, wanted + round(LATE_S * self._rate))

    @staticmethod
    def _callback(ring: PlaybackRing) -> Callable[[Real, int, Any, Any], None]:
        def play(out: Real, _count: int, _times: Any, _flags: Any) -> None:
            ring.play(out)

        return play

    def _revive(self) -> None:
        """Open a device again that is gone, beside who writes, and not too often."""
        if self._busy.is_set() or self._clock.now() < self._due:
            return
        self.fault = f"the sound output '{self._name}' was disconnected"
        self._lost, self._ring = self.lost, self._new_ring()
        self._busy.set()
        self._worker = self._start(self._attempt)

    def _attempt(self) -> None:
        try:
            self._close()
            with suppress(RossError):  # it stays disconnected
                self._open()
        finally:
            self._due = self._clock.now() + RETRY_S
            self._busy.clear()

    def _close(self) -> None:
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.close()


sink = BuiltInSink(DeviceOptions, DeviceSink)
