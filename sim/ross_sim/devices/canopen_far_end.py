"""The far end of a CAN bus: a CANopen drive by CiA 402 with its motor, and all that can go wrong around it."""

from __future__ import annotations

import math
from itertools import cycle

import numpy as np

from ross_payload.actuators.canopen_drive.drive_setup import RPDO2_ITEMS
from ross_payload.actuators.canopen_drive.options import Options
from ross_protocols.can import CanFrame
from ross_protocols.canopen import cia402
from ross_protocols.canopen.frames import RPDO, packed
from ross_sim.devices.bus_nodes import CanFarEnd, Node, Talker, babbler
from ross_sim.devices.drive_axis import Axis
from ross_sim.devices.drive_node import DriveNode
from ross_sim.devices.drive_objects import Objects
from ross_sim.devices.drive_servo import Axle
from ross_sim.devices.far_end import SLIP, Fault, checked

RIVALRY = 0.020  # [s] between two set-points of another master
BABBLE = CanFrame(0x001, bytes(8), extended=False)
SHORT = 0.2  # share of damaged frames that are too short; the others have one wrong byte
APART = math.radians(40)  # between a drive and its double [rad]


def rival(options: Options, now: float) -> Talker:
    """Another master, who sends the drive to the lower end of its travel by a set-point again and again."""
    target, new = options.counts(math.radians(options.lower_deg)), cycle((cia402.NEW_SET_POINT, 0))

    def frames() -> list[CanFrame]:
        word = cia402.ENABLED | cia402.AT_ONCE | next(new)
        data = packed(RPDO2_ITEMS, (word, target, cia402.Mode.PROFILE_POSITION))
        return [CanFrame(RPDO[1] + options.node_id, data, extended=False)]

    return Talker(frames, now, RIVALRY)


class Transmitter:
    """What the bus hears of a drive: it may be silent, or damaged."""

    def __init__(self, node: DriveNode, chance: np.random.Generator) -> None:
        self._node, self._chance = node, chance
        self.silent = self.damaged = False

    def on_frame(self, frame: CanFrame) -> None:
        """Hear a frame of somebody else."""
        self._node.on_frame(frame)

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


class DriveFarEnd(CanFarEnd):
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

    def __init__(self, options: Options, chance: np.random.Generator, angle: float = 0.0) -> None:
        self._options = options
        self.axle = Axle(options.scale, chance, angle=angle)
        self.node = self._drive(self.axle, 0.0)
        self._transmitter = Transmitter(self.node, chance)
        super().__init__(chance, self._transmitter)

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
                self._transmitter.silent = on
            case Fault.CORRUPT:
                self._transmitter.damaged = on
            case Fault.REBOOT:
                if on:
                    self.node.boot()
            case _:
                self.crowd.bring(fault, self._stranger(fault) if on else None)

    def _drive(self, axle: Axle, now: float) -> DriveNode:
        """Make a drive; one that needs homing counts from where it is switched on."""
        zero = round(math.radians(self._options.zero_deg) * self._options.scale)

        def power_up(objects: Objects) -> Axis:
            origin = zero if self._options.absolute else axle.counts
            return Axis(objects, axle, self._options.counts_per_turn, origin, zero)

        return DriveNode(self._options.node_id, Objects(self._options.node_id), power_up, now)

    def _stranger(self, fault: Fault) -> Node:
        if fault is Fault.TAKEN:
            return rival(self._options, self._now)
        if fault is Fault.SATURATED:
            return babbler(BABBLE)
        return self._drive(Axle(self._options.scale, self._chance, angle=self.axle.angle + APART), self._now)

    @classmethod
    def make(cls, config: Options, angle: float = 0.0) -> DriveFarEnd:
        """Make a drive set up as the driver's options say, at a joint angle [rad]."""
        return cls(config, np.random.default_rng(0), angle)


far_end = DriveFarEnd
