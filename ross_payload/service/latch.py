"""A stop that outlives a restart: who stopped the payload does not want it to turn because its program crashed."""

from __future__ import annotations

import logging
from pathlib import Path

from ross_payload.bounded_files import set_aside
from ross_payload.events import Event, State, StateChanged
from ross_payload.interfaces import Input

log = logging.getLogger(__name__)


class StopLatch:
    """An observer that keeps a file while the payload is stopped by an order.

    A disk that takes no file is logged and changes nothing else: the stop itself is the guard's.

    >>> import tempfile
    >>> latch = StopLatch(Path(tempfile.mkdtemp()) / "stopped")
    >>> latch.closed
    False
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    @property
    def closed(self) -> bool:
        """Whether the payload was stopped and not armed again; in doubt it was, whatever lies in the file's place."""
        try:
            self._path.lstat()
        except (FileNotFoundError, NotADirectoryError):
            return False
        except OSError:
            return True
        return True

    def heard(self, heard: Input) -> None:
        """Hops do not stop anything."""

    def said(self, event: Event, heard: Input) -> None:
        """Keep the file from a stop until the payload is armed again."""
        try:
            if isinstance(event, StateChanged) and event.state is State.STOPPED:
                self._path.touch(mode=0o600)
            elif isinstance(event, StateChanged) and event.state is State.IDLE:
                self._open()
        except OSError as error:
            log.error("%s: the stop is not remembered: %s", self._path, error.strerror)

    def _open(self) -> None:
        """Remove the file; a folder in its place is renamed, for it would count as a stop for ever."""
        if self._path.is_dir() and not self._path.is_symlink():
            log.warning("%s: expected a file, got a folder; %s", self._path, set_aside(self._path, "unreadable"))
        self._path.unlink(missing_ok=True)
