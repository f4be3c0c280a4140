"""What all browsers share: payloads as they are drawn, orders and settings under way, control, places."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from ross_payload.ground.page.control import Control
from ross_payload.ground.page.hands import Hands
from ross_payload.ground.page.overview import at_once, overview
from ross_payload.ground.page.pictures import Picture, to_json
from ross_payload.ground.page.places import Places
from ross_payload.ground.page.shelf import Flights
from ross_payload.ground.picture.fleet import Fleet
from ross_payload.ground.picture.known import Who
from ross_payload.ground.recordings import RecordingStore
from ross_protocols.codec import Packet

if TYPE_CHECKING:
    from ross_payload.ground.page.tiles import Tiles
    from ross_payload.ground.station import Station

FLEET_PERIOD = 0.5  # [s]
PARAMETERS_PERIOD = 0.25  # [s]
HISTORY_PERIOD = 1.0  # [s]


class Silence:
    """A station without links, for a page that plays past flights only."""

    system_id, component_id = 254, 190

    def __init__(self) -> None:
        self.fleet = Fleet()

    def now(self) -> float:
        """Return the time [s]."""
        return time.monotonic()

    def links(self) -> list[Any]:
        """Return nothing: there are none."""
        return []

    def advice(self) -> str:
        """Return nothing: nothing is wrong."""
        return ""

    def subscribe(self, call: Callable[[Packet, float], None]) -> Callable[[], None]:
        """Never call."""
        return lambda: None

    def send(self, message: Any, who: Who | None = None) -> None:
        """Tell nobody."""


class Hub:
    """One per process; ``wake`` is called when those who watch a payload, or all, may have something to get."""

    def __init__(self, station: Station | Silence, flights: Flights, recordings: RecordingStore | None = None) -> None:
        self.station, self.flights, self.recordings = station, flights, recordings
        self.live = not isinstance(station, Silence)
        self.hands = Hands(station)
        self.control = Control()
        self.places = Places()
        self.tiles: Tiles | None = None  # of a map that the user gave
        self.over = ""  # why no payload is heard any more, as a sentence: its simulation has ended
        self.wake: Callable[[Who | None], None] = lambda who: None
        self.watched: Callable[[], Iterable[Who]] = tuple  # by browsers
        self.fleet_text, self.fleet_version = "", 0
        self._pictures: dict[Who, Picture] = {}
        self._told: Any = None  # what of the fleet is told at once when it changes
        self._told_at = -FLEET_PERIOD  # [s]
        self.close = station.subscribe(self._heard)

    def picture(self, who: Who) -> Picture | None:
        """Return a payload's picture as of now; None: nobody knows it."""
        known = self.station.fleet.payloads.get(who)
        if known is None:
            return None
        picture, settings = self._pictures.setdefault(who, Picture(HISTORY_PERIOD)), self.hands.settings(who)
        picture.draw(known, settings.values)
        doing = self.hands.doing(who)
        picture.offer("orders", doing, lambda: [each.json() for each in doing])
        turn = self.station.now() // PARAMETERS_PERIOD
        picture.offer("parameters", turn, settings.rows)
        picture.offer("parameter_notes", turn, settings.notes)
        return picture

    def heard_ms(self, who: Who) -> int:
        """Return when a payload was last heard, UNIX time [ms]."""
        age = self.station.now() - self.station.fleet.payloads[who].last
        return round((time.time() - age) * 1e3)

    def tick(self) -> None:
        """Do what is due; call it ten times a second, and after every request."""
        now = self.station.now()
        self.hands.tick(now)
        self.control.tick(now)
        commanded = (each.who for each in self.hands.orders.doing)
        self.station.fleet.pinned = frozenset((*self.watched(), *self.places.typed, *commanded))
        told = at_once(self)
        if told != self._told or now - self._told_at >= FLEET_PERIOD:
            self._told, self._told_at = told, now
            self.fleet_text = to_json(overview(self, now))
            self.fleet_version += 1
            self.wake(None)

    def _heard(self, packet: Packet, at: float) -> None:
        who = Who(packet.system_id, packet.component_id)
        self.hands.heard(packet, self.station.fleet.payloads.get(who), at)
        self.wake(who)
