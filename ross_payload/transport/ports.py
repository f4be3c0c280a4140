"""What every transport has: it never waits, never queues without bound and never raises, but counts.

What cannot be sent at once is dropped and counted: the next report is more worth than the last one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Protocol

from ross_payload.errors import reason

Peer = Any  # what a listening port knows a peer by: a socket address, or the number of a connection

MAX_READ_BYTES = 8192  # of one call: a flood cannot hold up who polls
MAX_PEERS = 16  # that one listening port answers, unless told
MAX_WAITING_CLIENTS = 64  # connections that one listening port keeps besides, until they are admitted


@dataclass(frozen=True, slots=True)
class PortOptions:
    """How a port treats its far ends; the defaults are those of a payload."""

    first_pause_s: float = 0.5  # before a lost connection is tried again; every further pause is twice as long
    longest_pause_s: float = 8.0
    connect_timeout_s: float = 3.0
    vanished_after_s: float = 20.0  # without an answer, the other side of a TCP connection is taken for gone
    max_clients: int = MAX_PEERS  # that a TCP server answers
    first_come: bool = False  # every client is admitted as it comes, and one that finds no room is turned away


DEFAULTS = PortOptions()


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
    trouble: str = ""  # what is wrong now, in words; empty as soon as it is connected, or something is received


class Transport(Protocol):
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


def with_outcome(counts: Counts, taken: bool) -> Counts:
    """Count one frame that was sent, or dropped because it would have had to wait."""
    return replace(counts, sent=counts.sent + taken, dropped=counts.dropped + (not taken))


def with_failure(counts: Counts, error: Exception) -> Counts:
    """Count one failure to send or receive."""
    if isinstance(error, BlockingIOError):
        return replace(counts, dropped=counts.dropped + 1)
    if isinstance(error, ConnectionRefusedError):
        return replace(counts, refused=counts.refused + 1, trouble=reason(error))
    return replace(counts, failed=counts.failed + 1, error=reason(error), trouble=reason(error))
