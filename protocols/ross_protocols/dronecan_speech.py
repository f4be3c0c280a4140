"""DroneCAN: what one node says and hears, as frames: broadcasts of every type that is known here, and services."""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ross_protocols import dronecan
from ross_protocols.can import CanFrame
from ross_protocols.dronecan import DroneCanError, Received
from ross_protocols.dronecan_allocation import Allocation
from ross_protocols.dronecan_params import GetSetRequest, GetSetResponse, OpcodeRequest, OpcodeResponse
from ross_protocols.dronecan_ross import RossSources, RossStatus
from ross_protocols.dronecan_services import (
    NodeInfo,
    NodeInfoRequest,
    RestartRequest,
    RestartResponse,
    TransportStats,
    TransportStatsRequest,
)
from ross_protocols.dronecan_transfer import REQUEST, SERVICE, Header, Joiner, split

PRIORITY = 20  # of a request


@dataclass(frozen=True, slots=True)
class Kind:
    """A type of broadcast."""

    number: int
    seed: int  # CRC-16 of its signature
    priority: int
    unpack: Callable[[bytes], Any]


OWN = (Allocation, RossStatus, RossSources)
KINDS: dict[type[Any], Kind] = {
    kind: Kind(number, dronecan.SEEDS[number], dronecan.PRIORITIES[number], dronecan.TYPES[number])
    for kind, number in dronecan.IDS.items()
} | {kind: Kind(kind.NUMBER, kind.SEED, kind.PRIORITY, kind.unpack) for kind in OWN}
BROADCASTS = {kind.number: kind for kind in KINDS.values()}
ASKED = NodeInfoRequest, TransportStatsRequest, RestartRequest, GetSetRequest, OpcodeRequest
ANSWERED = NodeInfo, TransportStats, RestartResponse, GetSetResponse, OpcodeResponse
REQUESTS = {kind.NUMBER: kind for kind in ASKED}
RESPONSES = {kind.NUMBER: kind for kind in ANSWERED}


@dataclass(frozen=True, slots=True)
class Call:
    """A request that a node sends us."""

    node: int
    request: Any
    transfer: int
    priority: int


@dataclass(frozen=True, slots=True)
class Reply:
    """A response that a node sends us."""

    node: int
    response: Any


class Voice:
    """Turns what one node says into frames."""

    def __init__(self, node: int) -> None:
        self._node = node
        self._counts: Counter[tuple[int, int]] = Counter()  # by type and addressee

    def broadcast(self, message: Any) -> list[CanFrame]:
        """Return the frames of a message to everybody."""
        kind = KINDS[type(message)]
        header = Header(kind.number, self._node, priority=kind.priority)
        return split(header.identifier, message.pack(), kind.seed, self._count(kind.number, 0))

    def request(self, message: Any, node: int) -> list[CanFrame]:
        """Return the frames of a request to a node."""
        header = Header(message.NUMBER, self._node, node, True, PRIORITY)
        return split(header.identifier, message.pack(), message.SEED, self._count(message.NUMBER, node))

    def response(self, call: Call, message: Any) -> list[CanFrame]:
        """Return the frames of the answer to a request."""
        header = Header(message.NUMBER, self._node, call.node, False, call.priority)
        return split(header.identifier, message.pack(), message.SEED, call.transfer)

    def _count(self, number: int, node: int) -> int:
        count = self._counts[number, node]
        self._counts[number, node] = (count + 1) % 32
        return count


class Ear:
    """Turns the frames of a bus into what a node hears; what is broken, unknown or for others is dropped."""

    def __init__(self, node: int) -> None:
        self._node = node  # 0: has no id, so that nobody calls it
        self._joiner = Joiner()

    @property
    def broken(self) -> int:
        """How many transfers came damaged or in part."""
        return self._joiner.broken.total()

    def feed(self, frame: CanFrame) -> Received | Call | Reply | None:
        """Return what this frame completes."""
        if not frame.extended:
            return None
        try:
            return self._service(frame) if frame.id & SERVICE else self._broadcast(frame)
        except (struct.error, DroneCanError):
            return None

    def _broadcast(self, frame: CanFrame) -> Received | None:
        source = frame.id & 0x7F
        kind = BROADCASTS.get(frame.id >> 8 & (0xFFFF if source else 3))
        whole = None if kind is None else self._joiner.feed(frame, kind.seed)
        if kind is None or whole is None:
            return None
        return Received(source, kind.unpack(whole.payload), whole.transfer)

    def _service(self, frame: CanFrame) -> Call | Reply | None:
        if not self._node or frame.id >> 8 & 0x7F != self._node or not frame.id & 0x7F:
            return None
        asked = bool(frame.id & REQUEST)
        kind: Any = (REQUESTS if asked else RESPONSES).get(frame.id >> 16 & 0xFF)
        whole = None if kind is None else self._joiner.feed(frame, kind.SEED)
        if whole is None:
            return None
        header, said = Header.of(frame.id), kind.unpack(whole.payload)
        return Call(header.source, said, whole.transfer, header.priority) if asked else Reply(header.source, said)
