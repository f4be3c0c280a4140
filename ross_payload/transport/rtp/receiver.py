"""RTP packets in, samples out: whoever plays takes as many samples as the clock asks for, whatever came.

No socket, no thread, no clock: datagrams are given to `RtpReceiver.on_datagram` with the time they arrived, samples are
taken by `RtpReceiver.read`, and what `RtpReceiver.feedback` returns goes back to the sender. A lock is the caller's.
"""

from __future__ import annotations

import struct
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from aiortc.rtp import RtcpByePacket, RtcpPacket, RtcpSrPacket, RtpPacket, is_rtcp

from ross_payload.interfaces import Samples
from ross_payload.transport.rtp.opus_decoder import OpusDecoder
from ross_payload.transport.rtp.packet_store import PacketCounts, PacketStore, Queued
from ross_payload.transport.rtp.playout_delay import PlayoutDelay
from ross_payload.transport.rtp.reception_reports import NTP_EPOCH, ReceptionReports
from ross_payload.transport.rtp.session_description import OPUS, Media
from ross_payload.transport.rtp.waveforms import Concealer, lengthened, shortened

SOURCE_TIMEOUT_S = (
    1.0  # without packets, until another sender may take over, and what plays waits for a new beginning [s]
)
MAX_LEAD_S = 2.0  # between what is played and what came, until the rest is skipped [s]
SPLICE_INTERVAL_S = 0.06  # splices: at least [s]
BROKEN = (ValueError, IndexError, struct.error)  # what parsers of aiortc raise


@dataclass(frozen=True, slots=True)
class Reception:
    """How it goes. Packets are counted since the beginning: sent = received + lost."""

    received: int
    lost: int  # never came
    late: int  # of the received: came too late to be played
    duplicates: int
    bad: int  # datagrams that are no packets of this stream
    skipped: int  # of the received: left out since nobody read
    recovered: int  # of the lost or late: played from the forward error correction
    asked: int  # that the sender was asked for once more
    concealed_s: float  # of sound that was made up [s]
    adjusted_s: float  # of sound put in, or below 0 left out, to follow clocks and network [s]
    delay_s: float  # that a packet of median delay waits here [s]
    jitter_s: float  # of the arrivals, RFC 3550 [s]
    silent_s: float  # since anything came from the sender, sound or report [s]; 0 before anything did
    playing: bool  # something came within the last second
    ended: bool  # the sender said that it is over

    @property
    def lost_share(self) -> float:
        """Share of the packets that never came, 0 to 1."""
        return self.lost / max(self.lost + self.received, 1)


class Decoder(Protocol):
    """Packets to samples."""

    def decode(self, payload: bytes) -> Samples:
        """Return the samples of a packet; ValueError when it is none."""

    def conceal(self, n: int) -> Samples:
        """Return ``n`` samples in place of lost ones."""

    def has_fec(self, after: bytes) -> bool:
        """Tell whether a packet repeats the one before it."""

    def recover(self, after: bytes, n: int) -> Samples:
        """Return the ``n`` samples before a packet; ValueError when it is none."""


class _L16Decoder:
    """Samples as they are, RFC 3551."""

    def __init__(self, rate: int) -> None:
        self._concealer = Concealer(rate)
        self.conceal = self._concealer.conceal

    def decode(self, payload: bytes) -> Samples:
        if not payload or len(payload) % 2:
            raise ValueError(f"expected samples of two bytes, got {len(payload)} bytes")
        return self._concealer.resume(np.frombuffer(payload, ">i2").astype(np.float32) * np.float32(1 / 32768))

    def has_fec(self, after: bytes) -> bool:
        return False

    def recover(self, after: bytes, n: int) -> Samples:
        return self.conceal(n)


class RtpReceiver:
    """Plays one stream.

    Parameters
    ----------
    media
        What it carries.
    delay_s
        How long a packet of median delay waits before it is played [s]; 0: as short as the network allows.

    Raises
    ------
    ConfigError
        When it is Opus, and there is no libopus.
    """

    def __init__(self, media: Media, delay_s: float = 0.0) -> None:
        self.media = media
        self._delay_s = delay_s
        self._ratio = media.clock // media.rate  # ticks of a sample
        self._counts, self._reports = PacketCounts(), ReceptionReports()
        self._recovered = self._concealed = self._adjusted = self._since_splice = 0
        self._source: tuple[int, Hashable] | None = None  # SSRC and sender
        self._heard_at = self._alive_at = self._transit = self._jitter = 0.0
        self._begin()

    def _begin(self) -> None:
        self._decoder: Decoder = OpusDecoder(self.media.rate) if self.media.codec == OPUS else _L16Decoder(self.rate)
        self._store = PacketStore(self._counts)
        self._delay = PlayoutDelay(self._delay_s)
        self._decoded: Samples = np.zeros(0, np.float32)  # and not taken yet
        self._position: int | None = None  # timestamp behind what is decoded; None: nothing is played
        self._ticks = self.media.packet * self._ratio  # of a packet
        self._starved = 0  # ticks since the latest packet was played
        self._mapping: tuple[float, int] | None = None  # wall time [s] of a timestamp
        self._ended = False

    @property
    def rate(self) -> int:
        """Of the samples [Hz]."""
        return self.media.rate

    @property
    def sender(self) -> Hashable:
        """Who is heard, as given to `on_datagram`; None before anybody is."""
        return self._source[1] if self._source is not None else None

    # ------------------------------------------------------------------------------------------- packets

    def on_datagram(self, datagram: bytes, now: float, sender: Hashable = None) -> None:
        """Take what arrived at ``now`` [s, monotonic]; whatever it is, it only is counted when it is no packet."""
        try:
            if is_rtcp(datagram):
                self._take_reports(RtcpPacket.parse(datagram), now, sender)
                return
            packet = RtpPacket.parse(datagram)
        except BROKEN:
            self._counts.bad += 1
            return
        if packet.payload_type != self.media.payload_type or not self._is_source((packet.ssrc, sender), now):
            self._counts.bad += 1
            return
        queued = self._store.add(packet)
        if queued is None:
            return
        lead = queued.timestamp / self.media.clock - now
        self._note_jitter(lead)
        self._heard_at = self._alive_at = now
        played = self._played
        if played is not None and abs(queued.timestamp - played) > MAX_LEAD_S * self.media.clock:
            self._store.skip()  # nobody read, or the sender's clock was set
            self._position = None
        elif self._position is None:
            self._start(queued)
        self._delay.arrived(lead)

    def feedback(self, now: float) -> list[bytes]:
        """Return the datagrams that are to be sent to `sender` now; to be asked for every 10 ms or so."""
        if self._source is None or now > self._heard_at + SOURCE_TIMEOUT_S:
            return []
        return self._reports.due(self._store, self._source[0], self._jitter, self.media.clock, now)

    def _is_source(self, source: tuple[int, Hashable], now: float) -> bool:
        if source != self._source and (self._source is None or self._ended or now > self._heard_at + SOURCE_TIMEOUT_S):
            if self._source is not None:
                self._store.skip()
                self._begin()
            self._source = source
        return source == self._source

    def _start(self, packet: Queued) -> None:
        """Play a packet after a while of silence."""
        silence = round(self._delay.first * self.rate)
        self._position, self._starved = packet.timestamp, 0
        self._decoded = np.zeros(silence, np.float32)
        self._delay = PlayoutDelay(self._delay_s)

    def _note_jitter(self, lead: float) -> None:
        change = abs(lead - self._transit) if self._transit else 0.0
        self._transit = lead
        self._jitter += (min(change, SOURCE_TIMEOUT_S) - self._jitter) / 16

    def _take_reports(self, reports: Sequence[object], now: float, sender: Hashable) -> None:
        for report in reports:
            if isinstance(report, RtcpSrPacket) and (report.ssrc, sender) == self._source:
                self._alive_at, info = now, report.sender_info
                self._reports.on_report(report, now)
                self._mapping = info.ntp_timestamp / 2**32 - NTP_EPOCH, info.rtp_timestamp
            elif isinstance(report, RtcpByePacket) and self._source is not None and sender == self._source[1]:
                self._ended = self._ended or self._source[0] in report.sources

    # ------------------------------------------------------------------------------------------- samples

    def read(self, n: int, now: float) -> Samples:
        """Return the next ``n`` samples, (n,), zeros where there is nothing: never more, never fewer."""
        parts, count = [self._decoded], len(self._decoded)
        while count < n and self._position is not None:
            block = self._next_block()
            parts.append(block)
            count += len(block)
        samples = np.concatenate([*parts, np.zeros(max(n - count, 0), np.float32)])
        self._decoded = samples[n:]
        played = self._played
        if played is not None:
            self._delay.taken(played / self.media.clock - now)
        return samples[:n]

    @property
    def _played(self) -> int | None:
        """Timestamp of the sample to be taken next."""
        return None if self._position is None else self._position - len(self._decoded) * self._ratio

    def _next_block(self) -> Samples:
        """Return what comes next, about a packet: played, recovered, made up, or silence that was sent as a pause."""
        position = self._position or 0
        while (first := self._store.first()) and first.timestamp + self._ticks <= position:
            self._store.take_first(late=True)
        if first is None:
            return self._starve()
        hole = first.timestamp - position
        if hole > 0 and first.sequence > self._store.next:
            return self._lost(first, min(hole, self._ticks))
        if hole > 0:  # a pause of the sender
            return self._advanced(np.zeros(max(min(hole, self._ticks) // self._ratio, 1), np.float32))
        self._store.take_first()
        try:
            samples = self._decoder.decode(first.payload)
        except ValueError:
            self._counts.bad += 1
            return self._made_up(self._ticks)
        self._ticks = max(len(samples), self.media.packet // 8) * self._ratio
        self._starved = 0
        return self._fitted(self._advanced(samples[-hole // self._ratio :] if hole else samples))

    def _lost(self, after: Queued, ticks: int) -> Samples:
        """Return what stands for the packet that would be next; ``after`` is the first one that came."""
        self._store.give_up()
        n = ticks // self._ratio
        if after.sequence == self._store.next and self._decoder.has_fec(after.payload):
            try:
                samples = self._decoder.recover(after.payload, n)
            except ValueError:
                return self._made_up(ticks)
            self._recovered += 1
            return self._advanced(samples)
        return self._made_up(ticks)

    def _starve(self) -> Samples:
        """Return what stands for packets that may still come; after a while wait for a new beginning."""
        self._starved += self._ticks
        if self._starved > SOURCE_TIMEOUT_S * self.media.clock:
            self._position = None
            return np.zeros(self._ticks // self._ratio, np.float32)
        missing = self._delay.correction() * self.media.clock
        if missing < self._ticks:
            return self._made_up(self._ticks)
        samples = self._decoder.conceal(self._ticks // self._ratio)  # the delay is too short: what comes is played
        self._shift(len(samples))
        self._concealed += len(samples)
        return samples

    def _made_up(self, ticks: int) -> Samples:
        samples = self._decoder.conceal(max(ticks // self._ratio, 1))
        self._concealed += len(samples)
        return self._advanced(samples)

    def _advanced(self, samples: Samples) -> Samples:
        self._position = (self._position or 0) + len(samples) * self._ratio
        return samples

    def _fitted(self, samples: Samples) -> Samples:
        """Leave out a period, or put one in, when the delay is to change."""
        self._since_splice += len(samples)
        wanted = round(self._delay.correction() * self.rate)
        if not wanted or self._since_splice < SPLICE_INTERVAL_S * self.rate:
            return samples
        fitted = lengthened(samples, wanted) if wanted > 0 else shortened(samples, -wanted)
        self._since_splice = 0
        self._shift(len(fitted) - len(samples))
        return fitted

    def _shift(self, n: int) -> None:
        self._adjusted += n
        self._delay.shifted(n / self.rate)

    # ------------------------------------------------------------------------------------------- how it goes

    def reception(self, now: float) -> Reception:
        """Tell how it goes."""
        counts = self._counts
        return Reception(
            *(counts.received, counts.lost, counts.late, counts.duplicates, counts.bad, counts.skipped),
            recovered=self._recovered,
            asked=self._reports.asked,
            concealed_s=self._concealed / self.rate,
            adjusted_s=self._adjusted / self.rate,
            delay_s=self._delay.delay,
            jitter_s=self._jitter,
            silent_s=max(now - self._alive_at, 0.0) if self._source is not None else 0.0,
            playing=self._position is not None and now < self._heard_at + SOURCE_TIMEOUT_S,
            ended=self._ended,
        )

    def total_delay(self, wall: float) -> float | None:
        """Return how long ago [s] the sound that is to be taken next was at the microphone; None: not known.

        By the sender's reports, so as good as the clocks of both computers agree; ``wall`` is the time since 1970 [s].
        """
        played = self._played
        if self._mapping is None or played is None:
            return None
        time, timestamp = self._mapping
        behind = (played - timestamp + 2**31) % 2**32 - 2**31  # the report has 32 bits of it
        return wall - time - behind / self.media.clock
