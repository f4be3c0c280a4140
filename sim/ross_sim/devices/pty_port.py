"""A pseudo terminal that stands for the serial device of a simulated controller."""

from __future__ import annotations

import os
import select
import termios
import threading
import tty
from contextlib import suppress
from types import TracebackType
from typing import Self

from ross_payload.interfaces import Clock
from ross_sim.devices.wires import TICK, Side

MOST = 4096  # bytes of one look


class PtyServer:
    """Serves whoever opens the pseudo terminal ``name``; a context manager with a thread of its own.

    It stands for a device that is always plugged in: its own end stays open, so that programs come and go, and what
    nobody reads is dropped when the terminal is full. Modem lines there are none.

    Parameters
    ----------
    side
        Of the wire, see `ross_sim.devices.wires`.
    clock
        Both processes'.
    """

    def __init__(self, side: Side, clock: Clock) -> None:
        self._side = side
        self._clock = clock
        self._stopping = threading.Event()
        self._ours, self._theirs = os.openpty()
        tty.setraw(self._theirs, termios.TCSANOW)
        os.set_blocking(self._ours, False)
        self.name = os.ttyname(self._theirs)
        self._thread = threading.Thread(target=self._serve, name="pty")

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stopping.set()
        self._thread.join()
        os.close(self._ours)
        os.close(self._theirs)

    def _serve(self) -> None:
        while not self._stopping.is_set():
            if select.select([self._ours], [], [], TICK)[0]:
                self._side.arrived(os.read(self._ours, MOST), self._clock.now())
            for data in self._side.due(self._clock.now()):
                with suppress(BlockingIOError):  # nobody reads
                    os.write(self._ours, data)
