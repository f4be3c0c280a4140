"""One node on a DroneCAN bus, polled by the pump: its id, its heartbeat, who it is, and what others make it do.

Whoever speaks on the bus for this payload shares this node: `send` broadcasts, `subscribe` hears broadcasts, `serve`
answers requests. Nothing waits and nothing raises: what the bus does not take is lost, and `trouble` says why.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ross_payload.dronecan.allocatee import Allocatee
from ross_payload.errors import LinkError
from ross_payload.interfaces import Port
from ross_protocols.dronecan.messages import Allocation, Health, Mode, NodeStatus, Received
from ross_protocols.dronecan.node_messages import Call, Decoder, Encoder, Reply
from ross_protocols.dronecan.services import NodeInfo, NodeInfoRequest, TransportStats, TransportStatsRequest

NODE_STATUS_PERIOD_S = 1.0  # [s] between two NodeStatus
ALLOCATOR_TIMEOUT_S = 5.0  # to get an id from an allocator
QUIET_AFTER_S = (
    5.0  # [s] without a frame of another node with our id, or without a failure of the bus, until all is well
)
MOST_ANSWERS = 5  # in one poll: who asks more often asks again
ROUNDING_S = 1e-6  # so much before its time something is due [s]
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Identity:
    """Who a node is."""

    name: str  # as in a reversed domain name
    unique_id: bytes  # 16 bytes, for ever the same
    node_id: int = 0  # 0: asked of an allocator
    preferred: int = 0  # the id that is asked for; 0: any
    software: tuple[int, int] = (0, 0)  # version


class Node:
    """A node on a bus.

    Parameters
    ----------
    identity : Identity
        Who we are.
    port : Port
        The bus; its frames are all ours to read.
    rng : Generator
        For the waiting between requests for an id.
    now : float
        When the node starts [s].
    allocated
        Is told the id that an allocator gives us.
    """

    def __init__(
        self,
        identity: Identity,
        port: Port,
        rng: np.random.Generator,
        now: float,
        allocated: Callable[[int], None] = lambda node_id: None,
    ) -> None:
        self._identity = identity
        self._port = port
        self._rng = rng
        self._start = self._next_beat = self._now = self._asking_since = now
        self._health, self._mode, self._code = Health.OK, Mode.INITIALIZATION, 0
        self._calls: list[Callable[[Received, float], None]] = []
        self._replies: list[Callable[[Reply, float], None]] = []
        self._answers: dict[type[Any], Callable[[Any], Any]] = {
            NodeInfoRequest: self._info,
            TransportStatsRequest: self._statistics,
        }
        self._counts: Counter[str] = Counter()  # as in TransportStats
        self._answered = 0
        self._asked = 0  # anonymous transfers
        self._trouble = {"bus": "", "id": ""}  # in words
        self._failed = now  # the bus, last [s]
        self._clash_until: float | None = None  # another node has our id [s]
        self._allocatee: Allocatee | None = None
        self._allocated = allocated
        self._take_id(identity.node_id)
        if not identity.node_id:
            self._ask_for_id(identity.preferred, now)
        self.seen: dict[int, float] = {}  # when each node id was heard last [s]

    # ------------------------------------------------------------------------------------- for its users

    @property
    def id(self) -> int:
        """The node id; 0: there is none, or none that is ours alone, so that nothing is sent."""
        return self._id if self._clash_until is None else 0

    @property
    def trouble(self) -> str:
        """Why nobody hears us, in words; empty: they do."""
        return self._trouble["bus"] or self._trouble["id"]

    @property
    def unique_id(self) -> bytes:
        """What tells this node from every other one in the world."""
        return self._identity.unique_id

    def stands(self, health: Health, mode: Mode, code: int = 0) -> None:
        """Let the heartbeat say from now on how we are; ``code`` is for those who know us."""
        self._health, self._mode, self._code = health, mode, code

    def subscribe(self, call: Callable[[Received, float], None]) -> None:
        """Call with every broadcast whose type is known, and the time [s]; node 0 is one without an id."""
        self._calls.append(call)

    def replies(self, call: Callable[[Reply, float], None]) -> None:
        """Call with every response to a request of ours, and the time [s]."""
        self._replies.append(call)

    def serve(self, kind: type[Any], answer: Callable[[Any], Any]) -> None:
        """Answer requests of a type with what ``answer`` returns."""
        self._answers[kind] = answer

    def send(self, message: Any) -> bool:
        """Broadcast; tell whether it left."""
        return bool(self.id) and self._out(self._voice.broadcast(message))

    def request(self, message: Any, node: int) -> bool:
        """Ask a node something; tell whether it left."""
        return bool(self.id) and self._out(self._voice.request(message, node))

    def poll(self, now: float) -> None:
        """Read the bus, answer, send what is due at ``now`` [s]."""
        self._now, self._answered = now, 0
        for frame in self._arrived():
            if frame.extended:
                self._take_in(frame)
        if self._clash_until is not None and now > self._clash_until:
            self._clash_until = None
            self._note("id", "")
        if self._allocatee is not None:
            ask = self._allocatee.due(self._now)
            if ask is not None:
                self._asked += 1
                self._out([ask.asked(self._allocatee.discriminator, self._asked)])
            if self._now - self._asking_since > ALLOCATOR_TIMEOUT_S:
                self._note("id", "no node id yet: no allocator on the bus answers")
        if now >= self._next_beat - ROUNDING_S:
            self._next_beat = now + NODE_STATUS_PERIOD_S
            self.send(self._status())

    def close(self) -> None:
        """Say that we leave, and leave; idempotent."""
        self.stands(self._health, Mode.OFFLINE, self._code)
        try:
            self.send(self._status())
        finally:
            self._port.close()

    # ------------------------------------------------------------------------------------- in

    def _arrived(self) -> list[Any]:
        try:
            frames = self._port.receive()
        except LinkError as error:
            self._fail(error)
            return []
        self._counts["frames_received"] += len(frames)
        if frames or self._now > self._failed + QUIET_AFTER_S:  # a bus without anybody takes frames for a while
            self._note("bus", "")
        return frames

    def _take_in(self, frame: Any) -> None:
        source = frame.id & 0x7F
        if source and source == self._id:
            self._clash()
            return
        self.seen[source] = self._now
        received = self._ear.feed(frame)
        self._counts["received"] += received is not None
        if isinstance(received, Received):
            self._on_message(received)
        elif isinstance(received, Call):
            self._answer(received)
        elif isinstance(received, Reply):
            for on_reply in self._replies:
                on_reply(received, self._now)

    def _on_message(self, received: Received) -> None:
        if self._allocatee is not None and isinstance(received.message, Allocation):
            given = self._allocatee.on_allocation(received.node, received.message, self._now)
            if given is not None:
                self._take_id(given)
                self._allocated(given)
                log.info("DroneCAN: node %d assigned us node id %d", received.node, given)
        for call in self._calls:
            call(received, self._now)

    def _answer(self, call: Call) -> None:
        answer = self._answers.get(type(call.request))
        if answer is not None and self.id and self._answered < MOST_ANSWERS:
            self._answered += 1
            self._out(self._voice.response(call, answer(call.request)))

    def _info(self, request: NodeInfoRequest) -> NodeInfo:
        return NodeInfo(self._status(), self._identity.name, self.unique_id, self._identity.software)

    def _statistics(self, request: TransportStatsRequest) -> TransportStats:
        return TransportStats(**self._counts, broken=self._ear.broken.total())

    # ------------------------------------------------------------------------------------- our id

    def _take_id(self, node_id: int) -> None:
        self._id = node_id
        self._voice, self._ear = Encoder(node_id), Decoder(node_id)
        if node_id:
            self._allocatee = None
            self._note("id", "")

    def _ask_for_id(self, preferred: int, now: float) -> None:
        self._allocatee = Allocatee(self.unique_id, preferred, self._rng, now)
        self._asking_since = now

    def _clash(self) -> None:
        """Somebody else has our id: take another one where that is ours to do, else be silent while he is there."""
        if not self._identity.node_id:
            self._note("id", f"another node on the bus has our node id {self._id}: requesting another one")
            self._take_id(0)
            self._ask_for_id(0, self._now)
            return
        self._note("id", f"another node on the bus has our node id {self._id}: not transmitting until it leaves")
        self._clash_until = self._now + QUIET_AFTER_S

    # ------------------------------------------------------------------------------------- out

    def _status(self) -> NodeStatus:
        return NodeStatus(int(self._now - self._start), self._health, self._mode, self._code)

    def _out(self, frames: list[Any]) -> bool:
        try:
            for frame in frames:
                self._port.send(frame)
        except LinkError as error:
            self._fail(error)
            return False
        self._counts["sent"] += 1
        self._counts["frames_sent"] += len(frames)
        return True

    def _fail(self, error: LinkError) -> None:
        self._failed = self._now
        self._counts["failures"] += 1
        self._note("bus", str(error))

    def _note(self, what: str, trouble: str) -> None:
        """Remember what is wrong with the bus or with our id, and tell of a change."""
        before, self._trouble[what] = self._trouble[what], trouble
        if trouble and trouble != before:
            log.warning("DroneCAN: %s", trouble)
        elif before and not trouble:
            log.info("DroneCAN: resolved: %s", before)
