"""The router: all links on one side, our own components on the other.

What a component sends goes out on the links and to the other components; what arrives goes to every component.
Everything here happens on the thread that polls, and nothing waits.
"""

from __future__ import annotations

import math
from collections import OrderedDict, deque
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, ExitStack
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Self

from ross_payload.clock import suspended_time
from ross_payload.config import Link as LinkConfig
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Clock
from ross_payload.mavlink.component import Component, Dispatcher, Received
from ross_payload.mavlink.link import Arrived, Channel, LinkStatus
from ross_payload.named_paths import expanded
from ross_payload.transport.link_url import parse
from ross_payload.transport.open_port import open_port
from ross_payload.transport.ports import Transport
from ross_payload.transport.signing import SigningTime, read_key
from ross_protocols.mavlink.codec import Decoder, Encoder, Packet, message_of
from ross_protocols.mavlink.commands import is_stop
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.peers import PRESENT
from ross_protocols.mavlink.signing import Guardian
from ross_protocols.mavlink.vehicle import AUTOPILOT, NO_AUTOPILOT

LOCAL = "local"  # the link and the role of what our own components say
MOST_LOCAL = 1000  # frames that wait for the next poll
MOST_SENT = 4096  # frames that are known again, about ten seconds of three busy links
HEAD, PAYLOAD = 4, 10  # where the sequence number and the payload of a frame begin
HELD_UP = 3.0  # [s] without a poll, after which senders have given up what they ordered meanwhile
CATCHING_UP = 1.0  # [s] after such a pause in which what arrives may have waited
UNKNOWN_SYSTEM = 1  # what we call ourselves towards an autopilot whose system id we wait for


def unix_time() -> float:
    """Return what the system believes the UNIX time to be [s]."""
    return datetime.now(UTC).timestamp()


class SentFrames:
    """The latest frames that went out on any link, whoever has signed them since: to know them when they come back."""

    def __init__(self) -> None:
        self._known: OrderedDict[int, None] = OrderedDict()  # the latest last

    def note(self, frame: bytes) -> None:
        """Remember a frame."""
        mark = _mark(frame)
        self._known[mark] = None
        self._known.move_to_end(mark)  # the same beat comes again after 256 frames
        if len(self._known) > MOST_SENT:
            self._known.popitem(last=False)

    def __contains__(self, frame: bytes) -> bool:
        """Tell whether we have sent a frame: the same sequence number, sender, message and payload."""
        return _mark(frame) in self._known


def _mark(frame: bytes) -> int:
    return hash(frame[HEAD : PAYLOAD + frame[1]])


class Router(AbstractContextManager["Router"]):
    """All links of the payload, for one thread. A context manager."""

    def __init__(
        self,
        clock: Clock,
        system_id: int = 1,
        state: Path | None = None,
        unix: Callable[[], float] = unix_time,
        suspended: Callable[[], float] = suspended_time,
    ) -> None:
        self.system_id = system_id  # 0: until an autopilot tells
        self.dispatcher = Dispatcher()
        self._clock = clock
        self._state = state
        self._unix = unix
        self._signing: SigningTime | None = None
        self._links: list[Channel] = []
        self._components: dict[int, Component] = {}
        self._logs: dict[ComponentId, Encoder] = {}
        self._scale = Encoder(UNKNOWN_SYSTEM, 0)  # tells how long a frame is
        self._decoder = Decoder()  # of what our own components say
        self._local: deque[tuple[int, bytes]] = deque(maxlen=MOST_LOCAL)
        self._sent = SentFrames()
        self._twin: tuple[int, float] | None = None  # component id, when
        self._autopilots: dict[int, tuple[float, float]] = {}  # by system id: heard since when, and last [s]
        self._suspended = suspended
        self._polled = math.inf  # when, on a clock that goes on while the computer is suspended [s]
        self._stale_until = -math.inf  # [s]: what arrives before was perhaps sent long ago
        self._held_up = ""  # why it is not obeyed

    @classmethod
    def open(
        cls,
        links: Iterable[LinkConfig],
        clock: Clock,
        *,
        system_id: int = 1,
        state: Path | None = None,
        patient: bool = False,
    ) -> Self:
        """Open every link, or none; ``patient`` links go on trying to reach a peer that is not there yet.

        ``state`` is the folder in which signed links remember the time.

        Raises
        ------
        ConfigError
            When a URL is malformed or a key cannot be used: before any is opened.
        LinkError
            When a port cannot be opened; those before it are closed again.
        """
        links = list(links)
        for link in links:
            parse(link.url)
        router = cls(clock, system_id, state)
        guardians = [router._guardian(link) for link in links]
        with ExitStack() as stack:
            stack.callback(router.close)
            for link, guardian in zip(links, guardians, strict=True):
                router._add(link, open_port(link.url, clock.now, patient=patient), guardian)
            stack.pop_all()
        return router

    def attach(self, link: LinkConfig, port: Transport) -> None:
        """Add a link whose port was made elsewhere; it is closed with the others.

        Raises
        ------
        ConfigError
            When its key cannot be used.
        """
        self._add(link, port, self._guardian(link))

    def component(self, component_id: int) -> Component:
        """Return our own component with this id; it is made when it is first asked for."""
        if component_id not in self._components:
            self._components[component_id] = Component(component_id, self)
        return self._components[component_id]

    def send(self, component_id: int, content: Any, link: str | None) -> None:
        """Send in the name of a component; see `Component.send`."""
        message, sender = message_of(content), self._own(component_id)
        frame = self._logs.setdefault(sender, Encoder(*sender)).encode(message)
        self._components[component_id].log(frame)
        if len(self._components) > 1:
            self._local.append((component_id, frame))
        self._give(sender, message, len(frame), link)

    def repeat(self, component_id: int, content: Any, link: str) -> None:
        """Send on one link what logs and other local components are told otherwise."""
        message = message_of(content)
        self._give(self._own(component_id), message, len(self._scale.encode(message)), link)

    def poll(self) -> None:
        """Tell the components what has arrived since the last call.

        After a long pause of this program nothing that waited is obeyed but a stop: nobody expects it any more.
        """
        now = self._clock.now()
        polled, self._polled = self._polled, now + self._suspended()
        if self._polled - polled > HELD_UP:
            self._stale_until = now + CATCHING_UP
            self._held_up = f"the payload stood still for {self._polled - polled:.0f} s: send it again"
        for sender, frame in [self._local.popleft() for _ in range(len(self._local))]:
            for packet in self._decoder.feed(frame):
                self.dispatcher.dispatch(Received(LOCAL, LOCAL, packet, may_order=True), but=sender)
        for link in self._links:
            for arrived in link.receive(self._clock.now()):
                self._on_frame(link, arrived)

    @property
    def twin(self) -> int | None:
        """The component id of ours in which somebody else has spoken lately."""
        if self._twin is None or self._clock.now() - self._twin[1] > PRESENT:
            return None
        return self._twin[0]

    @property
    def other_autopilot(self) -> int | None:
        """The system id of an autopilot that has been heard for a while, and ours has not; None: there is none."""
        now = self._clock.now()
        present = {system: since for system, (since, last) in self._autopilots.items() if now - last <= PRESENT}
        if not self.system_id or self.system_id in present:
            return None
        return next((system for system, since in present.items() if now - since > PRESENT), None)

    @property
    def signing_ahead(self) -> str:
        """Why signed peers may be refused in spite of the right key, in words; empty: nothing is known against it."""
        return "" if self._signing is None else self._signing.ahead

    @property
    def trouble(self) -> str:
        """Why signed links obey nothing but a stop, or soon will; empty when they do not."""
        return "" if self._signing is None else self._signing.trouble

    def rates(self) -> dict[str, float]:
        """Return what every link may say in the long run [bytes/s], by its URL; infinite: anything."""
        return {link.config.url: link.rate for link in self._links}

    def claim(self, url: str, size: int, wait: bool) -> bool:
        """Tell whether a link has room for a frame of so many bytes.

        If it is to ``wait``, what repeats itself leaves it the room; it has to be asked again until there is. A link
        that is none of ours, as `LOCAL`, has room for anything.
        """
        now = self._clock.now()
        return all(link.claim(size, now, wait) for link in self._links if link.config.url == url)

    def status(self) -> tuple[LinkStatus, ...]:
        """Return how every link is, in the order of their opening."""
        now = self._clock.now()
        return tuple(link.status(now) for link in self._links)

    def close(self) -> None:
        """Close every link; idempotent."""
        for link in self._links:
            link.close()
        if self._signing is not None:
            self._signing.close()

    def __exit__(self, *error: object) -> None:
        """Close every link."""
        self.close()

    def _guardian(self, link: LinkConfig) -> Guardian | None:
        if not link.key_file:
            return None
        key = read_key(expanded(link.key_file))
        if self._state is None:
            raise ConfigError(f"link '{link.url}': a key_file needs a folder in which to remember the signing time")
        self._signing = self._signing or SigningTime(self._state, self._unix, self._clock.now())
        return Guardian(key, self._signing)

    def _add(self, link: LinkConfig, port: Transport, guardian: Guardian | None) -> None:
        self._links.append(Channel(link, port, self._clock.now(), len(self._links), guardian))

    def _own(self, component_id: int) -> ComponentId:
        return ComponentId(self.system_id or UNKNOWN_SYSTEM, component_id)

    def _give(self, sender: ComponentId, message: Any, size: int, url: str | None) -> None:
        now = self._clock.now()
        for link in self._ways(message, url):
            if frame := link.send(sender, message, size, now):
                self._sent.note(frame)

    def _ways(self, message: Any, url: str | None) -> list[Channel]:
        """Return the links that a message is for."""
        links = [link for link in self._links if url in (None, link.config.url)]
        if not self.system_id:
            links = [link for link in links if link.config.role == "autopilot" and message.get_type() == "HEARTBEAT"]
        system, component = getattr(message, "target_system", 0), getattr(message, "target_component", 0)
        if not system:
            return links
        if system == self.system_id and component in self._components:
            return []
        return [link for link in links if link.knows(system, component)] or links

    def _on_frame(self, link: Channel, arrived: Arrived) -> None:
        now, packet = self._clock.now(), arrived.packet
        if packet.component_id in self._components and self._own(packet.component_id)[0] == packet.system_id:
            if packet.frame not in self._sent:
                link.twins += 1
                self._twin = packet.component_id, now
                if arrived.fresh:
                    link.admit(packet, arrived.peer, now)  # it learns from our answers that there are two of us
            return
        if arrived.fresh:
            link.meet(packet, arrived.peer, now)
        self._latch(link, packet)
        may_order, refusal = link.may_order(arrived), arrived.refusal
        waited = may_order and now < self._stale_until and not is_stop(packet.message)
        if waited:
            may_order, refusal = False, self._held_up
        where = link.config.url, link.config.role
        self.dispatcher.dispatch(Received(*where, packet, may_order, refusal, arrived.peer, waited))

    def _latch(self, link: Channel, packet: Packet) -> None:
        if link.config.role != "autopilot" or packet.component_id != AUTOPILOT or packet.name != "HEARTBEAT":
            return
        if packet.message.autopilot != NO_AUTOPILOT:
            self.system_id = self.system_id or packet.system_id
            now = self._clock.now()
            since, last = self._autopilots.get(packet.system_id, (now, now))
            self._autopilots[packet.system_id] = (since if now - last <= PRESENT else now, now)
