"""What every wire of the ground side has: it opens itself again, never queues without bound, and says what is wrong.

A port tells its `Listener` whom it can send to, and what came from whom. All of it happens on one asyncio loop.
"""

from __future__ import annotations

import asyncio
import os
from collections.abc import Awaitable, Callable, Hashable
from contextlib import suppress
from dataclasses import dataclass
from typing import NoReturn, Protocol

HERE = "here"  # the peer of a port that has only one
MOST_WAITING = 65536  # bytes that a busy connection may owe; frames beyond are dropped
FIRST_PAUSE, LONGEST_PAUSE = 0.2, 0.8  # [s] between two attempts: what is there again is heard within 3 s

Peer = Hashable  # an address, or the number of a connection


class Listener(Protocol):
    """Who has a port."""

    def met(self, peer: Peer) -> None:
        """Learn that there is somebody to send to."""

    def came(self, peer: Peer, data: bytes) -> None:
        """Take what came from somebody."""

    def gone(self, peer: Peer) -> None:
        """Learn that somebody is no longer there."""


class Port(Protocol):
    """One end of a link."""

    health: Health

    async def open(self) -> None:
        """Begin. OSError: this computer refuses; ModuleNotFoundError: an extra is missing."""

    def send(self, frame: bytes, peer: Peer) -> None:
        """Send one frame or drop it; never waits."""

    async def close(self) -> None:
        """Give the port back; idempotent."""


@dataclass(slots=True)
class Health:
    """How a port is."""

    up: bool = False  # connected, as far as one can know
    error: str = ""  # the latest failure, in words; empty as soon as something is heard


async def keep(health: Health, hold: Callable[[], Awaitable[None]]) -> NoReturn:
    """Call ``hold``, which opens something and raises when it is lost, again and again."""
    pause = FIRST_PAUSE
    while True:
        try:
            await hold()
        except (OSError, ValueError) as error:  # a ValueError: a name or a rate that the system cannot take
            pause = FIRST_PAUSE if health.up else pause
            health.up, health.error = False, words(error)
        await asyncio.sleep(pause)
        pause = min(2 * pause, LONGEST_PAUSE)


async def cancelled(task: asyncio.Task[NoReturn] | None) -> None:
    """End a task and wait until it has cleaned up."""
    if task is not None:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


def words(error: Exception) -> str:
    """Return what is wrong, in words.

    >>> words(ConnectionRefusedError(111, "Connect call failed ('127.0.0.1', 5760)"))
    'Connection refused'
    """
    if isinstance(error, OSError) and error.errno and error.errno > 0:
        return os.strerror(error.errno)
    return (error.strerror if isinstance(error, OSError) else None) or str(error)
