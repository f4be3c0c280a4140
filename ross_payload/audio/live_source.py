"""Microphones that cannot be asked to wait: a feed writes into a ring, the mission reads at its own pace."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, Self, runtime_checkable

from ross_payload.audio.channel_map import ChannelMap
from ross_payload.audio.gap_filler import PAUSE_S, GapFiller
from ross_payload.audio.reconnecting_feed import Feed, ReconnectingFeed, Worker, in_thread
from ross_payload.audio.ring import Ring
from ross_payload.errors import AudioError
from ross_payload.interfaces import AudioBlock, AudioFlag, Clock, Real

FIRST_SOUND_TIMEOUT_S = 5.0  # [s] after the opening within which something must be heard
SHORTEST_NAP, LONGEST_NAP = 0.001, 0.02  # [s] between two looks into the ring

log = logging.getLogger(__name__)
OnSamples = Callable[[Real], None]  # takes frames (n, n_channels); never waits
Opener = Callable[[OnSamples], Feed]


@dataclass(frozen=True, slots=True)
class SourceStatus:
    """A source at one moment."""

    lost: int = 0  # samples that never came, or came too fast and were left out, since it was opened
    reopened: int = 0  # times since it was opened
    waiting: float = 0.0  # audio heard but not yet read [s]
    rate: float | None = None  # measured against the Clock [Hz]
    trouble: str = ""  # why nothing is heard, in words; empty: something is


@runtime_checkable
class Watched(Protocol):
    """A source that tells how it is."""

    def status(self) -> SourceStatus:
        """How the source is."""


class LiveSource:
    """An AudioSource in real time.

    Samples are consecutive and in step with the Clock: what never came is zeros, flagged MISSING, counted in
    `status`. What comes faster than it can be heard is left out, flagged and counted alike. Since counting samples is
    counting time, ``AudioBlock.lost`` is always 0. While the feed is gone, reads deliver such
    zeros in real time and it is opened again.

    Parameters
    ----------
    opener
        Opens the feed, which hands frames of all its channels to what it is given.
    rate
        Of the feed [Hz].
    wiring
        Which of the channels are the microphones.
    buffer
        Audio that can wait to be read [s].
    clock
        Stamps what arrives.
    settling
        Not heard at the start [s], while filters of a sound card settle.
    start
        Runs the attempts to open the feed again.
    """

    def __init__(
        self,
        opener: Opener,
        rate: int,
        wiring: ChannelMap,
        buffer: float,
        clock: Clock,
        *,
        settling: float = 0.0,
        start: Callable[[Callable[[], None]], Worker] = in_thread,
    ) -> None:
        self._rate = rate
        self._channels = wiring.channels
        self._correction = wiring.correction(rate)
        self._clock = clock
        self._ring = Ring(round(buffer * rate))
        self._gap_filler = GapFiller(rate, settling)
        self._feed = ReconnectingFeed(lambda: opener(self._on_samples), clock, start)
        self._index = 0
        self._open = False
        self._looked = self._resumed = clock.now()  # into the ring, and when the reader last began to look again [s]

    @property
    def rate(self) -> int:
        """Sampling rate [Hz]."""
        return self._rate

    def read(self, n: int) -> AudioBlock:
        """Return the next ``n`` consecutive samples; waits until they were heard, or should have been.

        Raises
        ------
        AudioError
            When the source is not open.
        """
        if not self._open:
            raise AudioError("the microphones are not open")
        while self._fetch(n) < n:
            now = self._clock.now()
            if now - self._looked > PAUSE_S:  # as when the whole computer was held up
                self._resumed = now
            self._looked = now
            self._gap_filler.wait(now, self._resumed)
            self._feed.check(self._ring.offered, self._resumed)
            short = n - self._gap_filler.available
            if short > 0:
                self._clock.sleep(min(max(short / self._rate, SHORTEST_NAP), LONGEST_NAP))
        stretch = self._gap_filler.read(n)
        wired = self._correction.apply(stretch.samples)
        flags = wired.flags | (AudioFlag.MISSING if stretch.missing or stretch.spliced else AudioFlag.NONE)
        index, self._index = self._index, self._index + n
        return AudioBlock(wired.samples, index, stretch.time, flags=flags, raw=wired.raw, carried=wired.carried)

    def status(self) -> SourceStatus:
        """How the source is; from any thread."""
        waiting = self._ring.waiting + self._gap_filler.held + self._gap_filler.available
        return SourceStatus(
            lost=self._gap_filler.missing + self._gap_filler.left_out,
            reopened=self._feed.reopened,
            waiting=waiting / self._rate,
            rate=self._gap_filler.rate,
            trouble=self._feed.trouble,
        )

    def __enter__(self) -> Self:
        """Open the feed and wait for the first sound.

        Raises
        ------
        AudioError
            When it cannot be opened, was opened before, or stays silent.
        """
        if self._ring.offered or self._open:
            raise AudioError("the microphones can be opened only once")
        self._feed.open()
        try:
            self._begin()
        except BaseException:
            self._feed.close()
            raise
        self._open = True
        return self

    def __exit__(self, *exception: object) -> None:
        """Close the feed."""
        self._open = False
        self._feed.close()

    def _begin(self) -> None:
        until = self._clock.now() + FIRST_SOUND_TIMEOUT_S
        while not self._gap_filler.started:
            if self._clock.now() > until:
                raise AudioError(f"the microphones were opened, but gave no audio within {FIRST_SOUND_TIMEOUT_S:g} s")
            self._clock.sleep(LONGEST_NAP)
            self._fetch(1)

    def _fetch(self, n: int) -> int:
        """Take from the ring until ``n`` samples can be given; returns how many can."""
        while self._gap_filler.available < n:
            piece = self._ring.read()
            if piece is None:
                break
            before = self._gap_filler.left_out
            self._gap_filler.add(piece)
            if self._gap_filler.left_out > before == 0:
                log.warning("audio comes faster than audio.rate_hz = %d and real time: parts are left out", self._rate)
        return self._gap_filler.available

    def _on_samples(self, frames: Real) -> None:
        self._ring.write(frames, self._channels, self._clock.now())
