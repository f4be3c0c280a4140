"""One link: its port, its parser, its writer, its budget, and what went through."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from ross_payload.config import Link as LinkConfig
from ross_payload.mavlink.decoders import ManyPeers, SinglePeer
from ross_payload.token_bucket import TokenBucket
from ross_payload.transport.open_port import Server
from ross_payload.transport.ports import Peer, Transport
from ross_protocols.mavlink.codec import Encoder, Packet, message_of
from ross_protocols.mavlink.commands import is_stop
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.signing import SIGNATURE_SIZE, Guardian, Trust, is_signed

ADMISSION_TIMEOUT_S = 5.0  # with connections that have not shown our key [s]
BURST = 0.5  # [s] of the rate of a budget that may go out at once
LARGEST_FRAME = 293  # signed, with a full payload [bytes]
ACKNOWLEDGEMENT_SIZE = 22  # COMMAND_ACK, unsigned [bytes]
SERIAL_SHARE = 0.5  # of a serial line's bytes that we may use
BITS_PER_BYTE = 10  # on a serial line: start bit, eight, stop bit
CLAIM_S = 0.5  # [s] for which room is left to an answer that does not ask for it again
TIMES_BURST, TIMES_RATE = 20, 20.0  # heartbeats for those whose signing time is behind, at once, and [1/s]


@dataclass(frozen=True, slots=True)
class LinkStatus:
    """How a link is, and what went through it since it was made."""

    url: str
    role: str
    up: bool  # connected, as far as one can know
    room: float  # what the budget allows at this moment [bytes]; inf: anything
    most: float  # what it ever allows at once [bytes]
    claimed: float  # of that, what waits for an answer that needs so much at once [bytes]
    peers: tuple[ComponentId, ...]  # heard lately
    sent: int  # frames
    sent_bytes: int
    dropped: int  # frames that had no room, in the budget or in the port
    received: int  # frames
    received_bytes: int
    lost: int | None  # frames, by the senders' counts; None: behind a router nobody can tell
    bad: int  # what began like a frame and had a wrong checksum
    unknown: int  # frames of messages that nobody here knows
    refused: int  # frames whose signature is missing, wrong or old
    twins: int  # frames that somebody else has sent in our name
    reconnects: int
    error: str  # the latest failure of the port, in words


@dataclass(frozen=True, slots=True)
class Arrived:
    """A packet, where it came from, and how far it is believed."""

    packet: Packet
    peer: Peer
    refusal: str = ""  # why nothing that it orders is obeyed; empty: its sender decides
    fresh: bool = True  # it cannot have been played again


class Channel:
    """A link: a port with a decoder per peer and an encoder per local component."""

    def __init__(self, config: LinkConfig, port: Transport, now: float, number: int, guardian: Guardian | None) -> None:
        self.config = config
        self.twins = 0
        self._port = port
        self._number = number % 256  # the link id of our signatures
        self._guardian = guardian
        self._listener = port if isinstance(port, Server) else None
        self._decoders = SinglePeer(port, now) if self._listener is None else ManyPeers(self._listener)
        if self._listener is not None and (guardian is not None or not self._listener.connected):
            self._listener.require_admission()
        self._encoders: dict[ComponentId, Encoder] = {}
        self._heartbeat = b""  # the latest, as it was sent
        self._times = TokenBucket(TIMES_BURST, TIMES_RATE)
        self._baud = port.counts.baud
        self._budget = budget_of(config, self._baud)
        self._claim = 0.0, -math.inf  # how much [bytes], and until when [s]
        self._counts = {"sent": 0, "sent_bytes": 0, "dropped": 0, "received": 0, "refused": 0}

    @property
    def rate(self) -> float:
        """What the budget allows in the long run [bytes/s]; infinite: anything."""
        return self._budget.rate

    def send(self, sender: ComponentId, content: Any, size: int, now: float) -> bytes:
        """Send a value or message that takes ``size`` bytes unsigned; return the frame, or nothing if it is dropped."""
        stamp: int | None = 0
        if self._guardian is not None:
            size += SIGNATURE_SIZE
            stamp = self._guardian.time.stamp(now)
        if stamp is None or not self._budget.spend(now, size):
            self._counts["dropped"] += 1
            return b""
        frame = self._encoder(sender).encode(content, stamp)
        self._port.send(frame)
        if message_of(content).get_msgId() == common.MAVLINK_MSG_ID_HEARTBEAT:
            self._heartbeat = frame
        self._counts["sent"] += 1
        self._counts["sent_bytes"] += len(frame)
        return frame

    def claim(self, size: int, now: float, wait: bool) -> bool:
        """Tell whether there is room for an unsigned frame of so many bytes, and for an acknowledgement beside it.

        If it is to ``wait``, what repeats itself leaves it the room.
        """
        signature = 0 if self._guardian is None else SIGNATURE_SIZE
        need = min(size + ACKNOWLEDGEMENT_SIZE + 2 * signature, self._budget.burst)
        there = self._budget.tokens(now) >= need
        if not wait:
            return there
        if there:
            self._claim = (0.0, -math.inf) if need >= self._claim[0] else self._claim  # a larger one still waits
        else:
            self._claim = need, now + CLAIM_S
        return there

    def receive(self, now: float) -> Iterator[Arrived]:
        """Give what has arrived and may be believed; `meet` what is not an echo of ours."""
        if self._port.counts.baud != self._baud:  # it was found by listening
            self._baud = self._port.counts.baud
            self._budget = budget_of(self.config, self._baud)
        if self._listener is not None and self._guardian is not None:
            self._listener.expire(ADMISSION_TIMEOUT_S, now)
        for packet, peer in self._decoders.read(now):
            self._counts["received"] += 1
            arrived = self._judged(packet, peer, now)
            if arrived is None:
                self._counts["refused"] += 1
            else:
                yield arrived

    def meet(self, packet: Packet, peer: Peer, now: float) -> None:
        """Note who has sent a packet that is believed; from now on it is answered where it spoke from."""
        self.admit(packet, peer, now)
        self._decoders.meet(packet, peer, now)

    def knows(self, system_id: int, component_id: int) -> bool:
        """Tell whether a component was heard here; component 0 is any of its system."""
        return any(each.knows(system_id, component_id) for each in self._decoders.senders)

    def admit(self, packet: Packet, peer: Peer, now: float) -> None:
        """Answer a peer from now on, where its packet may be believed."""
        if self._guardian is None or is_signed(packet.frame):
            self._decoders.admit(peer, now)

    def may_order(self, arrived: Arrived) -> bool:
        """Tell whether the sender of a packet may order something."""
        packet = arrived.packet
        if arrived.refusal:
            return False
        accepted = not self.config.accept or packet.system_id in self.config.accept
        return accepted and (self._guardian is None or is_signed(packet.frame))

    def status(self, now: float) -> LinkStatus:
        """Return how the link is."""
        counts, decoded = self._port.counts, self._decoders
        present = sorted({who for senders in decoded.senders for who in senders.present(now)})
        mine = self._counts | {"dropped": self._counts["dropped"] + counts.dropped + counts.failed}
        return LinkStatus(
            url=self.config.url, role=self.config.role, up=counts.up, room=self._budget.tokens(now),
            most=self._budget.burst, claimed=self._claim[0] if now < self._claim[1] else 0.0,
            peers=tuple(present), lost=decoded.lost, bad=sum(each.bad for each in decoded.decoders),
            unknown=sum(each.unknown for each in decoded.decoders), received_bytes=decoded.received_bytes,
            reconnects=counts.reconnects, twins=self.twins, error=counts.error, **mine,
        )  # fmt: skip

    def close(self) -> None:
        """Give the port back; idempotent."""
        self._port.close()

    def _judged(self, packet: Packet, peer: Peer, now: float) -> Arrived | None:
        """Return what may be believed; who signs with a time behind ours is told ours, and is believed from then on."""
        if self._guardian is None:
            return Arrived(packet, peer)
        trust = self._guardian.judge(packet, now)
        if trust is Trust.BEHIND and self._listener is not None and self._heartbeat and self._times.spend(now):
            self._listener.send_to(self._heartbeat, peer)  # all that it hears until it is believed
            self._counts["sent"] += 1
            self._counts["sent_bytes"] += len(self._heartbeat)
        return judged(trust, self._guardian, packet, peer)

    def _encoder(self, sender: ComponentId) -> Encoder:
        if sender not in self._encoders:
            key = None if self._guardian is None else self._guardian.key
            self._encoders[sender] = Encoder(*sender, key, self._number)
        return self._encoders[sender]


def judged(trust: Trust, guardian: Guardian, packet: Packet, peer: Peer) -> Arrived | None:
    """Return what a signature of this worth lets pass; None: nothing.

    A stop needs no time that is on the disk: to play it again harms nobody. That of other orders is their sender's only
    proof, so while the disk takes none they are refused, aloud.
    """
    stop = is_stop(packet.message)
    if trust is Trust.BELIEVED or (trust is Trust.UNSAVED and stop):
        return Arrived(packet, peer)
    if trust is Trust.UNSAVED and guardian.time.trouble:
        return Arrived(packet, peer, refusal=guardian.time.trouble)
    if trust in (Trust.OLD, Trust.BEHIND) and stop and guardian.time.trouble:
        return Arrived(packet, peer, fresh=False)
    return None


def budget_of(config: LinkConfig, baud: int) -> TokenBucket:
    """Return the budget of a link [bytes] on a line with ``baud``, 0 when it is none: without a rate all has room.

    >>> budget_of(LinkConfig(url="serial:/dev/ttyAMA0:57600"), 57600).rate
    2880.0
    """
    rate = config.max_bytes_s or SERIAL_SHARE * baud / BITS_PER_BYTE or math.inf
    return TokenBucket(max(rate * BURST, LARGEST_FRAME), rate)
