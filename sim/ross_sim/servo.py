"""The far end of a CAN bus: a DroneCAN servo or gimbal with its motor, and all that can go wrong around it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ross_payload.actuators.dronecan_options import Options
from ross_payload.angles import wrap
from ross_protocols.can import CanFrame
from ross_protocols.dronecan import (
    ArrayCommand,
    Assembler,
    CommandKind,
    Health,
    Message,
    Mode,
    NodeStatus,
    Sender,
    Status,
)
from ross_protocols.dronecan_gimbal import AngularCommand, GimbalMode, GimbalStatus
from ross_sim.can_bus import ROOM, Bus, Plug
from ross_sim.far_end import SLIP, Fault, checked
from ross_sim.servo_shaft import STEP, Drive, Shaft

REPORT, BEAT = 0.020, 1.0  # [s] between two reports, two NodeStatus
EARLY = 1e-6  # so much before its time something is due [s]
DAMAGE = 0.5  # share of damaged frames while they are
STRANGER = 99  # node id of whoever should not be there
APART = math.radians(40)  # between a servo and its double [rad]


class Station(Protocol):
    """A node on the simulated bus."""

    def take(self, frame: CanFrame) -> None:
        """Hear a frame of somebody else."""

    def live(self, until: float) -> list[CanFrame]:
        """Live until ``until`` [s]; return what is said then."""


class ServoNode:
    """The firmware: obeys commands for its actuator, reports where its encoder says it is.

    Parameters
    ----------
    options : Options
        How the driver believes the servo to be set up; it is.
    shaft : Shaft
        Motor, load and encoder.
    """

    def __init__(self, options: Options, shaft: Shaft) -> None:
        self.shaft = shaft
        self.health = Health.OK
        self.mode = Mode.OPERATIONAL
        self.silent = False
        self._options = options
        self._assembler = Assembler()
        self._sender = Sender(options.node_id)
        self._goal: float | None = None  # of the shaft [rad]
        self._started = self._now = 0.0
        self._next_report = self._next_beat = 0.0

    def take(self, frame: CanFrame) -> None:
        """Obey a frame."""
        received = self._assembler.feed(frame)
        match received and received.message:
            case ArrayCommand(commands):
                for command in commands:
                    if (command.actuator_id, command.kind) == (self._options.actuator_id, self._kind):
                        self._obey(self._options.joint_of(command.value))
            case AngularCommand(number, yaw, GimbalMode.BODY_FRAME) if self._gimbal and number == self._options.number:
                self._obey(self._nearest(self._options.joint_of(yaw)))

    def live(self, until: float) -> list[CanFrame]:
        """Live until ``until`` [s]; return what is said then."""
        for _ in range(round((until - self._now) / STEP)):
            self.shaft.live(self._goal)
        self._now = until
        messages: list[Message] = []
        if until >= self._next_report - EARLY:
            self._next_report = until + REPORT
            messages.append(self._status())
        if until >= self._next_beat - EARLY:
            self._next_beat = until + BEAT
            messages.append(NodeStatus(int(until - self._started), self.health, self.mode))
        frames = [frame for message in messages for frame in self._sender.frames(message)]
        return [] if self.silent else frames

    def restart(self) -> None:
        """Reset the firmware: without torque until a command comes, uptime 0."""
        self._goal = None
        self._sender = Sender(self._options.node_id)
        self._started = self._next_beat = self._now

    def boot(self, now: float) -> None:
        """Begin to live at ``now`` [s]."""
        self._now = self._next_report = now
        self.restart()

    def joint(self) -> float:
        """Return the true joint angle [rad]."""
        return self._options.joint_at(self.shaft.turned + self._zero)

    @property
    def _gimbal(self) -> bool:
        return self._options.command == "gimbal"

    @property
    def _kind(self) -> CommandKind | None:
        """What commands it obeys among an actuator's."""
        return None if self._gimbal else CommandKind[self._options.command.upper()]

    @property
    def _zero(self) -> float:
        """Position that it reports at joint angle 0 [rad]."""
        return math.radians(self._options.zero_position_deg)

    def _obey(self, joint: float) -> None:
        """Take a joint angle [rad] for its goal; the shaft stands at 0 when the joint does."""
        if math.isfinite(joint):
            self._goal = joint * self._options.gear_ratio

    def _nearest(self, joint: float) -> float:
        """Return the turn of a joint angle [rad] that is nearest to the goal before, or to where it stands."""
        before = (self.shaft.measured if self._goal is None else self._goal) / self._options.gear_ratio
        return before + wrap(joint - before)

    def _status(self) -> Status | GimbalStatus:
        known = self._options.feedback == "measured"
        position = self.shaft.reported + self._zero if known else math.nan
        if self._gimbal:
            return GimbalStatus(self._options.number, position)
        return Status(self._options.number, position, speed=self.shaft.rate if known else math.nan)


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


class Babbler:
    """A node that fills the bus with frames of the highest priority."""

    def take(self, frame: CanFrame) -> None:
        """Listen to nobody."""

    def live(self, until: float) -> list[CanFrame]:
        """Say as much as its interface takes."""
        return [CanFrame(20999 << 8 | STRANGER, bytes(7) + b"\xc0")] * 2 * ROOM


@dataclass(frozen=True, slots=True)
class _Seat:
    plug: Plug
    station: Station


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
    """

    def __init__(self, options: Options, drive: Drive, chance: np.random.Generator) -> None:
        everything = frozenset(Fault)
        self.faults = everything if options.feedback == "measured" else everything - {Fault.NOISY}
        self.node = ServoNode(options, Shaft(drive, chance))
        self._options = options
        self._drive = drive
        self._chance = chance
        self._now = 0.0
        self.bus = Bus(chance)
        self.port = self.bus.plug()
        self._seat = _Seat(self.bus.plug(), self.node)
        self._seats = [self._seat]
        self._strangers: dict[Fault, _Seat] = {}

    def advance(self, now: float) -> None:
        """Let frames cross, everybody live until ``now`` [s], and frames cross again."""
        half = (now - self._now) / 2
        self._now = now
        self.bus.carry(half)
        for seat in self._seats:
            for frame in seat.plug.receive():
                seat.station.take(frame)
            for frame in seat.station.live(now):
                seat.plug.send(frame)
        self.bus.carry(half)

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
                self._seat.plug.damage = DAMAGE * on
            case Fault.REBOOT:
                if on:
                    self.node.restart()
            case _:
                self._bring(fault, on)

    def complaints(self) -> list[str]:
        """Return nothing: a servo loses no steps."""
        return []

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
