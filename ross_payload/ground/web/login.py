"""The token at the door: shown once in the address or in a form, then kept by the browser as a cookie.

Wrong tokens are counted by network address, those in the address of the page and those in the form apart: any page can
make a browser open an address, but only our own can make it send our form. What a browser says is another site's doing
is never tried, and no count keeps out a browser that has the cookie. Programs show the token in a header, with every
request; these are counted apart, too, and no count keeps the right token from stopping a payload.
"""

from __future__ import annotations

import asyncio
import html
import math
import re
import time
from importlib import resources
from urllib.parse import parse_qs

from aiohttp import web
from aiohttp.typedefs import Handler, Middleware

from ross_payload.ground.web.connections import HEADER_TIMEOUT, Connections
from ross_payload.ground.web.security import Gate, host_fits, origin_fits, shown

WANTED = "This page needs the token that the terminal shows, or the one in the token file."
WRONG = "The token is wrong."
WANTED_HEADER = "expected Authorization: Bearer and the token"
CHALLENGE = {"WWW-Authenticate": "Bearer"}
LINKED = "You come from another site: press Open to log in."
LOCKED_LINK = "Too many wrong tokens in the address of this page; you can still enter the token here."
FORM = "application/x-www-form-urlencoded"
MOST_FIELDS = 10
STOP = re.compile(r"/api/v1(/payloads/[^/]+)?/stop")  # paths that nobody's guesses may lock
LASTING = ("/live", "/listen")  # paths of WebSockets
ELSEWHERE = ("cross-site", "same-site")  # of Sec-Fetch-Site: what a page of another origin causes


def guard(gate: Gate, connections: Connections, *, loopback: bool) -> Middleware:
    """Look at every request before it is answered: whom it means, which page sends it, and who asks."""

    @web.middleware
    async def guarded(request: web.Request, handler: Handler) -> web.StreamResponse:
        if loopback and not host_fits(request.host):
            raise web.HTTPMisdirectedRequest(text=f"host: expected this computer, got {shown(request.host)}\n")
        if not origin_fits(request.headers.get("Origin"), request.host) or _intrudes(request):
            raise web.HTTPForbidden(text="request from another origin: refused\n")
        if not (gate.lets_in(request.cookies.get(_cookie_name(request), "")) or _shows_token(gate, request)):
            return await _stranger(gate, request)
        with connections.answering(request.protocol, lasting=request.path in LASTING):
            if request.path == "/login" or (request.path == "/" and "token" in request.query):
                return web.Response(status=303, headers={"Location": "/"})
            return await handler(request)

    return guarded


def _from_elsewhere(request: web.Request) -> bool:
    return request.headers.get("Sec-Fetch-Site") in ELSEWHERE


def _intrudes(request: web.Request) -> bool:
    """Whether a page of another origin asks for more than that the user be led to our page."""
    led = request.method == "GET" and request.path == "/" and request.headers.get("Sec-Fetch-Mode") == "navigate"
    return _from_elsewhere(request) and not led


def _shows_token(gate: Gate, request: web.Request) -> bool:
    """Whether a program shows the token; False: it shows none.

    Raises
    ------
    web.HTTPUnauthorized, web.HTTPTooManyRequests
        When it is wrong, or one of too many.
    """
    scheme, _, token = request.headers.get("Authorization", "").partition(" ")
    if scheme.lower() != "bearer":  # a proxy may want a header of its own
        return False
    who, now = f"{request.remote} by header", time.monotonic()
    if request.method == "POST" and STOP.fullmatch(request.path) and gate.knows(token.strip()):
        return True
    if wait := math.ceil(gate.waits(who, now)):
        raise web.HTTPTooManyRequests(text=f"too many wrong tokens: wait {wait} s", headers={"Retry-After": str(wait)})
    if not gate.tried(token.strip(), who, now):
        raise web.HTTPUnauthorized(text=f"{WANTED_HEADER}, got another one", headers=CHALLENGE)
    return True


async def _stranger(gate: Gate, request: web.Request) -> web.StreamResponse:
    """Answer somebody who has not shown the token yet."""
    address = request.remote or ""
    if request.method == "POST" and request.path == "/login":
        return _try(gate, request, await _posted(request), address)
    if request.method == "GET" and request.path == "/":
        token = request.query.get("token")
        if token is None:
            return _form(WANTED, 401)
        if _from_elsewhere(request):
            return _form(LINKED, 401, token)
        return _try(gate, request, token, f"{address} by link", by_link=True)
    raise web.HTTPUnauthorized(text=f"{WANTED_HEADER}, got none: or open the page to log in\n", headers=CHALLENGE)


async def _posted(request: web.Request) -> str:
    """Return the token of the form.

    Raises
    ------
    web.HTTPBadRequest, web.HTTPRequestTimeout, web.HTTPRequestEntityTooLarge
        When it is none, does not come, or is too large.
    """
    if request.content_type != FORM:
        raise web.HTTPBadRequest(text=f"Content-Type: expected {FORM}, got {shown(request.content_type)}\n")
    try:
        async with asyncio.timeout(HEADER_TIMEOUT):
            body = await request.read()
        fields = parse_qs(body.decode("utf-8", "replace"), max_num_fields=MOST_FIELDS)
    except TimeoutError as error:
        raise web.HTTPRequestTimeout(text=f"form: expected it within {HEADER_TIMEOUT:.0f} s\n") from error
    except ValueError as error:
        raise web.HTTPBadRequest(text=f"form: expected at most {MOST_FIELDS} fields, got more\n") from error
    return fields.get("token", [""])[0]


def _try(gate: Gate, request: web.Request, token: str, who: str, *, by_link: bool = False) -> web.StreamResponse:
    now = time.monotonic()
    if wait := math.ceil(gate.waits(who, now)):
        response = _form(LOCKED_LINK if by_link else f"Too many wrong tokens: wait {wait} s.", 429, token)
        response.headers["Retry-After"] = str(wait)
        return response
    if not gate.tried(token, who, now):
        return _form(WRONG, 401)
    response = web.Response(status=303, headers={"Location": "/"})
    secure = request.scheme == "https"
    response.set_cookie(_cookie_name(request), gate.cookie, httponly=True, samesite="Strict", secure=secure)
    return response


def _form(why: str, status: int, token: str = "") -> web.Response:
    """Return the form; a token in it is what somebody has shown already, and nothing that only we know."""
    text = resources.files(__package__).joinpath("login.html").read_text("utf-8")
    text = text.replace("{why}", why).replace("{token}", html.escape(token.encode("utf-8", "replace").decode()))
    return web.Response(text=text, content_type="text/html", status=status)


def _cookie_name(request: web.Request) -> str:
    """Cookies know hosts but no ports: two pages of one computer keep theirs apart by name."""
    port = request.host.rpartition(":")[2]
    known = port.isascii() and port.isdecimal() and len(port) <= 5
    return f"ross-{port if known else 443 if request.scheme == 'https' else 80}"
