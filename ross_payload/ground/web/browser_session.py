"""One browser: what it watches, what it has been sent, and what it gets next."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Callable
from typing import Any

from ross_payload import __version__
from ross_payload.ground.errors import GroundError
from ross_payload.ground.web.operator import Operator
from ross_payload.ground.web.page_state import PageState
from ross_payload.ground.web.playback_session import PlaybackSession
from ross_payload.ground.web.view_cache import to_json
from ross_protocols.mavlink.component_id import ComponentId

MAX_WAITING = 64  # answers that wait for a browser; older ones are dropped


class BrowserSession:
    """One socket of a browser, from its first message to its last; the id stays when the browser comes again.

    ``proof`` is known to this browser alone; ``cut`` ends the socket without a word.
    """

    def __init__(self, state: PageState, browser: str, name: str, proof: str, cut: Callable[[], None]) -> None:
        self.state, self.id, self.operator = state, browser, Operator(state, browser, name)
        self.cut = cut
        self.wake = asyncio.Event()
        self.obeyed = asyncio.Event()  # what its socket brought, to the end
        self.watched: ComponentId | None = None
        self._seen = 0  # number of the view that was sent
        self._fleet_seen = 0
        self._control_seen = 0
        self._waiting: deque[str] = deque(maxlen=MAX_WAITING)
        self.slots: dict[str, PlaybackSession] = {}
        self._closing: set[asyncio.Task[None]] = set()
        mode = "live" if state.live else "flight"
        tiles = None if state.tiles is None else state.tiles.about
        hello = {
            "you": browser,
            "proof": proof,
            "version": __version__,
            "mode": mode,
            "may_order": state.live,
            "map": tiles,
        }
        self.send({"type": "hello", **hello})

    def watch(self, who: ComponentId | None) -> None:
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
            self.state.flights.path(flight)
        except GroundError as error:
            raise ValueError(error.message) from error
        self.close_flight(name)
        slot = self.slots[name] = PlaybackSession(name, flight, self.wake.set)
        slot.start(lambda: self.state.flights.readable(flight), lambda why: self.refuse("flight", why))

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

    def send(self, message: dict[str, Any]) -> None:
        """Send a message as soon as there is room."""
        self._waiting.append(to_json(message))
        self.wake.set()

    def refuse(self, what: str, reason: str) -> None:
        """Tell why nothing was passed on."""
        self.send({"type": "refused", "what": what, "reason": reason})

    def due(self) -> list[str]:
        """Return what is to be sent now, as of now."""
        texts = list(self._waiting)
        self._waiting.clear()
        if self._control_seen != self.state.control.version:
            self._control_seen = self.state.control.version
            texts.append(to_json({"type": "control", **self.operator.control()}))
        if self._fleet_seen != self.state.fleet_version:
            self._fleet_seen = self.state.fleet_version
            texts.append(self.state.fleet_text)
        return texts + self._payload() + [text for slot in self.slots.values() for text in slot.due()]

    def _payload(self) -> list[str]:
        view = None if self.watched is None else self.state.view(self.watched)
        if self.watched is None or view is None or not (sections := view.since(self._seen)):
            return []
        self._seen = view.number
        times = f'"now":{self.state.station.now():.3f},"sent":{round(time.time() * 1e3)}'
        heard = self.state.last_packet_ms(self.watched)
        head = f'{{"type":"payload","id":"{self.watched}",{times},"heard":{heard}'
        return [f'{head},"sections":{sections}}}']
