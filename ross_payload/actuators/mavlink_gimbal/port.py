"""The wire ``mavlink:`` of actuators: the payload's own links, shared with everything else that speaks MAVLink."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import Any

from ross_payload.actuators.wires import open_wire
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Clock, Port
from ross_payload.links import Heard, Links
from ross_protocols.codec import Packet
from ross_protocols.gimbal import Address

SCHEME = "mavlink:"


@dataclass(frozen=True, slots=True)
class Arrived:
    """A packet of our own vehicle, and what we are called on it."""

    packet: Packet
    us: Address


class ComponentPort:
    """A driver's ear and voice as one of the payload's components; frames go out as messages and come in as `Arrived`.

    `send` belongs to the pump, like the links.

    Raises
    ------
    ConfigError
        When there is no link.
    """

    def __init__(self, links: Links, component_id: int) -> None:
        if not links.status():
            raise ConfigError('actuator.options.port = "mavlink:": expected at least one [[links]] table, got none')
        self._links = links
        self._component = links.component(component_id)
        self._arrived: SimpleQueue[Arrived] = SimpleQueue()
        self._closed = False
        self._component.subscribe(self._hear)

    def send(self, frame: Any) -> None:
        """Send one of pymavlink's messages."""
        self._component.send(frame)

    def receive(self) -> list[Any]:
        """Return what has arrived."""
        arrived = []
        try:
            while True:
                arrived.append(self._arrived.get_nowait())
        except Empty:
            return arrived

    def close(self) -> None:
        """Hear nothing more; the links stay."""
        self._closed = True

    def _hear(self, heard: Heard) -> None:
        if not self._closed and heard.packet.system_id == self._links.system_id:
            self._arrived.put(Arrived(heard.packet, (self._links.system_id, self._component.id)))


def opener(links: Links, component_id: int, clock: Clock) -> Callable[[str], Port]:
    """Return what opens the wire of an actuator: ``mavlink:`` shares the links, any other is a plug-in's."""

    def open_port(url: str) -> Port:
        return ComponentPort(links, component_id) if url == SCHEME else open_wire(url, clock)

    return open_port
