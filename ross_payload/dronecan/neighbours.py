"""Who else is on the bus: whoever gives ids must know their unique ids first."""

from __future__ import annotations

from dataclasses import dataclass

OFFLINE = 3.0  # [s] of silence
PERIOD = 1.0  # [s] between two questions to one node
MOST_ASKED = 4  # questions to a node that does not answer


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
        if known is None or now - known.received_at > OFFLINE:
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
                each.asked, each.ask_at = each.asked + 1, now + PERIOD
                return node
        return None

    @property
    def all_known(self) -> bool:
        """Whether everybody has said who he is, or was asked often enough."""
        return not self._strangers()

    def present(self, node: int, now: float) -> bool:
        """Tell whether a node is on the bus."""
        return node in self._nodes and now - self._nodes[node].received_at <= OFFLINE

    def who(self, node: int) -> bytes | None:
        """Return the unique id of a node; None: it has not said."""
        return self._nodes[node].unique_id if node in self._nodes else None

    def _strangers(self) -> list[tuple[int, Neighbour]]:
        return [(n, each) for n, each in self._nodes.items() if each.unique_id is None and each.asked <= MOST_ASKED]
