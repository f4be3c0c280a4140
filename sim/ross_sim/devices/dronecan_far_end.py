"""The far end of a CAN bus: a DroneCAN servo or gimbal with its motor, and all that can go wrong around it."""

from __future__ import annotations

import math

import numpy as np

from ross_payload.actuators.dronecan_servo.options import Options
from ross_protocols.can import CanFrame
from ross_protocols.dronecan.node_messages import Encoder
from ross_sim.devices.bus_nodes import CanFarEnd, Node, Talker, babbler
from ross_sim.devices.far_end import SLIP, Fault, checked
from ross_sim.devices.servo_node import REPORT, ServoNode
from ross_sim.devices.servo_shaft import Drive, Shaft

DAMAGE = 0.5  # share of damaged frames while they are
STRANGER = 99  # node id of whoever should not be there
BABBLE = CanFrame(20999 << 8 | STRANGER, bytes(7) + b"\xc0")
APART = math.radians(40)  # between a servo and its double [rad]


def rival(options: Options, now: float) -> Talker:
    """A node that holds the same actuator at joint angle 0, and commands at the rate of reports."""
    sender, message = Encoder(STRANGER), options.message(0.0)
    return Talker(lambda: sender.broadcast(message), now, REPORT)


class ServoFarEnd(CanFarEnd):
    """The servo on a bus with the payload, and with whom a fault brings.

    Parameters
    ----------
    options : Options
        How the servo is set up.
    drive : Drive
        What its motor can do.
    chance : numpy.random.Generator
        Of noise and damage.
    fixed : bool
        The servo's node id is set in it; else it asks for it.
    """

    def __init__(self, options: Options, drive: Drive, chance: np.random.Generator, *, fixed: bool = True) -> None:
        if options.feedback != "measured":
            self.faults = self.faults - {Fault.NOISY}
        self.node = ServoNode(options, Shaft(drive, chance), fixed=fixed)
        self._options = options
        self._drive = drive
        super().__init__(chance, self.node)

    def angle(self) -> float:
        """Return the true joint angle [rad]."""
        return self.node.joint()

    def afflict(self, fault: Fault, on: bool = True) -> None:
        """Break the servo, or the bus, or mend them."""
        shaft = self.node.shaft
        match checked(fault, self.faults):
            case Fault.STALL:
                shaft.powerless = on
            case Fault.STUCK:
                shaft.jammed = on
            case Fault.NOISY:
                shaft.noisy = on
            case Fault.SLIP:
                shaft.slipped += SLIP * self._options.gear_ratio * on
            case Fault.SILENT:
                self.node.silent = on
            case Fault.CORRUPT:
                self.crowd.plug.damage = DAMAGE * on
            case Fault.REBOOT:
                if on:
                    self.node.restart()
            case _:
                self.crowd.bring(fault, self._stranger(fault) if on else None)

    def _stranger(self, fault: Fault) -> Node:
        if fault is Fault.TAKEN:
            return rival(self._options, self._now)
        if fault is Fault.SATURATED:
            return babbler(BABBLE)
        double = ServoNode(self._options, Shaft(self._drive, self._chance))
        double.shaft.place(self.node.shaft.angle + APART)
        double.boot(self._now)
        return double

    @classmethod
    def make(cls, config: Options, drive: Drive | None = None) -> ServoFarEnd:
        """Make a servo set up as the driver's options say, at joint angle 0."""
        return cls(config, drive or Drive(), np.random.default_rng(0))


far_end = ServoFarEnd
