"""Everybody who was heard: payloads, and the vehicles that carry them. Fed with packets, from wherever they come."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Any

from ross_payload.ground.picture.ears import TWIN_SPAN, Ear
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
GONE = 60.0  # [s] of silence, after which a payload makes room for another one


@dataclass(frozen=True, slots=True)
class Vehicle:
    """An autopilot's system."""

    system: int
    at: float  # when it was heard of [s]
    position: Position


class Fleet:
    """Payloads by `Who`, and vehicles by system id; a payload enters when it says something of our dialect or a mirror.

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
        self.refused = 0  # payloads beyond `MOST_PAYLOADS`
        self._ears: dict[Who, Ear] = {}
        self._senders = Senders()

    def copy(self) -> Fleet:
        """Return another fleet that knows the same; what either hears next is not the other's business."""
        other = Fleet()
        other.payloads, other.vehicles, other.refused = dict(self.payloads), dict(self.vehicles), self.refused
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

    def _known(self, who: Who, told: Packet, at: float) -> Payload | None:
        known = self.payloads.get(who)
        if known is not None or not _is_ours(told):
            return known
        if len(self.payloads) >= MOST_PAYLOADS and not self._make_room(at):
            self.refused += 1
            return None
        self._ears[who] = Ear()
        return Payload(who, at, at)

    def _make_room(self, at: float) -> bool:
        """Forget whoever was not heard for longest, if that is long."""
        oldest = min(self.payloads.values(), key=lambda known: known.last)
        if at - oldest.last < GONE:
            return False
        del self.payloads[oldest.who], self._ears[oldest.who]
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
            return flawed(replace(known, last=at), f"{told.name} with a number that is none (NaN or infinite)")
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
