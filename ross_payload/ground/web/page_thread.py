"""The page beside a program that has no loop of its own, such as a simulation: on a thread."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from queue import SimpleQueue

from ross_payload.ground.recordings import RecordingStore
from ross_payload.ground.station import Station
from ross_payload.ground.web.faults import FaultLog
from ross_payload.ground.web.flight_library import FlightLibrary
from ross_payload.ground.web.server import Served, serve

Started = tuple[Served, asyncio.AbstractEventLoop, asyncio.Event]


@contextmanager
def in_background(
    urls: Sequence[str], *, port: int = 0, flights: Path | None = None, recordings: RecordingStore | None = None
) -> Iterator[Served]:
    """Serve the page on this computer with what is heard at the URLs, past flights of a folder, and recordings.

    Raises
    ------
    GroundError
        When a URL is none, or a port is in use.
    """
    outcomes: SimpleQueue[Started | BaseException] = SimpleQueue()
    thread = threading.Thread(target=_run, args=(outcomes, urls, port, flights, recordings), name="page", daemon=True)
    thread.start()
    started = outcomes.get()
    if isinstance(started, BaseException):
        thread.join()
        raise started
    served, loop, ended = started
    try:
        yield served
    finally:
        loop.call_soon_threadsafe(ended.set)
        thread.join()


def _run(
    outcomes: SimpleQueue[Started | BaseException],
    urls: Sequence[str],
    port: int,
    flights: Path | None,
    recordings: RecordingStore | None,
) -> None:
    async def serving() -> None:
        ended = asyncio.Event()
        asyncio.get_running_loop().set_exception_handler(FaultLog().of_loop)
        async with Station(urls) as station, serve(station, FlightLibrary(flights), recordings, port=port) as served:
            outcomes.put((served, asyncio.get_running_loop(), ended))
            await ended.wait()

    try:
        asyncio.run(serving())
    except BaseException as error:  # the caller's thread raises it
        outcomes.put(error)
