"""What every wire of a link has: it never waits, never queues without bound and never raises, but counts.

What cannot be sent at once is dropped and counted: the next report is more worth than the last one.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Any, Protocol, runtime_checkable

Peer = Any  # what a listening port knows a peer by: a socket address, or the number of a connection

MOST = 8192  # that one call reads: a flood cannot hold up who polls [bytes]
PEERS = 16  # that one listening port answers
WAITING = 64  # connections that one listening port keeps besides, until they are admitted


@dataclass(frozen=True, slots=True)
class Counts:
    """How a port is, and what went through it."""

    up: bool = True  # connected, as far as one can know
    sent: int = 0  # frames handed to the system
    dropped: int = 0  # frames that would have had to wait
    refused: int = 0  # times that nobody listened there
    failed: int = 0  # other errors, and frames for a connection that is gone
    received: int = 0  # bytes
    reconnects: int = 0  # connections after the first one
    baud: int = 0  # of a serial line, as soon as it is known
    error: str = ""  # the latest failure, in words


class LinkPort(Protocol):
    """A port that counts."""

    @property
    def counts(self) -> Counts:
        """How the port is, and what went through it."""

    def send(self, frame: bytes) -> None:
        """Send one frame or drop it; never waits."""

    def receive(self) -> list[bytes]:
        """Return what has arrived; never waits."""

    def close(self) -> None:
        """Give the port back; idempotent."""


@runtime_checkable
class Listener(Protocol):
    """A port that anybody can speak to: it tells its peers apart, and can be told to answer only some of them."""

    connected: bool  # whether a peer's address is proven by a connection

    def require_admission(self) -> None:
        """From now on, send to admitted peers only."""

    def receive_from(self, now: float, busy: Collection[Peer]) -> list[tuple[Peer, bytes]]:
        """Return what has arrived at ``now`` [s], and from whom; nothing of ``busy`` peers. Never waits."""

    def admit(self, peer: Peer) -> None:
        """Answer a peer from now on; when there are too many, the one unheard for longest has to go."""

    def expire(self, patience: float, now: float) -> None:
        """Close the connections that were not admitted within ``patience`` [s]."""

    def send(self, frame: bytes) -> None:
        """Send one frame to every peer that is answered."""


def noted(counts: Counts, error: OSError) -> Counts:
    """Count one failure to send or receive."""
    if isinstance(error, BlockingIOError):
        return replace(counts, dropped=counts.dropped + 1)
    if isinstance(error, ConnectionRefusedError):
        return replace(counts, refused=counts.refused + 1)
    return replace(counts, failed=counts.failed + 1, error=error.strerror or str(error))
