"""Which payload is watched and commanded in a terminal, which source, and what the keys do."""

from __future__ import annotations

from collections.abc import Callable

from ross_payload.ground.client.command_protocol import CommandProtocol
from ross_payload.ground.client.command_types import Cancel, Explore, Listen, Order, Rearm, Stop
from ross_payload.ground.client.stream_orders import StopStream, Stream
from ross_payload.ground.model.fleet import Fleet
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.model.view import word
from ross_payload.ground.terminal.blocks import SILENT_S, View, safe_view
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId

NOTE_S = 3.0  # for which a note stands
STOPS = ("s", "S", "\x13")  # Shift, caps lock and Ctrl take nothing from a stop
PLACES = tuple("123456789")  # of payloads; a byte of another script's letter may be a digit, too, as chr(0xB2)
HEARING = ("h", "m")  # start live listening, or change what is heard
PLAIN: dict[str, Callable[[], Order]] = {"e": Explore, "v": Listen, "c": Cancel, "r": Rearm, "x": StopStream}
PLAIN |= dict.fromkeys(STOPS, Stop)


class Selection:
    """The payload of a fleet that is watched and commanded: ``wanted``, or else the first one received."""

    def __init__(self, fleet: Fleet, orders: CommandProtocol, wanted: ComponentId | None = None) -> None:
        self.fleet, self.orders, self.wanted = fleet, orders, wanted
        self.now = 0.0

    def on_packet(self, packet: Packet, now: float) -> None:
        """Take every packet that the station receives, for what becomes of commands."""
        self.orders.on_packet(packet, now)

    def tick(self, now: float) -> None:
        """Let time go on."""
        self.now = now
        for known in self.fleet.payloads.values():
            self.orders.on_state(known)
        self.orders.tick(now)

    @property
    def payload(self) -> PayloadState | None:
        """What is known of the payload; None: nothing was received of it."""
        if self.wanted is None:
            self.wanted = next(iter(self.fleet.payloads), None)
        return None if self.wanted is None else self.fleet.payloads.get(self.wanted)

    @property
    def view(self) -> View | None:
        """Its sections."""
        known = self.payload
        return None if known is None else safe_view(known)


class Controller(Selection):
    """Obeys the keys of a terminal; ``hear_at`` is what streams are sent to, address, port and codec."""

    def __init__(
        self,
        fleet: Fleet,
        orders: CommandProtocol,
        wanted: ComponentId | None = None,
        hear_at: tuple[str, int, str] | None = None,
    ) -> None:
        super().__init__(fleet, orders, wanted)
        self.hear_at = hear_at
        self._source: int | None = None
        self._note, self._noted = "", 0.0
        self.going = True

    @property
    def chosen(self) -> int | None:
        """The source that `l` listens to."""
        known = self.payload
        there = known is not None and any(each.source == self._source for each in known.sources)
        return self._source if there else None

    @property
    def others(self) -> list[tuple[str, bool, str]]:
        """Every payload: its name, whether it is this one, its state."""
        return [(str(who), who == self.wanted, self._state(self.fleet.payloads[who])) for who in self._ordered()]

    @property
    def note(self) -> str:
        """Something for the user to know, for a moment."""
        return self._note if self.now - self._noted < NOTE_S else ""

    def press(self, key: str) -> None:
        """Obey a key: one letter, or ``left`` and ``right``."""
        if key in ("q", "\x03", "\x04"):
            self.going = False
        elif key in ("left", "right", "up", "down"):
            self._next(-1 if key in ("left", "up") else 1)
        elif key in PLACES:
            self._choose(int(key))
        elif key in PLAIN or key in HEARING or key == "l":
            self._order(key)

    def _order(self, key: str) -> None:
        if self.payload is None and (key not in STOPS or self.wanted is None):  # who is not heard may hear a stop
            self._notify("no payload to command: no telemetry")
        elif key == "l" and self.chosen is None:
            self._notify("select a source with the arrow keys first; v finds the enrolled voice")
        elif key in HEARING:
            self._hear(key)
        elif self.wanted is not None:
            self.orders.order(self.wanted, Listen(source=self.chosen) if key == "l" else PLAIN[key]())

    def _hear(self, key: str) -> None:
        """Have the mixture, the chosen source or the target sent to where the user listens."""
        if self.hear_at is None or self.wanted is None:
            self._notify("start with --hear-at ADDRESS:PORT to say where you listen")
            return
        address, port, codec = self.hear_at
        what = "mixture" if key == "m" else "target" if self.chosen is None else "source"
        order = Stream(what=what, source=self.chosen or 0, address=address, port=port, codec=codec)
        self.orders.order(self.wanted, order)

    def _next(self, step: int) -> None:
        known = self.payload
        indices = [each.source for each in known.sources] if known is not None else []
        if not indices:
            self._notify("no sources yet")
            return
        chosen = self.chosen
        place = (indices.index(chosen) + step) if chosen is not None else 0 if step > 0 else -1
        self._source = indices[place % len(indices)]

    def _choose(self, place: int) -> None:
        ordered = self._ordered()
        if place > len(ordered):
            self._notify(f"there is no payload {place}")
        else:
            self.wanted, self._source = ordered[place - 1], None

    def _ordered(self) -> list[ComponentId]:
        return sorted(self.fleet.payloads)

    def _state(self, known: PayloadState) -> str:
        if self.now - known.last > SILENT_S:
            return "no telemetry"
        return (word("ROSS_STATE", known.status.state) if known.status else None) or "?"

    def _notify(self, note: str) -> None:
        self._note, self._noted = note, self.now
