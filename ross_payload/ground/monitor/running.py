"""The process of ``ross monitor``: from what the user wants to a screen with keys, lines for logs, or one look."""

from __future__ import annotations

import asyncio
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from ross_payload.ground.clients.orders import Orders
from ross_payload.ground.links.keys import read_key
from ross_payload.ground.monitor.lines import Lines, tell_lines
from ross_payload.ground.monitor.live import show
from ross_payload.ground.monitor.once import look
from ross_payload.ground.monitor.watch import Watch
from ross_payload.ground.picture.known import Who
from ross_payload.ground.station import Station


@dataclass(frozen=True, slots=True)
class Wanted:
    """The options of the command."""

    urls: tuple[str, ...]
    who: Who | None
    json: bool
    once: bool
    wait: float  # [s]
    mavlink_key: Path | None
    system_id: int


def run(wanted: Wanted) -> None:
    """Watch until ended by the user, or as long as one look takes.

    Raises
    ------
    GroundError
        When a URL or the key is wrong, or one look saw nothing.
    """
    asyncio.run(_run(wanted, Console(highlight=False)))


async def _run(wanted: Wanted, console: Console) -> None:
    key = None if wanted.mavlink_key is None else read_key(wanted.mavlink_key)
    ended = asyncio.Event()
    with _signals(ended.set):
        async with Station(wanted.urls, system_id=wanted.system_id, key=key) as station:
            watch = Watch(station.fleet, Orders(station.send, station.system_id, station.component_id), wanted.who)
            if wanted.once:
                await look(station, watch, console, ended, wait=wanted.wait, as_json=wanted.json)
            elif wanted.json or not console.is_terminal or console.is_dumb_terminal or not sys.stdin.isatty():
                await tell_lines(station, Lines(as_json=wanted.json), wanted.who, ended)
            else:
                await show(station, watch, console, ended)


@contextmanager
def _signals(end: Callable[[], None]) -> Iterator[None]:
    """Let Ctrl-C and SIGTERM end it in good order."""
    loop = asyncio.get_running_loop()
    both = (signal.SIGINT, signal.SIGTERM)
    for number in both:
        loop.add_signal_handler(number, end)
    try:
        yield
    finally:
        for number in both:
            loop.remove_signal_handler(number)
