"""Samples in, RTP packets out, and reports: no socket, no thread, no clock. The receiver is `RtpReceiver`.

L16 is RFC 3551, Opus RFC 7587 by PyAV, with the forward error correction in every packet. What a receiver asks for by a
NACK (RFC 4585) is sent once more, as it was.
"""

from __future__ import annotations

import secrets
import struct
from collections import OrderedDict
from collections.abc import Iterator
from typing import Protocol

import av
import numpy as np
from aiortc.rtp import (
    RTCP_RTPFB_NACK,
    RtcpByePacket,
    RtcpPacket,
    RtcpRrPacket,
    RtcpRtpfbPacket,
    RtcpSdesPacket,
    RtcpSenderInfo,
    RtcpSourceInfo,
    RtcpSrPacket,
    RtpPacket,
)

from ross_payload.audio.sinks.listener_watch import ListenerWatch
from ross_payload.interfaces import Samples, VoiceBlock
from ross_payload.transport.rtp.reception_reports import CNAME, NTP_EPOCH, REPORT_PERIOD_S
from ross_payload.transport.rtp.session_description import OPUS, Media

KEPT_S = 1.0  # of packets, to be sent once more [s]
ONCE_MORE = 0.25  # share of packets that are sent once more, at most
EXPECTED_LOSS = 10  # for which Opus repeats itself [%]


class Encoder(Protocol):
    """Samples of one packet to its payload."""

    lookahead: int  # ticks by which what comes out is later than what goes in

    def encode(self, samples: Samples) -> bytes:
        """Return the payload."""


class _L16:
    lookahead = 0

    def encode(self, samples: Samples) -> bytes:
        return (np.clip(samples, -1, 1) * 32767).round().astype(">i2").tobytes()


class _Opus:
    """Opus as `audio`: as `voip` it shapes the spectrum, and 10 dB of SI-SDR are gone at any bit rate."""

    def __init__(self, rate: int, bit_rate: int) -> None:
        codec = av.CodecContext.create("libopus", "w")
        codec.sample_rate, codec.bit_rate = rate, bit_rate
        codec.layout, codec.format = "mono", "flt"
        codec.options = {"application": "audio", "fec": "1", "packet_loss": str(EXPECTED_LOSS), "frame_duration": "20"}
        codec.open()
        self._codec, self._rate = codec, rate
        (self.lookahead,) = struct.unpack_from("<H", codec.extradata or b"", 10)  # the pre-skip, RFC 7845

    def encode(self, samples: Samples) -> bytes:
        frame = av.AudioFrame.from_ndarray(samples[None].astype(np.float32), "flt", "mono")
        frame.sample_rate = self._rate
        return b"".join(bytes(packet) for packet in self._codec.encode(frame))


class RtpSender:
    """Makes the packets of one stream.

    Parameters
    ----------
    rate
        Of the samples [Hz].
    media
        What they become.
    bit_rate
        Of Opus [bit/s].
    """

    def __init__(self, rate: int, media: Media, bit_rate: int) -> None:
        self.media = media
        self._rate = rate
        self._resampler = self._new_resampler()
        self._encoder: Encoder = _Opus(media.rate, bit_rate) if media.codec == OPUS else _L16()
        self._ratio = media.clock // media.rate  # ticks of a sample
        self._ssrc, self._sequence = secrets.randbits(32), secrets.randbits(15)
        self._offset = secrets.randbits(32)  # of the timestamps
        self._name = secrets.token_urlsafe(12).encode()  # RFC 7022: tells nothing of the computer
        self._waiting: Samples = np.zeros(0, np.float32)  # for a packet to be full, at the rate of the media
        self._first = 0  # sample of the stream that is the first of them, at the rate of the media
        self._next: int | None = None  # index of the block to come; None: any
        self._restarts = 0  # what is added to indices, which start again when the source is opened again
        self._time: tuple[int, float] = (0, 0.0)  # timestamp of a sample, and when it was heard [s]
        self._sent: OrderedDict[int, bytes] = OrderedDict()
        self._packets = self._bytes = 0
        self._allowed = 0.0  # packets that may be sent once more
        self._report_at = -np.inf
        self.listener = ListenerWatch()  # told of reports here, of all else by who sends
        self.packets_lost: int | None = None  # on the way, as it reports

    # ------------------------------------------------------------------------------------------- packets

    def packets(self, block: VoiceBlock) -> Iterator[bytes]:
        """Take the next samples; return the packets that are full. A pause ends one, and marks the next."""
        index, samples = block.index + self._restarts, block.samples
        if self._next is not None and index < self._next:
            self._restarts += self._next - index
            index = self._next
        place = round(index * self.media.rate / self._rate)
        marker = self._next is None
        if self._next is not None and 0 < index - self._next < self._rate * self.media.packet // self.media.rate:
            samples = np.concatenate([np.zeros(index - self._next, np.float32), samples])
        elif index != self._next:
            yield from self._flush()
            self._first, marker = place, True
        self._next = index + len(block.samples)
        self._waiting = np.concatenate([self._waiting, self._resampled(samples)])
        self._time = self._timestamp(place), block.time
        while len(self._waiting) >= self.media.packet:
            yield self._packet(self._waiting[: self.media.packet], marker)
            self._waiting = self._waiting[self.media.packet :]
            marker = False

    def _flush(self) -> Iterator[bytes]:
        """Return what waits in packets, with silence behind it; the next samples start again."""
        if self._resampler is not None and self._next is not None:
            held = _joined(self._resampler.resample(None))  # by its filter, from before the pause
            end = round(self._next * self.media.rate / self._rate)
            self._waiting = np.concatenate([self._waiting, held])[: max(end - self._first, 0)]
            self._resampler = self._new_resampler()
        while len(self._waiting) > self.media.packet:
            yield self._packet(self._waiting[: self.media.packet], False)
            self._waiting = self._waiting[self.media.packet :]
        if len(self._waiting):
            yield self._packet(np.pad(self._waiting, (0, self.media.packet - len(self._waiting))), False)
        self._waiting = self._waiting[:0]

    def _packet(self, samples: Samples, marker: bool) -> bytes:
        payload = self._encoder.encode(samples)
        packet = RtpPacket(
            payload_type=self.media.payload_type,
            marker=int(marker),
            sequence_number=self._sequence,
            timestamp=(self._timestamp(self._first) - self._encoder.lookahead) % 2**32,
            ssrc=self._ssrc,
            payload=payload,
        ).serialize()
        self._first += len(samples)
        self._sent[self._sequence] = packet
        while len(self._sent) > KEPT_S * self.media.rate / self.media.packet:
            self._sent.popitem(last=False)
        self._sequence = (self._sequence + 1) % 2**16
        self._packets, self._bytes = self._packets + 1, self._bytes + len(payload)
        self._allowed = min(self._allowed + ONCE_MORE, ONCE_MORE * len(self._sent))
        return packet

    def _timestamp(self, index: int) -> int:
        return (self._offset + index * self._ratio) % 2**32

    def _new_resampler(self) -> av.AudioResampler | None:
        return av.AudioResampler("flt", "mono", self.media.rate) if self.media.rate != self._rate else None

    def _resampled(self, samples: Samples) -> Samples:
        if self._resampler is None:
            return samples
        frame = av.AudioFrame.from_ndarray(samples[None].astype(np.float32), "flt", "mono")
        frame.sample_rate = self._rate
        return _joined(self._resampler.resample(frame))

    # ------------------------------------------------------------------------------------------- reports

    def report(self, now: float, wall: float) -> bytes | None:
        """Return the sender's report that is due at ``now`` [s], when it is ``wall`` [s since 1970]; None: none is.

        It tells which timestamp was heard at the microphone at what time of day.
        """
        if not self._packets or now < self._report_at + REPORT_PERIOD_S:
            return None
        self._report_at = now
        timestamp, heard = self._time
        time = wall - (now - heard) + NTP_EPOCH
        info = RtcpSenderInfo(
            ntp_timestamp=round(time * 2**32) % 2**64,
            rtp_timestamp=timestamp,
            packet_count=self._packets % 2**32,
            octet_count=self._bytes % 2**32,
        )
        return bytes(RtcpSrPacket(self._ssrc, info)) + self._description()

    def goodbye(self) -> bytes:
        """Return the report that ends the stream."""
        return bytes(RtcpRrPacket(self._ssrc)) + self._description() + bytes(RtcpByePacket([self._ssrc]))

    def on_report(self, datagram: bytes, now: float) -> list[bytes]:
        """Take what the receiver says; return the packets that it asks for, as far as they are kept."""
        try:
            reports = RtcpPacket.parse(datagram)
        except (ValueError, IndexError, struct.error):
            return []
        again: list[bytes] = []
        for report in reports:
            if isinstance(report, RtcpRrPacket):
                self.listener.reported(now)
                for block in report.reports:
                    if block.ssrc == self._ssrc:  # below 0 when packets came twice, RFC 3550, section 6.4.1
                        self.packets_lost = max(block.packets_lost, 0)
            elif isinstance(report, RtcpByePacket):
                self.listener.left(now)
            elif isinstance(report, RtcpRtpfbPacket) and (report.fmt, report.media_ssrc) == (
                RTCP_RTPFB_NACK,
                self._ssrc,
            ):
                again += [self._sent[each % 2**16] for each in report.lost if each % 2**16 in self._sent]
        again = again[: int(self._allowed)]
        self._allowed -= len(again)
        return again

    def _description(self) -> bytes:
        return bytes(RtcpSdesPacket([RtcpSourceInfo(self._ssrc, [(CNAME, self._name)])]))


def _joined(frames: list[av.AudioFrame]) -> Samples:
    """Return the samples of frames of one channel, (n,)."""
    return np.concatenate([np.zeros(0, np.float32), *(each.to_ndarray()[0] for each in frames)])
