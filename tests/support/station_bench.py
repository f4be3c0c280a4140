"""Far ends for a ground station: voices of payloads on sockets of their own, and patience for real sockets."""

import asyncio
import contextlib
import socket
from typing import Any

from ross_payload.ground.station import Station
from ross_protocols.mavlink.codec import Decoder, Encoder, Packet
from ross_protocols.mavlink.values import Audio, Health, Heartbeat, Status

BEAT = Heartbeat(Health.ACTIVE, 6)
AUDIO = Audio(time_usec=1)
FRAME = Encoder(1, 191).encode(AUDIO)


def status(seconds: float) -> Status:
    """A status so many seconds [s] into the life of a payload."""
    return Status(round(seconds * 1e6), seconds, 3, earth=True, heading=0.5)


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
        with contextlib.suppress(RuntimeError):  # no loop runs here
            asyncio.get_running_loop().set_debug(True)  # it complains of calls from other threads
        return self

    def __exit__(self, *_: object) -> None:
        self._sock.close()


def known(station: Station) -> list[str]:
    """Names of the payloads that a station has heard."""
    return [str(who) for who in station.fleet.payloads]


async def opened(*urls: str) -> None:
    """Open links, and close them."""
    async with Station(urls):
        pass
