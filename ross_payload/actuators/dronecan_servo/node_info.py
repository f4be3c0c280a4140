"""Who is who on the bus: the node that a driver alone on its bus is, and who the servo says it is."""

from __future__ import annotations

import hashlib
import platform
import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ross_payload import __version__
from ross_payload.actuators.dronecan_servo.options import Options
from ross_payload.dronecan.node import Identity, Node
from ross_payload.interfaces import Port
from ross_protocols.can import CanFrame
from ross_protocols.dronecan.messages import Health, Mode
from ross_protocols.dronecan.node_messages import Decoder, Reply
from ross_protocols.dronecan.services import NodeInfo, NodeInfoRequest

NODE_NAME = "org.ross.payload"  # of our node
MACHINE_ID = Path("/etc/machine-id")  # tells this computer from all others
RETRY_PERIOD_S, TRIES = 1.0, 3  # [s] with an answer; how often to ask: not every node has one


class NodeInfoQuery:
    """Asks a node for its name until it tells it, or is not going to.

    Parameters
    ----------
    node_id : int
        Its node id.
    """

    def __init__(self, node_id: int) -> None:
        self._node_id = node_id
        self._decoder: Decoder | None = None
        self._left, self._due = TRIES, 0.0
        self.identity = ""  # name and versions

    def on_frames(self, frames: Iterable[CanFrame]) -> None:
        """Take in frames of the bus."""
        if self._decoder is None or self.identity:
            return
        for frame in frames:
            decoded = self._decoder.feed(frame)
            if isinstance(decoded, Reply) and decoded.node == self._node_id and isinstance(decoded.response, NodeInfo):
                self.identity = described(decoded.response)

    def poll(self, us: Node, now: float) -> None:
        """Ask at ``now`` [s], if it is time for it."""
        if not self.identity and self._left and now >= self._due and us.request(NodeInfoRequest(), self._node_id):
            self._decoder = self._decoder or Decoder(us.id)
            self._left, self._due = self._left - 1, now + RETRY_PERIOD_S


def described(info: NodeInfo) -> str:
    """Say who a node is, in one line.

    >>> from ross_protocols.dronecan.messages import NodeStatus
    >>> described(NodeInfo(NodeStatus(5), "org.ardupilot.periph", bytes(16), (1, 7), (2, 0)))
    'org.ardupilot.periph, software 1.7, hardware 2.0'
    """
    name = "".join(letter for letter in info.name if letter.isprintable()) or "without a name"
    (major, minor), (hard, soft) = info.software, info.hardware
    return f"{name}, software {major}.{minor}, hardware {hard}.{soft}"


def own_node(options: Options, port: Port, now: float) -> Node:
    """Return a node for a driver that is alone on its bus."""
    machine = MACHINE_ID.read_text() if MACHINE_ID.is_file() else platform.node()
    unique = hashlib.blake2b(f"{machine} {options.port}".encode(), digest_size=16, person=b"ross-payload").digest()
    major, minor = (int(part) for part in re.findall(r"\d+", __version__)[:2])
    identity = Identity(NODE_NAME, unique, options.own_node_id, software=(major, minor))
    node = Node(identity, port, np.random.default_rng(list(unique)), now)
    node.stands(Health.OK, Mode.OPERATIONAL)
    return node
