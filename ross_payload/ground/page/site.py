"""What the page's addresses answer: files, the socket, flights that are brought."""

from __future__ import annotations

import asyncio
import hashlib

from aiohttp import web

from ross_payload.ground.page.assets import Asset, asset
from ross_payload.ground.page.browsers import Browsers
from ross_payload.ground.page.login import guard
from ross_payload.ground.page.security import HEADERS, Gate
from ross_payload.ground.page.shelf import Refused

CHUNK = 65536  # [bytes]
LARGEST = 65536  # [bytes] of a form


def application(browsers: Browsers, gate: Gate, *, loopback: bool) -> web.Application:
    """Return the site of some browsers, behind a gate."""
    app = web.Application(middlewares=[guard(gate, loopback=loopback)], client_max_size=LARGEST)

    async def bring(request: web.Request) -> web.Response:
        return await _bring(browsers, request)

    async def tile(request: web.Request) -> web.Response:
        return await _tile(browsers, request)

    async def ends(_: web.Application) -> None:
        await browsers.close()

    app.router.add_get("/", _page)
    app.router.add_get("/assets/{path:.+}", _asset)
    app.router.add_get("/live", browsers.serve)
    app.router.add_post("/flights", bring)
    app.router.add_get(r"/tiles/{zoom:\d{1,2}}/{column:\d{1,10}}/{row:\d{1,10}}", tile)
    app.on_response_prepare.append(_protect)
    app.on_shutdown.append(ends)
    return app


async def _protect(request: web.Request, response: web.StreamResponse) -> None:
    response.headers.update(HEADERS)


async def _page(request: web.Request) -> web.Response:
    return _file(request, "index.html")


async def _asset(request: web.Request) -> web.Response:
    return _file(request, request.match_info["path"])


async def _tile(browsers: Browsers, request: web.Request) -> web.Response:
    """Answer a tile of the map; 204 where the map has none: a map has edges."""
    zoom, column, row = (int(request.match_info[name]) for name in ("zoom", "column", "row"))
    tiles = browsers.hub.tiles
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


async def _bring(browsers: Browsers, request: web.Request) -> web.Response:
    """Take a flight as the raw body."""
    flights = browsers.hub.flights
    try:
        name = await flights.take(request.query.get("name", ""), request.content.iter_chunked(CHUNK))
    except Refused as error:
        return web.json_response({"error": error.message}, status=error.status)
    await browsers.look()
    return web.json_response({"name": name})
