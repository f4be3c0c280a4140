"""Recorded flights over HTTP: one that is brought, and the sound of one."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

from aiohttp import web

from ross_payload.ground.errors import GroundError
from ross_payload.ground.web.file_answer import FileAnswer
from ross_payload.ground.web.flight_library import FlightLibrary, UploadRefused
from ross_payload.ground.web.security import shown
from ross_payload.ground.web.websocket_sessions import WebSocketSessions

CHUNK_BYTES = 65536
STALL_S = 30.0  # without a byte of a flight that is uploaded
SOUNDS = {".wav": "audio/wav", ".flac": "audio/flac"}


async def upload(browsers: WebSocketSessions, request: web.Request) -> web.Response:
    """Take a flight as the raw body."""
    try:
        name = await browsers.state.flights.save_upload(request.query.get("name", ""), chunks(request))
    except UploadRefused as error:
        return web.json_response({"error": error.message}, status=error.status)
    await browsers.refresh_flights()
    return web.json_response({"name": name})


async def sound(browsers: WebSocketSessions, request: web.Request) -> web.StreamResponse:
    """Answer with a track of a flight, or a range of it."""
    return await sound_of(browsers.state.flights, request.match_info["name"], request.match_info["track"])


async def sound_of(flights: FlightLibrary, name: str, track: str) -> FileAnswer:
    """Return the answer that is a track of a flight.

    Raises
    ------
    web.HTTPNotFound
        When there is none.
    """
    try:
        path = await asyncio.to_thread(flights.sound, name, track)
    except GroundError as error:
        raise web.HTTPNotFound(text=f"{shown(error.message)}\n") from error
    return FileAnswer(path, {"Content-Type": SOUNDS[path.suffix]})


async def chunks(request: web.Request) -> AsyncIterator[bytes]:
    """Yield a body as it comes; whoever sends nothing for long is told so.

    Raises
    ------
    UploadRefused
        When nothing came for `STALL_S`.
    """
    while True:
        try:
            async with asyncio.timeout(STALL_S):
                chunk = await request.content.read(CHUNK_BYTES)
        except TimeoutError as error:
            raise UploadRefused(408, f"no data received for {STALL_S:.0f} s") from error
        if not chunk:
            return
        yield chunk
