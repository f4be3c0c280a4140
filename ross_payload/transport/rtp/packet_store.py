"""Packets in the order they were sent, and what became of each: played, lost, late, twice.

Sequence numbers have 16 bits on the wire, timestamps 32; here they never wrap (RFC 3550, appendix A.1).
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass

from aiortc.rtp import RtpPacket

FARTHEST = 3000  # that a sequence number may jump; else it is a restart, or not of this stream
REMEMBERED = 2048  # packets of which it is known what became of them


@dataclass(frozen=True, slots=True)
class Queued:
    """A packet that waits to be played."""

    sequence: int
    timestamp: int  # of its first sample, in ticks of the clock
    payload: bytes


@dataclass(slots=True)
class PacketCounts:
    """What became of packets: every one that was sent is received or lost, and those late are of the received."""

    received: int = 0  # once, in time or late
    lost: int = 0
    late: int = 0  # came when something else had been played in their place
    duplicates: int = 0
    bad: int = 0  # datagrams that are no packets of this stream
    skipped: int = 0  # came, and were left out since nobody had read for long


class PacketStore:
    """What has come and was not played yet.

    Parameters
    ----------
    counts
        Where it is counted.
    """

    def __init__(self, counts: PacketCounts) -> None:
        self.counts = counts
        self.next = 0  # sequence number to be played
        self.highest: int | None = None  # that came
        self._timestamp = 0  # the latest
        self._waiting: dict[int, Queued] = {}
        self._given_up: OrderedDict[int, None] = OrderedDict()  # nothing of them came in time
        self._playing = False  # a packet was taken or given up
        self._after_jump: int | None = None  # the number that would confirm a restart

    def add(self, packet: RtpPacket) -> Queued | None:
        """Take a packet; None: it is a duplicate or no part of this stream. One that is late is returned, too."""
        if self.highest is None:
            self.highest, self._timestamp = packet.sequence_number, packet.timestamp
            self.next = self.highest
        step = _difference(packet.sequence_number, self.highest, 16)
        if abs(step) > FARTHEST:
            return self._jumped(packet)
        self._after_jump = None
        queued = Queued(
            sequence := self.highest + step,
            self._timestamp + _difference(packet.timestamp, self._timestamp, 32),
            packet.payload,
        )
        if not self._playing and step < 0:  # overtaken by the first one that came
            self.next = min(self.next, sequence)
        if sequence in self._waiting or (sequence < self.next and sequence not in self._given_up):
            self.counts.duplicates += 1
            return None
        self.counts.received += 1
        if step > 0:
            self.highest, self._timestamp = sequence, queued.timestamp
        if sequence < self.next:
            del self._given_up[sequence]
            self.counts.lost -= 1
            self.counts.late += 1
        else:
            self._waiting[sequence] = queued
        return queued

    def first(self) -> Queued | None:
        """Return the packet to be played first, of those that wait."""
        return self._waiting[min(self._waiting)] if self._waiting else None

    def take_first(self, late: bool = False) -> None:
        """Remove the first packet: it is played or, if ``late``, something else was; what is before it is lost."""
        first = self.first()
        if first is None:
            return
        while self.next < first.sequence:
            self.give_up()
        del self._waiting[first.sequence]
        self.next, self._playing = first.sequence + 1, True
        self.counts.late += late

    def give_up(self) -> None:
        """Wait no longer for the packet that would be next."""
        self._playing = True
        self.counts.lost += 1
        self._given_up[self.next] = None
        self.next += 1
        while len(self._given_up) > REMEMBERED:
            self._given_up.popitem(last=False)

    def skip(self) -> None:
        """Leave out all that waits."""
        while self._waiting:
            self.take_first()
            self.counts.skipped += 1

    def missing(self) -> list[int]:
        """Return the sequence numbers that did not come though later ones have, and are not given up yet."""
        return [each for each in range(self.next, self.highest or 0) if each not in self._waiting]

    def __len__(self) -> int:
        return len(self._waiting)

    def _jumped(self, packet: RtpPacket) -> Queued | None:
        """Start again when two packets in a row say that the numbers are others now."""
        if packet.sequence_number != self._after_jump:
            self._after_jump = (packet.sequence_number + 1) % 2**16
            self.counts.bad += 1
            return None
        self.skip()
        self.__init__(self.counts)  # type: ignore[misc]
        return self.add(packet)


def _difference(number: int, other: int, bits: int) -> int:
    """Return how far a number that wraps is ahead of another one.

    >>> _difference(2, 65535, 16), _difference(65535, 65536 + 2, 16)
    (3, -3)
    """
    half = 1 << (bits - 1)
    return (number - other + half) % (1 << bits) - half
