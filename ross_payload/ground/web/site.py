"""What the page's addresses answer: its files, the socket, map tiles, flights that are uploaded, the REST interface."""

from __future__ import annotations

import asyncio
import hashlib
import re
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from functools import partial
from importlib import resources
from pathlib import PurePosixPath

from aiohttp import ClientPayloadError, web
from aiohttp.http_exceptions import HttpProcessingError

from ross_payload.ground.web import flight_files, recordings
from ross_payload.ground.web.connections import Connections
from ross_payload.ground.web.faults import report
from ross_payload.ground.web.listening_sockets import ListeningSockets
from ross_payload.ground.web.login import guard
from ross_payload.ground.web.rest.problems import as_problems, is_problem, refusal_of_http
from ross_payload.ground.web.rest.routes import add_routes
from ross_payload.ground.web.security import HEADERS, Gate, shown
from ross_payload.ground.web.websocket_sessions import WebSocketSessions

Handle = Callable[[web.BaseRequest], Awaitable[web.StreamResponse]]

MAX_FORM_BYTES = 65536
TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
    ".json": "application/json",
    ".txt": "text/plain; charset=utf-8",
    ".png": "image/png",
}
_NAME = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9_.-]*")


@dataclass(frozen=True, slots=True)
class Asset:
    """A file to serve."""

    body: bytes
    content_type: str
    etag: str


def asset(path: str) -> Asset | None:
    """Read a file below ``assets``; None: there is none, or the path leads elsewhere.

    >>> asset("../server.py") is None, asset("views") is None, asset(".hidden.js") is None
    (True, True, True)
    """
    parts = path.split("/")
    content_type = TYPES.get(PurePosixPath(path).suffix)
    if content_type is None or not all(map(_NAME.fullmatch, parts)):
        return None
    place = resources.files(__package__).joinpath("assets", *parts)
    if not place.is_file():
        return None
    body = place.read_bytes()
    return Asset(body, content_type, hashlib.sha256(body).hexdigest()[:32])


def application(
    browsers: WebSocketSessions, listening: ListeningSockets, gate: Gate, connections: Connections, *, loopback: bool
) -> web.Application:
    """Return the site of some browsers, behind a gate."""
    guarded = guard(gate, connections, loopback=loopback)
    app = web.Application(middlewares=[as_problems, guarded], client_max_size=MAX_FORM_BYTES)

    async def ends(_: web.Application) -> None:
        browsers.state.changed.close()
        await listening.close()
        await browsers.close()

    app.router.add_get("/", _page)
    app.router.add_get("/assets/{path:.+}", _asset)
    app.router.add_get("/live", browsers.serve)
    app.router.add_get("/listen", listening.serve)
    app.router.add_post("/flights", partial(flight_files.upload, browsers))
    app.router.add_get("/flights/{name}/sound/{track}", partial(flight_files.sound, browsers))
    app.router.add_get(r"/tiles/{zoom:\d{1,2}}/{column:\d{1,10}}/{row:\d{1,10}}", partial(_tile, browsers))
    store = browsers.state.recordings
    app.router.add_get("/recordings", partial(recordings.listed, store))
    app.router.add_get("/recordings/{name}.zip", partial(recordings.archive, store))
    app.router.add_get("/recordings/{name}/{file}", partial(recordings.one_file, store))
    app.router.add_delete("/recordings/{name}", partial(recordings.deleted, store))
    add_routes(app, browsers, token=gate.token is not None)
    app.on_response_prepare.append(_protect)
    app.on_shutdown.append(ends)
    return app


def tolerant(handle: Handle) -> Handle:
    """Wrap what answers requests: what cannot be read is the client's mistake, and a fault of ours is one line.

    A middleware would be too late: aiohttp looks at some headers before it calls any.
    """

    async def handled(request: web.BaseRequest) -> web.StreamResponse:
        try:
            return await handle(request)
        except (web.HTTPException, ConnectionError):
            raise
        except (web.RequestPayloadError, HttpProcessingError, ClientPayloadError, UnicodeError) as error:
            raise web.HTTPBadRequest(text=f"request: {shown(str(error))}\n") from error
        except Exception as error:
            report(error)
            raise web.HTTPInternalServerError(text="an internal error of the page: see the terminal\n") from error

    async def answered(request: web.BaseRequest) -> web.StreamResponse:
        try:
            return await handled(request)
        except web.HTTPException as error:
            if not is_problem(request.path, error):
                raise
            return refusal_of_http(error).response()

    return answered


async def _protect(request: web.Request, response: web.StreamResponse) -> None:
    for name, value in HEADERS.items():
        response.headers.setdefault(name, value)


async def _page(request: web.Request) -> web.Response:
    return _file(request, "index.html")


async def _asset(request: web.Request) -> web.Response:
    return _file(request, request.match_info["path"])


async def _tile(browsers: WebSocketSessions, request: web.Request) -> web.Response:
    """Answer a tile of the map; 204 where the map has none: a map has edges."""
    zoom, column, row = (int(request.match_info[name]) for name in ("zoom", "column", "row"))
    tiles = browsers.state.tiles
    found = None if tiles is None else await asyncio.to_thread(tiles.read, zoom, column, row)
    if found is None:
        return web.Response(status=204)
    return _cached(request, Asset(found.body, found.content_type, hashlib.sha256(found.body).hexdigest()[:32]))


def _file(request: web.Request, path: str) -> web.Response:
    found = asset(path)
    if found is None:
        raise web.HTTPNotFound(text="no such file\n")
    return _cached(request, found)


def _cached(request: web.Request, found: Asset) -> web.Response:
    """Answer with a body, or that the browser has it already."""
    same = any(each.value == found.etag for each in request.if_none_match or ())
    response = web.Response(status=304) if same else web.Response(body=found.body)
    response.headers["Content-Type"] = found.content_type
    response.etag = found.etag
    return response
