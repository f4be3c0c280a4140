"""Far ends for a ground station: voices of payloads on sockets of their own, and patience for real sockets."""

import asyncio
import socket
import time
from collections.abc import Awaitable, Callable
from typing import Any

from ross_payload.ground.station import Station
from ross_protocols.codec import Decoder, Encoder, Packet
from ross_protocols.values import Audio, Health, Heartbeat, Status

BEAT = Heartbeat(Health.ACTIVE, 6)
AUDIO = Audio(time_usec=1)
FRAME = Encoder(1, 191).encode(AUDIO)


def status(seconds: float) -> Status:
    """A status so many seconds [s] into the life of a payload."""
    return Status(round(seconds * 1e6), seconds, 3, earth=True, heading=0.5)


async def until(true: Callable[[], object], seconds: float = 30.0) -> Any:
    """Wait for something to become true, and return it."""
    async with asyncio.timeout(seconds):
        while not (found := true()):
            await asyncio.sleep(0.01)
    return found


class HandClock:
    """Real time that can be moved on."""

    def __init__(self) -> None:
        self.ahead = 0.0

    def now(self) -> float:
        """Return the time [s]."""
        return time.monotonic() + self.ahead


class Far:
    """The far end of a UDP link: speaks for one component and keeps what it hears."""

    def __init__(self, to: int, system: int = 1, component: int = 191, bind: int = 0, key: bytes | None = None) -> None:
        self.encoder = Encoder(system, component, key)
        self.heard: list[Packet] = []
        self._decoder = Decoder()
        self._to = ("127.0.0.1", to)
        self._sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._sock.bind(("127.0.0.1", bind))
        self._sock.setblocking(False)

    def say(self, *said: Any) -> None:
        """Send values, a datagram each."""
        for each in said:
            self.throw(self.encoder.encode(each))

    def throw(self, data: bytes) -> None:
        """Send a datagram."""
        self._sock.sendto(data, self._to)

    def listen(self) -> list[Packet]:
        """Return all that was heard."""
        while True:
            try:
                data = self._sock.recv(2048)
            except BlockingIOError:
                return self.heard
            self.heard += self._decoder.feed(data)

    def names(self) -> list[str]:
        """Return the names of what was heard."""
        return [packet.name for packet in self.listen()]

    def __enter__(self) -> "Far":
        return self

    def __exit__(self, *_: object) -> None:
        self._sock.close()


def run(claim: Callable[[], Awaitable[None]]) -> None:
    """Let it happen in a loop that complains, within two minutes."""
    asyncio.run(asyncio.wait_for(claim(), 120), debug=True)


def known(station: Station) -> list[str]:
    """Names of the payloads that a station has heard."""
    return [str(who) for who in station.fleet.payloads]


async def opened(*urls: str) -> None:
    """Open links, and close them."""
    async with Station(urls):
        pass
