"""Keeps the voices that are enrolled while the payload runs, until `ross enroll --forget` deletes them."""

from __future__ import annotations

import logging
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import AbstractContextManager
from dataclasses import replace
from datetime import datetime
from itertools import count
from queue import SimpleQueue
from types import TracebackType

from ross_payload.errors import ConfigError, RossError
from ross_payload.events import Answer, Answered, Enrolled, Event
from ross_payload.interfaces import Input
from ross_payload.orders import Enrol, Order
from ross_payload.transport.async_task import begin
from ross_payload.voiceprint import EmbeddingPrint, VoiceStore
from ross_payload.voiceprint.store import NameTaken

log = logging.getLogger(__name__)

LISTING_S = 0.05  # [s] that the disk may take to say who is in the store: the pump waits
OVER = (Answer.DONE, Answer.REFUSED, Answer.FAILED, Answer.CANCELLED)


class VoiceKeeper(AbstractContextManager["VoiceKeeper"]):
    """An observer that stores every voice print which an order asks for; a context manager.

    Parameters
    ----------
    store
        Where voice prints are kept, readable by their owner only; None: nowhere.
    utc
        The time of day, for the note of consent; None while no clock can be trusted.
    """

    def __init__(self, store: VoiceStore | None, utc: Callable[[], datetime | None] = lambda: None) -> None:
        self._store = store
        self._utc = utc
        self._names: set[str] = set()  # given here; not all of them are written yet
        self._chosen: set[str] = set()  # of these, the numbers that nobody asked for
        self._listing: Future[tuple[str, ...]] | None = None  # of the store, under way
        self._listed: set[str] = set()  # who was in the store at the latest listing
        self._pending: dict[int, str] = {}  # of these, whose enrolment is not over, by the number of the order
        self._writer = ThreadPoolExecutor(max_workers=1, thread_name_prefix="voices")
        self._troubles: SimpleQueue[str] = SimpleQueue()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Wait until what was enrolled is written."""
        self._writer.shutdown()

    def named(self, order: Order) -> Order:
        """Return an order with a name for whom it enrols: "talker-" and a number, where none was told."""
        if not isinstance(order, Enrol):
            return order
        if order.name:
            self._chosen.discard(order.name)
            return order
        name = self._choose()
        if order.number:
            self._pending[order.number] = name
        return replace(order, name=name)

    def poll(self, send_text: Callable[[str], None]) -> None:
        """Tell in words what went wrong since the last call."""
        while not self._troubles.empty():
            send_text(self._troubles.get())

    def on_input(self, hop: Input) -> None:
        """Nobody is enrolled by a hop."""

    def on_event(self, event: Event, hop: Input) -> None:
        """Store a voice that was enrolled, without waiting for the disk; a number is free again if nobody was."""
        if isinstance(event, Answered) and event.answer in OVER:
            name = self._pending.pop(event.order, None)
            if name is not None and event.answer is not Answer.DONE:
                self._names.discard(name)
                self._chosen.discard(name)
        if isinstance(event, Enrolled) and self._store is not None and isinstance(event.voiceprint, EmbeddingPrint):
            now = self._utc()
            when = "at a time that no clock told" if now is None else f"{now:%Y-%m-%dT%H:%M:%SZ}"
            voice = event.voiceprint.agreed(f"told by the order to enrol, {when}")
            self._names.add(event.name)
            try:
                self._writer.submit(self._keep, self._store, event.name, voice)
            except RuntimeError as error:  # the system has no thread left: it is written with the next one
                self._tell_not_kept(event.name, error)

    def _choose(self) -> str:
        """Return the lowest number that nobody has, here or in the store, which other programs write to as well."""
        taken = self._names | self._stored()
        name = next(name for number in count(1) if (name := f"talker-{number}") not in taken)
        self._names.add(name)
        self._chosen.add(name)
        return name

    def _stored(self) -> set[str]:
        """Return who has a print in the store, as far as it can be read: it may be on a disk that is gone, or hangs."""
        if self._store is None:
            return set()
        self._listing = listing = self._listing or begin(self._store.names)
        if not wait((listing,), LISTING_S).done:
            log.warning("the store of voices does not answer: who was there before counts")
            return self._listed
        self._listing = None
        try:
            self._listed = set(listing.result())
        except (ConfigError, OSError) as error:
            log.warning("%s", error)
            self._listed = set()
        return self._listed

    def _keep(self, store: VoiceStore, name: str, voice: EmbeddingPrint) -> None:
        try:
            kept = self._saved(store, name, voice)
        except (RossError, OSError) as error:
            self._tell_not_kept(name, error)
            return
        log.info("enrolled %s; 'ross enroll %s --forget' deletes the voice print", kept, kept)
        if kept != name:
            self._troubles.put(f"voice print of {name} kept as {kept}: another {name} was enrolled meanwhile")

    def _tell_not_kept(self, name: str, error: Exception) -> None:
        log.error("%s is enrolled until this program ends: %s", name, error)
        self._troubles.put(f"voice print of {name} not kept: {error}")

    def _saved(self, store: VoiceStore, name: str, voice: EmbeddingPrint) -> str:
        """Save a voice and return its name: another number when somebody else has got a chosen one meanwhile."""
        while name in self._chosen:
            try:
                store.save(name, voice, new=True)
            except NameTaken:
                name = self._choose()
            else:
                return name
        store.save(name, voice)
        return name
