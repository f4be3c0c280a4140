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


class Wakeup:
    """Wakes all coroutines that wait until something is found."""

    def __init__(self) -> None:
        self._event = asyncio.Event()
        self._closed = False

    def wake(self) -> None:
        """Let every coroutine look again."""
        self._event.set()
        self._event = asyncio.Event()

    def close(self) -> None:
        """Let every coroutine end: nothing will change any more."""
        self._closed = True
        self.wake()

    async def until(self, find: Callable[[], Found | None]) -> Found:
        """Return what ``find`` returns, as soon as that is true.

        Raises
        ------
        LinkLost
            When there is nothing left to wait for.
        """
        while not (found := find()):
            if self._closed:
                raise LinkLost("what is awaited", "the client is closed")
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
