"""How an ArduPilot passes on what it hears, after its MAVLink_routing.

A link is learned when anything is heard on it, a component when it is heard. What has a target goes where that
component was heard (of another vehicle or a ground station: any component), the rest to every learned link; nothing
goes back to where it came from, and messages that the autopilot does not know go nowhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega

from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId, target_of

KNOWN = frozenset(ardupilotmega.mavlink_map)  # message ids
NEVER = frozenset((ardupilotmega.MAVLINK_MSG_ID_RADIO, ardupilotmega.MAVLINK_MSG_ID_RADIO_STATUS))


@dataclass(frozen=True, slots=True)
class Way:
    """What becomes of a message."""

    links: tuple[str, ...] = ()  # where it goes on
    ours: bool = False  # whether the autopilot itself is meant


class RoutingTable:
    """The routes of one autopilot, component 1 of its system."""

    def __init__(self, system_id: int) -> None:
        self._own = ComponentId(system_id, 1)
        self._routes: dict[str, set[ComponentId]] = {}

    def way(self, link: str, packet: Packet) -> Way:
        """Learn from a message that was heard on a link; return where it goes."""
        sender = packet.sender
        number = packet.message.get_msgId()
        if number not in KNOWN or sender == self._own:
            return Way()
        self._routes.setdefault(link, set()).add(sender)
        if number in NEVER:
            return Way()
        links = tuple(other for other in self.toward(packet.message) if other != link)
        system, component = target_of(packet.message)
        here = system in (0, self._own.system)
        return Way(links, here and (component in (0, 1) or not links))

    def toward(self, message: Any) -> tuple[str, ...]:
        """Return the links where the target of a message was heard, or all when it has none."""
        system, component = target_of(message)
        return tuple(
            link
            for link, heard in self._routes.items()
            if not system or any(self._matches(system, component, route) for route in heard)
        )

    def _matches(self, system: int, component: int, route: ComponentId) -> bool:
        """Whether a target may be behind a route; of other systems every component is."""
        return route.system == system and (component in (0, route.component) or system != self._own.system)
