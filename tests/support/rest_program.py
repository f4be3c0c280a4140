"""A program that speaks the REST interface of a page."""

from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any

import aiohttp

BASE = "api/v1"
PAYLOAD = "/payloads/1-191"


@dataclass(frozen=True)
class Answer:
    status: int
    told: Any  # JSON, or bytes of anything else
    headers: Any

    def refused(self, status, code):
        """Tell the reason of a problem, after a look at its form."""
        assert self.status == status, self.told
        assert self.headers["Content-Type"] == "application/problem+json"
        assert (self.told["status"], self.told["code"], self.told["type"]) == (status, code, "about:blank")
        assert self.told["title"]
        assert "\n" not in self.told["detail"]
        return self.told["detail"]


class Program:
    def __init__(self, session, url):
        self.session, self.base = session, url.split("?")[0] + BASE

    async def ask(self, method, path, **how):
        async with self.session.request(method, self.base + path, **how) as answer:
            body = await answer.read()
            told = await answer.json(content_type=None) if "json" in answer.content_type and body else body
            return Answer(answer.status, told, answer.headers)

    async def get(self, path, **how):
        return await self.ask("GET", path, **how)

    async def order(self, wait=None, who="1-191", **order):
        """Order something of a kind."""
        path = f"/payloads/{who}/orders" + (f"?wait={wait}" if wait is not None else "")
        return await self.ask("POST", path, json=order)

    async def events(self, path):
        """Yield the events of a stream as kind and data."""
        async with self.session.get(self.base + path) as answer:
            assert (answer.status, answer.content_type) == (200, "text/event-stream")
            kind = ""
            async for line in answer.content:
                name, _, value = line.decode().strip().partition(": ")
                if name == "event":
                    kind = value
                elif name == "data":
                    yield kind, value


@asynccontextmanager
async def program(served, name="", token="", **how):
    """Connect a program that has a name, and shows a token."""
    headers = ({"Ross-Client": name} if name else {}) | ({"Authorization": f"Bearer {token}"} if token else {})
    async with aiohttp.ClientSession(headers=headers, **how) as session:
        yield Program(session, served.url)
