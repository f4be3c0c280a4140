"""Keeps the voices that are enrolled while the payload runs, until `ross enroll --forget` deletes them."""

from __future__ import annotations

import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from dataclasses import replace
from datetime import UTC, datetime
from itertools import count
from queue import SimpleQueue
from types import TracebackType

from ross_payload.errors import ConfigError
from ross_payload.events import Enrolled, Event
from ross_payload.interfaces import Input
from ross_payload.orders import Enrol, Order
from ross_payload.voiceprint import EmbeddingPrint, VoiceStore

log = logging.getLogger(__name__)


class VoiceKeeper(AbstractContextManager["VoiceKeeper"]):
    """An observer that stores every voice print which an order asks for; a context manager.

    Parameters
    ----------
    store
        Where voice prints are kept, readable by their owner only; None: nowhere.
    """

    def __init__(self, store: VoiceStore | None) -> None:
        self._store = store
        self._names = set(store.names()) if store is not None else set()
        self._writer = ThreadPoolExecutor(max_workers=1, thread_name_prefix="voices")
        self._troubles: SimpleQueue[str] = SimpleQueue()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Wait until what was enrolled is written."""
        self._writer.shutdown()

    def named(self, order: Order) -> Order:
        """Return an order with a name for whom it enrols: "talker-" and a number, where none was told."""
        if not isinstance(order, Enrol) or order.name:
            return order
        name = next(name for number in count(1) if (name := f"talker-{number}") not in self._names)
        self._names.add(name)
        return replace(order, name=name)

    def poll(self, tell: Callable[[str], None]) -> None:
        """Tell in words what went wrong since the last call."""
        while not self._troubles.empty():
            tell(self._troubles.get())

    def on_input(self, hop: Input) -> None:
        """Nobody is enrolled by a hop."""

    def on_event(self, event: Event, hop: Input) -> None:
        """Store a voice that was enrolled, without waiting for the disk."""
        if isinstance(event, Enrolled) and self._store is not None and isinstance(event.voiceprint, EmbeddingPrint):
            when = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
            voice = event.voiceprint.agreed(f"told by the order to enrol, {when}")
            self._names.add(event.name)
            self._writer.submit(self._keep, self._store, event.name, voice)

    def _keep(self, store: VoiceStore, name: str, voice: EmbeddingPrint) -> None:
        try:
            store.save(name, voice)
        except (ConfigError, OSError) as error:
            log.error("%s is enrolled until this program ends: %s", name, error)
            self._troubles.put(f"voice print of {name} not kept: {error}")
        else:
            log.info("enrolled %s; 'ross enroll %s --forget' deletes the voice print", name, name)
