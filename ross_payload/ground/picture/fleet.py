"""Everybody who was heard: payloads, and the vehicles that carry them. Fed with packets, from wherever they come."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from heapq import nlargest
from typing import Any

from ross_payload.ground.picture.ears import SPAN, TWIN_SPAN, Ear, Presence
from ross_payload.ground.picture.known import Payload, Who, twins
from ross_payload.ground.picture.learning import flawed, hear_computer, hear_text, is_sane, learn, restarted
from ross_payload.ground.picture.senders import Senders
from ross_protocols.codec import Packet
from ross_protocols.computer import computer_of
from ross_protocols.tunnel import OURS, unwrap
from ross_protocols.values import Array, Health, Heartbeat, Named, Status, Text
from ross_protocols.vehicle import Position, position_of

MOST_PAYLOADS = 64
AUTOPILOT = 1  # component id
GONE = float(SPAN)  # [s] of silence, after which a payload makes room for another one
STEADIER = 2  # seconds more of the last `SPAN` in which one must have been heard to take the place of another


@dataclass(frozen=True, slots=True)
class Vehicle:
    """An autopilot's system."""

    system: int
    at: float  # when it was heard of [s]
    position: Position


class Fleet:
    """Payloads by `Who`, and vehicles by system id; a payload enters when it says something of our dialect or a mirror.

    At most `MOST_PAYLOADS` are known at once: those that are ``pinned`` and those that are heard most steadily, so that
    no flood of made-up ids hides a payload. The rest is counted.

    >>> from ross_protocols.codec import Decoder, Encoder
    >>> from ross_protocols.values import Audio
    >>> fleet = Fleet()
    >>> for packet in Decoder().feed(Encoder(1, 191).encode(Audio(time_usec=0))):
    ...     fleet.hear(packet, at=0.0)
    >>> [str(who) for who in fleet.payloads]
    ['1-191']
    """

    def __init__(self) -> None:
        self.payloads: dict[Who, Payload] = {}
        self.vehicles: dict[int, Vehicle] = {}
        self.pinned: frozenset[Who] = frozenset()  # who is watched or commanded: they have a place before all others
        self._hidden: dict[Who, Presence] = {}  # who has no place, the latest to be heard last
        self._ears: dict[Who, Ear] = {}
        self._senders = Senders()

    def copy(self) -> Fleet:
        """Return another fleet that knows the same; what either hears next is not the other's business."""
        other = Fleet()
        other.payloads, other.vehicles, other.pinned = dict(self.payloads), dict(self.vehicles), self.pinned
        other._hidden = {who: replace(presence) for who, presence in self._hidden.items()}
        other._ears = {who: ear.copy() for who, ear in self._ears.items()}
        other._senders = self._senders.copy()
        return other

    def hear(self, packet: Packet, at: float, way: Hashable = None) -> None:
        """Take a packet that came ``at`` a time [s] on a ``way``, a link and a peer; None: not told, as in a log."""
        self._senders.meet(packet, way)
        if packet.component_id == AUTOPILOT:
            self._vehicle(packet, at)
            return
        who = Who(packet.system_id, packet.component_id)
        inner = unwrap(packet.message) if packet.name == "TUNNEL" else None
        told = packet if inner is None else inner
        known = self._known(who, told, at)
        if known is None or self._ears[who].frame == packet.frame:
            return  # nobody that we know, or a frame that the network doubled
        known = self._counted(known, packet, way, tunnelled=inner is not None)
        self.payloads[who] = self._told(known, told, at)

    def twin(self, who: Who, at: float) -> None:
        """Learn that two payloads speak as ``who``; it is forgotten when nothing has shown it for a while."""
        if who in self.payloads:
            self._ears[who].twin_at = at
            self.payloads[who] = self._doubled(self.payloads[who])

    def hidden(self, now: float, most: int = 8) -> tuple[int, list[Who]]:
        """Return how many were heard within `GONE` and have no place, and the steadiest of them."""
        while self._hidden and not self._hidden[oldest := next(iter(self._hidden))].seconds(now):
            del self._hidden[oldest]
        return len(self._hidden), nlargest(most, self._hidden, key=lambda who: self._hidden[who].seconds(now))

    def _known(self, who: Who, told: Packet, at: float) -> Payload | None:
        known = self.payloads.get(who)
        if known is not None:
            self._ears[who].presence.heard(at)
        if known is not None or not _is_ours(told):
            return known
        presence = self._hidden.pop(who, None) or Presence()
        fresh = presence.heard(at)
        if len(self.payloads) >= MOST_PAYLOADS and not (fresh and self._make_room(who, presence.seconds(at), at)):
            self._hidden[who] = presence
            return None
        self._ears[who] = Ear(presence=presence)
        return Payload(who, at, at)

    def _make_room(self, who: Who, seconds: int, at: float) -> bool:
        """Take the place of the least steady one for another, who was heard in so many seconds, if that is fair."""
        others = [each for each in self.payloads if each not in self.pinned]
        ranks = {each: (self._ears[each].presence.seconds(at), self.payloads[each].last) for each in others}
        least = min(others, key=ranks.__getitem__, default=None)
        if least is None:
            return False
        silent = at - self.payloads[least].last >= GONE
        if not (silent or who in self.pinned or seconds >= ranks[least][0] + STEADIER):
            return False
        if not silent:
            self._hidden[least] = self._ears[least].presence
        del self.payloads[least], self._ears[least]
        return True

    def _counted(self, known: Payload, packet: Packet, way: Hashable, *, tunnelled: bool) -> Payload:
        ear, before = self._ears[known.who], known.counts
        ear.frame = packet.frame
        tunnelled = tunnelled or known.tunnelled
        counts = replace(
            before,
            frames=before.frames + 1,
            size=before.size + len(packet.frame),
            missing=before.missing + ear.missing(packet.sequence),
            routed=tunnelled or self._senders.is_routed(way),
        )
        return replace(known, counts=counts, tunnelled=tunnelled)

    def _told(self, known: Payload, told: Packet, at: float) -> Payload:
        ear = self._ears[known.who]
        for said in ear.texts.waited(at):
            known = hear_text(known, said)
        if (computer := computer_of(told.message)) is not None:
            return hear_computer(known, computer, at)
        value = told.value
        if value is None:
            return replace(known, last=at)
        if not is_sane(value):
            return flawed(replace(known, last=at), f"{told.name} with a number that is NaN or infinite")
        if isinstance(value, Text):
            for said in ear.texts.heard(value, at):
                known = hear_text(known, said)
            return replace(known, last=at)
        return learn(self._since(known, value, at), value, at)

    def _since(self, known: Payload, value: Any, at: float) -> Payload:
        """Notice a new start: its heartbeat boots again, or its time goes back. Often back means two of one id."""
        ear = self._ears[known.who]
        if isinstance(value, Heartbeat):
            before = known.heartbeat
            if value.health is Health.BOOT and before is not None and before.health is not Health.BOOT:
                ear.status = None  # its next one is no second start
                return restarted(known, at)
        if not isinstance(value, Status):
            return known
        if not ear.went_back(value, at):
            return replace(known, twin=False) if known.twin and at - ear.twin_at > TWIN_SPAN else known
        if ear.is_twin(at):
            ear.twin_at = at
            return self._doubled(known)
        return known if known.twin else restarted(known, at)

    @staticmethod
    def _doubled(known: Payload) -> Payload:
        return replace(known if known.twin else flawed(known, twins(known.who)), twin=True)

    def _vehicle(self, packet: Packet, at: float) -> None:
        place = position_of(packet.message)
        if place is not None:
            self.vehicles[packet.system_id] = Vehicle(packet.system_id, at, place)


def _is_ours(told: Packet) -> bool:
    if told.name.startswith(OURS):
        return True
    value = told.value if told.name in ("NAMED_VALUE_FLOAT", "DEBUG_FLOAT_ARRAY") else None
    return isinstance(value, (Named, Array)) and value.name.startswith("ross_")
