"""What a terminal shows and what its keys do: which payload, which source, what was ordered."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ross_payload.ground.clients.orders import Cancel, Explore, Listen, Order, Orders, Rearm, Stop
from ross_payload.ground.monitor.blocks import SILENT
from ross_payload.ground.monitor.clean import clean
from ross_payload.ground.picture.fleet import Fleet
from ross_payload.ground.picture.known import Payload, Who
from ross_payload.ground.picture.view import view, word
from ross_protocols.codec import Packet

NOTED = 3.0  # [s] for which a note stands
STOPS = ("s", "S", "\x13")  # Shift, caps lock and Ctrl take nothing from a stop
PLAIN: dict[str, Callable[[], Order]] = {"e": Explore, "v": Listen, "c": Cancel, "r": Rearm}
PLAIN |= dict.fromkeys(STOPS, Stop)


class Watch:
    """Looks at one payload of a fleet; ``wanted`` is the one to begin with, else the first that is heard."""

    def __init__(self, fleet: Fleet, orders: Orders, wanted: Who | None = None) -> None:
        self._fleet, self.orders = fleet, orders
        self._who = wanted
        self._source: int | None = None
        self._note, self._noted = "", 0.0
        self._now = 0.0
        self.going = True

    def heard(self, packet: Packet, at: float) -> None:
        """Take every packet that the station hears, for the fate of orders."""
        self.orders.heard(packet, at)

    def tick(self, now: float) -> None:
        """Let time go on."""
        self._now = now
        for known in self._fleet.payloads.values():
            self.orders.met(known)
        self.orders.tick(now)

    @property
    def wanted(self) -> Who | None:
        """Whom it looks for; None: anybody."""
        return self._who

    @property
    def payload(self) -> Payload | None:
        """The one that is looked at."""
        known = self._fleet.payloads
        if self._who is None and known:
            self._who = next(iter(known))
        return None if self._who is None else known.get(self._who)

    @property
    def picture(self) -> dict[str, Any] | None:
        """Its sections."""
        known = self.payload
        pictured: dict[str, Any] | None = None if known is None else clean(view(known))
        return pictured

    @property
    def chosen(self) -> int | None:
        """The source that `l` listens to."""
        known = self.payload
        there = known is not None and any(each.source == self._source for each in known.sources)
        return self._source if there else None

    @property
    def others(self) -> list[tuple[str, bool, str]]:
        """Every payload: its name, whether it is this one, its state."""
        return [(str(who), who == self._who, self._state(self._fleet.payloads[who])) for who in self._ordered()]

    @property
    def note(self) -> str:
        """Something for the user to know, for a moment."""
        return self._note if self._now - self._noted < NOTED else ""

    def press(self, key: str) -> None:
        """Obey a key: one letter, or ``left`` and ``right``."""
        if key in ("q", "\x03", "\x04"):
            self.going = False
        elif key in ("left", "right", "up", "down"):
            self._next(-1 if key in ("left", "up") else 1)
        elif key.isdigit() and key != "0":
            self._choose(int(key))
        elif key in PLAIN or key == "l":
            self._order(key)

    def _order(self, key: str) -> None:
        if self.payload is None and (key not in STOPS or self._who is None):  # who is not heard may hear a stop
            self._say("no payload to command: no telemetry")
        elif key == "l" and self.chosen is None:
            self._say("select a source with the arrow keys first; v finds the enrolled voice")
        elif self._who is not None:
            self.orders.order(self._who, Listen(source=self.chosen) if key == "l" else PLAIN[key]())

    def _next(self, step: int) -> None:
        known = self.payload
        indices = [each.source for each in known.sources] if known is not None else []
        if not indices:
            self._say("no sources yet")
            return
        chosen = self.chosen
        place = (indices.index(chosen) + step) if chosen is not None else 0 if step > 0 else -1
        self._source = indices[place % len(indices)]

    def _choose(self, place: int) -> None:
        ordered = self._ordered()
        if place > len(ordered):
            self._say(f"there is no payload {place}")
        else:
            self._who, self._source = ordered[place - 1], None

    def _ordered(self) -> list[Who]:
        return sorted(self._fleet.payloads)

    def _state(self, known: Payload) -> str:
        if self._now - known.last > SILENT:
            return "no telemetry"
        return (word("ROSS_STATE", known.status.state) if known.status else None) or "?"

    def _say(self, note: str) -> None:
        self._note, self._noted = note, self._now
