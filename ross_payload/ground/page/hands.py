"""What this ground station asks of payloads: orders and settings under way, fed with all that is heard."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ross_payload.ground.clients.doing import Doing
from ross_payload.ground.clients.orders import Orders
from ross_payload.ground.clients.settings import Settings
from ross_payload.ground.picture.known import Payload, Who
from ross_protocols.codec import Packet

if TYPE_CHECKING:
    from ross_payload.ground.page.hub import Silence
    from ross_payload.ground.station import Station


class Hands:
    """Parameters of a payload are asked for when `settings` is first called for it, not before."""

    def __init__(self, station: Station | Silence) -> None:
        self._station = station
        self._us = station.system_id, station.component_id
        self.orders = Orders(station.send, *self._us)
        self._settings: dict[Who, Settings] = {}

    def settings(self, who: Who) -> Settings:
        """Return a payload's parameters, as far as they are known."""
        if who not in self._settings:
            self._settings[who] = Settings(self._station.send, who, *self._us)
        return self._settings[who]

    def doing(self, who: Who) -> tuple[Doing, ...]:
        """Return the latest orders to a payload, newest last."""
        return tuple(each for each in self.orders.doing if each.who == who)

    def heard(self, packet: Packet, payload: Payload | None, now: float) -> None:
        """Take a packet, and what is known of its sender."""
        settings = self._settings.get(Who(packet.system_id, packet.component_id))
        if payload is not None:
            self.orders.met(payload)
            if settings is not None:
                settings.met(payload)
        self.orders.heard(packet, now)
        if settings is not None:
            settings.heard(packet, now)

    def tick(self, now: float) -> None:
        """Send again what is not answered."""
        self.orders.tick(now)
        for settings in self._settings.values():
            settings.tick(now)
