"""The wire ``mavlink:`` of actuators: the payload's own links, shared with everything else that speaks MAVLink."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from queue import SimpleQueue
from typing import Any

from ross_payload.actuators.wires import open_wire
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Clock, Port
from ross_payload.mavlink import Received, Router
from ross_payload.transport.async_task import drained
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId, target_of
from ross_protocols.mavlink.vehicle import AUTOPILOT

SCHEME = "mavlink:"


@dataclass(frozen=True, slots=True)
class ReceivedPacket:
    """A packet of our own vehicle, or a set-point for its gimbal, and what we are called on it."""

    packet: Packet
    us: ComponentId


class ComponentPort:
    """A port of one of the payload's components: what is sent are messages, what comes in are `ReceivedPacket`.

    What the autopilot says is heard on links of role ``autopilot`` alone, where there is one: on any other somebody
    else may say it. Of other systems, such as ground stations, only what points a gimbal device of our vehicle is
    heard: two managers would fight. `send` belongs to the pump, like the links.

    Raises
    ------
    ConfigError
        When there is no link.
    """

    def __init__(self, links: Router, component_id: int) -> None:
        roles = {link.role for link in links.status()}
        if not roles:
            raise ConfigError('actuator.options.port = "mavlink:": expected at least one [[links]] table, got none')
        self._links = links
        self._role_of_autopilot = roles & {"autopilot"} or roles
        self._component = links.component(component_id)
        self._received: SimpleQueue[ReceivedPacket] = SimpleQueue()
        self._closed = False
        self._component.subscribe(self._on_packet)

    def send(self, frame: Any) -> None:
        """Send one of pymavlink's messages."""
        self._component.send(frame)

    def receive(self) -> list[Any]:
        """Return what has arrived."""
        return list(drained(self._received))

    def close(self) -> None:
        """Hear nothing more; the links stay."""
        self._closed = True

    def _on_packet(self, received: Received) -> None:
        packet, vehicle = received.packet, self._links.system_id
        if self._closed:
            return
        if packet.system_id != vehicle:
            points = packet.name == "GIMBAL_DEVICE_SET_ATTITUDE" and target_of(packet.message).system in (0, vehicle)
            if points:
                self._received.put(ReceivedPacket(packet, self._component.id))
        elif packet.component_id != AUTOPILOT or received.role in self._role_of_autopilot:
            self._received.put(ReceivedPacket(packet, self._component.id))


def opener(links: Router, component_id: int, clock: Clock) -> Callable[[str], Port]:
    """Return what opens the wire of an actuator: ``mavlink:`` shares the links, any other is a plug-in's."""

    def open_port(url: str) -> Port:
        return ComponentPort(links, component_id) if url == SCHEME else open_wire(url, clock)

    return open_port
