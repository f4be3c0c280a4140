"""What a client of the file server has open in one of its sessions, and what it waits for."""

from __future__ import annotations

import math
from collections import deque
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from typing import Protocol

from ross_protocols.mavlink.ftp import Opcode, Packet


class Content(Protocol):
    """What a client has open."""

    @property
    def size(self) -> int:
        """Its length [bytes]."""

    def read(self, offset: int, size: int) -> bytes | None:
        """Return a portion, empty behind the end; None: ask again later."""


@dataclass(frozen=True, slots=True)
class InMemory:
    """A file in memory."""

    content: bytes

    @property
    def size(self) -> int:
        """Its length [bytes]."""
        return len(self.content)

    def read(self, offset: int, size: int) -> bytes:
        """Return a portion, empty behind the end."""
        return self.content[offset:][:size]


@dataclass(slots=True)
class Session:
    """One session."""

    link: str
    content: Content | None = None
    name: str = ""  # of the content, as it was asked for
    reads: deque[Packet] = field(default_factory=deque)  # portions that were asked for one by one
    burst: Packet | None = None  # the next portion of a burst, as a request
    asked: int = 0  # offset of the latest request for a burst
    ends: float = -math.inf  # the burst [s]
    job: tuple[Packet, Future[Content | bytes]] | None = None  # what it asks of the disk
    last_answer: tuple[Packet, Packet, float] | None = None  # the last request to the disk, its answer, when [s]

    def open(self, content: Content, name: str) -> None:
        """Have a file open, and nothing of the one before."""
        self.content, self.name, self.burst = content, name, None
        self.reads.clear()

    def put_in_line(self, request: Packet, most: int) -> None:
        """Let a portion wait; asked for again, with whatever number, it waits once. Of too many the last is lost."""
        alike = (place for place, each in enumerate(self.reads) if each.offset == request.offset)
        place = next(alike, None)
        if place is not None:
            self.reads[place] = request
        elif len(self.reads) < most:
            self.reads.append(request)

    @property
    def next(self) -> Packet | None:
        """The next portion, as a request: a gap goes before the burst that has left it."""
        return self.reads[0] if self.reads else self.burst

    def goes_on(self, request: Packet) -> bool:
        """Let a burst go on that has come up to the offset of a request; False: it has to begin there.

        Who asks for the same offset again has not got what is there.
        """
        before, self.asked = self.asked, request.offset
        if self.burst is None or not before < request.offset <= self.burst.offset:
            return False
        self.burst = replace(request, offset=self.burst.offset)
        return True

    def sent(self, request: Packet, answer: Packet) -> None:
        """Go on behind an answered portion."""
        if request.opcode == Opcode.READ:
            self.reads.popleft()
        elif answer.opcode == Opcode.NAK or answer.burst_complete:
            self.burst = None
        else:
            after = request.offset + len(answer.data)
            self.burst = replace(request, sequence=request.sequence + 1, offset=after)
