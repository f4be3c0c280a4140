"""A simulated CAN bus: frames take their time and the lowest identifier goes first."""

from __future__ import annotations

import numpy as np

from ross_protocols.can import CanFrame
from ross_sim.devices.far_end import WireEnd

BITRATE = 1e6  # [bit/s]
STUFFED = 1.1  # bits of a frame with those that are stuffed in, over those without
ROOM = 100  # frames that wait in an interface; more are lost


class Plug(WireEnd):
    """One end of the bus; ``damage`` is the share of its frames that nobody can read."""

    damage = 0.0


class Bus:
    """Carries frames between plugs; ``chance`` tells which damaged frames are lost."""

    def __init__(self, chance: np.random.Generator) -> None:
        self._chance = chance
        self._plugs: list[Plug] = []
        self._debt = 0.0  # by which the last frame was longer than its time [s]

    def plug(self, plug: Plug | None = None) -> Plug:
        """Add an end."""
        self._plugs.append(plug or Plug())
        return self._plugs[-1]

    def unplug(self, plug: Plug) -> None:
        """Take an end away."""
        self._plugs.remove(plug)

    def carry(self, duration: float) -> None:
        """Let frames cross for ``duration`` [s]; what does not fit waits, as long as there is room for it."""
        left = duration - self._debt
        while left > 0 and (ready := [plug for plug in self._plugs if plug.sent]):
            winner = min(ready, key=lambda plug: plug.sent[0].id)
            frame = winner.sent.pop(0)
            left -= lasts(frame)
            if not (winner.damage and self._chance.random() < winner.damage):
                self._deliver(frame, winner)
        self._debt = max(-left, 0.0)
        for plug in self._plugs:
            del plug.sent[ROOM:]

    def _deliver(self, frame: CanFrame, sender: Plug) -> None:
        for plug in self._plugs:
            if plug is not sender:
                plug.arrived.append(frame)


def lasts(frame: CanFrame) -> float:
    """Return how long a frame occupies the bus [s].

    >>> round(lasts(CanFrame(0, bytes(8))) * 1e6)
    144
    """
    return STUFFED * ((67 if frame.extended else 47) + 8 * len(frame.data)) / BITRATE
