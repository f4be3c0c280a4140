"""A hub of links on wires that a test holds in its hands, or on real ones, and what is said over them."""

from typing import Any

from clocks import FakeClock
from ross_payload.clock import SystemClock
from ross_payload.config import Link
from ross_payload.mavlink import LinkStatus, Received, Router
from ross_payload.transport.ports import Counts
from ross_protocols.mavlink.codec import Decoder, Encoder, Packet
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.values import Health, Heartbeat

BEAT = Heartbeat(Health.ACTIVE, 6)
VEHICLE = common.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3)
ATTITUDE = common.MAVLink_attitude_message(0, 0.1, 0.2, 0.3, 0, 0, 0)
GROUND = Link(url="udpin::14550")
PILOT = Link(url="serial:/dev/ttyAMA0:57600", role="autopilot")


class Wire:
    """The far end of a link."""

    def __init__(self) -> None:
        self.counts = Counts()
        self.coming: list[bytes] = []
        self.sent: list[bytes] = []
        self.open = True

    def send(self, frame: bytes) -> None:
        self.sent.append(frame)

    def receive(self) -> list[bytes]:
        coming, self.coming = self.coming, []
        return coming

    def close(self) -> None:
        self.open = False

    def packets(self) -> list[Packet]:
        return Decoder().feed(b"".join(self.sent))


class Bench:
    """A hub with wires named by their URLs, and what its component 191 hears."""

    def __init__(self, *links: Link, system_id: int = 1) -> None:
        self.clock = FakeClock()
        self.suspended = 0.0  # the computer, so far [s]
        self.links = Router(self.clock, system_id, suspended=lambda: self.suspended)
        self.wires = {link.url: Wire() for link in links}
        for link in links:
            self.links.attach(link, self.wires[link.url])
        self.payload = self.links.component(191)
        self.heard: list[Received] = []
        self.payload.subscribe(self.heard.append)

    def say(self, url: str, message: Any, system: int = 1, component: int = 1, sequence: int = 0) -> None:
        """Let somebody at the far end speak, and poll."""
        encoder = Encoder(system, component)
        encoder._mavlink.seq = sequence
        self.hear(url, encoder.encode(message))

    def hear(self, url: str, data: bytes) -> None:
        self.wires[url].coming.append(data)
        self.links.poll()

    def names(self) -> list[str]:
        return [heard.packet.name for heard in self.heard]


def links_to(*urls: str, clock: SystemClock | None = None, patient: bool = False) -> Router:
    return Router.open([Link(url=url) for url in urls], clock or SystemClock(), patient=patient)


def status(links: Router) -> LinkStatus:
    (only,) = links.status()
    return only


def hears(links: Router) -> list[Received]:
    heard: list[Received] = []
    links.component(191).subscribe(heard.append)
    return heard


def command(system: int, component: int) -> Any:
    return common.MAVLink_command_long_message(system, component, 512, 0, 397, 0, 0, 0, 0, 0, 0)
