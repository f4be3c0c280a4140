"""The web server of the page: from an address to a site that is served."""

from __future__ import annotations

import asyncio
import errno
import socket
import ssl
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from aiohttp import web

from ross_payload.errors import refused_as
from ross_payload.ground.errors import GroundError
from ross_payload.ground.recordings import RecordingStore
from ross_payload.ground.web.connections import HEADER_TIMEOUT, Connections
from ross_payload.ground.web.faults import FaultLog, report
from ross_payload.ground.web.flight_library import FlightLibrary
from ross_payload.ground.web.listening_sockets import ListeningSockets
from ross_payload.ground.web.page_state import NoStation, PageState
from ross_payload.ground.web.security import Gate, is_loopback
from ross_payload.ground.web.site import application, tolerant
from ross_payload.ground.web.websocket_sessions import WebSocketSessions

if TYPE_CHECKING:
    from ross_payload.ground.station import Station
    from ross_payload.ground.web.tiles import Tiles

TICK = 0.1  # [s]
LOOK = 10.0  # [s] between two looks at the folder of flights
RECORDINGS_PERIOD = 2.0  # [s] between two looks at the recordings
SEND_BUFFER = 65536  # [bytes] of the system, per browser: what a slow one has not got must not be old
LINGERING = 1.0  # [s] for which the rest of a request is read that was answered before its end
TELLING = 0.3  # [s] for browsers to hear that the page ends


@dataclass(frozen=True, slots=True)
class Served:
    """A page that is being served."""

    url: str
    state: PageState


@asynccontextmanager
async def serve(
    station: Station | None,
    flights: FlightLibrary | None = None,
    recordings: RecordingStore | None = None,
    *,
    host: str = "127.0.0.1",
    port: int = 0,
    token: str | None = None,
    tls: ssl.SSLContext | None = None,
    listener: socket.socket | None = None,
    tiles: Tiles | None = None,
    audio_address: str = "",
) -> AsyncIterator[Served]:
    """Serve the page; without a station it plays past flights only. Port 0: a free one.

    ``recordings`` are those of this computer: they are offered for download, to whoever may open the page. ``listener``
    is bound to ``host`` already, else one is bound here. ``audio_address`` is that of this computer as payloads reach
    it, where it is not that of the way on which they are heard.

    Raises
    ------
    GroundError
        When the port cannot be had, or others could reach the page without a token.
    """
    if token is None and not is_loopback(host):
        raise GroundError(f"--host {host}: reachable from other computers: expected a token, got none")
    with listener or bound(host, port) as door, flights or FlightLibrary(None) as library:
        browsers, connections = WebSocketSessions(PageState(station or NoStation(), library, recordings)), Connections()
        browsers.state.tiles = tiles
        listening = ListeningSockets(browsers.state, audio_address)
        site = application(browsers, listening, Gate(token), connections, loopback=is_loopback(host))
        async with _working(browsers, listening), _protocols(site) as protocols:
            with connections.accepted(door, protocols, tls):
                yield Served(_url(host, door.getsockname()[1], tls is not None), browsers.state)


@asynccontextmanager
async def _protocols(site: web.Application) -> AsyncIterator[web.Server]:
    """Give what makes the protocol of every connection."""
    runner = web.AppRunner(
        site,
        access_log=None,
        shutdown_timeout=TELLING,
        keepalive_timeout=HEADER_TIMEOUT,
        lingering_time=LINGERING,
        logger=FaultLog().logger(),
    )
    await runner.setup()
    if runner.server is None:
        raise RuntimeError("the web server did not start")
    runner.server.request_handler = tolerant(runner.server.request_handler)
    try:
        yield runner.server
    finally:
        await runner.cleanup()


@asynccontextmanager
async def _working(browsers: WebSocketSessions, listening: ListeningSockets) -> AsyncIterator[None]:
    """Do what comes again and again, until the end."""
    works = (
        _every(TICK, partial(_tick, browsers)),
        _every(TICK, listening.tick),
        _every(LOOK, browsers.refresh_flights),
        _every(RECORDINGS_PERIOD, browsers.refresh_recordings),
    )
    tasks = [asyncio.create_task(each) for each in works]
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        browsers.state.close()


def bound(host: str, port: int) -> socket.socket:
    """Return a socket that is bound to an address, and listens: until one does, two may be bound to the same port.

    Raises
    ------
    GroundError
        When the address is not of this computer, or the port is taken.
    """
    with refused_as(GroundError, f"--host {host}: expected an address of this computer, got"):
        (family, _, _, _, address), *_ = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
        listener.bind(address)
        listener.listen()
    except OSError as error:
        listener.close()
        raise GroundError(_why(host, port, error)) from error
    return listener


def _why(host: str, port: int, error: OSError) -> str:
    if error.errno == errno.EADDRINUSE:
        return f"--port {port}: expected a free port, got one in use; --port 0 takes any"
    if error.errno == errno.EADDRNOTAVAIL:
        return f"--host {host}: expected an address of this computer"
    return f"{host}:{port}: {error.strerror}"


def _url(host: str, port: int, tls: bool) -> str:
    name = socket.gethostname() if host in ("0.0.0.0", "::") else host  # noqa: S104
    name = f"[{name}]" if ":" in name else name
    return f"http{'s' if tls else ''}://{name}:{port}/"


async def _tick(browsers: WebSocketSessions) -> None:
    browsers.state.tick()


async def _every(period: float, call: Callable[[], Awaitable[None]]) -> None:
    """Call something again and again [s]; what fails is told once, and does not take the stop button away."""
    told = ""
    while True:
        try:
            await call()
        except Exception as error:
            if repr(error) != told:
                told = repr(error)
                report(error)
        await asyncio.sleep(period)
