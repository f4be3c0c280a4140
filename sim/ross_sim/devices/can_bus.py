"""A simulated CAN bus: frames take their time and the lowest identifier goes first; also for another process."""

from __future__ import annotations

from queue import SimpleQueue
from typing import Any

import numpy as np

from ross_payload.actuators.wires.can_codec import CanCodec
from ross_payload.interfaces import Port
from ross_protocols.can import CanFrame
from ross_sim.devices.wires import drained

BITRATE = 1e6  # [bit/s]
STUFFED = 1.1  # bits of a frame with those that are stuffed in, over those without
ROOM = 100  # frames that wait in an interface; more are lost


class Plug:
    """One end of the bus, a `Port`; ``damage`` is the share of its frames that nobody can read."""

    def __init__(self) -> None:
        self.sent: list[CanFrame] = []
        self.arrived: list[CanFrame] = []
        self.damage = 0.0

    def send(self, frame: CanFrame) -> None:
        """Send one frame to everybody else, as soon as the bus is free."""
        self.sent.append(frame)

    def receive(self) -> list[CanFrame]:
        """Return what the others have sent."""
        arrived, self.arrived = self.arrived, []
        return arrived

    def close(self) -> None:
        """Return at once: an in-process bus holds nothing."""


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


class CanSide:
    """Gives the bus to a payload in another process: frames take effect when they arrived."""

    codec = CanCodec

    def __init__(self, port: Port, epoch: float) -> None:
        self._port = port
        self._epoch = epoch
        self._inbox: SimpleQueue[tuple[float, Any]] = SimpleQueue()
        self._outbox: SimpleQueue[Any] = SimpleQueue()
        self._waiting: list[tuple[float, Any]] = []

    def arrived(self, frame: Any, now: float) -> None:
        """Keep a frame with the world's time of its arrival."""
        self._inbox.put((now - self._epoch, frame))

    def due(self, now: float) -> list[Any]:
        """Return what the servo has said."""
        return drained(self._outbox)

    def exchange(self, begin: float) -> None:
        """Give the servo what has arrived by then, and take what it says."""
        self._waiting += drained(self._inbox)
        while self._waiting and self._waiting[0][0] <= begin:
            self._port.send(self._waiting.pop(0)[1])
        for frame in self._port.receive():
            self._outbox.put(frame)
