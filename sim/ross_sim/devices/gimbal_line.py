"""What stands between a payload and a gimbal: a line that others may fill, and somebody who wants the gimbal too."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Any

from numpy.random import Generator

from ross_protocols import gimbal
from ross_protocols.codec import Packet
from ross_protocols.gimbal import Address

DELAY, LOSS = 0.6, 0.3  # [s] on a line that others fill, and the share of frames that it drops
EARLY = 1e-9  # [s], of rounding
AGAIN = 0.1  # [s] between two set-points of a rival


@dataclass(slots=True)
class Line:
    """One direction of a wire; frames keep their order."""

    chance: Generator
    crowded: bool = False
    _under_way: deque[tuple[float, bytes]] = field(default_factory=deque)

    def pass_on(self, frames: list[bytes], now: float) -> list[bytes]:
        """Take frames in; return those that have arrived by ``now`` [s]."""
        for frame in frames:
            if not (self.crowded and self.chance.random() < LOSS):
                self._under_way.append((now + DELAY * self.crowded, frame))
        arrived = []
        while self._under_way and self._under_way[0][0] <= now + EARLY:
            arrived.append(self._under_way.popleft()[1])
        return arrived


class Rival:
    """A station that takes control from a manager, or points a device that another one manages.

    Parameters
    ----------
    address
        Its own.
    whom
        The manager or the device.
    at
        Joint angle [rad] to which it points a device; None: ``whom`` is a manager.
    """

    def __init__(self, address: Address, whom: Address, at: float | None) -> None:
        self.address = address
        self._whom = whom
        self._at = at
        self._due = 0.0

    def hear(self, packet: Packet, now: float) -> list[Any]:
        """Care for nobody."""
        return []

    def live(self, now: float) -> list[Any]:
        """Return what is due at ``now`` [s]."""
        if now < self._due:
            return []
        if self._at is not None:
            self._due = now + AGAIN
            return [gimbal.point_device(self._whom, self._at)]
        self._due = float("inf")
        return [gimbal.configure(self._whom, 0, gimbal.ITSELF)]
