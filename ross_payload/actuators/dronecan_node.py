"""The payload as a node on a CAN bus, and what it hears there of the servo and of others."""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass

from ross_payload.actuators.dronecan_options import Options
from ross_payload.errors import LinkError
from ross_payload.interfaces import Port
from ross_protocols.dronecan import (
    ArrayCommand,
    Assembler,
    Command,
    Health,
    LogMessage,
    Message,
    Mode,
    NodeStatus,
    Sender,
    Status,
)

BEAT = 1.0  # [s] between two NodeStatus of ours
LEVELS = (logging.DEBUG, logging.INFO, logging.WARNING, logging.ERROR)
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Place:
    """A report of the servo."""

    joint: float = math.nan  # joint angle [rad]; not-a-number: the servo does not say
    time: float = -math.inf  # of the report [s]


class Node:
    """Sends commands and heartbeats; keeps what the servo says and what is wrong.

    Parameters
    ----------
    options : Options
        Whose servo it is, and who we are.
    port : Port
        The bus.
    now : float
        When the node starts [s].
    """

    def __init__(self, options: Options, port: Port, now: float) -> None:
        self._options = options
        self._port = port
        self._sender = Sender(options.own_node_id)
        self._assembler = Assembler()
        self._start = self._next_beat = now
        self._uptime: int | None = None  # of the servo [s]
        self._said = ""
        self.place = Place()
        self.heard = -math.inf  # any report of the servo [s]
        self.condition = ""  # of the servo, as it says itself
        self.event = ""  # what happened on the bus and is not undone by itself; whoever reads it clears it
        self.restarted = False  # likewise

    def take_in(self, now: float) -> None:
        """Read the bus."""
        for frame in self._port.receive():
            if frame.extended and frame.id & 0x7F == self._options.own_node_id:
                self.event = f"another node on the bus has our node id {self._options.own_node_id}"
                continue
            received = self._assembler.feed(frame)
            if received is not None:
                self._take(received.node, received.message, now)

    def beat(self, now: float) -> None:
        """Tell the others that we live, once a second."""
        if now >= self._next_beat - 1e-6:
            self._next_beat = now + BEAT
            self._send(NodeStatus(int(now - self._start)))

    def command(self, joint: float) -> None:
        """Tell the servo its joint angle [rad]."""
        options = self._options
        self._send(ArrayCommand((Command(options.actuator_id, options.kind, options.value(joint)),)))

    def close(self) -> None:
        """Say that we leave, where the bus still takes it, and leave."""
        try:
            self._send(NodeStatus(0, mode=Mode.OFFLINE))
        except LinkError as error:
            log.warning("%s", error)
        self._port.close()

    def _send(self, message: Message) -> None:
        for frame in self._sender.frames(message):
            self._port.send(frame)

    def _take(self, node: int, message: Message, now: float) -> None:
        number = self._options.actuator_id
        if isinstance(message, ArrayCommand):
            if any(command.actuator_id == number for command in message.commands):
                self.event = f"node {node} commands actuator {number} too"
        elif node == self._options.node_id:
            self._take_of_servo(message, now)
        elif isinstance(message, Status) and message.actuator_id == number:
            self.event = f"node {node} reports as actuator {number} too; wanted node {self._options.node_id}"

    def _take_of_servo(self, message: Message, now: float) -> None:
        if isinstance(message, Status) and message.actuator_id == self._options.actuator_id:
            finite = math.isfinite(message.position)
            self.place = Place(self._options.joint_at(message.position) if finite else math.nan, now)
            self.heard = now
        elif isinstance(message, NodeStatus):
            self._take_status(message)
            self.heard = now
        elif isinstance(message, LogMessage) and message.text != self._said:
            self._said = message.text
            log.log(LEVELS[min(message.level, 3)], "servo: %s: %s", message.source, message.text)

    def _take_status(self, status: NodeStatus) -> None:
        if self._uptime is not None and status.uptime < self._uptime:
            self.event = f"the servo restarted after {self._uptime} s: where it stands is in doubt"
            self.restarted = True
        self._uptime = status.uptime
        self.condition = ""
        if status.mode is not Mode.OPERATIONAL or status.health >= Health.ERROR:
            health, mode = (word.name.lower().replace("_", " ") for word in (status.health, status.mode))
            code = f", code {status.vendor_code}" if status.vendor_code else ""
            self.condition = f"the servo says: health {health}, mode {mode}{code}"
