"""One link: its port, its parser, its writer, its budget, and what went through."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from ross_payload.config import Link as LinkConfig
from ross_payload.links.address import Serial, parse
from ross_payload.links.budget import Budget
from ross_payload.links.peers import Peers, Sender
from ross_payload.links.ports import LinkPort
from ross_protocols.codec import Decoder, Encoder, Packet

SERIAL_SHARE = 0.5  # of a serial line's bytes that we may use
BITS_PER_BYTE = 10  # on a serial line: start bit, eight, stop bit


@dataclass(frozen=True, slots=True)
class LinkStatus:
    """How a link is, and what went through it since it was made."""

    url: str
    role: str
    up: bool  # connected, as far as one can know
    room: float  # what the budget allows at this moment [bytes]; inf: anything
    peers: tuple[Sender, ...]  # (system id, component id) heard lately
    sent: int  # frames
    sent_bytes: int
    dropped: int  # frames that had no room, in the budget or in the port
    received: int  # frames
    received_bytes: int
    lost: int  # frames that are missing in the senders' counts
    bad: int  # what began like a frame and had a wrong checksum
    unknown: int  # frames of messages that nobody here knows
    refused: int  # frames whose signature is missing, wrong or old
    reconnects: int
    error: str  # the latest failure of the port, in words


class Link:
    """A port with one parser and one voice per local component."""

    def __init__(self, config: LinkConfig, port: LinkPort, now: float) -> None:
        self.config = config
        self.peers = Peers()
        self._port = port
        self._decoder = Decoder()
        self._encoders: dict[Sender, Encoder] = {}
        self._budget = Budget(rate_of(config), now)
        self._counts = {"sent": 0, "sent_bytes": 0, "dropped": 0, "received": 0, "received_bytes": 0, "refused": 0}

    def send(self, sender: Sender, said: Any, size: int, now: float) -> bytes:
        """Send a value or message that takes ``size`` bytes; return the frame, or nothing when it had no room."""
        if not self._budget.spend(size, now):
            self._counts["dropped"] += 1
            return b""
        frame = self._encoder(sender).encode(said)
        self._port.send(frame)
        self._counts["sent"] += 1
        self._counts["sent_bytes"] += len(frame)
        return frame

    def receive(self, now: float) -> Iterator[Packet]:
        """Give what has arrived and may be believed."""
        for data in self._port.receive():
            self._counts["received_bytes"] += len(data)
            for packet in self._decoder.feed(data):
                self._counts["received"] += 1
                yield packet

    def may_order(self, packet: Packet) -> bool:
        """Tell whether the sender of a packet may order something."""
        return not self.config.accept or packet.system_id in self.config.accept

    def status(self, now: float) -> LinkStatus:
        """Return how the link is."""
        counts, decoder = self._port.counts, self._decoder
        mine = self._counts | {"dropped": self._counts["dropped"] + counts.dropped + counts.failed}
        return LinkStatus(
            url=self.config.url, role=self.config.role, up=counts.up, room=self._budget.room(now),
            peers=self.peers.present(now), lost=self.peers.lost, bad=decoder.bad, unknown=decoder.unknown,
            reconnects=counts.reconnects, error=counts.error, **mine,
        )  # fmt: skip

    def close(self) -> None:
        """Give the port back; idempotent."""
        self._port.close()

    def _encoder(self, sender: Sender) -> Encoder:
        if sender not in self._encoders:
            self._encoders[sender] = Encoder(*sender)
        return self._encoders[sender]


def rate_of(config: LinkConfig) -> float:
    """Return the budget of a link [bytes/s]; 0 is no limit.

    >>> rate_of(LinkConfig(url="serial:/dev/ttyAMA0:57600"))
    2880.0
    """
    if config.max_bytes_s:
        return config.max_bytes_s
    address = parse(config.url)
    return SERIAL_SHARE * address.baud / BITS_PER_BYTE if isinstance(address, Serial) else 0.0
