"""The page as the process of ``ross ground``, until Ctrl-C, or on a thread of a program that has no loop of its own."""

from __future__ import annotations

import asyncio
import ssl
import threading
import webbrowser
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

import click

from ross_payload.ground.errors import GroundError
from ross_payload.ground.links.signing import read_key
from ross_payload.ground.recordings import RecordingStore
from ross_payload.ground.station import Station
from ross_payload.ground.web.connections import raise_descriptor_limit
from ross_payload.ground.web.faults import FaultLog, write_line
from ross_payload.ground.web.flight_library import FlightLibrary
from ross_payload.ground.web.security import is_loopback, new_token, out_of_date, read_token, tls_of
from ross_payload.ground.web.server import Served, bound, serve
from ross_payload.ground.web.tiles import Tiles
from ross_payload.transport.async_task import set_by_signal
from ross_protocols.mavlink.stream_command import unicast

ADVICE_AFTER_S = 10.0  # without telemetry before the terminal says what to look at
LOG_CHECK_PERIOD_S = 1.0  # between two looks at the log

Started = tuple[Served, asyncio.AbstractEventLoop, asyncio.Event]


@dataclass(frozen=True, slots=True)
class Options:
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
    audio_address: str = ""


def run(options: Options) -> None:
    """Serve the page until Ctrl-C or SIGTERM.

    Raises
    ------
    GroundError
        When a file, a URL or the address of the page is wrong.
    """
    tls = tls_of(options.certificate, options.key)
    if tls is not None and options.certificate is not None and (why := out_of_date(tls, options.certificate)):
        write_line(f"the certificate {options.certificate} {why}: browsers will not trust it")
    if options.flights is not None and options.flights != options.log and not options.flights.is_dir():
        raise GroundError(f"--flights {options.flights}: expected a folder, got none of that name")
    if options.audio_address:
        _check_address(options.audio_address)
    with nullcontext() if options.map is None else Tiles(options.map) as tiles:
        asyncio.run(_run(options, _token(options), tls, tiles))


def _check_address(text: str) -> None:
    try:
        unicast(text)
    except ValueError as error:
        raise GroundError(f"--audio-address: {str(error).removeprefix('address: ')}") from error


def _token(options: Options) -> str | None:
    if options.token_file is not None:
        return read_token(options.token_file)
    return None if is_loopback(options.host) else new_token()


async def _run(options: Options, token: str | None, tls: ssl.SSLContext | None, tiles: Tiles | None) -> None:
    asyncio.get_running_loop().set_exception_handler(FaultLog().of_loop)
    raise_descriptor_limit()
    ended = set_by_signal()
    key = None if options.mavlink_key is None else read_key(options.mavlink_key)
    flights = FlightLibrary(options.flights)
    listening = Station(options.urls, system_id=options.system_id, key=key, log=options.log)  # refuses a wrong URL
    with bound(options.host, options.port) as listener:  # before the log: a second ground must not leave an empty one
        async with (
            listening as station,
            serve(
                station,
                flights,
                host=options.host,
                token=token,
                tls=tls,
                listener=listener,
                tiles=tiles,
                audio_address=options.audio_address,
            ) as served,
        ):
            _announce(served, options, token)
            advising = asyncio.create_task(_advise(station))
            await ended.wait()
            advising.cancel()


def _announce(served: Served, options: Options, token: str | None) -> None:
    """Show the address; a token that was made is in it, one from a file stays there."""
    made = token is not None and options.token_file is None
    url = f"{served.url}?token={token}" if made else served.url
    click.echo(f"ross ground: {url}  (Ctrl-C ends it)")
    if options.certificate is None and not is_loopback(options.host):
        write_line("without --certificate all is sent in CLEAR TEXT: who reads the token can send commands and listen")
    if options.open_page:
        webbrowser.open(url)


async def _advise(station: Station) -> None:
    """Say once what to look at when nothing comes, and when the log has ended."""
    await asyncio.sleep(ADVICE_AFTER_S)
    if advice := station.advice():
        write_line(advice)
    while station.log is not None and not station.log.error:
        await asyncio.sleep(LOG_CHECK_PERIOD_S)
    if station.log is not None and station.log.error not in advice:
        write_line(station.log.error)


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
    thread = threading.Thread(target=_work, args=(outcomes, urls, port, flights, recordings), name="page", daemon=True)
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


def _work(
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
