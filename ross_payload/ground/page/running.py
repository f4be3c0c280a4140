"""The process of ``ross ground``: from what the user wants to a page that is served until Ctrl-C."""

from __future__ import annotations

import asyncio
import signal
import ssl
import webbrowser
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

import click

from ross_payload.ground.errors import GroundError
from ross_payload.ground.links.keys import read_key
from ross_payload.ground.page.connections import raise_descriptor_limit
from ross_payload.ground.page.faults import FaultLog
from ross_payload.ground.page.security import is_loopback, new_token, read_token
from ross_payload.ground.page.server import Served, bound, serve
from ross_payload.ground.page.shelf import Flights
from ross_payload.ground.page.tiles import Tiles
from ross_payload.ground.page.tls import out_of_date, tls_of
from ross_payload.ground.station import Station

SILENCE = 10.0  # [s] without telemetry before the terminal says what to look at
LOOK = 1.0  # [s] between two looks at the log


@dataclass(frozen=True, slots=True)
class Wanted:
    """The options of the command."""

    urls: tuple[str, ...]
    port: int
    host: str
    token_file: Path | None
    certificate: Path | None
    key: Path | None
    mavlink_key: Path | None
    system_id: int
    log: Path | None
    flights: Path | None
    open_page: bool
    map: Path | None = None


def run(wanted: Wanted) -> None:
    """Serve the page until Ctrl-C or SIGTERM.

    Raises
    ------
    GroundError
        When a file, a URL or the address of the page is wrong.
    """
    tls = tls_of(wanted.certificate, wanted.key)
    if tls is not None and wanted.certificate is not None and (why := out_of_date(tls, wanted.certificate)):
        _warn(f"the certificate {wanted.certificate} {why}: browsers will not trust it")
    if wanted.flights is not None and wanted.flights != wanted.log and not wanted.flights.is_dir():
        raise GroundError(f"--flights {wanted.flights}: expected a folder, got none of that name")
    with nullcontext() if wanted.map is None else Tiles(wanted.map) as tiles:
        asyncio.run(_run(wanted, _token(wanted), tls, tiles))


def _token(wanted: Wanted) -> str | None:
    if wanted.token_file is not None:
        return read_token(wanted.token_file)
    return None if is_loopback(wanted.host) else new_token()


async def _run(wanted: Wanted, token: str | None, tls: ssl.SSLContext | None, tiles: Tiles | None) -> None:
    ended, loop = asyncio.Event(), asyncio.get_running_loop()
    loop.set_exception_handler(FaultLog().of_loop)
    raise_descriptor_limit()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, ended.set)
    key = None if wanted.mavlink_key is None else read_key(wanted.mavlink_key)
    flights = Flights(wanted.flights)
    listening = Station(wanted.urls, system_id=wanted.system_id, key=key, log=wanted.log)  # refuses a wrong URL
    with bound(wanted.host, wanted.port) as listener:  # before the log: a second ground must not leave an empty one
        async with (
            listening as station,
            serve(station, flights, host=wanted.host, token=token, tls=tls, listener=listener, tiles=tiles) as served,
        ):
            _announce(served, wanted, token)
            advising = asyncio.create_task(_advise(station))
            await ended.wait()
            advising.cancel()


def _announce(served: Served, wanted: Wanted, token: str | None) -> None:
    """Show the address; a token that was made is in it, one from a file stays there."""
    made = token is not None and wanted.token_file is None
    url = f"{served.url}?token={token}" if made else served.url
    click.echo(f"ross ground: {url}  (Ctrl-C ends it)")
    if wanted.certificate is None and not is_loopback(wanted.host):
        _warn("without --certificate all is sent in CLEAR TEXT: who reads the token can send commands")
    if wanted.open_page:
        webbrowser.open(url)


async def _advise(station: Station) -> None:
    """Say once what to look at when nothing comes, and when the log has ended."""
    await asyncio.sleep(SILENCE)
    if advice := station.advice():
        _warn(advice)
    while station.log is not None and not station.log.error:
        await asyncio.sleep(LOOK)
    if station.log is not None and station.log.error not in advice:
        _warn(station.log.error)


def _warn(text: str) -> None:
    click.echo(f"ross ground: {text}", err=True)
