"""PortAudio as microphones and sound outputs share it: a process has it once, and one thread at a time may call it.

It lists the devices when it is initialised, and only then. To have the list made again it must be terminated, which
ends every stream, whoever has opened it, and nobody may ask anything of such a stream any more.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

CLOSE_TIMEOUT_S = 5.0  # that closing waits for a driver which hangs
SELDOM = 5  # attempts to open a device from one new list to the next: sounddevice silences stderr while it makes one


class SharedPortAudio:
    """Opens streams, and knows which of them PortAudio has ended.

    Parameters
    ----------
    module
        The binding to PortAudio, as of sounddevice.
    """

    def __init__(self, module: Any) -> None:
        self._module = module
        self._guard = threading.Lock()  # of all that PortAudio is asked
        self._streams: set[OpenStream] = set()
        self._is_initialised = True
        self._attempts = 0  # since the list was made

    @contextmanager
    def listed(self, *, ends_others: bool) -> Iterator[Callable[[Any], OpenStream]]:
        """Look for a device and open it; gives what takes a stream that was made, starts and keeps it.

        The list of devices is made again now and then, unless somebody else has a stream open.

        Parameters
        ----------
        ends_others
            Whether the list is made again in any case: without microphones there is nothing that others could play.
        """
        with self._guard:
            if ends_others or (self._attempts >= SELDOM and not self._streams):
                self._list_again()
            self._attempts += 1
            yield self._started

    def is_active(self, stream: OpenStream) -> bool:
        """Tell whether a stream runs; from any thread, never waits."""
        if not self._guard.acquire(blocking=False):
            return stream in self._streams  # a device is being opened: what became of it shows afterwards
        try:
            return stream in self._streams and bool(stream.stream.active)
        finally:
            self._guard.release()

    def close(self, stream: OpenStream) -> None:
        """End a stream, unless it has ended; what the driver says of a device that is gone does not matter."""
        if self._guard.acquire(timeout=CLOSE_TIMEOUT_S):
            try:
                if stream in self._streams:
                    self._streams.remove(stream)
                    stream.stream.close(ignore_errors=True)
            finally:
                self._guard.release()

    def _started(self, made: Any) -> OpenStream:
        try:
            made.start()
        except BaseException:
            made.close(ignore_errors=True)
            raise
        stream = OpenStream(self, made)
        self._streams.add(stream)
        return stream

    def _list_again(self) -> None:
        if self._is_initialised:
            self._is_initialised = False
            try:
                self._module._terminate()
            finally:
                self._streams.clear()  # not before: its callbacks run until then
        self._module._initialize()
        self._is_initialised, self._attempts = True, 0


class OpenStream:
    """A stream of PortAudio that was started."""

    def __init__(self, library: SharedPortAudio, stream: Any) -> None:
        self._library = library
        self.stream = stream

    @property
    def active(self) -> bool:
        """Whether it runs; from any thread, never waits."""
        return self._library.is_active(self)

    def close(self) -> None:
        """Give the device back; idempotent."""
        self._library.close(self)


@cache
def shared(module: Any) -> SharedPortAudio:
    """Return what all who use a binding to PortAudio share."""
    return SharedPortAudio(module)
