"""Drives one sink: opens it, opens it again when that failed, hands it blocks, and lets nobody else suffer from it."""

from __future__ import annotations

import logging
import math
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import fields
from functools import partial
from numbers import Integral, Real
from operator import index
from queue import Empty, Full, Queue
from typing import Protocol

from ross_payload.audio.sinks import SinkInfo, info_of
from ross_payload.errors import PLUGIN_RAISES, PluginError, RossError
from ross_payload.interfaces import AudioSink, Clock, VoiceBlock
from ross_payload.plugin_calls import called

RETRY_S = 2.0  # between two attempts to open a sink
BLOCKS = 128  # that wait for a sink which hangs: about 2 s
LAST_CALL_S = 2.0  # that a sink may take at the end
LOOK_S = 0.5  # between two looks at whether a sink that gets nothing has ended
KINDS: dict[str, type | tuple[type, ...]] = {  # by the annotation
    "SinkInfo": SinkInfo, "str": str, "int": Integral, "int | None": (Integral, type(None)), "float": Real,
}  # fmt: skip
FIELDS = tuple((each.name, str(each.type)) for each in fields(SinkInfo))
MOST = {"port": 0xFFFF, "rate": 0xFFFF_FFFF}  # of a number that telemetry has no more room for

log = logging.getLogger(__name__)
Make = Callable[[], AudioSink]


class SinkRunner(Protocol):
    """What a stream writes to."""

    @property
    def fault(self) -> str:
        """What is wrong, in words; empty while all is well."""

    @property
    def lost(self) -> int:
        """Samples that never got out."""

    @property
    def info(self) -> SinkInfo:
        """What the sink tells of itself."""

    def write(self, block: VoiceBlock) -> None:
        """Hand on samples; never waits, never raises."""

    def close(self) -> None:
        """Have the rest written, and the sink closed."""

    def wait(self) -> None:
        """Wait until it is closed; gives up on a sink that hangs."""


class DirectRunner:
    """Calls the sink at once: in simulated time, where nothing may be lost because the computer is slow.

    Parameters
    ----------
    name
        The stream in words, for the log.
    make
        Makes the sink, not open yet.
    clock
        Tells when to try again.
    """

    def __init__(self, name: str, make: Make, clock: Clock) -> None:
        self._name = name
        self._make = make
        self._clock = clock
        self._sink: AudioSink | None = None
        self._due = -1.0
        self._lost = 0  # by sinks that were closed, or never opened
        self._fault = ""
        self._well = (0.0, 0)  # when nothing was wrong the last time [s], and samples lost until then
        self._info = SinkInfo()

    @property
    def fault(self) -> str:
        """What is wrong, in words; empty while all is well."""
        return self._fault

    @property
    def info(self) -> SinkInfo:
        """What the sink tells of itself."""
        return self._info

    @property
    def lost(self) -> int:
        """Samples that never got out."""
        return self._lost + _lost_by(self._sink)

    def open(self) -> None:
        """Open the sink if it is time to."""
        now = self._clock.now()
        if self._sink is not None or now < self._due:
            return
        self._due = now + RETRY_S
        try:
            sink = self._make()
            called(self._name, "__enter__", sink.__enter__)
            self._sink = sink
            self._look(sink)
        except PLUGIN_RAISES as error:  # of others: a plug-in may raise anything
            self._end()
            self._fail(_in_words(error))

    def write(self, block: VoiceBlock) -> None:
        """Hand on samples."""
        self.open()
        if self._sink is None:
            self._lost += len(block.samples)
            return
        try:
            called(self._name, "write", partial(self._sink.write, block))
            self._look(self._sink)
        except PLUGIN_RAISES as error:  # of others: it may raise anything
            self._lost += len(block.samples)
            self._end()
            self._due = self._clock.now() + RETRY_S
            self._fail(_in_words(error))

    def close(self) -> None:
        """Close the sink; idempotent."""
        self._end()

    def wait(self) -> None:
        """It is closed already."""

    def _end(self) -> None:
        sink, self._sink = self._sink, None
        if sink is None:
            return
        try:
            called(self._name, "__exit__", partial(sink.__exit__, None, None, None))
            self._lost += _lost_by(sink)
            self._look(sink)
        except PLUGIN_RAISES as error:  # of others: it may raise anything
            self._fail(_in_words(error))

    def _look(self, sink: AudioSink) -> None:
        info, fault = info_of(sink), sink.fault
        _expect("info", info, "SinkInfo")
        for name, kind in FIELDS:
            value = getattr(info, name)
            _expect(f"info.{name}", value, kind)
            if isinstance(value, Integral) and not 0 <= int(value) <= MOST.get(name, math.inf):
                limit = f"0 to {MOST[name]}" if name in MOST else "0 or more"
                raise PluginError(f"the sink's info.{name}: expected {limit}, got {value}")
        _expect("fault", fault, "str")
        self._info = info
        self._fail(fault)

    def _fail(self, fault: str) -> None:
        """Log what changes, not what goes on."""
        before, self._fault = self._fault, fault
        now, lost = self._clock.now(), self.lost
        if fault and fault != before:
            log.warning("%s: %s", self._name, fault)
        elif before and not fault:
            since, count = self._well
            log.warning("%s: works again after %.1f s; %d samples are missing", self._name, now - since, lost - count)
        if not fault:
            self._well = (now, lost)


def _expect(name: str, value: object, kind: str) -> None:
    if not isinstance(value, KINDS[kind]):
        raise PluginError(f"the sink's {name}: expected {kind}, got {type(value).__name__}")


def _lost_by(sink: AudioSink | None) -> int:
    try:
        return 0 if sink is None else index(sink.lost)
    except PLUGIN_RAISES:  # of others: it may raise anything, and what it has lost is the least of it
        return 0


class ThreadedRunner:
    """Has a thread call the sink, so that one that hangs holds up nobody; parameters as of `DirectRunner`."""

    def __init__(self, name: str, make: Make, clock: Clock) -> None:
        self._name = name
        self._clock = clock
        self._direct = DirectRunner(name, make, clock)
        self._queue: Queue[VoiceBlock | None] = Queue(BLOCKS)
        self._refused = 0  # samples that found no room
        self._hangs = False
        self._well = (0.0, 0)  # when the sink began to hang [s], and samples refused until then
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._work, name=f"sink {name}", daemon=True)
        self._thread.start()

    @property
    def fault(self) -> str:
        """What is wrong, in words."""
        return "the sink hangs: what it does not take is lost" if self._hangs else self._direct.fault

    @property
    def lost(self) -> int:
        """Samples that never got out."""
        return self._direct.lost + self._refused

    @property
    def info(self) -> SinkInfo:
        """What the sink tells of itself."""
        return self._direct.info

    def write(self, block: VoiceBlock) -> None:
        """Queue samples; what finds no room is lost."""
        try:
            self._queue.put_nowait(block)
        except Full:
            if not self._hangs:
                self._hangs, self._well = True, (self._clock.now(), self._refused)
                log.warning("%s: the sink hangs: what it does not take is lost", self._name)
            self._refused += len(block.samples)
        else:
            if self._hangs and self._queue.qsize() <= BLOCKS // 2:
                self._hangs, (since, refused) = False, self._well
                lasted, count = self._clock.now() - since, self._refused - refused
                log.warning("%s: works again after %.1f s; %d samples are missing", self._name, lasted, count)

    def close(self) -> None:
        """Have the rest written, and the sink closed, while the caller goes on."""
        self._over.set()
        with suppress(Full):  # it sees that all is over when it has written the rest
            self._queue.put_nowait(None)

    def wait(self) -> None:
        """Wait until a sink that was closed has ended; gives up on one that hangs."""
        self._thread.join(LAST_CALL_S)
        if self._thread.is_alive():
            log.warning("%s: the sink hangs and is left behind", self._name)

    def _work(self) -> None:
        self._direct.open()
        while True:
            try:
                block = self._queue.get(timeout=LOOK_S)
            except Empty:
                block = None
                if not self._over.is_set():
                    continue
            if block is None:
                break
            self._direct.write(block)
        self._direct.close()


def _in_words(error: BaseException) -> str:
    if isinstance(error, RossError):
        return str(error)
    text = " ".join(str(error).split())[:120]
    return f"the sink raised {type(error).__name__}: {text}"
