"""Writes log lines on a thread of its own, so that nobody who logs waits for whoever reads.

A terminal that is held (Ctrl-S), that of an SSH connection that hangs, a pipe that nobody reads and a journal that
stalls take no more lines at some time. The pump and the mission log, too: they must go on.
"""

from __future__ import annotations

import logging
import os
import select
import threading
from queue import SimpleQueue

MOST_LINES = 1000  # that wait
LAST_WRITE_S = 1.0  # that whoever reads may take at the end


class LogWriter(logging.Handler):
    """Queues what is logged and writes it to a file descriptor; when too much waits, what is new is lost and counted.

    Parameters
    ----------
    descriptor
        Where to write. The thread has a copy of its own, since it may write for longer than this one is open.
    encoding
        Of the lines.

    Raises
    ------
    RuntimeError
        When the system has no thread left.
    """

    def __init__(self, descriptor: int, encoding: str = "utf-8") -> None:
        super().__init__()
        self._thread: threading.Thread | None = threading.Thread(target=self._work, name="log", daemon=True)
        self._descriptor = os.dup(descriptor)
        self._encoding = encoding
        self._lines: SimpleQueue[str | None] = SimpleQueue()  # None: end
        self._lost = 0
        self._over = False  # what is left is not written any more
        try:
            self._thread.start()
        except RuntimeError:
            self._thread = None
            os.close(self._descriptor)
            super().close()
            raise

    def emit(self, record: logging.LogRecord) -> None:
        """Queue a line; never waits."""
        if self._lines.qsize() >= MOST_LINES:
            self._lost += 1
            return
        self._tell_lost()
        try:
            self._lines.put(self.format(record))
        except Exception:  # as the handlers of `logging` do: what cannot be formatted ends nothing
            self.handleError(record)

    def close(self) -> None:
        """Wait, not for ever, until everything is written; idempotent."""
        if self._thread is not None:
            self._tell_lost()
            self._lines.put(None)
            self._thread.join(LAST_WRITE_S)
            self._over = True
            self._thread = None
        super().close()

    def _tell_lost(self) -> None:
        lost, self._lost = self._lost, 0
        if lost:
            text = "%d log lines were lost: whoever reads them is too slow"
            self._lines.put(self.format(logging.LogRecord(__name__, logging.WARNING, "", 0, text, (lost,), None)))

    def _work(self) -> None:
        for line in iter(self._lines.get, None):
            if self._over:
                break
            self._write(f"{line}\n".encode(self._encoding, "backslashreplace"))
        os.close(self._descriptor)

    def _write(self, data: bytes) -> None:
        while data:
            try:
                data = data[os.write(self._descriptor, data) :]
            except BlockingIOError:  # somebody else has made it one that does not wait
                select.select((), (self._descriptor,), ())
            except OSError:  # whoever read has gone
                return
