"""How a simulated device is connected: it serves its wire, joins a bus, or opens a MAVLink link."""

from __future__ import annotations

import json
import os
import select
import termios
import tty
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from typing import Any, Protocol

from ross_payload.actuators.registry import checked_options
from ross_payload.actuators.wires import open_wire
from ross_payload.clock import SystemClock
from ross_payload.config import VEHICLE_YAW, Config
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Clock
from ross_payload.transport.link_url import Tcp, Udp, host_and_port, parse, tcp_endpoint
from ross_payload.transport.open_port import open_port
from ross_sim.devices.far_end import FarEnd
from ross_sim.devices.gimbal_far_end import GimbalFarEnd
from ross_sim.devices.gimbal_manager import SET_ATTITUDE
from ross_sim.devices.vehicle_far_end import VehicleFarEnd
from ross_sim.devices.wire_servers import TICK, Served, Side, WireServer, side_of

LINK = "udpout:127.0.0.1:14560"  # of a gimbal, unless told: it speaks first
ON_LINKS = ("mavlink_gimbal", VEHICLE_YAW)  # actuators that share the payload's links
PTY = "serial:pty"  # of a controller on a serial line, unless told
BAUD = 115200  # of a pseudo terminal, which has none


class Exchange(Protocol):
    """What frames go through."""

    def send(self, frame: Any) -> None:
        """Send one frame."""

    def receive(self) -> list[Any]:
        """Return what has arrived."""


class Coupling(Protocol):
    """Connects a far end with what is outside."""

    def exchange(self, begin: float) -> None:
        """Give to the far end what has arrived by ``begin`` [s of its time], and send what it says."""


@dataclass(frozen=True, slots=True)
class Connection:
    """A far end that is connected."""

    lead: Coupling
    address: str  # that a payload needs
    used: Callable[[], bool]  # whether a payload was ever there


@dataclass(slots=True)
class JoinedCoupling:
    """Passes frames on between a far end and something that is there already; they take effect when they arrived."""

    outside: Exchange  # a bus, a line or a link
    far_end: Exchange  # the payload's end of the simulated wire
    clock: Clock  # tells when something arrives
    epoch: float  # time 0 of the far end on that clock [s]
    used: bool = False
    _waiting: list[tuple[float, Any]] = field(default_factory=list)

    def exchange(self, begin: float) -> None:
        """Pass frames on, both ways."""
        arrived = self.clock.now() - self.epoch
        self._waiting += [(arrived, frame) for frame in self.outside.receive()]
        self.used = self.used or bool(self._waiting)
        while self._waiting and self._waiting[0][0] <= begin:
            self.far_end.send(self._waiting.pop(0)[1])
        for frame in self.far_end.receive():
            self.outside.send(frame)


class EncodedWire:
    """The wire of a gimbal or a vehicle, for who has frames already.

    An autopilot stands between: what it tells the gimbal alone does not come out on this side.
    """

    def __init__(self, far_end: GimbalFarEnd | VehicleFarEnd) -> None:
        self._wire = far_end.port
        self._routed = isinstance(far_end, GimbalFarEnd) and far_end.autopilot is not None

    def send(self, frame: bytes) -> None:
        """Let the gimbal and its autopilot hear bytes."""
        self._wire.sent.append(frame)

    def receive(self) -> list[bytes]:
        """Return the frames that they have sent."""
        frames, self._wire.arrived = self._wire.arrived, []
        return [frame for frame in frames if not (self._routed and _number(frame) == SET_ATTITUDE)]


def _number(frame: bytes) -> int:
    """Id of the message in a frame of MAVLink 2."""
    return int.from_bytes(frame[7:10], "little")


def connected(config: Config, wire: str | None, far_end: FarEnd, *, epoch: float, stack: ExitStack) -> Connection:
    """Connect a far end.

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
    if isinstance(far_end, GimbalFarEnd | VehicleFarEnd):
        url = wire or LINK
        link = open_port(url, clock.now)
        stack.callback(link.close)
        lead = JoinedCoupling(link, EncodedWire(far_end), clock, epoch)
        return Connection(lead, opposite(url), lambda: lead.used)
    scheme = checked_options(config).port.partition(":")[0]
    wire = wire or (PTY if scheme == "serial" else f"{scheme}:tcp:127.0.0.1:0")
    if wire.partition(":")[0] != scheme:
        raise ConfigError(f"--wire: expected {scheme}:..., got {wire}")
    if wire == PTY or wire.startswith(f"{scheme}:tcp:"):
        return _served(scheme, wire, far_end, epoch, stack)
    outside = open_wire(wire, clock)
    stack.callback(outside.close)
    lead = JoinedCoupling(outside, far_end.port, clock, epoch)
    return Connection(lead, wire, lambda: lead.used)


def _served(scheme: str, wire: str, far_end: FarEnd, epoch: float, stack: ExitStack) -> Connection:
    side, clock = side_of(scheme, far_end.port, epoch), SystemClock()
    if wire == PTY:
        terminal = stack.enter_context(PtyServer(side, clock))
        return Connection(side, f"serial:{terminal.name}:{BAUD}", lambda: True)
    host, port = tcp_endpoint(wire.partition(":")[2], "--wire", min_port=0)
    server = stack.enter_context(WireServer(host, port, side, clock))
    return Connection(side, f"{scheme}:tcp:{host_and_port(host, server.port)}", lambda: server.used)


def configured_wire(config: Config) -> str:
    """Return the wire that a payload's configuration names, as its device names it; empty: it names none to be shared.

    A device can join a CAN bus and serve a TCP port; a serial line or a pin of this computer has no other end here.
    """
    if config.actuator.kind in ON_LINKS:
        urls = (link.url for link in config.links if link.role == "autopilot")
        return next((opposite(url) for url in urls if not url.startswith("serial:")), "")
    options = checked_options(config)
    named = options.port if "port" in options.model_fields_set else ""
    return str(named) if named.startswith("can:") or named.partition(":")[2].startswith("tcp:") else ""


def opposite(url: str) -> str:
    """Return the URL of the other end of a link.

    >>> opposite("udpin:127.0.0.1:14560"), opposite("tcp:[::1]:5760"), opposite("serial:/dev/ttyUSB0:115200")
    ('udpout:127.0.0.1:14560', 'tcpin:[::1]:5760', 'serial:/dev/ttyUSB0:115200')
    """
    address = parse(url)
    if not isinstance(address, Udp | Tcp):
        return url
    kinds = ("udpout", "udpin") if isinstance(address, Udp) else ("tcp", "tcpin")
    return f"{kinds[0] if address.listen else kinds[1]}:{host_and_port(address.host, address.port)}"


def advice(config: Config, address: str) -> str:
    """Return what a payload's configuration says of this device: only an autopilot's link has its role.

    >>> drive = {"kind": "canopen_drive", "options": {"node_id": 7}}
    >>> print(advice(Config.model_validate({"actuator": drive}), "can:tcp:127.0.0.1:4000"))
    [actuator]
    kind = "canopen_drive"
    options = { node_id = 7, port = "can:tcp:127.0.0.1:4000" }
    >>> bare = {"kind": "mavlink_gimbal", "options": {"role": "manager"}}
    >>> print(advice(Config.model_validate({"actuator": bare}), "udpin:127.0.0.1:14560"))
    [actuator]
    kind = "mavlink_gimbal"
    options = { role = "manager" }
    <BLANKLINE>
    [[links]]
    url = "udpin:127.0.0.1:14560"
    >>> still = {"kind": "vehicle_yaw", "options": {"turn_vehicle": False}}
    >>> print(advice(Config.model_validate({"actuator": still}), "udpin:127.0.0.1:14560").splitlines()[2])
    options = { turn_vehicle = false }
    """
    kind, options = config.actuator.kind, dict(config.actuator.options)
    if kind not in ON_LINKS:
        return _table(kind, options | {"port": address})
    if kind == VEHICLE_YAW:
        options.setdefault("turn_vehicle", True)
    alone = kind != VEHICLE_YAW and checked_options(config).role == "manager"
    role = "" if alone else '\nrole = "autopilot"'
    return f'{_table(kind, options)}\n\n[[links]]\nurl = "{address}"{role}'


def _table(kind: str, options: dict[str, Any]) -> str:
    """Return [actuator] with these options, as TOML: numbers, words and lists of them are written as in JSON."""
    items = ", ".join(f"{key} = {json.dumps(value)}" for key, value in options.items())
    return f'[actuator]\nkind = "{kind}"' + (f"\noptions = {{ {items} }}" if items else "")


MOST = 4096  # bytes of one look


class PtyServer(Served):
    """Serves whoever opens the pseudo terminal ``name``; on a thread of its own.

    It stands for a device that is always plugged in: its own end stays open, so that programs come and go, and what
    nobody reads is dropped when the terminal is full. Modem lines there are none.

    Parameters
    ----------
    side
        Of the wire, see `ross_sim.devices.wire_servers`.
    clock
        Both processes'.
    """

    def __init__(self, side: Side, clock: Clock) -> None:
        super().__init__(side, clock, "pty")
        self._ours, self._theirs = os.openpty()
        tty.setraw(self._theirs, termios.TCSANOW)
        os.set_blocking(self._ours, False)
        self.name = os.ttyname(self._theirs)

    def _close(self) -> None:
        os.close(self._ours)
        os.close(self._theirs)

    def _serve(self) -> None:
        while not self._stopping.is_set():
            if select.select([self._ours], [], [], TICK)[0]:
                self._side.arrived(os.read(self._ours, MOST), self._clock.now())
            for data in self._side.due(self._clock.now()):
                with suppress(BlockingIOError):  # nobody reads
                    os.write(self._ours, data)
