"""Keeps the voices that are enrolled while the payload runs, until `ross enroll --forget` deletes them."""

from __future__ import annotations

import logging
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import replace
from datetime import UTC, datetime
from itertools import count
from queue import SimpleQueue

from ross_payload.errors import ConfigError
from ross_payload.events import Enrolled, Event
from ross_payload.interfaces import Input
from ross_payload.orders import Enrol, Order
from ross_payload.voiceprint import VoicePrintModel, VoiceStore

log = logging.getLogger(__name__)


class VoiceKeeper:
    """An observer that stores every voice print which an order asks for.

    Parameters
    ----------
    store
        Where voice prints are kept, readable by their owner only.
    writer
        On whose thread the disk is waited for.
    tell
        Says in words, to whoever listens to the payload, what went wrong; called by `poll`.
    """

    def __init__(self, store: VoiceStore, writer: Executor, tell: Callable[[str], None]) -> None:
        self._store = store
        self._writer = writer
        self._tell = tell
        self._given: set[str] = set()  # names that are not stored yet
        self._troubles: SimpleQueue[str] = SimpleQueue()

    def named(self, order: Order) -> Order:
        """Return an order with a name for whom it enrols: a number, where none was told."""
        if not isinstance(order, Enrol) or order.name:
            return order
        known = {*self._store.names(), *self._given}
        name = next(name for number in count(1) if (name := f"talker-{number}") not in known)
        self._given.add(name)
        return replace(order, name=name)

    def poll(self) -> None:
        """Tell what went wrong; on the pump."""
        while not self._troubles.empty():
            self._tell(self._troubles.get())

    def on_input(self, hop: Input) -> None:
        """Nobody is enrolled by a hop."""

    def on_event(self, event: Event, hop: Input) -> None:
        """Store a voice that was enrolled."""
        if isinstance(event, Enrolled) and isinstance(event.voiceprint, VoicePrintModel):
            when = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
            model = replace(event.voiceprint, consent=f"told by the order to enrol, {when}")
            self._writer.submit(self._keep, event.name, model)

    def _keep(self, name: str, model: VoicePrintModel) -> None:
        try:
            self._store.save(name, model)
        except (ConfigError, OSError) as error:
            log.error("%s is enrolled until this program ends: %s", name, error)
            self._troubles.put(f"voice print of {name} not kept: {error}")
        else:
            log.info("enrolled %s; 'ross enroll %s --forget' deletes the voice print", name, name)
