"""Who the servo on a CAN bus says it is."""

from __future__ import annotations

from collections.abc import Iterable

from ross_payload.dronecan.node import Node
from ross_protocols.can import CanFrame
from ross_protocols.dronecan_services import NodeInfo, NodeInfoRequest
from ross_protocols.dronecan_speech import Ear, Reply

AGAIN, TRIES = 1.0, 3  # [s] with an answer; how often to ask: not every node has one


class Greeting:
    """Asks a node for its name until it tells it, or is not going to.

    Parameters
    ----------
    whom : int
        Its node id.
    """

    def __init__(self, whom: int) -> None:
        self._whom = whom
        self._ear: Ear | None = None
        self._left, self._due = TRIES, 0.0
        self.told = ""  # name and versions

    def hear(self, frames: Iterable[CanFrame]) -> None:
        """Take in frames of the bus."""
        if self._ear is None or self.told:
            return
        for frame in frames:
            heard = self._ear.feed(frame)
            if isinstance(heard, Reply) and heard.node == self._whom and isinstance(heard.response, NodeInfo):
                self.told = described(heard.response)

    def ask(self, us: Node, now: float) -> None:
        """Ask at ``now`` [s], if it is time for it."""
        if not self.told and self._left and now >= self._due and us.request(NodeInfoRequest(), self._whom):
            self._ear = self._ear or Ear(us.id)
            self._left, self._due = self._left - 1, now + AGAIN


def described(info: NodeInfo) -> str:
    """Say who a node is, in one line.

    >>> from ross_protocols.dronecan import NodeStatus
    >>> described(NodeInfo(NodeStatus(5), "org.ardupilot.periph", bytes(16), (1, 7), (2, 0)))
    'org.ardupilot.periph, software 1.7, hardware 2.0'
    """
    name = "".join(letter for letter in info.name if letter.isprintable()) or "without a name"
    (major, minor), (hard, soft) = info.software, info.hardware
    return f"{name}, software {major}.{minor}, hardware {hard}.{soft}"
