"""The client of MAVLink FTP, as far as reading one file needs it. No port, no clock.

A burst brings most of a file; while it comes, its end is put off by asking for what follows, so that no way there and
back is waited for. What is missing is then asked for piece by piece. What comes doubled, late, or from another session
changes nothing.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from typing import Any

from ross_protocols.mavlink.codec import Packet as MavlinkPacket
from ross_protocols.mavlink.component_id import ComponentId, target_of
from ross_protocols.mavlink.ftp import MOST, Error, Opcode, Packet, message_of, packet_of

MOST_BYTES = 1_000_000  # of a file
ANSWER_TIMEOUT_S = 1.0  # [s] for an answer
GOING_ON_S = 1.0  # [s] between two requests for more of a burst; the payload ends it 2.5 s after the latest one
MOST_UNANSWERED = 8  # requests in a row, until it is given up
MOST_REOPENS = 4  # times, when the other side forgets what is open
BURST_FROM = 4 * MOST  # a gap that is worth a burst [bytes]


class FileReader:
    """One file of a component: ``content`` when it is whole, or ``trouble``, why it cannot be had, in words.

    It begins with the first `tick`. ``send`` takes messages; ``us`` are the ids of whoever reads. Requests are numbered
    on from ``sequence``, so that no answer to a reading before can be taken for one to this.
    """

    def __init__(
        self, send: Callable[[Any], None], who: ComponentId, us: ComponentId, path: str, sequence: int = 0
    ) -> None:
        self.content: bytes | None = None
        self.trouble = ""
        self.sequence = sequence
        self._send = send
        self._who = who
        self._us = us
        self._path = path
        self._opens: set[int] = set()  # sequence numbers of answers to an open
        self._session = 0
        self._file: bytearray | None = None  # None: it is not open
        self._gaps: list[tuple[int, int]] = []  # from, to [bytes]
        self._due = self._asked = -math.inf
        self._tried = self._opened = 0

    @property
    def unanswered(self) -> bool:
        """Whether it was given up because nothing answered."""
        return self._tried > MOST_UNANSWERED

    @property
    def over(self) -> bool:
        """Whether it has ended, well or not."""
        return self.content is not None or bool(self.trouble)

    def tick(self, now: float) -> None:
        """Ask for what has not come."""
        if self.over or now < self._due:
            return
        if self.unanswered:
            self.trouble = f"{self._path}: no answer"
            return
        self._ask(now)

    def on_packet(self, packet: MavlinkPacket, now: float) -> None:
        """Take a packet; what is no answer to us passes by."""
        if self.over or packet.sender != self._who:
            return
        answer = packet_of(packet.message)
        if answer is None or not target_of(packet.message).includes(self._us):
            return
        if answer.opcode == Opcode.NAK:
            self._refused(answer, now)
        elif answer.opcode == Opcode.ACK and answer.asked == Opcode.OPEN_RO:
            self._open(answer, now)
        elif answer.opcode == Opcode.ACK and answer.asked in (Opcode.READ, Opcode.BURST_READ):
            self._on_data(answer, now)

    def _ask(self, now: float) -> None:
        self._tried += 1
        self._asked, self._due = now, now + ANSWER_TIMEOUT_S
        if self._file is None:
            name = self._path.encode("ascii", "replace")[:MOST]
            self._opens.add((self.sequence + 2) % 65536)
            self._request(Opcode.OPEN_RO, data=name, size=len(name))
            return
        start, end = self._gaps[0]
        opcode = Opcode.BURST_READ if end - start > BURST_FROM else Opcode.READ
        self._request(opcode, size=min(end - start, MOST), offset=start)

    def _request(self, opcode: Opcode, **fields: Any) -> None:
        self.sequence = (self.sequence + 1) % 65536
        request = Packet(self.sequence, opcode, self._session, **fields)
        self._send(message_of(request, self._who))

    def _open(self, answer: Packet, now: float) -> None:
        if self._file is not None or len(answer.data) < 4 or answer.sequence not in self._opens:
            return
        (size,) = struct.unpack_from("<I", answer.data)
        if size > MOST_BYTES:
            self.trouble = f"{self._path}: expected at most {MOST_BYTES} bytes, got {size}"
            return
        self._session, self._file, self._gaps = answer.session, bytearray(size), [(0, size)] if size else []
        self._go_on(now)

    def _on_data(self, answer: Packet, now: float) -> None:
        if self._file is None or answer.session != self._session:
            return
        start, end = answer.offset, min(answer.offset + len(answer.data), len(self._file))
        if start >= end:
            return
        self._file[start:end] = answer.data[: end - start]
        before, self._gaps = self._gaps, without(self._gaps, start, end)
        if self._gaps != before:
            self._tried = 0
        bursting = answer.asked == Opcode.BURST_READ and not answer.burst_complete
        if bursting and self._gaps:
            self._due = now + ANSWER_TIMEOUT_S
            if self._gaps != before and end < len(self._file) and now - self._asked >= GOING_ON_S:
                self._asked = now
                self._request(Opcode.BURST_READ, size=MOST, offset=end)
        elif self._gaps != before:
            self._go_on(now)

    def _go_on(self, now: float) -> None:
        self._tried = 0
        if self._gaps:
            self._ask(now)
            return
        self.content = bytes(self._file or b"")
        self._request(Opcode.TERMINATE)

    def _refused(self, answer: Packet, now: float) -> None:
        """Open it again when the other side has restarted; else tell why not."""
        if answer.asked not in (Opcode.OPEN_RO, Opcode.READ, Opcode.BURST_READ):
            return
        why = answer.data[0] if answer.data else 0
        if why == Error.INVALID_SESSION and self._file is not None and self._opened < MOST_REOPENS:
            self._opened += 1
            self._file, self._session = None, 0
            self._ask(now)
        elif why == Error.FILE_NOT_FOUND:
            self.trouble = f"{self._path}: there is no such file"
        elif why != Error.END_OF_FILE and self._file is None:
            self.trouble = f"{self._path}: refused (error {why})"


def without(gaps: list[tuple[int, int]], start: int, end: int) -> list[tuple[int, int]]:
    """Return what is left of some gaps, each from and to, when a piece is filled.

    >>> without([(0, 10), (20, 30)], 5, 22)
    [(0, 5), (22, 30)]
    """
    left = [(low, high) for gap in gaps for low, high in ((gap[0], min(gap[1], start)), (max(gap[0], end), gap[1]))]
    return [(low, high) for low, high in left if low < high]
