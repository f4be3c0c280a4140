"""A payload for scripts: what it is asked, what it answers, and what happens at it.

::

    async with connect("udpin:127.0.0.1:14550") as payload:
        await payload.turn(10)

All of it happens on one asyncio loop. Angles are degrees, clockwise as on a compass: from north when the payload knows
where that is, else from the zero of its mount.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Self, TypeVar
from weakref import WeakSet

from ross_payload.ground.client import command_types
from ross_payload.ground.client.command_protocol import CommandProtocol
from ross_payload.ground.client.command_status import CANCELLED, DONE, FAILED, NO_ANSWER, REFUSED, CommandStatus
from ross_payload.ground.client.events import (
    ContactLost,
    ContactRestored,
    Event,
    SourceEstimate,
    TaskProgress,
    events_between,
)
from ross_payload.ground.client.param_client import ParamClient
from ross_payload.ground.client.parameters import REASON_TIMEOUT_S, Parameters
from ross_payload.ground.client.stream_requests import StreamRequests
from ross_payload.ground.client.streams import EventStream, Found
from ross_payload.ground.errors import LinkLost, NoPayload, RefusedByPayload, TaskCancelled, TaskFailed
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.model.state_reducer import MOST_SOURCES
from ross_payload.ground.model.view import Section, view
from ross_payload.ground.station import Station
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId

Number = TypeVar("Number", int, float)

TICK_S = 0.05  # between two looks at what is due
SILENT_S = 3.0  # without a message until contact counts as lost
SETTLED_TIMEOUT_S = 2.0  # for the status after a turn; on a vehicle that turns the axis may never be at rest
ESTIMATE_TIMEOUT_S = 6.0  # for the sources of an exploration: a link may lose them, and they are repeated every 5 s
FAILURES = {REFUSED: RefusedByPayload, FAILED: TaskFailed, CANCELLED: TaskCancelled, NO_ANSWER: LinkLost}


class Payload(StreamRequests):
    """One payload that an open `Station` receives. An async context manager.

    Every request is a coroutine that ends when the payload says that it is done, and raises otherwise:

    - `RefusedByPayload`, with the payload's reason;
    - `TaskFailed`, when it was begun and could not be completed;
    - `TaskCancelled`, when a cancel, a stop or another command ended it;
    - `LinkLost`, when nothing answers; it may have been done nevertheless. Before the client is opened and after it is
      closed nothing is sent, and `LinkLost` says so at once.

    All of them belong to the event loop on which the client was opened, and raise `RuntimeError` on that of another
    thread: from there, ``asyncio.run_coroutine_threadsafe(payload.turn(10), loop)``.

    There is no time limit but ``asyncio.timeout``. Cancelling a coroutine, also by a time limit, ends the waiting and
    nothing else: the payload goes on with its task, and only `cancel` or `stop` end that.

    Raises
    ------
    NoPayload
        When the station has not received that payload.
    """

    def __init__(self, station: Station, component: ComponentId) -> None:
        received = [str(each) for each in sorted(station.fleet.payloads)]
        if component not in station.fleet.payloads:
            found = ", ".join(received) or "none"
            raise NoPayload(
                f"expected the ComponentId of a payload that is received, got {component!r}; {found} is", received
            )
        self.id = component
        us = ComponentId(station.system_id, station.component_id)
        super().__init__(lambda message: station.send(message, component), component, us)
        self._station = station
        self._state = station.fleet.payloads[component]
        self._commands = CommandProtocol(station.send, *us)
        self._commands.on_state(self._state)  # it was received
        self._settings = ParamClient(station.send, component, *us)
        self._statuses: dict[int, CommandStatus] = {}
        self._event_streams: WeakSet[EventStream] = WeakSet()
        self._silent = False
        self.parameters = Parameters(self._settings, self._changed)

    async def __aenter__(self) -> Self:
        """Begin to follow it."""
        self._changed.open()
        self._station.fleet.pinned |= {self.id}
        self._end = self._station.subscribe(self._on_packet)
        self._ticking = asyncio.create_task(self._tick())
        return self

    async def __aexit__(self, *error: object) -> None:
        """End every iteration over events, and every request that is not over; the payload goes on."""
        self._ticking.cancel()
        with suppress(asyncio.CancelledError):
            await self._ticking
        self._end()
        self._changed.close()

    # ------------------------------------------------------------------------------------------ what it is asked

    async def explore(self) -> tuple[SourceEstimate, ...]:
        """Find the number of sources and every azimuth; return them.

        Raises
        ------
        LinkLost
            Also when it was done and what was found did not arrive.
        """
        before = [source.estimate for source in self._state.sources]
        await self.request(command_types.Explore())
        status = self._state.status  # the acknowledgement overtakes what was found

        def arrived() -> bool:
            sources, now = self._state.sources, self._state.status
            if now is None or now is status or now.k is None or len(sources) != min(now.k, MOST_SOURCES):
                return False
            return all(source.final and source.estimate not in before for source in sources)

        if not await self._changed.within(ESTIMATE_TIMEOUT_S, arrived):
            raise LinkLost("explore", f"it was done, and what was found did not arrive within {ESTIMATE_TIMEOUT_S:g} s")
        return self.sources

    async def listen_to(self, source: int | SourceEstimate) -> None:
        """Turn so that a source of the latest estimate can be separated, and listen to it until cancelled."""
        index = source.source if isinstance(source, SourceEstimate) else source
        await self.request(command_types.Listen(source=_given("source", index)))

    async def listen_at(self, azimuth_deg: float) -> None:
        """Turn so that whoever is at an azimuth can be separated, and listen until cancelled."""
        await self.request(command_types.Listen(azimuth=_given("azimuth_deg", azimuth_deg)))

    async def find_voice(self, azimuths_deg: Sequence[float] = (), first: int | None = None) -> None:
        """Find the enrolled voice and listen to it until cancelled.

        With ``azimuths_deg``, one to six of them, it is sought there without exploring, at the ``first`` to begin with.

        Raises
        ------
        ValueError
            When there are more azimuths, or a first one and none.
        """
        try:
            wanted = tuple(azimuths_deg)  # not an array, of which one that is zero counts as none
        except TypeError as error:
            raise ValueError(f"azimuths_deg: expected a list of numbers, got {azimuths_deg!r}") from error
        if len(wanted) > command_types.MOST_AZIMUTHS:
            raise ValueError(f"azimuths_deg: expected at most {command_types.MOST_AZIMUTHS}, got {len(wanted)}")
        if first is not None and not wanted:  # it would explore
            raise ValueError(f"first: expected azimuths_deg with it, got {first!r} alone")
        await self.request(command_types.Inform(wanted, first) if wanted else command_types.Listen())

    async def turn(self, heading_deg: float) -> None:
        """Point the axis from microphone 1 to microphone 2 to a heading and stay there."""
        await self.request(command_types.Turn(heading_deg))
        await self._settled()

    async def park(self) -> None:
        """Turn to the parking position of the payload's configuration."""
        await self.request(command_types.Park())
        await self._settled()

    async def home(self) -> None:
        """Find the zero of the joint."""
        await self.request(command_types.Home())
        await self._settled()

    async def measure_noise(self, duration_s: float = 0.0) -> None:
        """Measure the noise while nobody talks; 0: as long as the lead-in of the payload's configuration."""
        await self.request(command_types.Noise(duration_s))

    async def stop(self) -> None:
        """Decelerate now, end the task, and refuse to move until `rearm`."""
        await self.request(command_types.Stop())

    async def rearm(self) -> None:
        """Accept moves again after a stop or a fault."""
        await self.request(command_types.Rearm())

    async def cancel(self) -> None:
        """End the task, and be ready for the next one."""
        await self.request(command_types.Cancel())

    async def record(self, on: bool = True) -> None:
        """Start, or end, recording a session on the payload's disk."""
        await self.request(command_types.Record(on))

    async def request(self, order: command_types.Order) -> CommandStatus:
        """Send a command, again until it is answered, and wait until it is done.

        Raises
        ------
        RefusedByPayload, TaskFailed, TaskCancelled, LinkLost
            When it is not.
        ValueError
            When a number of it is none, or no 32-bit float can hold it: nothing is sent then.
        RuntimeError
            On another event loop than that of the client: nothing is sent then but a stop, for which nobody waits.
        """
        if not isinstance(order, command_types.Order):
            raise ValueError(f"order: expected one of the client's orders, got {order!r}")
        order.check()
        if isinstance(order, command_types.Stop):  # not without one because a program has a mistake
            self._changed.check_loop(anyway=lambda: self._commands.order(self.id, order))
        self._changed.check_open(order.words)
        self._commands.tick(self._station.now())
        number = self._commands.order(self.id, order)
        self._publish_progress()
        status = await self._changed.until(lambda: self._over(number), order.words)
        if status.state == DONE:
            return status
        own_words = await self._changed.within(REASON_TIMEOUT_S, lambda: self._own_words(number))  # a little later
        reason = own_words or self._statuses[number].reason
        if status.state == NO_ANSWER and (advice := self._station.advice()):
            reason = f"{reason} ({advice})"
        raise FAILURES[status.state](status.words, reason)

    # ------------------------------------------------------------------------------------------ what is known of it

    @property
    def state(self) -> PayloadState:
        """Return everything that is known of it, as telemetry says it, in radians, counter-clockwise."""
        return self._state

    @property
    def view(self) -> dict[str, Section]:
        """The same as plain JSON in the sections that the page draws: degrees, clockwise."""
        return view(self._state, self._settings.values)

    @property
    def sources(self) -> tuple[SourceEstimate, ...]:
        """The sources of the latest estimate."""
        return tuple(map(SourceEstimate.of, self._state.sources))

    def events(self) -> EventStream:
        """Iterate over what happens from here on, until the client is closed: ``async for event in payload.events()``.

        Every iteration gets every event. Of those that nobody asks for, the latest 10,000 are kept.
        """
        stream = EventStream(self._changed)
        self._event_streams.add(stream)
        return stream

    async def until(self, find: Callable[[], Found | None]) -> Found:
        """Wait until something holds, looked at after every message: ``await payload.until(lambda: payload.sources)``.

        Raises
        ------
        LinkLost
            When the client is closed before.
        """
        return await self._changed.until(find)

    # ------------------------------------------------------------------------------------------ inside

    def _on_packet(self, packet: Packet, at: float) -> None:
        if packet.sender != self.id:
            return
        before, self._state = self._state, self._station.fleet.payloads.get(self.id, self._state)
        self._commands.on_state(self._state)
        self._commands.on_packet(packet, at)
        self._settings.on_state(self._state)
        self._settings.on_packet(packet, at)
        self._on_file_packet(packet, at)
        if self._silent:
            self._silent = False
            self._publish(ContactRestored(at))
        for event in events_between(before, self._state) if before is not self._state else ():
            self._publish(event)
        self._publish_progress()

    async def _settled(self) -> None:
        """Wait a little until the status says where the axis has come to rest: the acknowledgement overtakes it."""
        before = self._state.status

        def arrived() -> bool:
            now = self._state.status
            return now is not None and now is not before and now.settled

        await self._changed.within(SETTLED_TIMEOUT_S, arrived)

    async def _tick(self) -> None:
        """Do what is due, until cancelled."""
        while True:
            now = self._station.now()
            self._commands.tick(now)
            if not self._read_files(now) and self.parameters.wanted:
                self._settings.tick(now)
            if not self._silent and now - self._state.last > SILENT_S:
                self._silent = True
                self._publish(ContactLost(now))
            self._publish_progress()
            await asyncio.sleep(TICK_S)

    def _reads_files(self) -> bool:
        return self.parameters.wanted and not self._settings.described

    def _publish(self, event: Event) -> None:
        for stream in self._event_streams:
            stream.on_event(event)

    def _publish_progress(self) -> None:
        """Tell what has become of every request, and wake whoever waits."""
        statuses = {status.number: status for status in self._commands.doing}
        for number, status in statuses.items():
            if self._statuses.get(number) != status:
                self._publish(TaskProgress(status.at, status.words, status.state, status.progress, status.reason))
        self._statuses = statuses
        self._changed.wake()

    def _over(self, number: int) -> CommandStatus | None:
        status = self._statuses.get(number)
        if status is None:
            raise LinkLost("a request", "too many later ones: it is not followed any longer")
        return status if status.over else None

    def _own_words(self, number: int) -> str | None:
        status = self._statuses[number]
        return status.reason if status.explained else None


def _given(name: str, value: Number | None) -> Number:
    """Return what a caller gave; None would be the order to find the enrolled voice.

    Raises
    ------
    ValueError
        When it is None, as the source of a voice that was not found.
    """
    if value is None:
        raise ValueError(f"{name}: expected a number, got None")
    return value
