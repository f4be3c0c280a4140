"""The far end of a CAN bus: a CANopen drive by CiA 402 with its motor, and all that can go wrong around it."""

from __future__ import annotations

import math

import numpy as np

from ross_payload.actuators.canopen_drive.options import Options
from ross_payload.actuators.canopen_drive.setup import COMMAND
from ross_protocols import cia402
from ross_protocols.can import CanFrame
from ross_protocols.canopen import RPDO, packed
from ross_sim.devices.can_crowd import Babbler, Crowd, Station
from ross_sim.devices.drive_axis import Axis
from ross_sim.devices.drive_node import EARLY, DriveNode
from ross_sim.devices.drive_objects import Objects
from ross_sim.devices.drive_servo import Axle
from ross_sim.devices.far_end import SLIP, Fault, checked

RIVALRY = 0.020  # [s] between two set-points of another master
BABBLE = CanFrame(0x001, bytes(8), extended=False)
SHORT = 0.2  # share of damaged frames that are too short; the others have one wrong byte
APART = math.radians(40)  # between a drive and its double [rad]


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


class Voice:
    """What the bus hears of a drive: it may be silent, or damaged."""

    def __init__(self, node: DriveNode, chance: np.random.Generator) -> None:
        self._node, self._chance = node, chance
        self.silent = self.damaged = False

    def take(self, frame: CanFrame) -> None:
        """Hear a frame of somebody else."""
        self._node.take(frame)

    def live(self, until: float) -> list[CanFrame]:
        """Live until ``until`` [s]; return what arrives of what is said then."""
        said = self._node.live(until)
        if self.silent:
            return []
        return [self._broken(frame) for frame in said] if self.damaged else said

    def _broken(self, frame: CanFrame) -> CanFrame:
        """Return a frame with one byte changed, or too short."""
        place = int(self._chance.integers(len(frame.data)))
        if self._chance.random() < SHORT:
            return CanFrame(frame.id, frame.data[:place], extended=False)
        wrong = bytes((frame.data[place] ^ int(self._chance.integers(1, 256)),))
        return CanFrame(frame.id, frame.data[:place] + wrong + frame.data[place + 1 :], extended=False)


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
        self._voice = Voice(self.node, chance)
        self.crowd = Crowd(chance, self._voice)
        self.port = self.crowd.port

    def advance(self, now: float) -> None:
        """Let everybody on the bus live until ``now`` [s]."""
        self._now = now
        self.crowd.live(now)

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
                self._voice.silent = on
            case Fault.CORRUPT:
                self._voice.damaged = on
            case Fault.REBOOT:
                if on:
                    self.node.boot()
            case _:
                self.crowd.bring(fault, self._stranger(fault) if on else None)

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

    def _stranger(self, fault: Fault) -> Station:
        if fault is Fault.TAKEN:
            return Rival(self._options, self._now)
        if fault is Fault.SATURATED:
            return Babbler(BABBLE)
        return self._drive(Axle(self._options.scale, self._chance, angle=self.axle.angle + APART))


class DriveFarEndPlugin:
    """The drive behind ``canopen_drive``."""

    def make(self, config: Options, angle: float = 0.0) -> DriveFarEnd:
        """Make a drive set up as the driver's options say, at a joint angle [rad]."""
        return DriveFarEnd(config, np.random.default_rng(0), angle)


far_end = DriveFarEndPlugin()
