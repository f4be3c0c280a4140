"""A ground station whose links a test holds in its hands."""

import time
from collections.abc import Callable
from typing import Any

from ross_payload.ground.links.link import LinkState
from ross_payload.ground.model.fleet import Fleet
from ross_protocols.mavlink.codec import Decoder, Encoder, Packet
from ross_protocols.mavlink.component_id import ComponentId

PAYLOAD = ComponentId(1, 191)
NOTHING_YET = "no telemetry yet"


def link(url: str = "udpin:127.0.0.1:14550", *, up: bool = True, error: str = "") -> LinkState:
    """Return how a link is that has carried little."""
    return LinkState(
        url, up, error, frames=10, bytes=1000, lost=0, bad=0, skipped=0, refused=0, signed=0, strangers=0, peers=1,
        senders=(PAYLOAD,), last=None, frames_s=1.0, bytes_s=100.0, loss=0.0,
    )  # fmt: skip


class HandStation:
    """Hears what a test says, and keeps what it is asked to send; ``later`` [s] sets its clock forward."""

    def __init__(self) -> None:
        self.system_id, self.component_id = 254, 190
        self.fleet, self.later = Fleet(), 0.0
        self.states = [link()]
        self.sent: list[tuple[Any, ComponentId | None]] = []
        self._calls: list[Callable[[Packet, float], None]] = []
        self._encoders: dict[ComponentId, Encoder] = {}
        self._decoder = Decoder()

    def now(self) -> float:
        return time.monotonic() + self.later

    def links(self) -> list[LinkState]:
        return list(self.states)

    def address_towards(self, who: ComponentId) -> str:
        return "127.0.0.1"

    def advice(self) -> str:
        return "" if self.fleet.payloads else NOTHING_YET

    def subscribe(self, call: Callable[[Packet, float], None]) -> Callable[[], None]:
        self._calls.append(call)
        return lambda: self._calls.remove(call)

    def send(self, message: Any, who: ComponentId | None = None) -> None:
        self.sent.append((message, who))

    def say(self, *told: Any, who: ComponentId = PAYLOAD) -> None:
        """Let a payload say something."""
        encoder = self._encoders.setdefault(who, Encoder(who.system, who.component))
        for packet in self._decoder.feed(b"".join(map(encoder.encode, told))):
            at = self.now()
            self.fleet.on_packet(packet, at)
            for call in list(self._calls):
                call(packet, at)
