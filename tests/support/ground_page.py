"""The page in the loop of a test, and a browser without a screen."""

from __future__ import annotations

import asyncio
import json
import socket
import threading
from contextlib import asynccontextmanager, contextmanager

import aiohttp

from ross_payload.ground.web.server import serve
from ross_protocols.mavlink.values import Audio

WAIT = 20.0  # [s] for something that must come


class Browser:
    """Speaks the protocol of the page's socket; keeps what came."""

    def __init__(self, socket):
        self.socket, self.got = socket, []

    async def say(self, **message):
        await self.socket.send_str(json.dumps(message))

    async def next(self, kind, want=lambda message: True):
        """Return the next message of a type that is wanted; others are kept in `got`."""
        async with asyncio.timeout(WAIT):
            while True:
                message = json.loads(await self.socket.receive_str())
                self.got.append(message)
                if message["type"] == kind and want(message):
                    return message


@asynccontextmanager
async def browser(url, you="", window=None, **options):
    """Connect; ``window`` [bytes] makes the receive buffer of the system small."""

    def connected(address):
        made = socket.socket(*address[:3])
        if window is not None:
            made.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, window)
        return made

    address = url.split("?")[0] + "live" + (f"?you={you}" if you else "")
    connector = aiohttp.TCPConnector(socket_factory=connected)
    async with aiohttp.ClientSession(connector=connector) as client, client.ws_connect(address, **options) as live:
        yield Browser(live)


@asynccontextmanager
async def page(station, flights=None, **options):
    async with serve(station, flights, **options) as served:
        yield served


@contextmanager
def on_a_thread(station, **options):
    """Serve the page beside the test; yield its port, and the faults that it has told so far."""
    ready, ended, told, faults = threading.Event(), asyncio.Event(), [], []

    async def run():
        loop = asyncio.get_running_loop()
        loop.set_exception_handler(lambda _, words: faults.append(words))
        async with page(station, **options) as served:
            told.extend((int(served.url.rstrip("/").rpartition(":")[2]), loop))
            ready.set()
            await ended.wait()

    thread = threading.Thread(target=lambda: asyncio.run(run()))
    thread.start()
    try:
        assert ready.wait(20)
        yield told[0], faults
    finally:
        told[1].call_soon_threadsafe(ended.set)
        thread.join()


def audio(rate=16000):
    """What a payload says of its microphones."""
    return Audio(time_usec=0, rate=rate)
