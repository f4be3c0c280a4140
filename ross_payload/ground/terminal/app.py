"""The process of ``ross monitor``: a screen with keys, lines for logs, or one look; until the user ends it."""

from __future__ import annotations

import asyncio
import json
import math
import sys
from dataclasses import dataclass
from pathlib import Path

import click
from rich.console import Console, Group
from rich.live import Live

from ross_payload.ground.client.command_protocol import CommandProtocol
from ross_payload.ground.errors import GroundError
from ross_payload.ground.links.signing import read_key
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.station import Station
from ross_payload.ground.terminal.change_log import LineWriter
from ross_payload.ground.terminal.controller import Controller
from ross_payload.ground.terminal.keyboard import Keyboard
from ross_payload.ground.terminal.screen import ScreenState, compose
from ross_payload.transport.async_task import set_by_signal
from ross_protocols.mavlink.component_id import ComponentId

REDRAW_PERIOD_S = 0.2
LINES_PERIOD_S = 0.1  # between two looks for changes
LOOK_PERIOD_S = 0.05  # between two looks for something to print once
COMPLETE_WITHIN_S = 6.0  # of the first message all that matters is repeated
ROWS = 40  # of a picture that goes to no terminal


@dataclass(frozen=True, slots=True)
class Options:
    """The options of the command."""

    urls: tuple[str, ...]
    who: ComponentId | None
    json: bool
    once: bool
    wait: float  # [s]
    mavlink_key: Path | None
    system_id: int
    hear_at: tuple[str, int, str] | None = None  # address, port and codec of the streams that keys order


def run(options: Options) -> None:
    """Watch until ended by the user, or as long as one look takes.

    Raises
    ------
    GroundError
        When a URL or the key is wrong, or one look saw nothing.
    """
    asyncio.run(_run(options, Console(highlight=False)))


async def _run(options: Options, console: Console) -> None:
    key = None if options.mavlink_key is None else read_key(options.mavlink_key)
    ended = set_by_signal()
    async with Station(options.urls, system_id=options.system_id, key=key) as station:
        orders = CommandProtocol(station.send, station.system_id, station.component_id)
        controller = Controller(station.fleet, orders, options.who, options.hear_at)
        if options.once:
            await look(station, controller, console, ended, wait=options.wait, as_json=options.json)
        elif options.json or not console.is_terminal or console.is_dumb_terminal or not sys.stdin.isatty():
            await write_lines(station, LineWriter(as_json=options.json), options.who, ended)
        else:
            await show(station, controller, console, ended)


async def show(station: Station, controller: Controller, console: Console, ended: asyncio.Event) -> None:
    """Draw and obey keys until ``ended``; then the terminal is as it was."""
    wake = asyncio.Event()

    def press(key: str) -> None:
        controller.press(key)
        wake.set()

    unsubscribe = station.subscribe(controller.on_packet)
    keyboard = Keyboard(sys.stdin.fileno(), press, ended.set)
    with keyboard, Live(console=console, screen=True, auto_refresh=False, redirect_stderr=False) as live:
        while controller.going and not ended.is_set():
            wake.clear()
            controller.tick(station.now())
            live.update(_drawn(station, controller, console), refresh=True)
            await first_of(ended, wake, seconds=REDRAW_PERIOD_S)
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


def screen_state(station: Station, controller: Controller) -> ScreenState:
    """Return what goes on the screen now."""
    view = controller.view
    others = ", ".join(name for name, _, _ in controller.others)
    look_there = f"no telemetry from {controller.wanted}; receiving {others}" if view is None and others else ""
    return ScreenState(
        view=view,
        now=station.now(),
        advice=station.advice() or look_there,
        links=station.links(),
        doings=controller.orders.doing,
        others=controller.others,
        chosen=controller.chosen,
        note=controller.note,
        hearing=controller.hear_at is not None or any(each["on"] for each in (view or {}).get("streams", ())),
    )


def _drawn(station: Station, controller: Controller, console: Console) -> Group:
    width, height = console.size
    return Group(*compose(screen_state(station, controller), width, height, braille=has_braille(console)))


async def write_lines(station: Station, lines: LineWriter, wanted: ComponentId | None, ended: asyncio.Event) -> None:
    """Write a line per change until ``ended``, of one payload or of all."""
    while not ended.is_set():
        for link in station.links():
            lines.link(link.url, "" if link.up else link.error or "is not connected")
        if not station.fleet.payloads:
            lines.advise(station.advice() if station.links()[0].last is None else "")
        for who, known in list(station.fleet.payloads.items()):
            if wanted in (None, who):
                lines.look(known, station.now())
        await first_of(ended, seconds=LINES_PERIOD_S)


async def look(
    station: Station, controller: Controller, console: Console, ended: asyncio.Event, *, wait: float, as_json: bool
) -> None:
    """Print the picture once.

    Raises
    ------
    GroundError
        When nothing was heard for ``wait`` seconds.
    """
    if not await _gathered(station, controller, ended, wait):
        return
    controller.tick(station.now())
    if as_json:
        click.echo(json.dumps(controller.view))
        return
    rows = console.height - 1 if console.is_terminal else ROWS
    lines = compose(screen_state(station, controller), console.width, rows, braille=has_braille(console), keys=False)
    console.print(Group(*lines), end="")


async def _gathered(station: Station, controller: Controller, ended: asyncio.Event, wait: float) -> bool:
    """Wait until there is enough to show; tell whether there is, and nobody ended it."""
    began, first = station.now(), math.inf
    while not ended.is_set():
        known, now = controller.payload, station.now()
        if known is not None:
            first = min(first, now)
            if _is_whole(known) or now - first > COMPLETE_WITHIN_S:
                return True
        elif now - began > wait:
            raise GroundError(_silence(station, controller))
        await first_of(ended, seconds=LOOK_PERIOD_S)
    return False


def _silence(station: Station, controller: Controller) -> str:
    found = ", ".join(map(str, station.fleet.payloads))
    return (
        f"expected telemetry from {controller.wanted}, got {found}"
        if found
        else station.advice(delay=0.0) or "no telemetry"
    )


def _is_whole(known: PayloadState) -> bool:
    status = known.status
    if status is None or known.information is None or known.audio is None:
        return False
    return len(known.sources) >= min(status.k or 0, known.announced or 1)
