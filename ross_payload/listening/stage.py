"""The stage of live listening: hops of audio in, voices out; what runs it decides about threads.

Every stream is delayed alike, by the synthesis window and the look-ahead, so that a stream can go over from the mixture
to a voice and back without a gap, and every sample keeps the index that it has in the mixture.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from ross_payload.config import Config
from ross_payload.dsp.dc_offset import OffsetFilter
from ross_payload.dsp.streaming_stft import StreamingAnalysis, transform_for
from ross_payload.events import Event
from ross_payload.interfaces import AudioBlock, AudioFlag, Clock, Complex, Groups
from ross_payload.listening.scene_tracker import SceneTracker
from ross_payload.listening.sink_runner import SinkRunner
from ross_payload.listening.stream import Portion, Stream, StreamSettings, resting
from ross_payload.listening.voice_separation import VoiceSeparation
from ross_payload.mission.hearing import Hearing
from ross_payload.pointing import Pointing
from ross_payload.streams import LISTENER_TIMEOUT_S, StreamStatus, What

STATUS_S = 0.1  # between two times that the streams are told
DEAD_S = 1.0  # for which a microphone has been dead, from which no voice can be separated

OpenRunner = Callable[[StreamSettings], SinkRunner]
log = logging.getLogger(__name__)


class ListeningStage:
    """Everything but `streams` belongs to one thread.

    Parameters
    ----------
    config
        Everything.
    separation
        What separates.
    open_runner
        Opens the sink of a stream.
    clock
        For the delay; None: time is simulated, and delays are not told.
    """

    def __init__(
        self, config: Config, separation: VoiceSeparation, open_runner: OpenRunner, clock: Clock | None
    ) -> None:
        self._config = config
        self._rate = config.audio.rate_hz
        self._transform, self._lookahead = transform_for(self._rate, config.listening.latency_ms / 1000)
        self._separation = separation
        self._open_runner = open_runner
        self._clock = clock
        self._tracker = SceneTracker(config.array)
        self._offset_filter = OffsetFilter(self._rate, 2)
        self._hearing = Hearing(self._rate)
        self._wanted: dict[int, StreamSettings] = {}
        self._streams: dict[int, Stream] = {}
        self._leaving: list[SinkRunner] = []
        self._statuses: tuple[StreamStatus, ...] = ()
        self._descriptions: dict[int, str] = {}
        self._reported_at = 0.0  # when the statuses were renewed last, in audio [s]
        self._begin(0)

    @property
    def latency(self) -> float:
        """From a sample at the microphone until the stage gives it out, if it computes in no time [s]."""
        return (self._transform.latency + self._lookahead * self._transform.stft.hop) / self._rate

    @property
    def n_sources(self) -> int:
        """K, 0 when nobody is known."""
        return self._tracker.n_sources

    @property
    def streams(self) -> tuple[StreamStatus, ...]:
        """How every stream is, by number; from any thread."""
        return self._statuses

    @property
    def descriptions(self) -> Mapping[int, str]:
        """The session description (SDP) of every stream that has one, by number; from any thread."""
        return self._descriptions

    def want(self, wanted: Mapping[int, StreamSettings], why: str = "ordered") -> None:
        """Have these streams, by number, and no others."""
        for number in self._wanted.keys() - wanted.keys():
            self._end(number, why)
        for number, settings in wanted.items():
            before = self._wanted.get(number)
            same = before is not None and (before.sink, before.options) == (settings.sink, settings.options)
            if not settings.on or not same:
                self._end(number, settings.ended or why)
            if number in self._streams:
                self._streams[number].change(settings)
        self._wanted = dict(wanted)
        self._renew_statuses()

    def unheard(self) -> tuple[int, ...]:
        """Return the numbers of streams that nobody has taken for `LISTENER_TIMEOUT_S`; none in simulated time."""
        if self._clock is None:
            return ()
        streams = self._streams.items()
        return tuple(number for number, each in streams if each.runner.info.unheard_s >= LISTENER_TIMEOUT_S)

    def on_event(self, event: Event, *, earth: bool) -> None:
        """Take what the mission says; ``earth`` tells the frame of its angles."""
        self._tracker.on_event(event, earth=earth)

    def hear(self, block: AudioBlock, pointing: Pointing, *, settled: bool) -> None:
        """Take the next hop (2, n), and where the array pointed after it."""
        self._open_or_close()
        if not self._wanted:  # as while nobody listens to most missions: then the offset is not looked for either
            self._next = -1
            return
        complete = not block.flags & AudioFlag.MISSING
        take = self._offset_filter.push if complete else self._offset_filter.push_incomplete
        samples = take(block.samples)
        self._hearing.add(block.samples, self._rate, block.flags)
        if not self._streams:
            self._next = -1
            return
        if block.index != self._next:
            self._begin(block.index)
        self._next = block.index + samples.shape[1]
        self._origin = block.time - block.index / self._rate
        frames = self._analysis.push(samples)
        for number in range(frames.shape[2]):
            self._frame(frames[..., number], pointing, settled=settled)
        if self._next / self._rate - self._reported_at >= STATUS_S or self._reported_at > self._next / self._rate:
            self._reported_at = self._next / self._rate
            self._renew_statuses()

    def finish(self, why: str = "the program ends") -> None:
        """Give out what is still under way, and close every sink."""
        if self._streams and self._next >= 0:
            rest = self._transform.latency + self._lookahead * self._transform.stft.hop
            frames = self._analysis.push(np.zeros((2, rest), np.float32))
            for number in range(frames.shape[2]):
                self._mixed(frames[..., number], None, "", last=self._next)
        ended, self._wanted = dict(self._streams), {}
        for number in ended:
            self._end(number, why)
        for runner in self._leaving:
            runner.wait()
        self._leaving = []
        if ended:
            self._statuses = tuple(replace(stream.status(), on=False) for stream in ended.values())

    def _begin(self, index: int) -> None:
        """Hear from a sample on, as if nothing had been before."""
        self._analysis = StreamingAnalysis(self._transform, 2)
        self._delayed: deque[Complex] = deque()
        self._first = index
        self._next = index  # of the sample that comes next; -1: no stream is on
        self._frames = 0  # given out
        self._origin = 0.0  # time of sample 0 [s]
        self._separation.reset()

    def _open_or_close(self) -> None:
        for number, settings in self._wanted.items():
            wanted = settings.on and (settings.wanted is None or settings.wanted())
            if wanted and number not in self._streams:
                self._streams[number] = Stream(settings, self._transform, self._open_runner(settings))
                self._renew_statuses()
            elif not wanted and number in self._streams:
                self._end(number, "off at present")

    def _end(self, number: int, why: str) -> None:
        stream = self._streams.pop(number, None)
        if stream is None:
            return
        stream.end(why)
        self._leaving = [*(runner for runner in self._leaving[-8:]), stream.runner]
        self._renew_statuses()

    def _frame(self, frame: Complex, pointing: Pointing, *, settled: bool) -> None:
        """Take one frame (2, n_freqs)."""
        if self._tracker.quiet:
            self._separation.hear_noise(frame)
        groups, why = None, ""
        if any(stream.settings.selection.what is not What.MIXTURE for stream in self._streams.values()):
            placement = self._tracker.placement(pointing.heading, earth=pointing.earth, settled=settled)
            dead = self._hearing.dead_for(DEAD_S)
            groups = self._separation.step(frame, None if dead else placement)
            why = self._tracker.why or self._separation.fault or (f"microphone {dead} is dead" if dead else "")
        else:
            self._separation.reset()
        self._mixed(frame, groups, why)

    def _mixed(self, frame: Complex, groups: Groups | None, why: str, last: int | None = None) -> None:
        """Give every stream its portion of the frame that has been waited for."""
        self._delayed.append(frame[0])
        if len(self._delayed) <= self._lookahead:
            return
        mixture = self._delayed.popleft()
        index = self._first + self._transform.first_sample(self._frames)
        self._frames += 1
        now = None if self._clock is None else self._clock.now()
        for stream in self._streams.values():
            portion = self._portion(stream, mixture, groups, why)
            stream.push(portion, index, self._origin + index / self._rate, within=(self._first, last), now=now)

    def _portion(self, stream: Stream, mixture: Complex, groups: Groups | None, why: str) -> Portion:
        selection = stream.settings.selection
        if selection.what is What.MIXTURE:
            return Portion(mixture)
        source, nobody = self._tracker.source_of(selection)
        if groups is not None and source is not None:
            group = next((place for place, members in enumerate(groups.members) if source in members), None)
            if group is not None:
                return Portion(groups.signals[group, :, 0], source, group, self._tracker.azimuth(source))
            nobody = f"source {source} not separable"
        silent = self._config.listening.otherwise == "silence"
        return Portion(mixture * np.float32(0) if silent else mixture, detail=why or nobody)

    def _renew_statuses(self) -> None:
        def status_of(settings: StreamSettings) -> StreamStatus:
            stream = self._streams.get(settings.number)
            return resting(settings, self._rate) if stream is None else stream.status()

        self._statuses = tuple(status_of(self._wanted[number]) for number in sorted(self._wanted))
        infos = {number: stream.runner.info for number, stream in self._streams.items()}
        self._descriptions = {number: info.sdp for number, info in infos.items() if info.sdp}


def configured(config: Config) -> Iterator[StreamSettings]:
    """Return the streams of a configuration, numbered from 0 in their order."""
    for number, asked in enumerate(config.listening.streams):
        yield StreamSettings(
            number,
            asked.sink,
            asked.selection,
            asked.gain_db,
            asked.muted,
            asked.on,
            dict(asked.options),
            keeps=asked.sink == "file",
        )
