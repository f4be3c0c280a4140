"""A ground station: hears payloads on any number of links, speaks to them, and keeps the fleet.

All of it happens on one asyncio loop; nothing here waits for anybody.
"""

from __future__ import annotations

import asyncio
import socket
import time
from collections.abc import Callable, Sequence
from contextlib import AsyncExitStack, suppress
from pathlib import Path
from typing import Any, Self

from ross_payload.errors import reason
from ross_payload.ground.errors import GroundError
from ross_payload.ground.links.diagnostics import DIAGNOSIS_DELAY_S, advice
from ross_payload.ground.links.link import GroundLink, LinkState
from ross_payload.ground.links.routing import Route, RoutingTable
from ross_payload.ground.links.signing import SigningTime
from ross_payload.ground.links.tlog import BufferedTlog
from ross_payload.ground.model.fleet import Fleet
from ross_payload.transport.ports import Peer
from ross_protocols.mavlink.codec import Encoder, Packet, message_of
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.signing import Guardian

BEAT = 1.0  # [s] between two heartbeats, and between two writes of the log
TICK = 0.1  # [s] between two looks at what is due
ANY_PORT = 9  # nothing is sent there

Call = Callable[[Packet, float], None]


class Station:
    """Links, fleet and log of one ground station. An async context manager.

    Parameters
    ----------
    urls
        Where to listen or connect, see docs/reference/links.md.
    system_id, component_id
        Who we are; nobody else on the links may be the same. Other ground stations call themselves 255/190.
    key
        Of 32 bytes: what we send is signed, and only what is signed with it is heard.
    log
        Folder for a .tlog of everything heard and sent.
    now
        The clock of the fleet [s], monotonic.
    unix
        UNIX time [s], for signatures and the log.

    Raises
    ------
    GroundError
        When a URL is none, a port is in use, or the log cannot be written.
    """

    def __init__(
        self,
        urls: Sequence[str],
        *,
        system_id: int = 254,
        component_id: int = 190,
        key: bytes | None = None,
        log: Path | None = None,
        now: Callable[[], float] = time.monotonic,
        unix: Callable[[], float] = time.time,
    ) -> None:
        self.fleet = Fleet()
        self.now = now
        self.log: BufferedTlog | None = None
        self.system_id, self.component_id = system_id, component_id
        self._folder = log
        self._unix = unix
        self._began = now()
        self._signs = key is not None
        self._routes = RoutingTable()
        self._calls: list[Call] = []
        self._diary = Encoder(system_id, component_id)  # numbers what we say in the log
        self._links = self._made(urls, key)
        self._stack = AsyncExitStack()

    async def __aenter__(self) -> Self:
        """Open every link, and the log once all of them are open, or none."""
        async with AsyncExitStack() as stack:
            for link in self._links:
                stack.push_async_callback(link.close)
                await link.open()
            if self._folder is not None:
                self.log = BufferedTlog(self._folder, self._unix())
                stack.push_async_callback(self.log.close)
            for going in (self._go(), self._keep_log()):
                stack.push_async_callback(_ended, asyncio.create_task(going))
            self._stack = stack.pop_all()
        return self

    async def __aexit__(self, *error: object) -> None:
        """Close everything."""
        await self._stack.aclose()

    def links(self) -> list[LinkState]:
        """Return how every link is, in the order of the URLs."""
        now = self.now()
        return [link.state(now) for link in self._links]

    def subscribe(self, call: Call) -> Callable[[], None]:
        """Call ``call`` with every packet as it came, and its time [s]; return what ends that.

        Answers and texts that come on several ways are given once.
        """
        self._calls.append(call)
        return lambda: self._calls.remove(call)

    def send(self, message: Any, who: ComponentId | None = None) -> None:
        """Send a value or one of pymavlink's messages to where ``who`` was heard, else everywhere.

        Where it was heard on several ways, one of them is taken: a payload that gets an order on two links would
        refuse the second one. A stop, and what is sent again, goes all of them.
        """
        message = message_of(message)
        if self.log is not None:
            self.log.add(self._unix(), self._diary.encode(message), 0)
        routes = [] if who is None else self._routes.to(who, self.now(), message)
        open_routes = [route for route in routes if self._links[route.link].knows(route.peer)]
        for route in open_routes:
            self._links[route.link].send(message, [route.peer])
        if not open_routes:
            for link in self._links:
                link.send(message)

    def address_towards(self, who: ComponentId) -> str:
        """Return the IPv4 address of this computer as ``who`` reaches it, by the way on which it is heard.

        Raises
        ------
        GroundError
            When there is no such way: it was not heard, or is on a serial line or IPv6.
        """
        route = self._routes.best(who, self.now())
        if route is None:
            raise GroundError(f"{who} was not heard: nobody knows the way to it")
        link = self._links[route.link]
        return local_address(link.host_of(route.peer), f"{who} is heard on {link.url}")

    def advice(self, delay: float = DIAGNOSIS_DELAY_S) -> str:
        """Return what is wrong ``delay`` [s] after the start, and what to do about it; empty when all is well."""
        ended = "" if self.log is None else self.log.error
        payloads = tuple(self.fleet.payloads.values())
        heard = advice(self.links(), payloads, self.now(), self._began, self._signs, delay=delay)
        return "; ".join(part for part in (heard, ended) if part)

    def _made(self, urls: Sequence[str], key: bytes | None) -> list[GroundLink]:
        """Return the links, not open yet; they share one signing time."""
        signing_time = SigningTime(self._unix)
        me = ComponentId(self.system_id, self.component_id)
        return [
            GroundLink(
                number,
                url,
                me=me,
                now=self.now,
                on_packet=self._on_packet,
                guardian=Guardian(key, signing_time) if key else None,
            )
            for number, url in enumerate(urls)
        ]

    def _on_packet(self, number: int, peer: Peer, packet: Packet, at: float) -> None:
        who = packet.sender
        if self.log is not None:
            self.log.add(self._unix(), packet.frame, number)
        route = Route(number, peer)
        twin = self._routes.note(who, route, packet, at)
        copied = self._routes.is_copy(who, route, packet, at)
        self.fleet.on_packet(packet, at, way=route, copied=copied)
        if twin:
            self.fleet.twin(who, at)
        for call in tuple(self._calls if not copied else ()):
            call(packet, at)

    async def _go(self) -> None:
        """Do what is due, until cancelled."""
        due = self.now()
        while True:
            now = self.now()
            for link in self._links:
                link.tick(now)
            if now >= due:
                due = now + BEAT
                self.send(self._beat())
            await asyncio.sleep(TICK)

    async def _keep_log(self) -> None:
        while self.log is not None:
            await self.log.flush()
            await asyncio.sleep(BEAT)

    @staticmethod
    def _beat() -> Any:
        kind, none = common.MAV_TYPE_GCS, common.MAV_AUTOPILOT_INVALID
        return common.MAVLink_heartbeat_message(kind, none, 0, 0, common.MAV_STATE_ACTIVE, 3)


def local_address(host: str, why: str = "") -> str:
    """Return the IPv4 address of this computer on the way to a host; nothing is sent.

    >>> local_address("127.0.0.1")
    '127.0.0.1'

    Raises
    ------
    GroundError
        When no such way leads there; ``why`` tells why that host is asked for.
    """
    hint = "give the address of this computer with --audio-address"
    if not host:
        raise GroundError(f"{why}, which has no network address: {hint}")
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
            sock.connect((host.removeprefix("::ffff:"), ANY_PORT))
            return str(sock.getsockname()[0])
    except OSError as error:
        raise GroundError(f"{why}: {host} cannot be reached over IPv4 ({reason(error)}): {hint}") from error


async def _ended(task: asyncio.Task[None]) -> None:
    task.cancel()
    with suppress(asyncio.CancelledError):
        await task
