"""How our node gets an id from an allocator on the bus: the allocatee's rules of DroneCAN."""

from __future__ import annotations

import numpy as np

from ross_protocols.dronecan.messages import FOLLOW_UP, MOST_ASKED, REQUEST_PERIOD, UNIQUE, Allocation

DISCRIMINATORS = 2**14


class Allocatee:
    """Asks for an id in three parts of its unique id, each time after a random while.

    Parameters
    ----------
    unique_id : bytes
        Ours, 16 bytes.
    preferred : int
        The id that we would like; 0: any.
    rng : Generator
        For the waiting.
    now : float
        When it begins [s].
    """

    def __init__(self, unique_id: bytes, preferred: int, rng: np.random.Generator, now: float) -> None:
        self._unique_id = unique_id
        self._preferred = preferred
        self._rng = rng
        self._request_at = now + self._chance(REQUEST_PERIOD)
        self._follow: tuple[float, int] | None = None  # when [s], and from which byte on

    def on_allocation(self, node: int, message: Allocation, now: float) -> int | None:
        """Take what somebody says about allocation; return the id that is given to us."""
        self._request_at, self._follow = now + self._chance(REQUEST_PERIOD), None
        if not node or not message.unique_id or not self._unique_id.startswith(message.unique_id):
            return None
        if len(message.unique_id) < UNIQUE:
            self._follow = now + self._chance(FOLLOW_UP), len(message.unique_id)
            return None
        return message.node_id or None

    def due(self, now: float) -> Allocation | None:
        """Return what is to be said at ``now`` [s]."""
        if self._follow is not None and now >= self._follow[0]:
            begin, self._follow = self._follow[1], None
            return Allocation(self._preferred, self._unique_id[begin : begin + MOST_ASKED])
        if now >= self._request_at:
            self._request_at = now + self._chance(REQUEST_PERIOD)
            return Allocation(self._preferred, self._unique_id[:MOST_ASKED], first=True)
        return None

    @property
    def discriminator(self) -> int:
        """What tells our anonymous frames from those of others, by chance."""
        return int(self._rng.integers(DISCRIMINATORS))

    def _chance(self, span: tuple[float, float]) -> float:
        return float(self._rng.uniform(*span))
