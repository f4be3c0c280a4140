"""The token at the door: shown once in the address or in a form, then kept by the browser as a cookie."""

from __future__ import annotations

import math
import time
from importlib import resources

from aiohttp import web
from aiohttp.typedefs import Handler, Middleware

from ross_payload.ground.page.security import Gate, host_fits, origin_fits

WANTED = "This page wants the token that its terminal shows, or that its token file holds."
WRONG = "The token is wrong."


def guard(gate: Gate, *, loopback: bool) -> Middleware:
    """Look at every request before it is answered: whom it means, which page sends it, and who asks."""

    @web.middleware
    async def guarded(request: web.Request, handler: Handler) -> web.StreamResponse:
        if loopback and not host_fits(request.host):
            raise web.HTTPMisdirectedRequest(text=f"host {request.host} found, this computer wanted\n")
        if not origin_fits(request.headers.get("Origin"), request.host):
            raise web.HTTPForbidden(text="a page of another origin asks: refused\n")
        if gate.lets_in(request.cookies.get(_cookie_name(request), "")):
            return await handler(request)
        return await _stranger(gate, request)

    return guarded


async def _stranger(gate: Gate, request: web.Request) -> web.StreamResponse:
    """Answer somebody who has not shown the token yet."""
    if request.method == "POST" and request.path == "/login":
        return _try(gate, request, str((await request.post()).get("token", "")))
    if request.method == "GET" and request.path == "/":
        token = request.query.get("token")
        return _form(WANTED, 401) if token is None else _try(gate, request, token)
    raise web.HTTPUnauthorized(text="token wanted: open the page\n")


def _try(gate: Gate, request: web.Request, token: str) -> web.StreamResponse:
    address, now = request.remote or "", time.monotonic()
    if wait := math.ceil(gate.waits(address, now)):
        response = _form(f"Too many wrong tokens: wait {wait} s.", 429)
        response.headers["Retry-After"] = str(wait)
        return response
    if not gate.tried(token, address, now):
        return _form(WRONG, 401)
    response = web.Response(status=303, headers={"Location": "/"})
    secure = request.scheme == "https"
    response.set_cookie(_cookie_name(request), gate.cookie, httponly=True, samesite="Strict", secure=secure)
    return response


def _form(why: str, status: int) -> web.Response:
    text = resources.files(__package__).joinpath("login.html").read_text("utf-8").replace("{why}", why)
    return web.Response(text=text, content_type="text/html", status=status)


def _cookie_name(request: web.Request) -> str:
    """Cookies know hosts but no ports: two pages of one computer keep theirs apart by name."""
    return f"ross-{request.url.port}"
