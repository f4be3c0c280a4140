"""The screen: drawn again and again, with keys, until it is left."""

from __future__ import annotations

import asyncio
import sys

from rich.console import Console, Group
from rich.live import Live

from ross_payload.ground.monitor.keyboard import Keyboard
from ross_payload.ground.monitor.screen import Shown, compose
from ross_payload.ground.monitor.watch import Watch
from ross_payload.ground.station import Station

REDRAW = 0.2  # [s]


async def show(station: Station, watch: Watch, console: Console, ended: asyncio.Event) -> None:
    """Draw and obey keys until ``ended``; then the terminal is as it was."""
    wake = asyncio.Event()

    def press(key: str) -> None:
        watch.press(key)
        wake.set()

    unsubscribe = station.subscribe(watch.heard)
    keyboard = Keyboard(sys.stdin.fileno(), press, ended.set)
    with keyboard, Live(console=console, screen=True, auto_refresh=False, redirect_stderr=False) as live:
        while watch.going and not ended.is_set():
            wake.clear()
            watch.tick(station.now())
            live.update(_drawn(station, watch, console), refresh=True)
            await first_of(ended, wake, seconds=REDRAW)
    unsubscribe()


async def first_of(*events: asyncio.Event, seconds: float) -> None:
    """Wait for one of these events, so long at most."""
    tasks = [asyncio.ensure_future(event.wait()) for event in events]
    await asyncio.wait(tasks, timeout=seconds, return_when=asyncio.FIRST_COMPLETED)
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


def has_braille(console: Console) -> bool:
    """Whether a terminal can show more than ASCII."""
    return console.encoding.lower().startswith("utf")


def shown(station: Station, watch: Watch) -> Shown:
    """Return what goes on the screen now."""
    picture = watch.picture
    others = ", ".join(name for name, _, _ in watch.others)
    look_there = f"no telemetry from {watch.wanted}; receiving {others}" if picture is None and others else ""
    return Shown(
        picture=picture,
        now=station.now(),
        advice=station.advice() or look_there,
        links=station.links(),
        doings=watch.orders.doing,
        others=watch.others,
        chosen=watch.chosen,
        note=watch.note,
    )


def _drawn(station: Station, watch: Watch, console: Console) -> Group:
    width, height = console.size
    return Group(*compose(shown(station, watch), width, height, braille=has_braille(console)))
