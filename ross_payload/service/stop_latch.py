"""A stop that outlives a restart: who stopped the payload does not want it to turn because its program crashed."""

from __future__ import annotations

import logging
import os
import threading
from collections.abc import Callable
from pathlib import Path
from queue import Empty, SimpleQueue

from ross_payload.bounded_files import set_aside
from ross_payload.events import Event, State, StateChanged
from ross_payload.interfaces import Input
from ross_payload.orders import Order, Rearm, Stop

RETRY_S = 1.0  # until it is tried again
LAST_CALL_S = 2.0  # that the disk may take at the end
STOPPED = "the payload was stopped by a command: re-arm it first"

log = logging.getLogger(__name__)


class StopLatch:
    """An observer that keeps a file from an order to stop until the payload is re-armed.

    The file is written by a thread of its own: a disk that is slow, full or hung holds up nobody who brakes. `saved`
    tells when it is safe; what cannot be saved is logged, told by `failure`, and tried again every second.

    Parameters
    ----------
    path
        The file; its folder must be there.
    sync
        Has a file descriptor's contents written to the disk.
    retry
        When to try again what the disk has refused [s].

    >>> import tempfile
    >>> latch = StopLatch(Path(tempfile.mkdtemp()) / "stopped")
    >>> latch.closed, latch.saved
    (False, True)
    """

    def __init__(self, path: Path, sync: Callable[[int], None] = os.fsync, retry: float = RETRY_S) -> None:
        self._path = path
        self._retry = retry
        self._sync = sync
        self._wishes: SimpleQueue[bool | None] = SimpleQueue()  # keep the file, remove it; None: end
        self._lock = threading.Lock()
        self._asked = self._done = 0
        self._rearmed = False  # the latest order of its kind was to arm again, not to stop
        self._thread: threading.Thread | None = None
        self.failure = ""  # why the latest wish could not be saved

    @classmethod
    def of(cls, folder: Path) -> StopLatch:
        """Return the one in a state folder, which need not be there to be looked at."""
        return cls(folder / "stopped")

    @property
    def closed(self) -> bool:
        """Whether the payload was stopped and not re-armed; in doubt it was, whatever lies in the file's place."""
        try:
            self._path.lstat()
        except (FileNotFoundError, NotADirectoryError):
            return False
        except OSError:
            return True
        return True

    @property
    def saved(self) -> bool:
        """Whether the disk has taken, or refused, everything so far."""
        return self._done >= self._asked

    def ordered(self, order: Order) -> None:
        """Begin to save a stop; from any thread, never waits."""
        if isinstance(order, Stop):
            self._rearmed = False
            self._wish(keep=True)
        elif isinstance(order, Rearm):
            self._rearmed = True

    def on_input(self, hop: Input) -> None:
        """Hops do not stop anything."""

    def on_event(self, event: Event, hop: Input) -> None:
        """Keep the file while stopped; remove it when re-armed, unless another stop is on its way.

        With a fault the payload is no longer stopped, but idles only after `Home` is done.
        """
        if isinstance(event, StateChanged) and event.state is State.STOPPED:
            self._wish(keep=True)
        elif isinstance(event, StateChanged) and event.state in (State.IDLE, State.DONE) and self._rearmed:
            self._wish(keep=False)

    def close(self) -> None:
        """Wait, not for ever, until everything is saved; idempotent."""
        if self._thread is not None:
            self._wishes.put(None)
            self._thread.join(LAST_CALL_S)
            self._thread = None

    def _wish(self, *, keep: bool) -> None:
        with self._lock:
            self._asked += 1
            self._wishes.put(keep)
            if self._thread is None:
                thread = threading.Thread(target=self._work, name="stop latch", daemon=True)
                try:
                    thread.start()
                except RuntimeError as error:  # the system has none left: the next wish asks again, and saves this one
                    self.failure = f"{self._path}: {error}"
                    log.error("%s: the stop was not saved: %s", self._path, error)
                else:
                    self._thread = thread

    def _work(self) -> None:
        latest: bool | None = None
        while True:
            try:
                wish = self._wishes.get(timeout=self._retry if self.failure else None)
            except Empty:  # it has failed, and nothing else was wished since
                self._save(keep=bool(latest))
                continue
            if wish is None:
                return
            latest = wish
            self._save(keep=wish)
            self._done += 1

    def _save(self, *, keep: bool) -> None:
        try:
            self._write(keep=keep)
        except OSError as error:
            if not self.failure:
                log.error("%s: the stop was not saved: %s", self._path, error.strerror)
            self.failure = f"{self._path}: {error.strerror}"
        else:
            if self.failure:
                log.info("%s: saved again", self._path)
            self.failure = ""

    def _write(self, *, keep: bool) -> None:
        if keep:
            self._synced(os.open(self._path, os.O_WRONLY | os.O_CREAT, 0o600))
        else:
            if self._path.is_dir() and not self._path.is_symlink():  # it would count as a stop for ever
                log.warning("%s: expected a file, got a folder; %s", self._path, set_aside(self._path, "unreadable"))
            self._path.unlink(missing_ok=True)
        self._synced(os.open(self._path.parent, os.O_RDONLY))

    def _synced(self, descriptor: int) -> None:
        try:
            self._sync(descriptor)
        finally:
            os.close(descriptor)
