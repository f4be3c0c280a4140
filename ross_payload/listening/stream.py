"""One stream: what it carries, how loud, and the sink that takes it."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ross_payload.config.listening_options import selection_text
from ross_payload.dsp.streaming_stft import StreamingStft, StreamingSynthesis
from ross_payload.interfaces import Complex, VoiceBlock
from ross_payload.listening.limiter import LevelMeter, Limiter
from ross_payload.listening.sink_runner import SinkRunner
from ross_payload.streams import Selection, StreamStatus
from ross_payload.transport.link_url import host_in_url

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class StreamSettings:
    """What somebody wants of a stream."""

    number: int
    sink: str  # name of its entry point
    selection: Selection
    gain_db: float = 0.0
    muted: bool = False
    on: bool = True
    options: dict[str, Any] = field(default_factory=dict)  # of the sink
    keeps: bool = False  # what is heard stays on a disk
    ordered: bool = False  # not of the configuration: its number may be given to another when it is off
    ended: str = ""  # why it is off although nobody ordered that, in words
    voice: str = ""  # name of a voice in a recording, which no order changes; empty: it is an ordinary stream
    wanted: Callable[[], bool] | None = None  # whether anybody takes it at present; None: while it is on

    @property
    def title(self) -> str:
        """What it is, for the log.

        >>> from ross_payload.streams import What
        >>> StreamSettings(1, "tcp", Selection(What.TARGET), options={"address": "::1", "port": 5011}).title
        'stream 1 (target to tcp [::1]:5011)'
        """
        told = {name: str(self.options[name]) for name in ("path", "device", "address", "port") if name in self.options}
        if "path" in told:
            told["path"] = str(Path(told["path"]))  # without the ./ of a name that is no folder's
        if "address" in told:
            told["address"] = host_in_url(told["address"])
        sink = " ".join([self.sink, *filter(None, [":".join(told.values())])])
        return f"stream {self.number} ({selection_text(self.selection)} to {sink})"


@dataclass(frozen=True, slots=True, eq=False)
class Portion:
    """What one frame gives to a stream."""

    spectrum: Complex  # (n_freqs,)
    source: int | None = None  # whose voice it is; None: the mixture, or silence
    group: int | None = None
    azimuth: float | None = None  # of the source [rad]
    detail: str = ""  # why it is no voice, in words


class Stream:
    """Frames in, samples out to a sink.

    What changes, the selection, the gain, whether a voice can be separated, changes between two frames, and the
    synthesis windows, which overlap, crossfade it.

    Parameters
    ----------
    settings
        What is wanted.
    transform
        Frames of the stage.
    runner
        Drives the sink.
    """

    def __init__(self, settings: StreamSettings, transform: StreamingStft, runner: SinkRunner) -> None:
        self.settings = settings
        self.runner = runner
        rate = transform.stft.rate
        self._rate = rate
        self._synthesis = StreamingSynthesis(transform, 1)
        self._limiter = Limiter(rate)
        self._meter = LevelMeter(rate)
        self._portion = Portion(np.zeros(0, np.complex64))
        self._delay: float | None = None
        log.info("%s begins", settings.title)

    def change(self, settings: StreamSettings) -> None:
        """Want something else from the next frame on; the sink stays."""
        if settings.selection != self.settings.selection:
            log.info("%s carries %s from now on", self.settings.title, selection_text(settings.selection))
        self.settings = settings

    def push(
        self, portion: Portion, index: int, time: float, *, within: tuple[int, int | None], now: float | None
    ) -> None:
        """Take the portion of a frame, and hand on the samples that it completes.

        Parameters
        ----------
        portion
            What the frame gives.
        index
            Of the first sample that it completes.
        time
            Of that sample at the microphone, on the Clock [s].
        within
            Indices of the first sample that was heard, and behind the last, None while there are more: what lies
            outside is not handed on.
        now
            The time, for the delay [s]; None: it does not matter.
        """
        self._portion = portion
        gain = 0.0 if self.settings.muted else 10 ** (self.settings.gain_db / 20)
        samples = self._synthesis.push(portion.spectrum[None, :, None] * np.float32(gain))[0]
        first, last = within
        if index < first:
            samples, time = samples[first - index :], time + (first - index) / self._rate
            index = first
        samples = samples if last is None else samples[: max(last - index, 0)]
        if not len(samples):
            return
        limited = self._limiter.limited(samples)
        self._meter.add(limited)
        if now is not None:
            self._delay = now - time
        self.runner.write(VoiceBlock(limited, index, time))

    def end(self, why: str) -> None:
        """Close the sink."""
        log.info("%s ends: %s", self.settings.title, why)
        self.runner.close()

    def status(self) -> StreamStatus:
        """How it is."""
        told, portion = self.runner, self._portion
        return replace(
            resting(self.settings),
            on=True,
            rate=told.info.rate or self._rate,
            codec=told.info.codec,
            address=told.info.address,
            port=told.info.port,
            listeners=told.info.listeners,
            separated=portion.source is not None,
            source=portion.source,
            group=portion.group,
            azimuth=portion.azimuth,
            level_db=self._meter.level_db,
            delay=self._delay,
            packets_lost=told.info.packets_lost,
            lost=told.lost,
            fault=told.fault,
            detail=portion.detail,
        )


def resting(settings: StreamSettings, rate: int = 0) -> StreamStatus:
    """Return the status of a stream that is off."""
    return StreamStatus(
        settings.number,
        settings.sink,
        settings.selection,
        on=False,
        rate=rate,
        codec=str(settings.options.get("codec", "")),
        address=str(settings.options.get("address", "")),
        port=int(settings.options.get("port", 0)),
        listeners=0 if settings.ended else None,
        keeps=settings.keeps,
        gain_db=settings.gain_db,
        muted=settings.muted,
        detail=settings.ended,
    )
