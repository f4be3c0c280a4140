"""What is said to the servo on a CAN bus, and what is heard of it and of others.

One program is one node on a bus: where the payload already has one there, the driver speaks through it; else it is one.
"""

from __future__ import annotations

import logging
import math
from collections import Counter, defaultdict
from dataclasses import dataclass
from typing import Any

from ross_payload.actuators.dronecan_servo.diagnostics import LATE_REPORT_S, BusTraffic, DuplicateIdDetector
from ross_payload.actuators.dronecan_servo.node_info import NodeInfoQuery, own_node
from ross_payload.actuators.dronecan_servo.options import Options
from ross_payload.angles import wrap
from ross_payload.dronecan.node import Node
from ross_payload.dronecan.shared_bus import node_of
from ross_payload.errors import LinkError
from ross_payload.interfaces import Port
from ross_protocols.dronecan import messages
from ross_protocols.dronecan.gimbal_messages import AngularCommand, GimbalStatus
from ross_protocols.dronecan.node_messages import Decoder

ALIVE_TIMEOUT_S = 2.5  # since the last NodeStatus of the servo, and it still lives [s]
LOG_LEVELS = (logging.DEBUG, logging.INFO, logging.WARNING, logging.ERROR)
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class PositionReport:
    """A report of the servo."""

    joint: float = math.nan  # joint angle [rad]; not-a-number: the servo does not say
    time: float = -math.inf  # of the report [s]
    count: int = 0  # of the report, modulo 32


class SharedPort:
    """The port of our own node: it reads what the driver has read."""

    def __init__(self, port: Port) -> None:
        self._port = port
        self._arrived: list[Any] = []

    def read(self) -> list[Any]:
        """Read the bus."""
        self._arrived = self._port.receive()
        return self._arrived

    def send(self, frame: Any) -> None:
        """Send a frame."""
        self._port.send(frame)

    def receive(self) -> list[Any]:
        """Return what was read last."""
        return self._arrived

    def close(self) -> None:
        """Leave the bus."""
        self._port.close()


class ServoClient:
    """Sends commands; keeps what the servo says and what is wrong.

    Parameters
    ----------
    options : Options
        Whose servo it is, and who we are.
    port : Port
        The bus.
    now : float
        When it starts [s].
    joint : float
        Where it was last [rad]: a gimbal counts no turns.
    """

    def __init__(self, options: Options, port: Port, now: float, joint: float = 0.0) -> None:
        self._options = options
        self._port = port
        self._shared_port = SharedPort(port)
        self._own = own_node(options, self._shared_port, now)
        self._decoder = Decoder(0)
        self._traffic = BusTraffic()
        self._duplicates: defaultdict[type[messages.Message], DuplicateIdDetector] = defaultdict(DuplicateIdDetector)
        self._start = now
        self._last_joint = joint  # the last that was reported [rad]
        self._uptime: int | None = None  # of the servo [s]
        self._alive = -math.inf  # its last NodeStatus [s]
        self._last_log = ""
        self._named = False  # we had a node id
        self._info_query = NodeInfoQuery(options.node_id)
        self.report = PositionReport()
        self.heard_at = -math.inf  # any report of the servo [s]
        self.condition = ""  # of the servo, as it says itself
        self.event = ""  # what happened on the bus and is not undone by itself; whoever reads it clears it
        self.lost = False  # likewise: a set-point would make it jump, or fight with somebody

    @property
    def _node(self) -> Node:
        """Through whom we speak."""
        return node_of(self._port) or self._own

    @property
    def identity(self) -> str:
        """Who the servo says it is."""
        return self._info_query.identity

    @property
    def only_beats(self) -> bool:
        """Whether it has said nothing so far but that it lives, once a second."""
        return math.isinf(self.report.time)

    @property
    def nameless(self) -> str:
        """Why we cannot speak, in words; empty: we have a node id."""
        return "" if self._node.id else self._node.trouble or "waiting for a node id"

    def read(self, now: float) -> None:
        """Read the bus.

        Raises
        ------
        LinkError
            When it is down.
        """
        frames = [frame for frame in self._shared_port.read() if frame.extended]
        if self._node is self._own:
            self._own.poll(now)
        for frame in frames:
            received = self._decoder.feed(frame)
            if isinstance(received, messages.Received):
                self._on_message(received, now)
        self._info_query.on_frames(frames)
        if not math.isinf(self.heard_at):
            self._info_query.poll(self._node, now)
        senders = Counter(frame.id & 0x7F for frame in frames)
        self._traffic.update(now, senders, self._decoder.broken[self._options.node_id])
        late = now - max(self.heard_at, self._start) > (ALIVE_TIMEOUT_S if self.only_beats else LATE_REPORT_S)
        self.event = self.event or self._traffic.damage or (self._traffic.full if late else "")
        if self._named and self.nameless:
            self.event, self.lost = self.nameless, True
        self._named = not self.nameless

    def missing(self, now: float) -> str:
        """Say that the servo lives but reports nothing; empty when it does, or when nothing is heard of it."""
        silent = now - max(self.report.time, self._start) > ALIVE_TIMEOUT_S
        if not silent or now - self._alive > ALIVE_TIMEOUT_S:
            return ""
        what = f"{'gimbal' if self._options.command == 'gimbal' else 'actuator'} {self._options.number}"
        quiet = f"node {self._options.node_id} is online but sends no Status of {what}"
        return f"{quiet}; set feedback = 'model' if it never does"

    def command(self, joint: float) -> None:
        """Tell the servo its joint angle [rad].

        Raises
        ------
        LinkError
            When the bus does not take it.
        """
        if not self._node.send(self._options.message(joint)):
            raise LinkError(self._node.trouble or "a set-point was sent without a node id")

    def close(self) -> None:
        """Say that we leave, where nobody stays, and leave."""
        if self._node is self._own:
            self._own.close()
        else:
            self._port.close()

    def _on_message(self, received: messages.Received, now: float) -> None:
        node, message, number = received.node, received.message, self._options.number
        if isinstance(message, messages.ArrayCommand | AngularCommand):
            if self._commands_ours(message):
                self.event, self.lost = f"node {node} commands actuator {number} too", True
        elif node == self._options.node_id:
            if self._duplicates[type(message)].update(received.transfer):
                self.event = f"another node has the servo's id {node}"
            self._on_servo_message(message, received.transfer, now)
        elif self._is_report(message):
            self.event = (
                f"actuator {number}: expected reports of node {self._options.node_id} alone, got node {node}'s too"
            )

    def _commands_ours(self, message: messages.ArrayCommand | AngularCommand) -> bool:
        gimbal, number = self._options.command == "gimbal", self._options.number
        if isinstance(message, AngularCommand):
            return gimbal and message.gimbal_id == number
        return not gimbal and any(command.actuator_id == number for command in message.commands)

    def _is_report(self, message: messages.Message) -> bool:
        gimbal, number = self._options.command == "gimbal", self._options.number
        if isinstance(message, GimbalStatus):
            return gimbal and message.gimbal_id == number
        return isinstance(message, messages.Status) and not gimbal and message.actuator_id == number

    def _on_servo_message(self, message: messages.Message, count: int, now: float) -> None:
        if isinstance(message, messages.Status | GimbalStatus):
            if self._is_report(message):
                self.report, self.heard_at = PositionReport(self._joint(message), now, count), now
        elif isinstance(message, messages.NodeStatus):
            self._on_node_status(message)
            self.heard_at = self._alive = now
        elif isinstance(message, messages.LogMessage) and message.text != self._last_log:
            self._last_log = message.text
            log.log(LOG_LEVELS[min(message.level, 3)], "servo: %s: %s", message.source, message.text)

    def _joint(self, report: messages.Status | GimbalStatus) -> float:
        """Return the joint angle of a report [rad]; a gimbal counts no turns, so the nearest one is meant."""
        if isinstance(report, messages.Status):
            return self._options.joint_at(report.position) if math.isfinite(report.position) else math.nan
        if not math.isfinite(report.yaw):
            return math.nan
        joint = self._last_joint + wrap(self._options.joint_at(report.yaw) - self._last_joint)
        self._last_joint = joint if math.isfinite(self.report.joint) else self._inside(joint)
        return self._last_joint

    def _inside(self, joint: float) -> float:
        """Return the turn inside the travel that is nearest to a joint angle [rad], where one is.

        While nobody listened the gimbal can have been turned by hand.
        """
        options = self._options
        lower, upper = math.radians(options.lower_deg), math.radians(options.upper_deg)
        if not lower - math.radians(options.max_lag_deg) <= joint <= upper + math.radians(options.max_lag_deg):
            turns = (joint - 2 * math.pi, joint + 2 * math.pi)
            return next((turn for turn in turns if lower <= turn <= upper), joint)
        return joint

    def _on_node_status(self, status: messages.NodeStatus) -> None:
        if self._uptime is not None and status.uptime < self._uptime:
            what = f"the servo restarted after {self._uptime} s, or another node has the servo's id"
            self.event, self.lost = f"{what}: its position is uncertain", True
        self._uptime = status.uptime
        self.condition = ""
        if status.mode is not messages.Mode.OPERATIONAL or status.health >= messages.Health.ERROR:
            health, mode = (word.name.lower().replace("_", " ") for word in (status.health, status.mode))
            code = f", code {status.vendor_code}" if status.vendor_code else ""
            self.condition = f"the servo reports: health {health}, mode {mode}{code}"
