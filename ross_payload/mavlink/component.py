"""Our own MAVLink components: what they send, and who is told what arrives for them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

from ross_payload.transport.ports import Peer
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.commands import CancelRequest, Command, command_of
from ross_protocols.mavlink.component_id import ComponentId

Way = tuple[str, Peer]  # the URL of a link, and one of its peers


@dataclass(frozen=True)
class Received:
    """A packet, the link that it came from, and whether its sender may order something."""

    link: str  # url, or "local"
    role: str  # ground, autopilot or local
    packet: Packet
    may_order: bool
    refusal: str = ""  # why nobody may at present
    peer: Peer = None  # of the link, by which it came
    waited: bool = False  # while this program stood still: its sender may have given it up

    @property
    def way(self) -> Way:
        """The link and the peer that it came from: each sender there counts its frames by itself."""
        return self.link, self.peer

    @cached_property
    def request(self) -> Command | CancelRequest | None:
        """The command that it carries, read once for all components; None: it carries none."""
        return command_of(self.packet.message)


OnPacket = Callable[[Received], None]


class Dispatcher:
    """Calls who asked for a message, by its id: component by component, in the order in which these were made."""

    def __init__(self) -> None:
        self._handlers: dict[int, list[tuple[frozenset[int], OnPacket]]] = {}  # by component id; no ids: everything
        self._by_message: dict[int, tuple[tuple[int, OnPacket], ...]] = {}

    def register(self, component_id: int, on_packet: OnPacket | None = None, *message_ids: int) -> None:
        """Give a component its place, and call ``on_packet`` with these messages; without ids with all."""
        handlers = self._handlers.setdefault(component_id, [])
        if on_packet is not None:
            handlers.append((frozenset(message_ids), on_packet))
        self._by_message.clear()

    def dispatch(self, received: Received, but: int | None = None) -> None:
        """Call who asked for a packet, all components ``but`` the one that has sent it."""
        number = received.packet.message.get_msgId()
        if number not in self._by_message:
            self._by_message[number] = tuple(
                (component_id, on_packet)
                for component_id, handlers in self._handlers.items()
                for message_ids, on_packet in handlers
                if not message_ids or number in message_ids
            )
        for component_id, on_packet in self._by_message[number]:
            if component_id != but:
                on_packet(received)


class Network(Protocol):
    """What a component speaks through."""

    system_id: int  # 0: not known yet
    dispatcher: Dispatcher

    def send(self, component_id: int, content: Any, link: str | None) -> None:
        """Send in the name of a component."""

    def repeat(self, component_id: int, content: Any, link: str) -> None:
        """Send on one link what was sent otherwise, too."""


class Component:
    """One of our own components."""

    def __init__(self, component_id: int, network: Network) -> None:
        self.component_id = component_id
        self._network = network
        self._taps: list[Callable[[bytes], None]] = []
        network.dispatcher.register(component_id)

    @property
    def system_id(self) -> int:
        """Our system id; 0: not known yet."""
        return self._network.system_id

    @property
    def id(self) -> ComponentId:
        """Our address at present."""
        return ComponentId(self.system_id, self.component_id)

    def send(self, content: Any, link: str | None = None) -> None:
        """Send a value or one of pymavlink's messages: on every link, or on the one with this URL.

        A message with a target goes to the links where the target was heard, if it was heard at all. Other local
        components hear it too.
        """
        self._network.send(self.component_id, content, link)

    def repeat(self, content: Any, link: str) -> None:
        """Send on the link with this URL what logs and other local components are told otherwise."""
        self._network.repeat(self.component_id, content, link)

    def subscribe(self, on_packet: OnPacket, *message_ids: int) -> None:
        """Call ``on_packet`` with these messages, without ids with all; it must look for whom a packet is meant."""
        self._network.dispatcher.register(self.component_id, on_packet, *message_ids)

    def tap(self, on_frame: Callable[[bytes], None]) -> None:
        """Call ``on_frame`` with every frame that is sent, once and unsigned: for logs."""
        self._taps.append(on_frame)

    def log(self, frame: bytes) -> None:
        """Tell the taps."""
        for on_frame in tuple(self._taps):
            on_frame(frame)
