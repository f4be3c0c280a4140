"""DroneCAN: what one node says and hears, as frames: broadcasts of every type that is known here, and services."""

from __future__ import annotations

import struct
from collections import Counter
from dataclasses import dataclass
from typing import Any

from ross_protocols.can import CanFrame
from ross_protocols.dronecan import messages, services
from ross_protocols.dronecan.gimbal_messages import AngularCommand, GimbalStatus
from ross_protocols.dronecan.params import GetSetRequest, GetSetResponse, OpcodeRequest, OpcodeResponse
from ross_protocols.dronecan.ross_types import RossSources, RossStatus
from ross_protocols.dronecan.transfer import REQUEST, SERVICE, Header, Reassembler, split

PRIORITY = 20  # of a request


MESSAGES = (
    messages.NodeStatus, messages.ArrayCommand, messages.Status, messages.LogMessage, messages.Allocation,
    AngularCommand, GimbalStatus, RossStatus, RossSources,
)  # fmt: skip
BROADCASTS: dict[int, Any] = {kind.NUMBER: kind for kind in MESSAGES}
ASKED = services.NodeInfoRequest, services.TransportStatsRequest, services.RestartRequest, GetSetRequest, OpcodeRequest
ANSWERED = services.NodeInfo, services.TransportStats, services.RestartResponse, GetSetResponse, OpcodeResponse
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


class Encoder:
    """Turns what one node says into frames."""

    def __init__(self, node: int) -> None:
        self._node = node
        self._counts: Counter[tuple[int, int]] = Counter()  # by type and addressee

    def broadcast(self, message: Any) -> list[CanFrame]:
        """Return the frames of a message to everybody; a long transfer begins with its CRC.

        >>> [frame.data.hex() for frame in Encoder(9).broadcast(messages.Status(1, 0.5))]
        ['cd1b010038007e80', '007e7f60']
        """
        header = Header(message.NUMBER, self._node, priority=message.PRIORITY)
        return split(header.identifier, message.pack(), message.SEED, self._count(message.NUMBER, 0))

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


class Decoder:
    """Turns the frames of a bus into what a node hears; what is broken, unknown or for others is dropped."""

    def __init__(self, node: int) -> None:
        self._node = node  # 0: has no id, so that nobody calls it
        self._reassembler = Reassembler()

    @property
    def broken(self) -> Counter[int]:
        """Transfers that came damaged or in part, by node."""
        return self._reassembler.broken

    def feed(self, frame: CanFrame) -> messages.Received | Call | Reply | None:
        """Return what this frame completes."""
        if not frame.extended:
            return None
        try:
            return self._service(frame) if frame.id & SERVICE else self._broadcast(frame)
        except (struct.error, messages.DroneCanError):
            return None

    def _broadcast(self, frame: CanFrame) -> messages.Received | None:
        source = frame.id & 0x7F
        kind: Any = BROADCASTS.get(frame.id >> 8 & (0xFFFF if source else 3))
        whole = None if kind is None else self._reassembler.feed(frame, kind.SEED)
        if whole is None:
            return None
        return messages.Received(source, kind.unpack(whole.payload), whole.transfer)

    def _service(self, frame: CanFrame) -> Call | Reply | None:
        if not self._node or frame.id >> 8 & 0x7F != self._node or not frame.id & 0x7F:
            return None
        asked = bool(frame.id & REQUEST)
        kind: Any = (REQUESTS if asked else RESPONSES).get(frame.id >> 16 & 0xFF)
        whole = None if kind is None else self._reassembler.feed(frame, kind.SEED)
        if whole is None:
            return None
        header, said = Header.of(frame.id), kind.unpack(whole.payload)
        return Call(header.source, said, whole.transfer, header.priority) if asked else Reply(header.source, said)
