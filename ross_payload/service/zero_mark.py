"""Whether a zero that is declared at the start can be believed: not when the array was away from it as a payload died.

A motor without a sensor stands where the process that turned it has died, and the supervisor starts the next one,
which would declare that place the zero: all limits would move along.
"""

from __future__ import annotations

import logging
from concurrent.futures import Future, wait
from functools import partial
from pathlib import Path

from ross_payload.actuators.guard import Guard
from ross_payload.actuators.registry import checked_options
from ross_payload.atomic_files import write_whole
from ross_payload.config import Config
from ross_payload.events import Event
from ross_payload.interfaces import Input
from ross_payload.transport.async_task import begin

LAST_WRITE_S = 2.0  # that the disk may take at the end
log = logging.getLogger(__name__)


class ZeroMark:
    """An observer that keeps a file while the array is away from its zero, or nobody knows where it is.

    The file is written on a thread of its own: a disk that is slow or hangs holds nobody up.

    Parameters
    ----------
    folder
        Where it is kept: what outlives a restart.
    actuator
        Whose zero is declared when it is opened.
    """

    def __init__(self, folder: Path, actuator: Guard) -> None:
        self._path = folder / "away"
        self._actuator = actuator
        self._there = self._path.exists()  # the file, as was wished last
        self._known = False  # where it is, once at least
        self._work: Future[None] | None = None
        if self._there:
            log.warning("the payload ended while the array was away from its zero: home it first")
            actuator.doubt_zero()

    def on_input(self, hop: Input) -> None:
        """Look once per hop."""
        self.look()

    def look(self) -> None:
        """Have the file written, or removed, when the array has left its zero or is back at it.

        Before its place is known for the first time nothing has turned it.
        """
        state = self._actuator.state()
        self._known = self._known or state.homed
        if not self._known:
            return
        away = not state.homed or abs(state.angle) > self._actuator.capabilities.resolution
        if away or state.settled:
            self._keep(away=away)

    def on_event(self, event: Event, hop: Input) -> None:
        """Events turn nothing."""

    def forget(self) -> None:
        """Remove the file at an orderly end: who starts the payload again answers for where the array stands."""
        self._wait()
        self._write(away=False)

    def close(self) -> None:
        """Look once more, and wait, not for ever, until the disk has taken it."""
        self._wait()
        self.look()
        self._wait()

    def _wait(self) -> None:
        if self._work is not None:
            wait([self._work], LAST_WRITE_S)

    def _keep(self, *, away: bool) -> None:
        if self._work is not None and self._work.done() and self._work.exception() is not None:
            self._there, self._work = not self._there, None  # no thread was left: nothing has been written
        if away is not self._there and (self._work is None or self._work.done()):
            self._there, self._work = away, begin(partial(self._write, away=away))

    def _write(self, *, away: bool) -> None:
        try:
            if away:
                write_whole(self._path, b"")  # a power cut leaves the array there as well
            else:
                self._path.unlink(missing_ok=True)
        except OSError as error:
            log.warning("%s: %s: whether the array is at its zero is not kept", self._path, error.strerror)


def zero_mark_of(config: Config, folder: Path, actuator: Guard) -> ZeroMark | None:
    """Return the mark of an actuator whose zero is declared when it is opened; None: it finds or knows its zero."""
    declared = getattr(checked_options(config), "zero", "") == "declared"
    return ZeroMark(folder, actuator) if declared else None
