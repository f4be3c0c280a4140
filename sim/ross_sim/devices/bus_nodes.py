"""A simulated CAN bus and who lives on it: a device, the payload, and the strangers that faults bring.

Frames take their time and the lowest identifier goes first.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ross_protocols.can import CanFrame
from ross_sim.devices.far_end import OF_DEVICES, Fault, WireEnd

EARLY = 1e-6  # so much before its time something is due [s]
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


class Node(Protocol):
    """A node on the simulated bus."""

    def on_frame(self, frame: CanFrame) -> None:
        """Hear a frame of somebody else."""

    def live(self, until: float) -> list[CanFrame]:
        """Live until ``until`` [s]; return what is said then."""


class Talker:
    """A node that listens to nobody, and sends again and again.

    Parameters
    ----------
    frames
        Makes what it sends at a time.
    first
        When it begins [s].
    period
        Between two times [s].
    """

    def __init__(self, frames: Callable[[], list[CanFrame]], first: float, period: float) -> None:
        self._frames, self._due, self._period = frames, first, period

    def on_frame(self, frame: CanFrame) -> None:
        """Do not listen."""

    def live(self, until: float) -> list[CanFrame]:
        """Return what is due until ``until`` [s]."""
        if until < self._due - EARLY:
            return []
        self._due = until + self._period
        return self._frames()


def babbler(frame: CanFrame) -> Talker:
    """Make a node that fills the bus with one frame of the highest priority, as much as its interface takes."""
    return Talker(lambda: [frame] * 2 * ROOM, -math.inf, 0.0)


@dataclass(frozen=True, slots=True)
class _NodePlug:
    plug: Plug
    station: Node


class NodesOnBus:
    """A bus with everybody on it.

    Parameters
    ----------
    chance
        Tells which damaged frames are lost.
    device
        Always there.
    """

    def __init__(self, chance: np.random.Generator, device: Node) -> None:
        self.bus = Bus(chance)
        self.port = self.bus.plug()  # the payload's
        self.plug = self.bus.plug()  # the device's
        self._now = 0.0
        self._seats = [_NodePlug(self.plug, device)]
        self._strangers: dict[Fault, _NodePlug] = {}

    def live(self, until: float) -> None:
        """Let frames cross, everybody live until ``until`` [s], and frames cross again."""
        half = (until - self._now) / 2
        self._now = until
        self.bus.carry(half)
        for seat in self._seats:
            for frame in seat.plug.receive():
                seat.station.on_frame(frame)
            for frame in seat.station.live(until):
                seat.plug.send(frame)
        self.bus.carry(half)

    def bring(self, fault: Fault, stranger: Node | None) -> None:
        """Let the stranger of a fault join the bus in place of the one before; None: nobody."""
        before = self._strangers.pop(fault, None)
        if before is not None:
            self.bus.unplug(before.plug)
            self._seats.remove(before)
        if stranger is not None:
            self._strangers[fault] = seat = _NodePlug(self.bus.plug(), stranger)
            self._seats.append(seat)


class CanFarEnd:
    """A device on a bus with the payload, and with whom a fault brings: what all devices on CAN have in common."""

    faults = OF_DEVICES

    def __init__(self, chance: np.random.Generator, device: Node) -> None:
        self._chance = chance
        self._now = 0.0
        self.crowd = NodesOnBus(chance, device)
        self.port = self.crowd.port

    def advance(self, now: float) -> None:
        """Let everybody on the bus live until ``now`` [s]."""
        self._now = now
        self.crowd.live(now)

    def complaints(self) -> list[str]:
        """Return nothing: a device with an encoder loses no steps."""
        return []
