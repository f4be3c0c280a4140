"""The far end of a CAN bus: a DroneCAN servo or gimbal with its motor, and all that can go wrong around it."""

from __future__ import annotations

import math

import numpy as np

from ross_payload.actuators.dronecan_servo.options import Options
from ross_protocols.can import CanFrame
from ross_protocols.dronecan import Sender
from ross_sim.devices.can_crowd import Babbler, Crowd, Station
from ross_sim.devices.far_end import SLIP, Fault, checked
from ross_sim.devices.servo_node import EARLY, REPORT, ServoNode
from ross_sim.devices.servo_shaft import Drive, Shaft

DAMAGE = 0.5  # share of damaged frames while they are
STRANGER = 99  # node id of whoever should not be there
BABBLE = CanFrame(20999 << 8 | STRANGER, bytes(7) + b"\xc0")
APART = math.radians(40)  # between a servo and its double [rad]


class Rival:
    """A node that holds the same actuator at joint angle 0."""

    def __init__(self, options: Options, now: float) -> None:
        self._message = options.message(0.0)
        self._sender = Sender(STRANGER)
        self._due = now

    def take(self, frame: CanFrame) -> None:
        """Listen to nobody."""

    def live(self, until: float) -> list[CanFrame]:
        """Command at the rate of reports."""
        if until < self._due - EARLY:
            return []
        self._due = until + REPORT
        return self._sender.frames(self._message)


class ServoFarEnd:
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
        everything = frozenset(Fault)
        self.faults = everything if options.feedback == "measured" else everything - {Fault.NOISY}
        self.node = ServoNode(options, Shaft(drive, chance), fixed=fixed)
        self._options = options
        self._drive = drive
        self._chance = chance
        self._now = 0.0
        self.crowd = Crowd(chance, self.node)
        self.port = self.crowd.port

    def advance(self, now: float) -> None:
        """Let everybody on the bus live until ``now`` [s]."""
        self._now = now
        self.crowd.live(now)

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

    def complaints(self) -> list[str]:
        """Return nothing: a servo loses no steps."""
        return []

    def _stranger(self, fault: Fault) -> Station:
        if fault is Fault.TAKEN:
            return Rival(self._options, self._now)
        if fault is Fault.SATURATED:
            return Babbler(BABBLE)
        double = ServoNode(self._options, Shaft(self._drive, self._chance))
        double.shaft.place(self.node.shaft.angle + APART)
        double.boot(self._now)
        return double


class ServoFarEndPlugin:
    """The servo behind ``dronecan_servo``."""

    def make(self, config: Options, drive: Drive | None = None) -> ServoFarEnd:
        """Make a servo set up as the driver's options say, at joint angle 0."""
        return ServoFarEnd(config, drive or Drive(), np.random.default_rng(0))


far_end = ServoFarEndPlugin()
