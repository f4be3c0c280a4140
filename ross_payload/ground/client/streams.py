"""What lets coroutines wait for a payload: a wake-up whenever something may have changed, and a queue of events."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import Self, TypeVar

from ross_payload.ground.client.events import Event
from ross_payload.ground.errors import LinkLost

Found = TypeVar("Found")
MOST_EVENTS = 10_000  # that wait for a slow reader; the oldest are dropped
NOT_OPEN, CLOSED = "the client is not open: use it inside of 'async with'", "the client is closed"
OTHER_LOOP = (
    "expected the event loop on which the client was opened; from another thread use asyncio.run_coroutine_threadsafe"
)


class Wakeup:
    """Wakes all coroutines that wait until something is found."""

    def __init__(self, ended: str = "") -> None:
        self._event = asyncio.Event()
        self._ended = ended  # why nothing changes; empty: something may
        self._loop: asyncio.AbstractEventLoop | None = None  # on which it is woken; None: on any

    def open(self) -> None:
        """Begin: from here on something may change, on the loop that runs. What is closed stays so."""
        self._loop = asyncio.get_running_loop()
        self._ended = "" if self._ended == NOT_OPEN else self._ended

    def check_loop(self, anyway: Callable[[], object] | None = None) -> None:
        """Find out that the client's own event loop runs; on another one ``anyway`` is called on that of the client.

        Raises
        ------
        RuntimeError
            On another event loop, as of another thread: nobody would wake who waits there.
        """
        if self._loop is None or self._loop is asyncio.get_running_loop():
            return
        if anyway is not None:
            self._loop.call_soon_threadsafe(anyway)
        raise RuntimeError(OTHER_LOOP)

    def wake(self) -> None:
        """Let every coroutine look again."""
        self._event.set()
        self._event = asyncio.Event()

    def close(self) -> None:
        """Let every coroutine end: nothing will change any more."""
        self._ended = CLOSED
        self.wake()

    def check_open(self, request: str) -> None:
        """Find out before something is sent that nothing would be received.

        Raises
        ------
        LinkLost
            When nothing changes.
        RuntimeError
            On another event loop, as of another thread: nobody would wake it.
        """
        self.check_loop()
        if self._ended:
            raise LinkLost(request, f"nothing was sent: {self._ended}")

    async def until(self, find: Callable[[], Found | None], request: str = "what is awaited") -> Found:
        """Return what ``find`` returns, as soon as that is true; ``request`` is what that is for.

        Raises
        ------
        LinkLost
            When there is nothing left to wait for.
        RuntimeError
            On another event loop, as of another thread: nobody would wake it.
        """
        self.check_loop()
        while not (found := find()):
            if self._ended:
                raise LinkLost(request, self._ended)
            await self._event.wait()
        return found

    async def within(self, seconds: float, find: Callable[[], Found | None]) -> Found | None:
        """Return what ``find`` returns as soon as that is true; None when it is not for so long."""
        with suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                return await self.until(find)
        return None


class EventStream:
    """The events since it was made, as an async iterator that ends with its client."""

    def __init__(self, changed: Wakeup) -> None:
        self._changed = changed
        self._events: deque[Event] = deque(maxlen=MOST_EVENTS)

    def on_event(self, event: Event) -> None:
        """Keep an event until somebody asks for it."""
        self._events.append(event)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> Event:
        try:
            await self._changed.until(lambda: self._events)
        except LinkLost as error:
            raise StopAsyncIteration from error
        return self._events.popleft()
