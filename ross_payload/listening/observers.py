"""Live listening beside a mission: synchronously in simulated time, on a thread of its own in real time.

Both are observers of the mission and take orders from any thread; what they are asked for takes effect with the next
hop.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from typing import Self

from ross_payload.audio.sinks import SinkServices, checked_options, load_sink, make_sink
from ross_payload.config import Config
from ross_payload.config.listening_options import selection_text
from ross_payload.dsp.streaming_stft import transform_for
from ross_payload.errors import ConfigError, RossError
from ross_payload.events import Event
from ross_payload.interfaces import AudioBlock, AudioSink, Clock, Input
from ross_payload.listening.learning import BackgroundLearner, ImmediateLearner, Learner
from ross_payload.listening.order_book import OrderBook
from ross_payload.listening.sink_runner import DirectRunner, SinkRunner, ThreadedRunner
from ross_payload.listening.stage import ListeningStage
from ross_payload.listening.stream import StreamSettings
from ross_payload.listening.voice_separation import VoiceSeparation
from ross_payload.plugin_checks import load_separator
from ross_payload.pointing import Pointing
from ross_payload.streams import StreamOrder, StreamStatus

BEHIND_S = 2.0  # of audio that waits: then the computer is too slow, and what waits is left out
LAST_CALL_S = 5.0  # that the thread may take at the end

log = logging.getLogger(__name__)
Locate = Callable[[float, float], tuple[Pointing, bool]]  # begin, end [s]: where the array points, whether at rest


@dataclass(frozen=True, slots=True)
class RecordingVoices:
    """What a recording of sessions takes of the voices."""

    going_on: Callable[[], bool]  # whether a session is recorded at present; from any thread
    sink: Callable[[str], AudioSink]  # takes a voice by its name


class Listening:
    """What both have: the stage, and the orders that it has not obeyed yet.

    Parameters
    ----------
    config
        Everything.
    clock
        Tells when to try a sink again.
    folder
        Of files that are named without one.
    recording
        Takes voices into the session that is recorded; None: nothing can be recorded.

    Raises
    ------
    ConfigError
        When the separator is none, or an option of a sink is wrong.
    """

    live = False

    def __init__(self, config: Config, clock: Clock, folder: Path, recording: RecordingVoices | None = None) -> None:
        self._config = config
        self._clock = clock
        self._folder = folder
        self._recording = recording
        transform, lookahead = transform_for(config.audio.rate_hz, config.listening.latency_ms / 1000)
        separator = load_separator(config.listening.separator).live(lookahead)
        self._learner: Learner = (BackgroundLearner if self.live else ImmediateLearner)(separator)
        separation = VoiceSeparation(separator, self._learner, transform.stft, config)
        self._stage = ListeningStage(config, separation, self._open_runner, clock if self.live else None)
        self._orders = OrderBook(config, None if recording is None else recording.going_on)
        self._stage.want(self._orders.wanted)

    def streams(self) -> tuple[StreamStatus, ...]:
        """How every stream is, by number; from any thread."""
        return self._stage.streams

    def descriptions(self) -> Mapping[int, str]:
        """Return the session description (SDP) of every stream that has one, by number; from any thread."""
        return self._stage.descriptions

    def order(self, order: StreamOrder) -> str:
        """Start, change or stop a stream with the next hop; return '' or why not; from any thread, never waits."""
        return self._orders.place(order)

    def on_input(self, hop: Input) -> None:
        """One hop was heard by the mission."""

    def on_event(self, event: Event, hop: Input) -> None:
        """Take what the mission says."""
        self._stage.on_event(event, earth=hop.pointing.earth)

    def close(self) -> None:
        """Give out what is under way, and close every sink; idempotent."""
        self._stage.finish()
        self._learner.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _obey(self) -> None:
        """Have the streams that are wanted now; those that were ordered end when nobody takes them."""
        for number in self._stage.unheard():
            self._orders.give_up(number)
        wanted = self._orders.changed(self._stage.n_sources)
        if wanted is not None:
            self._stage.want(wanted)

    def _open_runner(self, settings: StreamSettings) -> SinkRunner:
        title = selection_text(settings.selection)
        rate, number = self._config.audio.rate_hz, settings.number

        def make() -> AudioSink:
            if settings.voice and self._recording is not None:
                return self._recording.sink(settings.voice)
            options = checked_options(settings.sink, settings.options, settings.title)
            least = self._config.recording.min_free_gb
            services = SinkServices(self._clock, rate, number, title, self._folder, self.live, least)
            return make_sink(settings.sink, options, services)

        return (ThreadedRunner if self.live else DirectRunner)(settings.title, make, self._clock)


class LockstepListening(Listening):
    """Listens while the mission's own thread waits: the same on every run."""

    def on_input(self, hop: Input) -> None:
        """Listen to one hop."""
        self._obey()
        self._stage.hear(hop.block, hop.pointing, settled=hop.settled)


class LiveListening(Listening):
    """Listens on a thread of its own, to blocks that `hear` is given as soon as they were heard.

    Parameters
    ----------
    locate
        Tells where the array pointed; called on that thread. The others are those of `Listening`.
    """

    live = True

    def __init__(
        self,
        config: Config,
        clock: Clock,
        folder: Path,
        recording: RecordingVoices | None = None,
        *,
        locate: Locate,
    ) -> None:
        super().__init__(config, clock, folder, recording)
        self._locate = locate
        self._queue: SimpleQueue[AudioBlock | tuple[Event, bool] | None] = SimpleQueue()
        self._most = round(1000 * BEHIND_S / config.audio.hop_ms)  # hops
        self._skipped = 0  # hops, since the last one that was heard
        self._thread = threading.Thread(target=self._work, name="listening", daemon=True)

    def hear(self, block: AudioBlock) -> None:
        """Take the next hop; from the thread that reads the source, never waits."""
        self._queue.put(block)

    def on_event(self, event: Event, hop: Input) -> None:
        """Take what the mission says; from its thread, never waits."""
        self._queue.put((event, hop.pointing.earth))

    def close(self) -> None:
        """Give out what is under way, and close every sink; idempotent."""
        self._queue.put(None)
        if self._thread.is_alive():
            self._thread.join(LAST_CALL_S)

    def __enter__(self) -> Self:
        """Begin to listen."""
        self._thread.start()
        return self

    def _work(self) -> None:
        while (item := self._queue.get()) is not None:
            try:
                self._take(item)
            except Exception:  # nobody who turns or decides may suffer from it
                log.exception("live listening has failed, and goes on with the next hop")
        super().close()

    def _take(self, item: AudioBlock | tuple[Event, bool]) -> None:
        if isinstance(item, tuple):
            self._stage.on_event(item[0], earth=item[1])
            return
        self._obey()
        listened = any(stream.on for stream in self._stage.streams)
        waiting = self._queue.qsize() if listened else 0  # else a hop takes no time
        if waiting > self._most or (self._skipped and waiting > 1):
            self._skipped += 1
            return
        if self._skipped:
            log.warning("the computer is too slow for live listening: %d hops were left out", self._skipped)
            self._skipped = 0
        end = item.time + item.samples.shape[1] / self._config.audio.rate_hz
        pointing, settled = self._locate(item.time, end)
        self._stage.hear(item, pointing, settled=settled)


def check_listening(config: Config) -> None:
    """Refuse streams and separators that cannot be; opens nothing.

    Raises
    ------
    ConfigError
        With the table and the key, what was expected and what was got.
    """
    asked = config.listening
    taken = {(asked.sdp_address, asked.sdp_port): "listening.sdp_port"} if asked.sdp_port else {}
    for number, stream in enumerate(asked.streams):
        try:
            load_sink(stream.sink)
        except RossError as error:
            raise type(error)(f"listening.streams.{number}.sink: {error}") from error
        where = f"listening.streams.{number}.options of '{stream.sink}'"
        options = checked_options(stream.sink, stream.options, where)
        if stream.sink == "tcp" and stream.on and getattr(options, "mode", "") == "listen":
            door = (getattr(options, "address", ""), getattr(options, "port", 0))
            if taken.setdefault(door, where) != where:
                raise ConfigError(f"{where}: port: expected another than that of {taken[door]}, got {door[1]} for both")
    try:
        _, lookahead = transform_for(config.audio.rate_hz, asked.latency_ms / 1000)
        load_separator(asked.separator).live(lookahead)
    except RossError as error:
        raise type(error)(f"listening: {error}") from error
