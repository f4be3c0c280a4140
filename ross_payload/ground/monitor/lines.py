"""Lines for logs and for other programs: one per change, each with its time."""

from __future__ import annotations

import asyncio
import json
import time
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

import click

from ross_payload.ground.monitor.clean import clean
from ross_payload.ground.monitor.live import first_of
from ross_payload.ground.monitor.tell import Teller
from ross_payload.ground.picture.known import Payload, Who
from ross_payload.ground.picture.view import view
from ross_payload.ground.station import Station

LOOK = 0.1  # [s] between two looks for changes


@dataclass(slots=True)
class _Told:
    """What was told of one payload."""

    teller: Teller = field(default_factory=Teller)
    known: Payload | None = None  # at the last look


class Lines:
    """Writes to standard output, in words or as JSON."""

    def __init__(self, *, as_json: bool) -> None:
        self._as_json = as_json
        self._told: dict[Who, _Told] = {}
        self._links: dict[str, str] = {}
        self._advice = ""

    def look(self, known: Payload, now: float) -> None:
        """Tell what is new about a payload."""
        told = self._told.setdefault(known.who, _Told())
        for heard in told.teller.presence(known.last, now):
            self._write(known.who, "heard", told.teller.present, heard)
        if told.known is known:
            return
        told.known, picture = known, clean(view(known))
        if self._as_json:
            for name, value in told.teller.sections(picture):
                self._write(known.who, name, value, "")
        else:
            for line in told.teller.words(picture):
                self._write(known.who, "", None, line)

    def link(self, url: str, words: str) -> None:
        """Tell how a link is when that changes; empty: it is up."""
        if self._links.get(url) != words:
            self._links[url] = words
            value = {"url": url, "up": not words, "error": words}
            self._write(None, "link", value, f"link {url} {words or 'is open'}")

    def advise(self, advice: str) -> None:
        """Tell what is wrong, once."""
        if advice and not self._advice:
            self._write(None, "advice", advice, advice)
        self._advice = advice

    def _write(self, who: Who | None, section: str, value: Any, words: str) -> None:
        at = time.time()
        if self._as_json:
            name = None if who is None else str(who)
            click.echo(json.dumps({"time": round(at, 3), "payload": name, "section": section, "value": value}))
        else:
            stamp = datetime.fromtimestamp(at).astimezone().isoformat(timespec="milliseconds")
            click.echo(f"{stamp} {who or '-'} {words}")


async def tell_lines(station: Station, lines: Lines, wanted: Who | None, ended: asyncio.Event) -> None:
    """Write a line per change until ``ended``, of one payload or of all."""
    while not ended.is_set():
        for link in station.links():
            lines.link(link.url, "" if link.up else link.error or "is not connected")
        if not station.fleet.payloads:
            lines.advise(station.advice() if station.links()[0].last is None else "")
        for who, known in list(station.fleet.payloads.items()):
            if wanted in (None, who):
                lines.look(known, station.now())
        await first_of(ended, seconds=LOOK)
