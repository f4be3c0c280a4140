"""Who speaks to a payload's ports without its key, and a station that has it."""

import secrets
import socket
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.signing import timestamp_of
from ross_protocols.mavlink.values import Health, Heartbeat

BEAT = Heartbeat(Health.ACTIVE, 6)
KEY = bytes(range(32))
STOP = 54004
PORTS = 20


def key_file(folder: Path) -> Path:
    """Write the key."""
    path = folder / "key"
    path.write_bytes(KEY)
    path.chmod(0o600)
    return path


def stop_command() -> Any:
    return common.MAVLink_command_long_message(1, 191, STOP, 0, *[0.0] * 7)


class Station:
    """Signs what it says with consecutive times; counts what it hears."""

    def __init__(self, unix: float, system: int = 255, key: bytes | None = KEY, link: int = 7) -> None:
        self._encoder = Encoder(system, 190, key, link)
        self._stamp = timestamp_of(unix)
        self.sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.sock.setblocking(False)
        self._decoder = Decoder()
        self.heard = 0

    def frame(self, said: Any = BEAT) -> bytes:
        self._stamp += 1
        return self._encoder.encode(said, self._stamp)

    def listen(self) -> int:
        """Take in what has arrived; return how many messages were heard so far."""
        with suppress(BlockingIOError):
            while True:
                self.heard += len(self._decoder.feed(self.sock.recv(2048)))
        return self.heard


class Strangers:
    """Twenty ports that take turns to say every kind of nonsense."""

    def __init__(self, where: tuple[str, int]) -> None:
        self._where = where
        self._socks = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(PORTS)]
        for sock in self._socks:
            sock.setblocking(False)
        unsigned, wrong = Encoder(9, 1), Encoder(255, 190, bytes(32), 7)
        self._kinds: list[Callable[[], bytes]] = [
            lambda: b"x",
            lambda: b"\xfd",  # begins a frame
            lambda: b"\xfd\xff\x00\x00\x01\xff\xbe\xff\xff\xff",  # a long one, of a message that nobody knows
            lambda: b"\xfe" * 400,
            lambda: secrets.token_bytes(1400),
            lambda: unsigned.encode(BEAT),
            lambda: wrong.encode(BEAT, 2**47),
        ]
        self._count = 0

    def say(self, count: int) -> None:
        for _ in range(count):
            data = self._kinds[self._count % len(self._kinds)]()
            self._socks[self._count % PORTS].sendto(data, self._where)
            self._count += 1

    def heard(self) -> int:
        """Return how many datagrams they were sent."""
        count = 0
        for sock in self._socks:
            with suppress(BlockingIOError):
                while sock.recv(2048):
                    count += 1
        return count

    def close(self) -> None:
        for sock in self._socks:
            sock.close()
