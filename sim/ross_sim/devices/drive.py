"""The far end of a CAN bus: a CANopen drive by CiA 402 with its motor, and all that can go wrong around it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ross_payload.actuators.canopen_drive.options import Options
from ross_payload.actuators.canopen_drive.setup import COMMAND
from ross_protocols import cia402
from ross_protocols.can import CanFrame
from ross_protocols.canopen import RPDO, packed
from ross_sim.devices.can_bus import ROOM, Bus, Plug
from ross_sim.devices.drive_axis import Axis
from ross_sim.devices.drive_node import EARLY, DriveNode
from ross_sim.devices.drive_objects import Objects
from ross_sim.devices.drive_servo import Axle
from ross_sim.devices.far_end import SLIP, Fault, checked

RIVALRY = 0.020  # [s] between two set-points of another master
SHORT = 0.2  # share of damaged frames that are too short; the others have one wrong byte
APART = math.radians(40)  # between a drive and its double [rad]


class Station(Protocol):
    """A node on the simulated bus."""

    def take(self, frame: CanFrame) -> None:
        """Hear a frame of somebody else."""

    def live(self, until: float) -> list[CanFrame]:
        """Live until ``until`` [s]; return what is said then."""


class Rival:
    """Another master, who sends the drive to the lower end of its travel."""

    def __init__(self, options: Options, now: float) -> None:
        self._id = RPDO[0] + options.node_id
        self._target = options.counts(math.radians(options.lower_deg))
        self._word = cia402.ENABLED | cia402.AT_ONCE
        self._due = now

    def take(self, frame: CanFrame) -> None:
        """Listen to nobody."""

    def live(self, until: float) -> list[CanFrame]:
        """Offer a set-point again and again."""
        if until < self._due - EARLY:
            return []
        self._due = until + RIVALRY
        self._word ^= cia402.NEW_SET_POINT
        data = packed(COMMAND, (self._word, self._target, cia402.Mode.PROFILE_POSITION))
        return [CanFrame(self._id, data, extended=False)]


class Babbler:
    """A node that fills the bus with frames of the highest priority."""

    def take(self, frame: CanFrame) -> None:
        """Listen to nobody."""

    def live(self, until: float) -> list[CanFrame]:
        """Say as much as its interface takes."""
        return [CanFrame(0x001, bytes(8), extended=False)] * 2 * ROOM


@dataclass(frozen=True, slots=True)
class _Seat:
    plug: Plug
    station: Station


class DriveFarEnd:
    """The drive on a bus with the payload, and with whom a fault brings.

    Parameters
    ----------
    options : Options
        How the drive is set up.
    chance : numpy.random.Generator
        Of noise and damage.
    angle : float
        Where the array stands at the beginning, joint angle [rad].
    """

    faults = frozenset(Fault)

    def __init__(self, options: Options, chance: np.random.Generator, angle: float = 0.0) -> None:
        self._options, self._chance = options, chance
        self._now = 0.0
        self.axle = Axle(options.scale, chance, angle=angle)
        self.node = self._drive(self.axle)
        self.bus = Bus(chance)
        self.port = self.bus.plug()
        self._seats = [_Seat(self.bus.plug(), self.node)]
        self._strangers: dict[Fault, _Seat] = {}
        self._silent = self._damaging = False

    def advance(self, now: float) -> None:
        """Let frames cross, everybody live until ``now`` [s], and frames cross again."""
        half = (now - self._now) / 2
        self._now = now
        self.bus.carry(half)
        for seat in self._seats:
            for frame in seat.plug.receive():
                seat.station.take(frame)
            for frame in seat.station.live(now):
                if seat.station is not self.node or not self._silent:
                    seat.plug.send(self._damaged(frame) if self._damaging else frame)
        self.bus.carry(half)

    def angle(self) -> float:
        """Return the true joint angle [rad]."""
        return self.axle.angle

    def afflict(self, fault: Fault, on: bool = True) -> None:
        """Break the drive, its encoder or the bus, or mend them."""
        match checked(fault, self.faults):
            case Fault.STALL:
                self.axle.limp = on
            case Fault.STUCK:
                self.axle.jammed = on
            case Fault.NOISY:
                self.axle.trembling = on
            case Fault.SLIP:
                self.axle.slip(SLIP * on)
            case Fault.SILENT:
                self._silent = on
            case Fault.CORRUPT:
                self._damaging = on
            case Fault.REBOOT:
                if on:
                    self.node.boot()
            case _:
                self._bring(fault, on)

    def complaints(self) -> list[str]:
        """Return nothing: a drive with an encoder loses no steps."""
        return []

    def _drive(self, axle: Axle) -> DriveNode:
        """Make a drive; one that needs homing counts from where it is switched on."""
        zero = round(math.radians(self._options.zero_deg) * self._options.scale)

        def power_up(objects: Objects) -> Axis:
            origin = zero if self._options.absolute else axle.counts
            return Axis(objects, axle, self._options.counts_per_turn, origin, zero)

        return DriveNode(self._options.node_id, Objects(self._options.node_id), power_up, self._now)

    def _bring(self, fault: Fault, on: bool) -> None:
        """Let the stranger of a fault join the bus, or leave it."""
        before = self._strangers.pop(fault, None)
        if before is not None:
            self.bus.unplug(before.plug)
            self._seats.remove(before)
        if on:
            self._strangers[fault] = seat = _Seat(self.bus.plug(), self._stranger(fault))
            self._seats.append(seat)

    def _stranger(self, fault: Fault) -> Station:
        if fault is Fault.TAKEN:
            return Rival(self._options, self._now)
        if fault is Fault.SATURATED:
            return Babbler()
        return self._drive(Axle(self._options.scale, self._chance, angle=self.axle.angle + APART))

    def _damaged(self, frame: CanFrame) -> CanFrame:
        """Return a frame with one byte changed, or too short."""
        place = int(self._chance.integers(len(frame.data)))
        if self._chance.random() < SHORT:
            return CanFrame(frame.id, frame.data[:place], extended=False)
        wrong = bytes((frame.data[place] ^ int(self._chance.integers(1, 256)),))
        return CanFrame(frame.id, frame.data[:place] + wrong + frame.data[place + 1 :], extended=False)


class DriveFarEndPlugin:
    """The drive behind ``canopen_drive``."""

    def make(self, config: Options, angle: float = 0.0) -> DriveFarEnd:
        """Make a drive set up as the driver's options say, at a joint angle [rad]."""
        return DriveFarEnd(config, np.random.default_rng(0), angle)


far_end = DriveFarEndPlugin()
