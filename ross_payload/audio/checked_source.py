"""Holds an audio source to what an `AudioSource` promises, whoever wrote it; what it does wrong becomes one line."""

from __future__ import annotations

import math
from typing import Any, Self

import numpy as np

from ross_payload.audio.live_source import SourceStatus, Watched
from ross_payload.errors import PLUGIN_RAISES, AudioError, PluginError, RossError
from ross_payload.interfaces import AudioBlock, AudioSource
from ross_payload.plugin_calls import called

SOURCE_METHODS = ("read", "__enter__", "__exit__")
BACK_S = 0.001  # by which the time of a block may lie before that of the last one: clocks are corrected
MOST_TEXT = 120  # characters of what a plug-in has raised


class CheckedSource:
    """An AudioSource whose every block is checked; one that does not fit ends the source.

    Parameters
    ----------
    name
        Of the plug-in, for messages.
    source
        What is heard with.
    """

    def __init__(self, name: str, source: AudioSource) -> None:
        self._who = f"audio source '{name}'"
        self._source = source
        self._rate = source.rate
        self._next = 0  # index of the next sample
        self._time = -math.inf  # of the first sample of the last block [s]
        self._is_open = self._was_open = False

    @property
    def rate(self) -> int:
        """Sampling rate [Hz]."""
        return self._rate

    def read(self, n: int) -> AudioBlock:
        """Return the next ``n`` consecutive samples.

        Raises
        ------
        AudioEnded
            When what it plays has an end, and this is it.
        AudioError
            When the source has broken, or is not open.
        PluginError
            When it gives what no source may give.
        """
        if not self._is_open:
            raise AudioError(f"{self._who} is not open")
        try:
            block = called(self._who, "read", lambda: self._source.read(n))
        except RossError:
            raise
        except PLUGIN_RAISES as error:  # of others: it may raise anything
            raise AudioError(f"{self._who}: read raised {_text(error)}") from error
        fault = self._fault(block, n)
        if fault:
            raise PluginError(f"{self._who}: read({n}): {fault}")
        self._next, self._time = block.index + n, block.time
        return block

    def status(self) -> SourceStatus:
        """How the source is; from any thread. One that does not tell has nothing to tell."""
        if not isinstance(self._source, Watched):
            return SourceStatus()
        try:
            status: Any = called(self._who, "status", self._source.status)
        except PLUGIN_RAISES as error:  # of others: it may raise anything, and the pump asks
            return SourceStatus(trouble=f"{self._who}: status raised {_text(error)}")
        if not isinstance(status, SourceStatus):
            return SourceStatus(trouble=f"{self._who}: status: expected SourceStatus, got {type(status).__name__}")
        return status

    def __enter__(self) -> Self:
        """Open the source.

        Raises
        ------
        AudioError
            When it cannot be opened, or was opened before.
        """
        if self._was_open:
            raise AudioError(f"{self._who} can be opened only once")
        try:
            called(self._who, "__enter__", self._source.__enter__)
        except RossError:
            raise
        except PLUGIN_RAISES as error:  # of others: it may raise anything
            raise AudioError(f"{self._who}: cannot be opened: {_text(error)}") from error
        self._is_open = self._was_open = True
        return self

    def __exit__(self, *exception: object) -> None:
        """Close the source; idempotent."""
        if self._is_open:
            self._is_open = False
            called(self._who, "__exit__", lambda: self._source.__exit__(None, None, None))

    def _fault(self, block: Any, n: int) -> str:
        """What is wrong with a block, in words; empty when nothing is."""
        if not isinstance(block, AudioBlock):
            return f"expected an AudioBlock, got {type(block).__name__}"
        for what, samples in (("samples", block.samples), ("raw", block.raw)):
            fault = "" if samples is None and what == "raw" else _fault_of_samples(samples, n)
            if fault:
                return f"{what}: {fault}"
        if block.lost < 0 or block.index != self._next + block.lost:
            return f"index: expected {self._next} and what was lost, got {block.index} with {block.lost} lost"
        if not (isinstance(block.carried, float) and math.isfinite(block.carried)):
            return f"carried: expected a finite number, got {block.carried!r}"
        if not block.time >= self._time - BACK_S or math.isinf(block.time):
            return f"time: expected one that grows, got {block.time!r} s after {self._time!r} s"
        return ""


def _fault_of_samples(samples: Any, n: int) -> str:
    if not isinstance(samples, np.ndarray) or samples.dtype != np.float32 or samples.shape != (2, n):
        got = f"{samples.dtype} {samples.shape}" if isinstance(samples, np.ndarray) else type(samples).__name__
        return f"expected float32 (2, {n}), got {got}"
    largest = float(np.abs(samples).max(initial=0.0))
    return "" if largest <= 1.0 else f"expected samples within -1 to 1, got {largest:g}"


def _text(error: BaseException) -> str:
    return f"{type(error).__name__}: {' '.join(str(error).split())[:MOST_TEXT]}"
