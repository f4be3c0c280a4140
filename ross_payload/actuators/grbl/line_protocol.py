"""The conversation with grbl: one line at a time and its answer, and ``?`` in between."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

from ross_payload.actuators.driver_shell import TIME_TOLERANCE_S
from ross_payload.interfaces import Port
from ross_protocols.grbl.protocol import STATUS, Error, Garbage, Lines, Message, Ok, Report

REPORT_TIMEOUT_S = 0.1  # so long a `?` waits for its report before it is asked again [s]
MAX_DAMAGED, DAMAGE_WINDOW_S = 3, 1.0  # so many damaged lines within so many [s] are too many


class LineProtocol:
    """Says lines, asks for reports, and keeps the last of both; never waits.

    A report is dated with the time of the ``?`` that it answers: it is not older than that.
    """

    def __init__(self, port: Port) -> None:
        self._port = port
        self._lines = Lines()
        self._asked: float | None = None  # when the first `?` went out that nobody has answered [s]
        self._again = 0.0  # when to ask once more [s]
        self._damage: deque[tuple[float, str]] = deque(maxlen=MAX_DAMAGED)
        self.damaged_at = float("-inf")  # when the last line that cannot be true came [s]
        self.waiting = False  # for the answer to a line
        self.answer: Ok | Error = Ok()
        self.report: Report | None = None
        self.time = float("-inf")  # of the report [s]
        self.is_new = False  # whether the report came after the last answer

    def read(self, now: float) -> Iterator[Message]:
        """Give what grbl said, but for answers, in its order."""
        for data in self._port.receive():
            for message in self._lines.feed(data):
                if isinstance(message, Garbage):
                    self.on_damage(now, message.text)
                elif not isinstance(message, Ok | Error):
                    yield message
                elif self.waiting:
                    self.waiting, self.answer, self.is_new = False, message, False

    def on_report(self, report: Report) -> float:
        """Keep a report; return the time of its ``?`` [s]."""
        self.report, self.is_new = report, True
        if self._asked is not None:
            self.time, self._asked = self._asked, None
        return self.time

    def send_line(self, line: bytes) -> None:
        """Say a line and wait for its answer."""
        self._port.send(line)
        self.waiting = True

    def send_byte(self, byte: bytes) -> None:
        """Say a byte that acts at once."""
        self._port.send(byte)

    def poll_report(self, now: float, period: float) -> None:
        """Ask for a report, when one is due."""
        due = self.time + period if self._asked is None else self._again
        if now >= due - TIME_TOLERANCE_S:
            self._asked = now if self._asked is None else self._asked
            self._again = now + REPORT_TIMEOUT_S
            self._port.send(STATUS)

    def forget(self) -> None:
        """Expect no answers: grbl has been reset."""
        self.waiting, self._asked, self.is_new = False, None, False

    def on_damage(self, now: float, text: str) -> None:
        """Note a line that cannot be true."""
        self._damage.append((now, text))
        self.damaged_at = now

    def noise(self, now: float) -> str:
        """Say that the line is noisy; empty when it is not."""
        if len(self._damage) < MAX_DAMAGED or self._damage[0][0] < now - DAMAGE_WINDOW_S:
            return ""
        found = f"{MAX_DAMAGED} damaged lines within {DAMAGE_WINDOW_S:g} s, such as {self._damage[-1][1]}"
        return f"the serial line is noisy: {found}"
