"""Who lives on a simulated CAN bus: a device, the payload, and the strangers that faults bring."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ross_protocols.can import CanFrame
from ross_sim.devices.can_bus import ROOM, Bus, Plug
from ross_sim.devices.far_end import Fault


class Station(Protocol):
    """A node on the simulated bus."""

    def take(self, frame: CanFrame) -> None:
        """Hear a frame of somebody else."""

    def live(self, until: float) -> list[CanFrame]:
        """Live until ``until`` [s]; return what is said then."""


class Babbler:
    """A node that fills the bus with one frame of the highest priority."""

    def __init__(self, frame: CanFrame) -> None:
        self._frame = frame

    def take(self, frame: CanFrame) -> None:
        """Listen to nobody."""

    def live(self, until: float) -> list[CanFrame]:
        """Say as much as its interface takes."""
        return [self._frame] * 2 * ROOM


@dataclass(frozen=True, slots=True)
class _Seat:
    plug: Plug
    station: Station


class Crowd:
    """A bus with everybody on it.

    Parameters
    ----------
    chance
        Tells which damaged frames are lost.
    device
        Always there.
    """

    def __init__(self, chance: np.random.Generator, device: Station) -> None:
        self.bus = Bus(chance)
        self.port = self.bus.plug()  # the payload's
        self.plug = self.bus.plug()  # the device's
        self._now = 0.0
        self._seats = [_Seat(self.plug, device)]
        self._strangers: dict[Fault, _Seat] = {}

    def live(self, until: float) -> None:
        """Let frames cross, everybody live until ``until`` [s], and frames cross again."""
        half = (until - self._now) / 2
        self._now = until
        self.bus.carry(half)
        for seat in self._seats:
            for frame in seat.plug.receive():
                seat.station.take(frame)
            for frame in seat.station.live(until):
                seat.plug.send(frame)
        self.bus.carry(half)

    def bring(self, fault: Fault, stranger: Station | None) -> None:
        """Let the stranger of a fault join the bus in place of the one before; None: nobody."""
        before = self._strangers.pop(fault, None)
        if before is not None:
            self.bus.unplug(before.plug)
            self._seats.remove(before)
        if stranger is not None:
            self._strangers[fault] = seat = _Seat(self.bus.plug(), stranger)
            self._seats.append(seat)
