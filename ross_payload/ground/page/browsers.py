"""The sockets of all browsers: each is written to at its own pace, and what it is too slow for is never sent."""

from __future__ import annotations

import asyncio
import re
import secrets
from typing import Any

from aiohttp import WSCloseCode, WSMsgType, web

from ross_payload.ground.page.faults import report
from ross_payload.ground.page.hub import Hub
from ross_payload.ground.page.requests import hear
from ross_payload.ground.page.session import Session
from ross_payload.ground.picture.known import Who
from ross_payload.ground.recordings import described

GATHER = 0.015  # [s] that a change waits for those which come with it
PERIOD = 0.05  # [s] between two messages to one browser
PATIENCE = 10.0  # [s] for a browser that takes nothing
HEARTBEAT = 5.0  # [s]
BUFFER = 65536  # [bytes] that may wait in this process for one browser
LARGEST = 65536  # [bytes] of what a browser says
MOST = 32  # sessions
_ID = re.compile(r"[0-9a-f]{4}")
_NAMES = {"edg/": "edge", "firefox/": "firefox", "chrome/": "chrome", "safari/": "safari"}


class Browsers:
    """Sessions by the id of their browser."""

    def __init__(self, hub: Hub) -> None:
        self.hub = hub
        hub.wake, hub.watched = self.wake, self.watched
        self.sessions: dict[str, Session] = {}
        self._flights: list[dict[str, Any]] = []
        self._recordings: dict[str, Any] | None = None  # None: nobody offers any
        self._sockets: set[web.WebSocketResponse] = set()

    def wake(self, who: Who | None) -> None:
        """Wake the browsers that watch a payload, or all."""
        for session in self.sessions.values():
            if who is None or session.watched == who:
                session.wake.set()

    def watched(self) -> list[Who]:
        """Return the payloads that are watched."""
        return [session.watched for session in self.sessions.values() if session.watched is not None]

    async def serve(self, request: web.Request) -> web.StreamResponse:
        """Talk with one browser until it goes."""
        if len(self.sessions) >= MOST:
            raise web.HTTPServiceUnavailable(text=f"{MOST} browsers are connected, no more are served\n")
        socket = web.WebSocketResponse(
            heartbeat=HEARTBEAT, compress=False, max_msg_size=LARGEST, writer_limit=BUFFER, timeout=0.5
        )
        await socket.prepare(request)
        session = self._session(request)
        self._sockets.add(socket)
        writer = asyncio.create_task(_write(session, socket, request))
        try:
            async for message in socket:
                if message.type is WSMsgType.TEXT:
                    hear(session, message.data)
        finally:
            self._sockets.discard(socket)
            await self._end(session, writer)
        return socket

    async def look(self) -> None:
        """Look which flights there are; tell all browsers when that has changed."""
        known = await asyncio.to_thread(self.hub.flights.known)
        if known != self._flights:
            self._flights = known
            self._tell({"type": "flights", "known": known})

    async def look_at_recordings(self) -> None:
        """Look which recordings there are; tell all browsers when that has changed."""
        store = self.hub.recordings
        if store is not None and (told := await asyncio.to_thread(described, store)) != self._recordings:
            self._recordings = told
            self._tell({"type": "recordings", **told})

    def _tell(self, message: dict[str, Any]) -> None:
        for session in self.sessions.values():
            session.tell(message)

    async def close(self) -> None:
        """Tell all browsers that the page ends."""
        closing = [socket.close(code=WSCloseCode.GOING_AWAY, message=b"ross ground ends") for socket in self._sockets]
        await asyncio.gather(*closing, return_exceptions=True)

    def _session(self, request: web.Request) -> Session:
        """Begin a session, with the id that a browser says it had, unless another one has it."""
        wanted = request.query.get("you", "")
        browser = wanted if _ID.fullmatch(wanted) and wanted not in self.sessions else self._new_id()
        self.hub.control.came(browser)
        session = self.sessions[browser] = Session(self.hub, browser, _name(request))
        session.tell({"type": "flights", "known": self._flights})
        if self._recordings is not None:
            session.tell({"type": "recordings", **self._recordings})
        return session

    def _new_id(self) -> str:
        taken = {*self.sessions, self.hub.control.holder}
        return next(each for _ in range(1000) if (each := secrets.token_hex(2)) not in taken)

    async def _end(self, session: Session, writer: asyncio.Task[None]) -> None:
        del self.sessions[session.id]
        self.hub.control.went(session.id, self.hub.station.now())
        writer.cancel()
        await asyncio.gather(writer, session.close(), return_exceptions=True)


async def _write(session: Session, socket: web.WebSocketResponse, request: web.Request) -> None:
    """Send what is due until the browser goes, takes nothing for long, or a fault happens; then it may come again."""
    try:
        while True:
            await session.wake.wait()
            await asyncio.sleep(GATHER)
            session.wake.clear()
            async with asyncio.timeout(PATIENCE):
                for text in session.due():
                    await socket.send_str(text)
                await _taken(request.transport)
            await asyncio.sleep(PERIOD - GATHER)
    except ConnectionError:
        return
    except TimeoutError:
        pass
    except Exception as error:
        report(error)
    if request.transport is not None:
        request.transport.abort()


async def _taken(transport: asyncio.Transport | None) -> None:
    """Wait until a browser has taken most of what was sent."""
    while transport is not None and transport.get_write_buffer_size() > BUFFER:
        await asyncio.sleep(PERIOD)


def _name(request: web.Request) -> str:
    agent = request.headers.get("User-Agent", "").lower()
    return f"{next((name for mark, name in _NAMES.items() if mark in agent), 'browser')} at {request.remote}"
