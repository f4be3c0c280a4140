"""The far end of a CAN bus: a DroneCAN servo with its motor, friction and encoder."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from queue import SimpleQueue

from ross_payload.actuators.can_codec import CanCodec
from ross_payload.actuators.dronecan_options import Options
from ross_payload.interfaces import Port
from ross_protocols.can import CanFrame
from ross_protocols.dronecan import (
    ArrayCommand,
    Assembler,
    Health,
    Message,
    Mode,
    NodeStatus,
    Sender,
    Status,
)
from ross_sim.far_end import Fault, checked
from ross_sim.wires import drained

STEP = 0.001  # of the simulation [s]
REPORT, BEAT = 0.020, 1.0  # [s] between two Status, two NodeStatus
EARLY = 1e-6  # so much before its time something is due [s]


@dataclass(frozen=True, slots=True)
class Drive:
    """What a servo can do, at its own shaft: a good pan servo."""

    speed: float = math.radians(360)  # highest [rad/s]
    acceleration: float = math.radians(3000)  # of motor and load, without friction [rad/s^2]
    friction: float = math.radians(150)  # sticking and sliding, as acceleration [rad/s^2]
    position_gain: float = 30.0  # [1/s]
    speed_gain: float = 100.0  # [1/s]
    counts: int = 4096  # of its encoder per turn


@dataclass(slots=True)
class Shaft:
    """A position loop around a speed loop around a shaft with friction.

    The speed wanted is the gain times the error as the encoder sees it, and never more than can be braked away over
    that error with half of the acceleration. Friction holds a shaft at rest until the motor pulls harder.
    """

    drive: Drive
    angle: float = 0.0  # [rad]
    rate: float = 0.0  # [rad/s]
    jammed: bool = False

    @property
    def measured(self) -> float:
        """The angle as the encoder sees it [rad]."""
        unit = 2 * math.pi / self.drive.counts
        return round(self.angle / unit) * unit

    def live(self, goal: float | None) -> None:
        """Live for one step with a goal [rad], or without torque."""
        drive = self.drive
        pull = 0.0 if goal is None else drive.speed_gain * (self._wanted(goal - self.measured) - self.rate)
        pull = max(-drive.acceleration, min(pull, drive.acceleration))
        if self.jammed or (self.rate == 0.0 and abs(pull) <= drive.friction):
            self.rate = 0.0
            return
        before = self.rate
        drag = math.copysign(drive.friction, before or pull)
        self.rate = before + (pull - drag) * STEP
        if before * self.rate < 0 and abs(pull) <= drive.friction:
            self.rate = 0.0
        self.angle += (before + self.rate) / 2 * STEP

    def _wanted(self, error: float) -> float:
        drive = self.drive
        speed = min(drive.position_gain * abs(error), math.sqrt(drive.acceleration * abs(error)), drive.speed)
        return math.copysign(speed, error)


@dataclass(slots=True)
class Bus:
    """The payload's end of an in-process CAN bus."""

    sent: list[CanFrame] = field(default_factory=list)
    arrived: list[CanFrame] = field(default_factory=list)

    def send(self, frame: CanFrame) -> None:
        """Send one frame to everybody else."""
        self.sent.append(frame)

    def receive(self) -> list[CanFrame]:
        """Return what the others have sent."""
        arrived, self.arrived = self.arrived, []
        return arrived

    def close(self) -> None:
        """Return at once: an in-process bus holds nothing."""


class ServoNode:
    """The firmware: obeys commands for its actuator, reports where its encoder says it is.

    Parameters
    ----------
    options : Options
        How the driver believes the servo to be set up; it is.
    drive : Drive
        Motor, load and encoder.
    """

    def __init__(self, options: Options, drive: Drive) -> None:
        self.shaft = Shaft(drive)
        self.health = Health.OK
        self.mode = Mode.OPERATIONAL
        self.silent = False
        self._options = options
        self._assembler = Assembler()
        self._sender = Sender(options.node_id)
        self._goal: float | None = None
        self._started = self._now = 0.0
        self._next_report = self._next_beat = 0.0

    def take(self, frame: CanFrame) -> None:
        """Obey a frame."""
        received = self._assembler.feed(frame)
        if received is None or not isinstance(received.message, ArrayCommand):
            return
        for command in received.message.commands:
            if (command.actuator_id, command.kind) == (self._options.actuator_id, self._options.kind):
                self._goal = self._at(self._options.joint_of(command.value))

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
        self._started = self._next_beat = self._now

    def joint(self) -> float:
        """Return the true joint angle [rad]."""
        return self._options.joint_at(self.shaft.angle + self._zero)

    @property
    def _zero(self) -> float:
        """Position that it reports at joint angle 0 [rad]."""
        return math.radians(self._options.zero_position_deg)

    def _at(self, joint: float) -> float:
        """Return the angle of the shaft [rad] at a joint angle [rad]; the shaft stands at 0 when the joint does."""
        return joint * self._options.gear_ratio

    def _status(self) -> Status:
        if self._options.feedback == "model":
            return Status(self._options.actuator_id)
        return Status(self._options.actuator_id, self.shaft.measured + self._zero, speed=self.shaft.rate)


class ServoFarEnd:
    """The servo alone on a bus with the payload; frames arrive with the next advance."""

    faults = frozenset({Fault.STUCK, Fault.SILENT, Fault.REBOOT})

    def __init__(self, node: ServoNode) -> None:
        self.port = Bus()
        self.node = node

    def advance(self, now: float) -> None:
        """Give the servo what was sent, then let it live until ``now`` [s]."""
        frames, self.port.sent = self.port.sent, []
        for frame in frames:
            self.node.take(frame)
        self.port.arrived += self.node.live(now)

    def angle(self) -> float:
        """Return the true joint angle [rad]."""
        return self.node.joint()

    def afflict(self, fault: Fault, on: bool = True) -> None:
        """Jam, fall silent or restart."""
        match checked(fault, self.faults):
            case Fault.STUCK:
                self.node.shaft.jammed = on
            case Fault.SILENT:
                self.node.silent = on
            case _ if on:
                self.node.restart()

    def complaints(self) -> list[str]:
        """Return nothing: a servo loses no steps."""
        return []


class CanSide:
    """Gives the bus to a payload in another process: frames take effect when they arrived."""

    codec = CanCodec

    def __init__(self, port: Port, epoch: float) -> None:
        self._port = port
        self._epoch = epoch
        self._inbox: SimpleQueue[tuple[float, CanFrame]] = SimpleQueue()
        self._outbox: SimpleQueue[CanFrame] = SimpleQueue()
        self._waiting: list[tuple[float, CanFrame]] = []

    def arrived(self, frame: CanFrame, now: float) -> None:
        """Keep a frame with the world's time of its arrival."""
        self._inbox.put((now - self._epoch, frame))

    def due(self, now: float) -> list[CanFrame]:
        """Return what the servo has said."""
        return drained(self._outbox)

    def exchange(self, begin: float) -> None:
        """Give the servo what has arrived by then, and take what it says."""
        self._waiting += drained(self._inbox)
        while self._waiting and self._waiting[0][0] <= begin:
            self._port.send(self._waiting.pop(0)[1])
        for frame in self._port.receive():
            self._outbox.put(frame)


class ServoFarEndPlugin:
    """The servo behind ``dronecan_servo``."""

    def make(self, config: Options, drive: Drive | None = None) -> ServoFarEnd:
        """Make a servo set up as the driver's options say, at joint angle 0."""
        return ServoFarEnd(ServoNode(config, drive or Drive()))


far_end = ServoFarEndPlugin()
