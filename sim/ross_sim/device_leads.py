"""How a simulated device is connected: it serves its wire, joins a bus, or opens a MAVLink link."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Protocol

from ross_payload.actuators.registry import checked_options
from ross_payload.actuators.wires import open_wire
from ross_payload.clock import SystemClock
from ross_payload.config import Config
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Clock, Port
from ross_payload.links import LinkPort, open_port
from ross_payload.links.address import Tcp, Udp, parse
from ross_sim.address import tcp_address
from ross_sim.far_end import FarEnd
from ross_sim.gimbal import GimbalFarEnd
from ross_sim.wires import WireServer, side_of

LINK = "udpin:127.0.0.1:14560"  # of a gimbal, unless told


class Lead(Protocol):
    """Connects a far end with what is outside."""

    def exchange(self, now: float) -> None:
        """Give to the far end what has arrived by ``now`` [s of its time], and send what it says."""


class JoinedLead:
    """A bus or a line that is there already: the device is one more on it."""

    def __init__(self, outside: Port, far_end: Port) -> None:
        self._outside = outside
        self._far_end = far_end

    def exchange(self, now: float) -> None:
        """Pass frames on, both ways."""
        for frame in self._outside.receive():
            self._far_end.send(frame)
        for frame in self._far_end.receive():
            self._outside.send(frame)


class MavlinkLead:
    """A MAVLink link to a gimbal and, where there is one, its autopilot; bytes take effect when they arrived.

    Parameters
    ----------
    link
        Open.
    far_end
        Speaks and hears frames.
    clock
        Tells when something arrives.
    epoch
        Time 0 of the far end on that clock [s].
    """

    def __init__(self, link: LinkPort, far_end: GimbalFarEnd, clock: Clock, epoch: float) -> None:
        self._link = link
        self._wire = far_end.port
        self._clock = clock
        self._epoch = epoch
        self._waiting: list[tuple[float, bytes]] = []
        self.used = False  # whether anybody has ever spoken

    def exchange(self, now: float) -> None:
        """Let the far end hear what has arrived by then, and say what it has to say."""
        arrived = self._clock.now() - self._epoch
        self._waiting += [(arrived, data) for data in self._link.receive()]
        self.used = self.used or bool(self._waiting)
        while self._waiting and self._waiting[0][0] <= now:
            self._wire.sent.append(self._waiting.pop(0)[1])
        frames, self._wire.arrived = self._wire.arrived, []
        for frame in frames:
            self._link.send(frame)


def lead_of(config: Config, wire: str | None, far_end: FarEnd, *, epoch: float, stack: ExitStack) -> tuple[Lead, str]:
    """Connect a far end; return with what, and the address that a payload needs.

    Parameters
    ----------
    config
        Names the actuator; the port among its options has the scheme that the wire must have.
    wire
        Asked for; None: the usual one.
    epoch
        Time 0 of the far end on the monotonic clock [s].
    stack
        Closes what is opened.

    Raises
    ------
    ConfigError
        When the wire is malformed or of another kind.
    LinkError
        When it cannot be opened.
    """
    clock = SystemClock()
    if isinstance(far_end, GimbalFarEnd):
        url = wire or LINK
        link = open_port(url, clock)
        stack.callback(link.close)
        return MavlinkLead(link, far_end, clock, epoch), opposite(url)
    scheme = checked_options(config).port.partition(":")[0]
    wire = wire or f"{scheme}:tcp:127.0.0.1:0"
    if wire.partition(":")[0] != scheme:
        raise ConfigError(f"--wire {wire}: a {config.actuator.kind} has a wire {scheme}:")
    if wire.startswith(f"{scheme}:tcp:"):
        host, number = tcp_address(wire.partition(":")[2], "--wire")
        side = side_of(scheme, far_end.port, epoch)
        server = stack.enter_context(WireServer(host, number, side, clock))
        return side, f"{scheme}:tcp:{wire.split(':', 2)[2].rpartition(':')[0]}:{server.port}"
    outside = open_wire(wire, clock)
    stack.callback(outside.close)
    return JoinedLead(outside, far_end.port), wire


def opposite(url: str) -> str:
    """Return the URL of the other end of a link.

    >>> opposite("udpin:127.0.0.1:14560"), opposite("tcp:[::1]:5760"), opposite("serial:/dev/ttyUSB0:115200")
    ('udpout:127.0.0.1:14560', 'tcpin:[::1]:5760', 'serial:/dev/ttyUSB0:115200')
    """
    address = parse(url)
    if not isinstance(address, Udp | Tcp):
        return url
    kinds = ("udpout", "udpin") if isinstance(address, Udp) else ("tcp", "tcpin")
    host = f"[{address.host}]" if ":" in address.host else address.host
    return f"{kinds[0] if address.listen else kinds[1]}:{host}:{address.port}"
