"""Server-sent events: what happens at a payload from now on, as the client for scripts tells it, and to its orders."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

from aiohttp import web
from pydantic import TypeAdapter

from ross_payload.ground.client import events
from ross_payload.ground.client.command_status import CommandStatus
from ross_payload.ground.client.events import events_between
from ross_payload.ground.client.streams import Wakeup
from ross_payload.ground.errors import LinkLost
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.web.rest.operation import Call
from ross_payload.ground.web.rest.order_handlers import told_of
from ross_payload.ground.web.rest.page_answers import OrderStatus
from ross_payload.ground.web.rest.places import OfPayload
from ross_payload.ground.web.security import PRIVATE
from ross_protocols.mavlink.codec import Packet

MEDIA = "text/event-stream"
KEEP_ALIVE_S = 10.0  # without an event until a comment shows that the stream lives
STALLED_S = 10.0  # that a program may take nothing
MOST_WAITING = 1000  # events; the oldest are dropped
KINDS: tuple[type, ...] = (
    events.StateChanged,
    events.SourceFound,
    events.SourceMoved,
    events.TargetFound,
    events.TargetLost,
    events.FaultRaised,
    events.FaultCleared,
    events.StreamChanged,
    events.TextReceived,
    events.PayloadRestarted,
    OrderStatus,
)  # by which an event is called, and whose fields are its data
ADAPTERS: dict[type, TypeAdapter[Any]] = {kind: TypeAdapter(kind) for kind in KINDS}


class EventQueue:
    """What has happened at one payload since it was made, as text of the stream; a context manager."""

    def __init__(self, call: Call, where: OfPayload) -> None:
        self._call, self._who = call, where.who
        self._known: PayloadState = call.operator.known(where.who)
        self._orders: dict[int, CommandStatus] = self._statuses()
        self._waiting: deque[str] = deque(maxlen=MOST_WAITING)

    def __enter__(self) -> EventQueue:
        """Begin to listen."""
        self._end = self._call.operator.state.station.subscribe(self._on_packet)
        return self

    def __exit__(self, *error: object) -> None:
        """Listen no more."""
        self._end()

    def due(self) -> str:
        """Return what has happened since the last call; empty: nothing."""
        for status in self._changed_orders():
            self._waiting.append(text_of(told_of(status)))
        texts = "".join(self._waiting)
        self._waiting.clear()
        return texts

    def _on_packet(self, packet: Packet, at: float) -> None:
        after = self._call.operator.state.station.fleet.payloads.get(self._who)
        if packet.sender != self._who or after is None or after is self._known:
            return
        before, self._known = self._known, after
        self._waiting.extend(text_of(event) for event in events_between(before, after))

    def _changed_orders(self) -> Iterator[CommandStatus]:
        before, self._orders = self._orders, self._statuses()
        yield from (status for number, status in self._orders.items() if before.get(number) != status)

    def _statuses(self) -> dict[int, CommandStatus]:
        return {each.number: each for each in self._call.operator.state.client.doing(self._who)}


async def get_events(call: Call, where: OfPayload) -> web.StreamResponse:
    """What happens from now on, as server-sent events, until the program goes.

    An event is called StateChanged, SourceFound, SourceMoved, TargetFound, TargetLost, FaultRaised, FaultCleared,
    StreamChanged, TextReceived, PayloadRestarted or OrderStatus; its data are JSON, with the fields of the schema of
    that name. Who asks keeps control, if it has it, as long as the stream is open.
    """
    with call.programs.streaming(), EventQueue(call, where) as queue:
        response = web.StreamResponse(headers={**PRIVATE, "Content-Type": MEDIA})
        await response.prepare(call.request)
        try:
            await _write(response, queue, call.operator.state.changed)
        except TimeoutError:
            if call.request.transport is not None:
                call.request.transport.abort()
    return response


async def _write(response: web.StreamResponse, queue: EventQueue, changed: Wakeup) -> None:
    """Write what happens until the page ends, the program leaves, or it takes nothing for long (TimeoutError)."""
    with suppress(LinkLost, ConnectionError):
        while True:
            text = await changed.within(KEEP_ALIVE_S, queue.due)
            async with asyncio.timeout(STALLED_S):
                await response.write((text or ": still here\n\n").encode())


def text_of(happened: Any) -> str:
    r"""Return an event as the stream has it.

    >>> text_of(events.TargetLost(2.5))
    'event: TargetLost\ndata: {"at":2.5}\n\n'
    """
    data = ADAPTERS[type(happened)].dump_json(happened).decode()
    return f"event: {type(happened).__name__}\ndata: {data}\n\n"
