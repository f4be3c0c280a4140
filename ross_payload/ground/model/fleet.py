"""Everybody who was heard: payloads, and the vehicles that carry them. Fed with packets, from wherever they come."""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass, replace
from heapq import nlargest
from typing import Any

from ross_payload.ground.model.decoder_state import LATE_S, PRESENCE_S, TWIN_SPAN_S, DecoderState, Presence, Senders
from ross_payload.ground.model.payload_state import PayloadState, twins
from ross_payload.ground.model.state_reducer import flawed, is_sane, learn, restarted, with_computer, with_text
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.computer import computer_of
from ross_protocols.mavlink.tunnel import OURS, unwrap
from ross_protocols.mavlink.values import Array, Health, Heartbeat, Named, Status, Text
from ross_protocols.mavlink.vehicle import AUTOPILOT, Position, position_of

MOST_PAYLOADS = 64
GONE_S = float(PRESENCE_S)  # [s] of silence, after which a payload makes room for another one
STEADIER_S = 2  # seconds more of the last `PRESENCE_S` in which one must have been heard to take the place of another


@dataclass(frozen=True, slots=True)
class Vehicle:
    """An autopilot's system."""

    system: int
    at: float  # when it was heard of [s]
    position: Position


class Fleet:
    """Payloads by `ComponentId`, vehicles by system id; a payload enters when it sends our dialect or a mirror.

    At most `MOST_PAYLOADS` are known at once: those that are ``pinned`` and those that are heard most steadily, so that
    no flood of made-up ids hides a payload. The rest is counted.

    >>> from ross_protocols.mavlink.codec import Decoder, Encoder
    >>> from ross_protocols.mavlink.values import Audio
    >>> fleet = Fleet()
    >>> for packet in Decoder().feed(Encoder(1, 191).encode(Audio(time_usec=0))):
    ...     fleet.on_packet(packet, at=0.0)
    >>> [str(who) for who in fleet.payloads]
    ['1-191']
    """

    def __init__(self) -> None:
        self.payloads: dict[ComponentId, PayloadState] = {}
        self.vehicles: dict[int, Vehicle] = {}
        self.pinned: frozenset[ComponentId] = (
            frozenset()
        )  # who is watched or commanded: they have a place before all others
        self._hidden: dict[ComponentId, Presence] = {}  # who has no place, the latest to be heard last
        self._decoders: dict[ComponentId, DecoderState] = {}
        self._senders = Senders()

    def copy(self) -> Fleet:
        """Return another fleet that knows the same; what either hears next is not the other's business."""
        other = Fleet()
        other.payloads, other.vehicles, other.pinned = dict(self.payloads), dict(self.vehicles), self.pinned
        other._hidden = {who: replace(presence) for who, presence in self._hidden.items()}
        other._decoders = {who: decoder.copy() for who, decoder in self._decoders.items()}
        other._senders = self._senders.copy()
        return other

    def on_packet(self, packet: Packet, at: float, way: Hashable = None, *, copied: bool = False) -> None:
        """Take a packet that came ``at`` a time [s] on a ``way``, a link and a peer; None: not told, as in a log.

        What a ``copied`` one says has come on another way before; it only counts.
        """
        self._senders.meet(packet, way)
        if packet.component_id == AUTOPILOT:
            place = position_of(packet.message)
            if place is not None:
                self.vehicles[packet.system_id] = Vehicle(packet.system_id, at, place)
            return
        who = packet.sender
        inner = unwrap(packet.message) if packet.name == "TUNNEL" else None
        content = packet if inner is None else inner
        known = self._known(who, content, at)
        if known is None or self._decoders[who].frame == packet.frame:
            return  # nobody that we know, or a frame that the network doubled
        known = self._counted(known, packet, way, tunnelled=inner is not None)
        self.payloads[who] = replace(known, last=at) if copied else self._with_content(known, content, at, way)

    def twin(self, who: ComponentId, at: float) -> None:
        """Learn that two payloads speak as ``who``; it is forgotten when nothing has shown it for a while."""
        if who in self.payloads:
            self._decoders[who].twin_at = at
            self.payloads[who] = self._doubled(self.payloads[who])

    def end(self, at: float) -> None:
        """Learn that nothing more comes ``at`` a time [s]: texts wait no longer for the rest of them."""
        for who, decoder in self._decoders.items():
            for text in decoder.texts.completed(math.inf):
                self.payloads[who] = with_text(self.payloads[who], replace(text, at=min(text.at, at)))

    def hidden(self, now: float, most: int = 8) -> tuple[int, list[ComponentId]]:
        """Return how many were heard within `GONE_S` and have no place, and the steadiest of them."""
        while self._hidden and not self._hidden[oldest := next(iter(self._hidden))].seconds(now):
            del self._hidden[oldest]
        return len(self._hidden), nlargest(most, self._hidden, key=lambda who: self._hidden[who].seconds(now))

    def _known(self, who: ComponentId, content: Packet, at: float) -> PayloadState | None:
        known = self.payloads.get(who)
        if known is not None:
            self._decoders[who].presence.note(at)
        if known is not None or not _is_ours(content):
            return known
        presence = self._hidden.pop(who, None) or Presence()
        fresh = presence.note(at)
        if len(self.payloads) >= MOST_PAYLOADS and not (fresh and self._make_room(who, presence.seconds(at), at)):
            self._hidden[who] = presence
            return None
        self._decoders[who] = DecoderState(presence=presence)
        return PayloadState(who, at, at)

    def _make_room(self, who: ComponentId, seconds: int, at: float) -> bool:
        """Take the place of the least steady one for another, who was heard in so many seconds, if that is fair."""
        others = [each for each in self.payloads if each not in self.pinned]
        ranks = {each: (self._decoders[each].presence.seconds(at), self.payloads[each].last) for each in others}
        least = min(others, key=ranks.__getitem__, default=None)
        if least is None:
            return False
        silent = at - self.payloads[least].last >= GONE_S
        if not (silent or who in self.pinned or seconds >= ranks[least][0] + STEADIER_S):
            return False
        if not silent:
            self._hidden[least] = self._decoders[least].presence
        del self.payloads[least], self._decoders[least]
        return True

    def _counted(self, known: PayloadState, packet: Packet, way: Hashable, *, tunnelled: bool) -> PayloadState:
        decoder, before = self._decoders[known.who], known.counts
        decoder.frame = packet.frame
        tunnelled = tunnelled or known.tunnelled
        counts = replace(
            before,
            frames=before.frames + 1,
            size=before.size + len(packet.frame),
            missing=before.missing + decoder.missing(packet.sequence),
            routed=tunnelled or self._senders.is_routed(way),
        )
        return replace(known, counts=counts, tunnelled=tunnelled)

    def _with_content(self, known: PayloadState, content: Packet, at: float, way: Hashable) -> PayloadState:
        decoder = self._decoders[known.who]
        for text in decoder.texts.completed(at):
            known = with_text(known, text)
        if (computer := computer_of(content.message)) is not None:
            return with_computer(known, computer, at)
        value = content.value
        if value is None:
            return replace(known, last=at)
        if not is_sane(value):
            return flawed(replace(known, last=at), f"{content.name} with a number that is NaN or infinite")
        if isinstance(value, Text):
            for text in decoder.texts.on_chunk(value, at):
                known = with_text(known, text)
            return replace(known, last=at)
        if isinstance(value, Status) and decoder.is_late(value, at, way):
            return replace(known, last=at)
        return learn(self._since(known, value, at, way), value, at)

    def _since(self, known: PayloadState, value: Any, at: float, way: Hashable) -> PayloadState:
        """Notice a new start: its heartbeat boots again, or its time goes back. Often back means two of one id."""
        decoder = self._decoders[known.who]
        if isinstance(value, Heartbeat):
            return self._since_beat(known, value, at, way)
        if not isinstance(value, Status):
            return known
        if not decoder.went_back(value, at, way):
            return replace(known, twin=False) if known.twin and at - decoder.twin_at > TWIN_SPAN_S else known
        if decoder.is_twin(at):
            decoder.twin_at = at
            return self._doubled(known)
        decoder.started_at = at
        return known if known.twin else restarted(known, at)

    def _since_beat(self, known: PayloadState, beat: Heartbeat, at: float, way: Hashable) -> PayloadState:
        """Notice a new start by a heartbeat; one that was noticed just before is told on a slower way once more."""
        decoder, before = self._decoders[known.who], known.heartbeat
        if beat.health is not Health.BOOT or (before is not None and before.health is Health.BOOT):
            return known
        if before is None or at - max(decoder.started_at, known.first) < LATE_S:
            return known
        decoder.note_start(at, way)  # its next status is no second start
        return restarted(known, at)

    @staticmethod
    def _doubled(known: PayloadState) -> PayloadState:
        return replace(known if known.twin else flawed(known, twins(known.who)), twin=True)


def _is_ours(content: Packet) -> bool:
    if content.name.startswith(OURS):
        return True
    value = content.value if content.name in ("NAMED_VALUE_FLOAT", "DEBUG_FLOAT_ARRAY") else None
    return isinstance(value, (Named, Array)) and value.name.startswith("ross_")
