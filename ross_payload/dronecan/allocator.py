"""Our node gives ids to nodes that have none: a centralised allocator of DroneCAN.

Whoever gives ids must know the unique ids of everybody else on the bus first.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass

from ross_payload.dronecan.node import Node
from ross_payload.dronecan.persistence import PersistentIds
from ross_protocols.dronecan.messages import FOLLOW_UP_TIMEOUT, UNIQUE, Allocation, Received
from ross_protocols.dronecan.node_messages import Reply
from ross_protocols.dronecan.services import NodeInfo, NodeInfoRequest

LISTEN_FIRST_S = 3.0  # [s] before the first id is given: who is there says so every second
HIGHEST = 125  # 126 and 127 are left to tools
AVOIDED = range(100, 106)  # PX4's parameter bridge takes these for cameras and drops what is meant for the node
OFFLINE_AFTER_S = 3.0  # [s] of silence
NODE_INFO_PERIOD_S = 1.0  # [s] between two questions to one node
MOST_ASKED = 4  # questions to a node that does not answer
log = logging.getLogger(__name__)


@dataclass(slots=True)
class Neighbour:
    """A node that was heard."""

    received_at: float  # [s]
    unique_id: bytes | None = None  # None: it has not said
    asked: int = 0
    ask_at: float = 0.0  # [s]


class Neighbours:
    """Every node that was heard, and the unique id of those that said."""

    def __init__(self) -> None:
        self._nodes: dict[int, Neighbour] = {}

    def on_status(self, node: int, now: float) -> None:
        """Note that a node lives; one that was away may be another one now."""
        known = self._nodes.get(node)
        if known is None or now - known.received_at > OFFLINE_AFTER_S:
            self._nodes[node] = Neighbour(now)
        else:
            known.received_at = now

    def on_identity(self, node: int, unique_id: bytes) -> None:
        """Note who a node is."""
        if node in self._nodes:
            self._nodes[node].unique_id = unique_id

    def next(self, now: float) -> int | None:
        """Return a node to be asked who it is; None: nobody at present."""
        for node, each in self._strangers():
            if now >= each.ask_at:
                each.asked, each.ask_at = each.asked + 1, now + NODE_INFO_PERIOD_S
                return node
        return None

    @property
    def all_known(self) -> bool:
        """Whether everybody has said who he is, or was asked often enough."""
        return not self._strangers()

    def present(self, node: int, now: float) -> bool:
        """Tell whether a node is on the bus."""
        return node in self._nodes and now - self._nodes[node].received_at <= OFFLINE_AFTER_S

    def who(self, node: int) -> bytes | None:
        """Return the unique id of a node; None: it has not said."""
        return self._nodes[node].unique_id if node in self._nodes else None

    def _strangers(self) -> list[tuple[int, Neighbour]]:
        return [(n, each) for n, each in self._nodes.items() if each.unique_id is None and each.asked <= MOST_ASKED]


class Allocator:
    """Gives each unique id a node id, the same one every time, and never one that was heard in use.

    Parameters
    ----------
    node
        Ours; it has an id.
    kept
        Whom we gave which id.
    now
        When it begins [s].
    """

    def __init__(self, node: Node, kept: PersistentIds, now: float) -> None:
        self._node = node
        self._kept = kept
        self._begin = now + LISTEN_FIRST_S
        self._neighbours = Neighbours()
        self._so_far = b""  # of the unique id that is being told
        self._heard_at = now  # [s]
        self._rival: int | None = None
        node.subscribe(self._on_message)
        node.replies(self._learn)

    def poll(self, now: float) -> None:
        """Note who is there; ask one who has not said who he is."""
        for other, time in self._node.seen.items():
            if other:
                self._neighbours.on_status(other, time)
        stranger = self._neighbours.next(now)
        if stranger is not None:
            self._node.request(NodeInfoRequest(), stranger)

    def _learn(self, reply: Reply, now: float) -> None:
        if isinstance(reply.response, NodeInfo):
            self._neighbours.on_identity(reply.node, reply.response.unique_id)

    def _on_message(self, received: Received, now: float) -> None:
        if not isinstance(received.message, Allocation):
            return
        if received.node:
            self._meet(received.node)
        elif self._rival is None and now >= self._begin and self._neighbours.all_known:
            self._on_allocation(received.message, now)

    def _meet(self, rival: int) -> None:
        """Two allocators would give one id to two nodes: we give way."""
        if self._rival is None:
            log.warning("DroneCAN: node %d allocates node ids, too: our allocator stops", rival)
        self._rival = rival

    def _on_allocation(self, asked: Allocation, now: float) -> None:
        """Take one part of a unique id; when it is whole, give an id, else ask for the next part."""
        if asked.first or now - self._heard_at > FOLLOW_UP_TIMEOUT:
            self._so_far = b""
        if not asked.unique_id or bool(self._so_far) == asked.first or len(self._so_far + asked.unique_id) > UNIQUE:
            return
        self._so_far, self._heard_at = self._so_far + asked.unique_id, now
        given = self._id_for(self._so_far, asked.node_id, now) if len(self._so_far) == UNIQUE else 0
        if given is None:
            log.warning("DroneCAN: a node requests an id, but all are in use")
            return
        self._node.send(Allocation(given, self._so_far))
        if given:
            log.info("DroneCAN: assigned node id %d to %s", given, self._so_far.hex())
            self._so_far = b""

    def _id_for(self, unique_id: bytes, wanted: int, now: float) -> int | None:
        """Return the id of a node; None: there is none left."""
        known = self._kept.table.get(unique_id)
        if known is not None and not self._is_anothers(known, unique_id, now):
            return known
        taken = {self._node.id, *AVOIDED, *self._kept.table.values(), *self._node.seen}
        upwards = range(wanted, HIGHEST + 1) if wanted else range(0)
        free = next((number for number in (*upwards, *range(HIGHEST, 0, -1)) if number not in taken), None)
        if free is not None:
            self._kept.gave(unique_id, free)
        return free

    def _is_anothers(self, node_id: int, unique_id: bytes, now: float) -> bool:
        """Tell whether somebody else lives under an id."""
        if node_id == self._node.id:
            return True
        return self._neighbours.present(node_id, now) and self._neighbours.who(node_id) != unique_id
