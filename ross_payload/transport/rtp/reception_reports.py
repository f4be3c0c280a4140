"""What a receiver says back to the sender over RTCP: how it goes, and which packets to send once more.

Receiver reports are RFC 3550, requests for packets the generic NACK of RFC 4585. Nothing names the computer: the
canonical name is random (RFC 7022).
"""

from __future__ import annotations

import secrets
from dataclasses import dataclass
from itertools import groupby

from aiortc.rtp import (
    RTCP_RTPFB_NACK,
    RtcpReceiverInfo,
    RtcpRrPacket,
    RtcpRtpfbPacket,
    RtcpSdesPacket,
    RtcpSourceInfo,
    RtcpSrPacket,
)

from ross_payload.transport.rtp.packet_store import PacketStore

REPORT_PERIOD_S = 1.0  # of reports [s]
NACK_INTERVAL_S = 0.04  # until a packet is asked for again [s]
REQUESTS = 3  # for one packet
AT_ONCE = 64  # packets in one request
NACK_JITTER_FACTOR = 1.25  # times the jitter, after which a missing packet is asked for: it may only be late
SOONEST, LATEST = 0.01, 0.1  # but not sooner, and no later [s]
CNAME = 1  # item of a source description
NTP_EPOCH = 2_208_988_800  # of 1970, in seconds since 1900
MOST_LOST = 0x7FFFFF


@dataclass(slots=True)
class _Missed:
    due: float  # when it is asked for [s]
    requests: int = 0


class ReceptionReports:
    """Writes the reports on one stream."""

    def __init__(self) -> None:
        self._ssrc = secrets.randbits(32)
        self._name = secrets.token_urlsafe(12).encode()
        self._due = 0.0
        self._missed: dict[int, _Missed] = {}
        self._before = (0, 0)  # packets expected and lost, at the latest report
        self._report: tuple[int, float] | None = None  # middle of the NTP time of the sender's report, when it came
        self.asked = 0  # packets asked for

    def on_report(self, report: RtcpSrPacket, now: float) -> None:
        """Note the sender's report, so that it can tell the round trip."""
        self._report = report.sender_info.ntp_timestamp >> 16 & 0xFFFFFFFF, now

    def due(self, store: PacketStore, source: int, jitter: float, clock: int, now: float) -> list[bytes]:
        """Return the datagrams to be sent now; ``jitter`` in seconds, ``clock`` of the timestamps [Hz]."""
        wanted = self._wanted(store, jitter, now)
        if not wanted and now < self._due:
            return []
        self._due = now + REPORT_PERIOD_S if now >= self._due else self._due
        parts = [bytes(RtcpRrPacket(self._ssrc, [self._block(store, source, round(jitter * clock), now)]))]
        parts.append(bytes(RtcpSdesPacket([RtcpSourceInfo(self._ssrc, [(CNAME, self._name)])])))
        if wanted:
            self.asked += len(wanted)
            for _, group in groupby(wanted, lambda each: each // 2**16):  # aiortc takes none that wrap
                numbers = [each % 2**16 for each in group]
                parts.append(bytes(RtcpRtpfbPacket(RTCP_RTPFB_NACK, self._ssrc, source, numbers)))
        return [b"".join(parts)]

    def _wanted(self, store: PacketStore, jitter: float, now: float) -> list[int]:
        missing = store.missing()
        patience = min(max(NACK_JITTER_FACTOR * jitter, SOONEST), LATEST)
        self._missed = {each: self._missed.get(each) or _Missed(now + patience) for each in missing}
        wanted = [each for each, state in self._missed.items() if state.requests < REQUESTS and now >= state.due]
        for each in wanted[:AT_ONCE]:
            self._missed[each] = _Missed(now + NACK_INTERVAL_S, self._missed[each].requests + 1)
        return wanted[:AT_ONCE]

    def _block(self, store: PacketStore, source: int, jitter: int, now: float) -> RtcpReceiverInfo:
        counts = store.counts
        lost, expected = counts.lost, counts.lost + counts.received
        more, more_lost = expected - self._before[0], lost - self._before[1]
        self._before = expected, lost
        middle, came = self._report or (0, now)
        return RtcpReceiverInfo(
            ssrc=source,
            fraction_lost=min(max(256 * more_lost // more, 0), 255) if more > 0 else 0,
            packets_lost=min(lost, MOST_LOST),
            highest_sequence=(store.highest or 0) & 0xFFFFFFFF,
            jitter=min(jitter, 0xFFFFFFFF),
            lsr=middle,
            dlsr=min(round((now - came) * 65536), 0xFFFFFFFF) if self._report else 0,
        )
