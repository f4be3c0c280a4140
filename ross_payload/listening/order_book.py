"""Which streams are wanted: those of the configuration, those that were ordered, and those of a recording."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from ross_payload.audio.sinks import checked_options
from ross_payload.config import Config
from ross_payload.config.listening_options import MOST_SOURCES
from ross_payload.errors import RossError
from ross_payload.listening.stage import configured
from ross_payload.listening.stream import StreamSettings
from ross_payload.streams import LISTENER_TIMEOUT_S, MAX_STREAMS, Selection, StreamOrder, What

RECORDED = 200  # number of the recorder's first stream; those of orders are lower
RECORDER = "recording"  # stands for the sink of these
ORDERED = "rtp"  # sink of a stream that is ordered by an address
LOUDEST_DB = 60.0


class OrderBook:
    """Takes orders on any thread; `changed` belongs to the thread that listens.

    Parameters
    ----------
    config
        The streams to begin with, and what a recording keeps.
    recording
        Whether a session is recorded at present; None: nothing can be.
    """

    def __init__(self, config: Config, recording: Callable[[], bool] | None) -> None:
        self._recording = recording
        self._sources = recording is not None and config.recording.sources
        self._lock = threading.Lock()
        self._news = False
        streams = {stream.number: stream for stream in configured(config)}
        if recording is not None and config.recording.target:
            streams |= {RECORDED: self._recorded(RECORDED, Selection(), "target")}
        self._streams = streams

    @property
    def wanted(self) -> dict[int, StreamSettings]:
        """Every stream by number, also those that are off."""
        return self._streams

    def changed(self, n_sources: int) -> dict[int, StreamSettings] | None:
        """Return the streams that are wanted if they are others than the last time; ``n_sources`` is K."""
        if self._sources:
            self._record_sources(n_sources)
        if not self._news:
            return None
        with self._lock:
            self._news = False
            return self._streams

    def place(self, order: StreamOrder) -> str:
        """Take an order; return '' or why it is refused."""
        why = _impossible(order)
        if why:
            return why
        with self._lock:
            return self._start(order) if order.on else self._stop(order)

    def give_up(self, number: int) -> None:
        """End a stream that nobody takes, if it was ordered: those of the configuration wait for a listener."""
        with self._lock:
            stream = self._streams.get(number)
            if stream is not None and stream.ordered and stream.on:
                ended = f"no listener for {LISTENER_TIMEOUT_S:g} s"
                self._put(self._streams | {number: replace(stream, on=False, ended=ended)})

    def _stop(self, order: StreamOrder) -> str:
        if order.number is not None and (why := self._no_such(order.number)):
            return why
        meant = [each for each in self._streams.values() if not each.voice and _ends(each, order)]
        if order.address and not meant:
            return f"there is no stream to {order.address}:{order.port}"
        self._put(self._streams | {each.number: replace(each, on=False, ended="") for each in meant})
        return ""

    def _start(self, order: StreamOrder) -> str:
        if order.number is None:
            return self._new(order)
        if why := self._no_such(order.number):
            return why
        before = self._streams[order.number]
        options = before.options | _sink_options(order)
        if options != before.options and (why := _wrong(before.sink, options)):
            return why
        self._put(
            self._streams
            | {
                order.number: replace(
                    before,
                    on=True,
                    ended="",
                    selection=before.selection if order.selection is None else order.selection,
                    gain_db=before.gain_db if order.gain_db is None else order.gain_db,
                    muted=before.muted if order.muted is None else order.muted,
                    options=options,
                )
            }
        )
        return ""

    def _new(self, order: StreamOrder) -> str:
        if not order.address:
            return "a new stream needs an address and a port"
        same = [each.number for each in self._streams.values() if each.sink == ORDERED and _goes_to(each, order)]
        if same:
            return self._start(replace(order, number=same[0]))
        if why := _wrong(ORDERED, _sink_options(order)):
            return why
        used = {each.number for each in self._streams.values() if each.on or not each.ordered}
        free = [number for number in range(MAX_STREAMS) if number not in used]
        if not free:
            return f"there are {MAX_STREAMS} streams already"
        unused = [number for number in free if number not in self._streams]
        number = (unused or free)[0]
        self._put(
            self._streams
            | {
                number: StreamSettings(
                    number,
                    ORDERED,
                    order.selection or Selection(),
                    order.gain_db or 0.0,
                    bool(order.muted),
                    options=_sink_options(order),
                    ordered=True,
                )
            }
        )
        return ""

    def _no_such(self, number: int) -> str:
        if number not in self._streams:
            return f"there is no stream {number}"
        return "this stream is the recorder's: stop the recording" if self._streams[number].voice else ""

    def _record_sources(self, n_sources: int) -> None:
        """Add a stream for every source that is known of."""
        number = RECORDED + n_sources
        if not n_sources or number in self._streams or n_sources > MOST_SOURCES:
            return
        news = {
            RECORDED + 1 + source: self._recorded(
                RECORDED + 1 + source, Selection(What.SOURCE, source), f"source-{source}"
            )
            for source in range(n_sources)
        }
        with self._lock:
            self._put(self._streams | news)

    def _recorded(self, number: int, selection: Selection, voice: str) -> StreamSettings:
        return StreamSettings(number, RECORDER, selection, keeps=True, voice=voice, wanted=self._recording)

    def _put(self, streams: dict[int, StreamSettings]) -> None:
        self._streams, self._news = streams, True


def _ends(settings: StreamSettings, order: StreamOrder) -> bool:
    """Tell whether an order to end streams means this one: by its number, by where it goes, or as one of all."""
    if order.number is not None:
        return settings.number == order.number
    return not order.address or _goes_to(settings, order)


def _goes_to(settings: StreamSettings, order: StreamOrder) -> bool:
    return (settings.options.get("address"), settings.options.get("port")) == (order.address, order.port)


def _impossible(order: StreamOrder) -> str:
    """Say what no stream can be asked for; empty: nothing of it."""
    selection, gain = order.selection, order.gain_db
    if gain is not None and not abs(gain) <= LOUDEST_DB:
        return f"gain: expected -60 to 60 dB, got {gain:g}"
    if selection is None:
        return ""
    if selection.what is What.SOURCE and not (selection.source is not None and 0 <= selection.source < MOST_SOURCES):
        return f"source: expected 0 to {MOST_SOURCES - 1}, got {selection.source}"
    if selection.what is What.AZIMUTH and not (selection.azimuth is not None and math.isfinite(selection.azimuth)):
        return f"azimuth: expected an angle, got {selection.azimuth}"
    return ""


def _sink_options(order: StreamOrder) -> dict[str, Any]:
    """Return the options of the sink that an order sets."""
    options = {"address": order.address, "port": order.port, "codec": order.codec}
    return {name: value for name, value in options.items() if value}


def _wrong(sink: str, options: dict[str, Any]) -> str:
    try:
        checked_options(sink, options, sink)
    except RossError as error:
        return str(error)
    return ""
