"""What all browsers share: views of the payloads, commands and parameters under way, control, positions."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import Any

from ross_payload.ground.client.command_protocol import CommandProtocol
from ross_payload.ground.client.command_status import CommandStatus
from ross_payload.ground.client.command_types import Stop
from ross_payload.ground.client.param_client import ParamClient
from ross_payload.ground.client.streams import Wakeup
from ross_payload.ground.errors import GroundError
from ross_payload.ground.model.fleet import Fleet
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.recordings import RecordingStore
from ross_payload.ground.station import Station
from ross_payload.ground.web.flight_library import FlightLibrary
from ross_payload.ground.web.overview import overview
from ross_payload.ground.web.positions import Positions
from ross_payload.ground.web.tiles import Tiles
from ross_payload.ground.web.view_cache import ViewCache, to_json
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId

FLEET_PERIOD_S = 0.5
PARAMETERS_PERIOD_S = 0.25
HISTORY_PERIOD_S = 1.0
CONTROL_GRACE_S = 10.0  # that control waits for a browser that went, to come back


class NoStation:
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

    def address_towards(self, who: ComponentId) -> str:
        """Refuse: nobody is heard."""
        raise GroundError(f"{who} was not heard: nobody knows the way to it")

    def advice(self) -> str:
        """Return nothing: nothing is wrong."""
        return ""

    def subscribe(self, call: Callable[[Packet, float], None]) -> Callable[[], None]:
        """Never call."""
        return lambda: None

    def send(self, message: Any, who: ComponentId | None = None) -> None:
        """Send to nobody."""


class Control:
    """Who may command: one browser at a time; whoever wants may acquire it, and all see it at once.

    ``holder`` is the id of that browser; ``version`` grows with every change.

    >>> control = Control()
    >>> control.may_order("a1", "chrome"), control.may_order("b2", "firefox"), control.name
    (True, False, 'chrome')
    """

    def __init__(self) -> None:
        self.holder: str | None = None
        self.name: str | None = None
        self.version = 1
        self._gone: float | None = None  # since when the holder is not there [s]

    def may_order(self, browser: str, name: str) -> bool:
        """Whether a browser may command; it acquires control when nobody has it."""
        if self.holder is None:
            self.acquire(browser, name)
        return self.holder == browser

    def acquire(self, browser: str | None, name: str | None) -> None:
        """Give control to a browser, whoever had it; None: to nobody."""
        self.holder, self.name, self._gone = browser, name, None
        self.version += 1

    def release(self, browser: str) -> None:
        """Free control when this browser has it."""
        if self.holder == browser:
            self.acquire(None, None)

    def on_disconnect(self, browser: str, now: float) -> None:
        """Notice that a browser is not there any more."""
        if self.holder == browser:
            self._gone = now

    def on_connect(self, browser: str) -> None:
        """Notice that a browser is there again."""
        if self.holder == browser:
            self._gone = None

    def tick(self, now: float) -> None:
        """Free control when its holder has been away for too long."""
        if self._gone is not None and now - self._gone > CONTROL_GRACE_S:
            self.acquire(None, None)


class CommandClient:
    """Commands and parameters under way; parameters are asked for when `settings` is first called for a payload."""

    def __init__(self, station: Station | NoStation) -> None:
        self._station = station
        self._us = station.system_id, station.component_id
        self.orders = CommandProtocol(station.send, *self._us)
        self._settings: dict[ComponentId, ParamClient] = {}

    def settings(self, who: ComponentId) -> ParamClient:
        """Return a payload's parameters, as far as they are known."""
        if who not in self._settings:
            self._settings[who] = ParamClient(self._station.send, who, *self._us)
        return self._settings[who]

    def values(self, who: ComponentId) -> dict[str, float]:
        """Return a payload's parameters as far as somebody has asked for them."""
        return self._settings[who].values if who in self._settings else {}

    def doing(self, who: ComponentId) -> tuple[CommandStatus, ...]:
        """Return the latest commands to a payload, newest last."""
        return tuple(each for each in self.orders.doing if each.who == who)

    def on_packet(self, packet: Packet, payload: PayloadState | None, now: float) -> None:
        """Take a packet, and what is known of its sender."""
        settings = self._settings.get(packet.sender)
        if payload is not None:
            self.orders.on_state(payload)
            if settings is not None:
                settings.on_state(payload)
        self.orders.on_packet(packet, now)
        if settings is not None:
            settings.on_packet(packet, now)

    def tick(self, now: float) -> None:
        """Send again what is not answered."""
        self.orders.tick(now)
        for settings in self._settings.values():
            settings.tick(now)


class PageState:
    """One per process; ``wake`` is called when those who watch a payload, or all, may have something to get."""

    def __init__(
        self, station: Station | NoStation, flights: FlightLibrary, recordings: RecordingStore | None = None
    ) -> None:
        self.station, self.flights, self.recordings = station, flights, recordings
        self.live = not isinstance(station, NoStation)
        self.client = CommandClient(station)
        self.control = Control()
        self.positions = Positions()
        self.tiles: Tiles | None = None  # of a map that the user gave
        self.over = ""  # why no payload is heard any more, as a sentence: its simulation has ended
        self.pace = ""  # how fast simulated time goes, as a sentence, where that is not as the clock
        self.wake: Callable[[ComponentId | None], None] = lambda who: None
        self.watched: Callable[[], Iterable[ComponentId]] = tuple  # by browsers
        self.changed = Wakeup()  # of programs that wait until something holds
        self.fleet_text, self.fleet_version = "", 0
        self._views: dict[ComponentId, ViewCache] = {}
        self._sent: Any = None  # what of the fleet is sent at once when it changes
        self._sent_at = -FLEET_PERIOD_S  # [s]
        self._end = station.subscribe(self._on_packet)

    def close(self) -> None:
        """Hear no more, and let nobody wait any longer."""
        self._end()
        self.changed.close()

    def view(self, who: ComponentId) -> ViewCache | None:
        """Return a payload's view as of now; None: nobody knows it."""
        known = self.station.fleet.payloads.get(who)
        if known is None:
            return None
        view, settings = self._views.setdefault(who, ViewCache(HISTORY_PERIOD_S)), self.client.settings(who)
        view.update(known, settings.values)
        doing = self.client.doing(who)
        view.offer("orders", doing, lambda: [each.json() for each in doing])
        turn = self.station.now() // PARAMETERS_PERIOD_S
        view.offer("parameters", turn, settings.rows)
        view.offer("parameter_notes", turn, settings.notes)
        return view

    def last_packet_ms(self, who: ComponentId) -> int:
        """Return when a payload was last heard, UNIX time [ms]."""
        age = self.station.now() - self.station.fleet.payloads[who].last
        return round((time.time() - age) * 1e3)

    def tick(self) -> None:
        """Do what is due; call it ten times a second, and after every request."""
        now = self.station.now()
        self.client.tick(now)
        self.control.tick(now)
        commanded = (each.who for each in self.client.orders.doing)
        self.station.fleet.pinned = frozenset((*self.watched(), *self.positions.typed, *commanded))
        urgent = self._urgent()
        if urgent != self._sent or now - self._sent_at >= FLEET_PERIOD_S:
            self._sent, self._sent_at = urgent, now
            told = overview(self.station.fleet, self.station.links(), self.positions, now)
            advice = "" if self.over else self.station.advice()
            about = {**self._stops(), "advice": advice, "over": self.over, "pace": self.pace}
            self.fleet_text = to_json({**told, **about})
            self.fleet_version += 1
            self.wake(None)
        self.changed.wake()

    def _stops(self) -> dict[str, Any]:
        """Return to whom a stop is being sent, and the latest stop of each payload."""
        stops = {each.who: each.json() for each in self.client.orders.doing if isinstance(each.order, Stop)}
        stopping = [str(who) for who in sorted(self.client.orders.stopping)]
        return {"stopping": stopping, "stops": list(stops.values())}

    def _urgent(self) -> Any:
        """Return what is sent as soon as it changes; the rest can wait."""
        payloads = self.station.fleet.payloads.values()
        states = [(each.who, each.boots, each.twin, each.state) for each in payloads]
        links = [(each.url, each.up, each.error) for each in self.station.links()]
        return (
            states,
            links,
            self.control.version,
            self.client.orders.doing,
            dict(self.positions.typed),
            self.over,
            self.pace,
        )

    def _on_packet(self, packet: Packet, at: float) -> None:
        who = packet.sender
        self.client.on_packet(packet, self.station.fleet.payloads.get(who), at)
        self.wake(who)
        self.changed.wake()
