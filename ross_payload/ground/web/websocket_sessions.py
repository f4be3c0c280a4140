"""The sockets of all browsers: each is written to at its own pace, and what it is too slow for is never sent."""

from __future__ import annotations

import asyncio
import re
import secrets
from collections.abc import Iterable
from functools import partial
from typing import Any

from aiohttp import WSCloseCode, WSMsgType, web

from ross_payload.ground.recordings import described
from ross_payload.ground.web.browser_requests import on_message
from ross_payload.ground.web.browser_session import BrowserSession
from ross_payload.ground.web.faults import report
from ross_payload.ground.web.page_state import PageState
from ross_protocols.mavlink.component_id import ComponentId

COALESCE_S = 0.015  # that a change waits for those which come with it
SEND_PERIOD_S = 0.05  # between two messages to one browser
SEND_TIMEOUT_S = 10.0  # for a browser that takes nothing
PING_PERIOD_S = 5.0
WRITE_BUFFER_BYTES = 65536  # that may wait in this process for one browser
MAX_MESSAGE_BYTES = 65536  # of what a browser says
MAX_SESSIONS = 32
_ID = re.compile(r"[0-9a-f]{4}")
_NAMES = {"edg/": "edge", "firefox/": "firefox", "chrome/": "chrome", "safari/": "safari"}


class WebSocketSessions:
    """Sessions by the id of their browser."""

    def __init__(self, state: PageState) -> None:
        self.state = state
        state.wake, state.watched = self.wake, self.watched
        self.sessions: dict[str, BrowserSession] = {}
        self._flights: list[dict[str, Any]] = []
        self._recordings: dict[str, Any] | None = None  # None: nobody offers any
        self._sockets: set[web.WebSocketResponse] = set()
        self._proofs: dict[str, str] = {}  # of the latest browser that had an id

    def wake(self, who: ComponentId | None) -> None:
        """Wake the browsers that watch a payload, or all."""
        for session in self.sessions.values():
            if who is None or session.watched == who:
                session.wake.set()

    def watched(self) -> list[ComponentId]:
        """Return the payloads that are watched."""
        return [session.watched for session in self.sessions.values() if session.watched is not None]

    async def serve(self, request: web.Request) -> web.StreamResponse:
        """Talk with one browser until it goes."""
        if len(self.sessions) >= MAX_SESSIONS and not (
            self._returns(request) and request.query["you"] in self.sessions
        ):
            raise web.HTTPServiceUnavailable(text=f"{MAX_SESSIONS} browsers are connected, no more are served\n")
        socket = await opened(request, MAX_MESSAGE_BYTES, WRITE_BUFFER_BYTES)
        session, left = self._session(request)
        self._sockets.add(socket)
        writer = asyncio.create_task(_write(session, socket, request))
        try:
            if left is not None:
                await left.obeyed.wait()  # what a browser said over its earlier socket comes first
            async for message in socket:
                if message.type is WSMsgType.TEXT:
                    on_message(session, message.data)
                    await asyncio.sleep(0)  # for others: the next one may have come, and is taken without waiting
        finally:
            session.obeyed.set()
            self._sockets.discard(socket)
            await self._end(session, writer)
        return socket

    async def refresh_flights(self) -> None:
        """Look which flights there are; send them to all browsers when that has changed."""
        known = await asyncio.to_thread(self.state.flights.known)
        if known != self._flights:
            self._flights = known
            self._broadcast({"type": "flights", "known": known})

    async def refresh_recordings(self) -> None:
        """Look which recordings there are; send them to all browsers when that has changed."""
        store = self.state.recordings
        if store is not None and (listed := await asyncio.to_thread(described, store)) != self._recordings:
            self._recordings = listed
            self._broadcast({"type": "recordings", **listed})

    def _broadcast(self, message: dict[str, Any]) -> None:
        for session in self.sessions.values():
            session.send(message)

    async def close(self) -> None:
        """Tell all browsers that the page ends."""
        await close_all(self._sockets)

    def _session(self, request: web.Request) -> tuple[BrowserSession, BrowserSession | None]:
        """Begin a session, with the id that a browser says it had, unless another one has it.

        A browser whose network changed has left a session whose socket is not known to be dead: that ends, and is
        given, too.
        """
        wanted, returns = request.query.get("you", ""), self._returns(request)
        left = self.sessions.pop(wanted, None) if returns else None
        if left is not None:
            left.cut()
        browser = wanted if _ID.fullmatch(wanted) and wanted not in self.sessions else self._new_id()
        self.state.control.on_connect(browser)
        proof = self._proofs[browser] = self._proofs[browser] if returns else secrets.token_hex(16)
        name, cut = browser_name(request), partial(_cut, request)
        session = self.sessions[browser] = BrowserSession(self.state, browser, name, proof, cut)
        session.send({"type": "flights", "known": self._flights})
        if self._recordings is not None:
            session.send({"type": "recordings", **self._recordings})
        return session, left

    def _returns(self, request: web.Request) -> bool:
        """Whether a browser shows that it was the latest one with the id that it says it had."""
        proof = self._proofs.get(request.query.get("you", ""), "")
        shown = request.query.get("proof", "").encode("utf-8", "replace")
        return bool(proof) and secrets.compare_digest(proof.encode(), shown)

    def _new_id(self) -> str:
        taken = {*self.sessions, self.state.control.holder}
        return next(each for _ in range(1000) if (each := secrets.token_hex(2)) not in taken)

    async def _end(self, session: BrowserSession, writer: asyncio.Task[None]) -> None:
        if self.sessions.get(session.id) is session:
            del self.sessions[session.id]
            self.state.control.on_disconnect(session.id, self.state.station.now())
        writer.cancel()
        await asyncio.gather(writer, session.close(), return_exceptions=True)


async def opened(request: web.Request, most: int, waiting: int) -> web.WebSocketResponse:
    """Open the socket of a browser, which may say ``most`` bytes at once and let ``waiting`` bytes wait for it."""
    socket = web.WebSocketResponse(
        heartbeat=PING_PERIOD_S, compress=False, max_msg_size=most, writer_limit=waiting, timeout=0.5
    )
    await socket.prepare(request)
    return socket


async def close_all(sockets: Iterable[web.WebSocketResponse]) -> None:
    """Close sockets because this process ends."""
    closing = [socket.close(code=WSCloseCode.GOING_AWAY, message=b"ross ground ends") for socket in sockets]
    await asyncio.gather(*closing, return_exceptions=True)


async def _write(session: BrowserSession, socket: web.WebSocketResponse, request: web.Request) -> None:
    """Send what is due until the browser goes, takes nothing for long, or a fault happens; then it may come again."""
    try:
        while True:
            await session.wake.wait()
            await asyncio.sleep(COALESCE_S)
            session.wake.clear()
            async with asyncio.timeout(SEND_TIMEOUT_S):
                for text in session.due():
                    await socket.send_str(text)
                await _drained(request.transport)
            await asyncio.sleep(SEND_PERIOD_S - COALESCE_S)
    except ConnectionError:
        return
    except TimeoutError:
        pass
    except Exception as error:
        report(error)
    _cut(request)


def _cut(request: web.Request) -> None:
    """End the connection of a request without a word."""
    if request.transport is not None:
        request.transport.abort()


async def _drained(transport: asyncio.Transport | None) -> None:
    """Wait until a browser has taken most of what was sent."""
    while transport is not None and transport.get_write_buffer_size() > WRITE_BUFFER_BYTES:
        await asyncio.sleep(SEND_PERIOD_S)


def browser_name(request: web.Request) -> str:
    """Return which browser it is, and where."""
    agent = request.headers.get("User-Agent", "").lower()
    return f"{next((name for mark, name in _NAMES.items() if mark in agent), 'browser')} at {request.remote}"
