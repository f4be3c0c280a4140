"""The firmware of a simulated DroneCAN servo or gimbal: a node that obeys commands and reports where it is."""

from __future__ import annotations

import hashlib
import math
from typing import Any

from ross_payload.actuators.dronecan_servo.options import Options
from ross_payload.angles import wrap
from ross_payload.dronecan.allocatee import Allocatee
from ross_protocols.can import CanFrame
from ross_protocols.dronecan.gimbal_messages import AngularCommand, GimbalMode, GimbalStatus
from ross_protocols.dronecan.messages import (
    Allocation,
    ArrayCommand,
    CommandKind,
    Health,
    Mode,
    NodeStatus,
    Received,
    Status,
)
from ross_protocols.dronecan.node_messages import Call, Decoder, Encoder
from ross_protocols.dronecan.services import MAGIC, NodeInfo, NodeInfoRequest, RestartRequest, RestartResponse
from ross_sim.devices.bus_nodes import EARLY
from ross_sim.devices.servo_shaft import STEP, Shaft

NAME = "org.ross.servo"
REPORT, BEAT = 0.020, 1.0  # [s] between two reports, two NodeStatus


class ServoNode:
    """Obeys commands for its actuator, reports where its encoder says it is, tells who it is and boots on request.

    Parameters
    ----------
    options : Options
        How the driver believes the servo to be set up; it is.
    shaft : Shaft
        Motor, load and encoder.
    fixed : bool
        Its node id is set in it; else it asks an allocator for that one.
    """

    def __init__(self, options: Options, shaft: Shaft, *, fixed: bool = True) -> None:
        self.shaft = shaft
        self.health = Health.OK
        self.mode = Mode.OPERATIONAL
        self.silent = False
        self._options = options
        self._fixed = fixed
        self._unique = hashlib.blake2b(f"{NAME} {options.number}".encode(), digest_size=16).digest()
        self._goal: float | None = None  # of the shaft [rad]
        self._answers: list[CanFrame] = []
        self._now = self._next_report = 0.0
        self.restart()

    def on_frame(self, frame: CanFrame) -> None:
        """Hear a frame of somebody else."""
        match self._ear.feed(frame):
            case Received(node, Allocation() as told) if not self.node_id:
                self._adopt(self._allocatee.on_allocation(node, told, self._now) or 0)
            case Received(_, message):
                self._command(message)
            case Call() as call:
                self._answer(call)

    def live(self, until: float) -> list[CanFrame]:
        """Live until ``until`` [s]; return what is said then."""
        for _ in range(round((until - self._now) / STEP)):
            self.shaft.live(self._goal)
        self._now = until
        frames, self._answers = self._answers, []
        frames += self._due() if self.node_id else self._ask()
        return [] if self.silent else frames

    def restart(self) -> None:
        """Reset the firmware: without torque until a command comes, uptime 0."""
        self._goal = None
        self._answers = []
        self._started = self._next_beat = self._now
        self._asked = 0
        self._allocatee = Allocatee(self._unique, self._options.node_id, self.shaft.chance, self._now)
        self._adopt(self._options.node_id if self._fixed else 0)

    def boot(self, now: float) -> None:
        """Begin to live at ``now`` [s]."""
        self._now = self._next_report = now
        self.restart()

    def joint(self) -> float:
        """Return the true joint angle [rad]."""
        return self._options.joint_at(self.shaft.turned + self._zero)

    # ------------------------------------------------------------------------------------- on the bus

    def _adopt(self, node_id: int) -> None:
        self.node_id = node_id  # 0: it has none yet
        self._voice, self._ear = Encoder(node_id), Decoder(node_id)

    def _ask(self) -> list[CanFrame]:
        """Ask for a node id, when it is time for it."""
        ask = self._allocatee.due(self._now)
        if ask is None:
            return []
        self._asked += 1
        return [ask.asked(self._allocatee.discriminator, self._asked)]

    def _due(self) -> list[CanFrame]:
        messages: list[Any] = []
        if self._now >= self._next_report - EARLY:
            self._next_report = self._now + REPORT
            messages.append(self._report())
        if self._now >= self._next_beat - EARLY:
            self._next_beat = self._now + BEAT
            messages.append(self._status())
        return [frame for message in messages for frame in self._voice.broadcast(message)]

    def _answer(self, call: Call) -> None:
        match call.request:
            case NodeInfoRequest():
                info = NodeInfo(self._status(), NAME, self._unique, (1, 0), (1, 0))
                self._answers += self._voice.response(call, info)
            case RestartRequest(magic):
                answer = self._voice.response(call, RestartResponse(magic == MAGIC))
                if magic == MAGIC:
                    self.restart()
                self._answers += answer

    def _status(self) -> NodeStatus:
        return NodeStatus(int(self._now - self._started), self.health, self.mode)

    # ------------------------------------------------------------------------------------- its actuator

    @property
    def _gimbal(self) -> bool:
        return self._options.command == "gimbal"

    @property
    def _zero(self) -> float:
        """Position that it reports at joint angle 0 [rad]."""
        return math.radians(self._options.zero_position_deg)

    def _command(self, message: Any) -> None:
        match message:
            case ArrayCommand(commands) if not self._gimbal:
                wanted = self._options.number, CommandKind[self._options.command.upper()]
                for command in commands:
                    if (command.actuator_id, command.kind) == wanted:
                        self._obey(self._options.joint_of(command.value))
            case AngularCommand(number, yaw, GimbalMode.BODY_FRAME) if self._gimbal and number == self._options.number:
                self._obey(self._nearest(self._options.joint_of(yaw)))

    def _obey(self, joint: float) -> None:
        """Take a joint angle [rad] for its goal; the shaft stands at 0 when the joint does."""
        if math.isfinite(joint):
            self._goal = joint * self._options.gear_ratio

    def _nearest(self, joint: float) -> float:
        """Return the turn of a joint angle [rad] that is nearest to the goal before, or to where it stands."""
        before = (self.shaft.measured if self._goal is None else self._goal) / self._options.gear_ratio
        return before + wrap(joint - before)

    def _report(self) -> Status | GimbalStatus:
        known = self._options.feedback == "measured"
        position = self.shaft.reported + self._zero if known else math.nan
        if self._gimbal:
            return GimbalStatus(self._options.number, position)
        return Status(self._options.number, position, speed=self.shaft.rate if known else math.nan)
