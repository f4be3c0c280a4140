"""One browser: what it watches, what it has been sent, and what it gets next."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from typing import Any

from ross_payload import __version__
from ross_payload.ground.errors import GroundError
from ross_payload.ground.page.hub import Hub
from ross_payload.ground.page.pictures import to_json
from ross_payload.ground.page.slot import Slot
from ross_payload.ground.picture.known import Who

MOST_WAITING = 64  # answers that wait for a browser; older ones are dropped


class Session:
    """One socket of a browser, from its first message to its last; the id stays when the browser comes again."""

    def __init__(self, hub: Hub, browser: str, name: str) -> None:
        self.hub, self.id, self.name = hub, browser, name
        self.wake = asyncio.Event()
        self.watched: Who | None = None
        self._seen = 0  # number of the picture that was sent
        self._fleet_seen = 0
        self._control_seen = 0
        self._waiting: deque[str] = deque(maxlen=MOST_WAITING)
        self.slots: dict[str, Slot] = {}
        self._closing: set[asyncio.Task[None]] = set()
        mode = "live" if hub.live else "flight"
        tiles = None if hub.tiles is None else hub.tiles.about
        hello = {"you": browser, "version": __version__, "mode": mode, "may_order": hub.live, "map": tiles}
        self.tell({"type": "hello", **hello})

    def watch(self, who: Who | None) -> None:
        """Watch a payload from now on; all of it is sent."""
        self.watched, self._seen = who, 0
        self.wake.set()

    def open_flight(self, name: str, flight: str) -> None:
        """Play a flight in a slot, instead of what is there.

        Raises
        ------
        ValueError
            When there is no such flight.
        """
        try:
            path = self.hub.flights.path(flight)
        except GroundError as error:
            raise ValueError(error.message) from error
        self.close_flight(name)
        slot = self.slots[name] = Slot(name, flight, self.wake.set)
        slot.start(path, lambda why: self.refuse("flight", why))

    def close_flight(self, name: str) -> None:
        """Empty a slot."""
        slot = self.slots.pop(name, None)
        if slot is not None:
            task = asyncio.create_task(slot.close())
            self._closing.add(task)
            task.add_done_callback(self._closing.discard)

    async def close(self) -> None:
        """End all playbacks."""
        for name in list(self.slots):
            self.close_flight(name)
        await asyncio.gather(*self._closing)

    def tell(self, message: dict[str, Any]) -> None:
        """Send a message as soon as there is room."""
        self._waiting.append(to_json(message))
        self.wake.set()

    def refuse(self, what: str, reason: str) -> None:
        """Tell why nothing was passed on."""
        self.tell({"type": "refused", "what": what, "reason": reason})

    def due(self) -> list[str]:
        """Return what is to be sent now, as of now."""
        texts = list(self._waiting)
        self._waiting.clear()
        if self._control_seen != self.hub.control.version:
            self._control_seen = self.hub.control.version
            texts.append(to_json(self._control()))
        if self._fleet_seen != self.hub.fleet_version:
            self._fleet_seen = self.hub.fleet_version
            texts.append(self.hub.fleet_text)
        return texts + self._payload() + [text for slot in self.slots.values() for text in slot.due()]

    def _control(self) -> dict[str, Any]:
        control = self.hub.control
        yours = control.holder == self.id
        return {"type": "control", "holder": control.holder, "name": control.name, "yours": yours}

    def _payload(self) -> list[str]:
        picture = None if self.watched is None else self.hub.picture(self.watched)
        if self.watched is None or picture is None or not (sections := picture.since(self._seen)):
            return []
        self._seen = picture.number
        times = f'"now":{self.hub.station.now():.3f},"sent":{round(time.time() * 1e3)}'
        heard = self.hub.heard_ms(self.watched)
        head = f'{{"type":"payload","id":"{self.watched}",{times},"heard":{heard}'
        return [f'{head},"sections":{sections}}}']
