"""One look: the picture as soon as it is whole, for scripts."""

from __future__ import annotations

import asyncio
import json
import math

import click
from rich.console import Console, Group

from ross_payload.ground.errors import GroundError
from ross_payload.ground.monitor.live import first_of, has_braille, shown
from ross_payload.ground.monitor.screen import compose
from ross_payload.ground.monitor.watch import Watch
from ross_payload.ground.picture.known import Payload
from ross_payload.ground.station import Station

LOOK = 0.05  # [s] between two looks
GATHER = 6.0  # [s] after the first word, in which all that matters is repeated
ROWS = 40  # of a picture that goes to no terminal


async def look(
    station: Station, watch: Watch, console: Console, ended: asyncio.Event, *, wait: float, as_json: bool
) -> None:
    """Print the picture once.

    Raises
    ------
    GroundError
        When nothing was heard for ``wait`` seconds.
    """
    if not await _gathered(station, watch, ended, wait):
        return
    watch.tick(station.now())
    if as_json:
        click.echo(json.dumps(watch.picture))
        return
    rows = console.height - 1 if console.is_terminal else ROWS
    lines = compose(shown(station, watch), console.width, rows, braille=has_braille(console), keys=False)
    console.print(Group(*lines), end="")


async def _gathered(station: Station, watch: Watch, ended: asyncio.Event, wait: float) -> bool:
    """Wait until there is enough to show; tell whether there is, and nobody ended it."""
    began, first = station.now(), math.inf
    while not ended.is_set():
        known, now = watch.payload, station.now()
        if known is not None:
            first = min(first, now)
            if _is_whole(known) or now - first > GATHER:
                return True
        elif now - began > wait:
            raise GroundError(_silence(station, watch))
        await first_of(ended, seconds=LOOK)
    return False


def _silence(station: Station, watch: Watch) -> str:
    found = ", ".join(map(str, station.fleet.payloads))
    return (
        f"expected telemetry from {watch.wanted}, got {found}"
        if found
        else station.advice(patience=0.0) or "no telemetry"
    )


def _is_whole(known: Payload) -> bool:
    status = known.status
    if status is None or known.information is None or known.audio is None:
        return False
    return len(known.sources) >= min(status.k or 0, known.announced or 1)
