"""From URLs to the client of a payload: `connect`, with which scripts begin."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager, suppress
from numbers import Integral, Real
from pathlib import Path

from ross_payload.ground.client.payload import Payload
from ross_payload.ground.client.streams import Wakeup
from ross_payload.ground.errors import GroundError, NoPayload
from ross_payload.ground.links.signing import read_key
from ross_payload.ground.station import Station
from ross_protocols.mavlink.component_id import ComponentId

OTHERS_S = 1.5  # after the first payload, in which every other one sends a heartbeat
KEY_BYTES = 32
CONNECT_TIMEOUT_S = 60.0  # a simulation, or a computer that boots, takes its time


@asynccontextmanager
async def connect(
    *urls: str,
    payload: ComponentId | str | None = None,
    key: bytes | Path | str | None = None,
    log: Path | str | None = None,
    system_id: int = 254,
    timeout_s: float = CONNECT_TIMEOUT_S,
) -> AsyncGenerator[Payload]:
    """Open links, wait for a payload, and give its client.

    Parameters
    ----------
    urls
        Where to listen or connect, such as ``udpin:127.0.0.1:14550``, see docs/reference/links.md.
    payload
        Which of several, such as ``"2-191"``; None: the only one that is received.
    key
        The signing key of 32 bytes, or its file: what is sent is signed, and only what is signed with it is received.
    log
        Folder for a .tlog of everything received and sent.
    system_id
        Who we are, 1 to 255; nobody else on the links may have the same. `ross ground` has 254, too.
    timeout_s
        How long to wait for the payload [s].

    Raises
    ------
    NoPayload
        When none is received in time, not the one that is wanted, or several and none is named.
    GroundError
        When a link cannot be opened, or the key is none.
    ValueError
        When there is no URL, ``payload`` is no id, ``system_id`` none, or something else of the wrong type. Nothing is
        opened then.
    """
    _check(urls, system_id, timeout_s)
    wanted = _id_of(payload)
    if not isinstance(key, Path | str | bytes | bytearray | None):
        raise ValueError(f"key: expected {KEY_BYTES} bytes, or their file, got {key!r}")
    if not isinstance(log, Path | str | None):
        raise ValueError(f"log: expected a folder, got {log!r}")
    secret = read_key(Path(key)) if isinstance(key, Path | str) else key
    if secret is not None and len(secret) != KEY_BYTES:
        raise GroundError(f"key: expected {KEY_BYTES} bytes, got {len(secret)}")
    async with (
        Station(urls, system_id=system_id, key=secret, log=None if log is None else Path(log)) as station,
        Payload(station, await _received(station, wanted, timeout_s)) as client,
    ):
        yield client


def _check(urls: tuple[str, ...], system_id: int, timeout_s: float) -> None:
    """Find out what is no URL, no system id and no time, before anything is opened.

    Raises
    ------
    ValueError
        When something is.
    """
    if not urls:
        raise ValueError("urls: expected one such as udpin:127.0.0.1:14550, got none")
    for url in urls:
        if not isinstance(url, str):
            hint = "; for a list: connect(*urls)" if isinstance(url, list | tuple) else ""
            raise ValueError(f"urls: expected text such as udpin:127.0.0.1:14550, got {url!r}{hint}")
    if not isinstance(system_id, Integral) or isinstance(system_id, bool) or not 1 <= system_id <= 255:
        raise ValueError(f"system_id: expected 1 to 255, got {system_id!r}")
    if not isinstance(timeout_s, Real) or not timeout_s >= 0:
        raise ValueError(f"timeout_s: expected a number of seconds from 0, got {timeout_s!r}")


def _id_of(payload: ComponentId | str | None) -> ComponentId | None:
    """Return the id of the payload that is wanted.

    Raises
    ------
    ValueError
        When it is none.
    """
    if payload is None:
        return None
    if isinstance(payload, str):
        return ComponentId.parse(payload)
    if not isinstance(payload, tuple) or len(payload) != 2:
        raise ValueError(f"payload: expected an id such as '1-191', got {payload!r}")
    return ComponentId.parse("-".join(map(str, payload)))


async def _received(station: Station, wanted: ComponentId | None, timeout_s: float) -> ComponentId:
    """Wait for the payload that is wanted; None: for the only one there is."""
    payloads, arrived = station.fleet.payloads, Wakeup()
    end = station.subscribe(lambda packet, at: arrived.wake())
    try:
        with suppress(TimeoutError):
            async with asyncio.timeout(timeout_s):
                await arrived.until(lambda: wanted in payloads if wanted else payloads)
                await asyncio.sleep(0 if wanted else OTHERS_S)
    finally:
        end()
    if wanted in payloads or (wanted is None and len(payloads) == 1):
        return wanted or next(iter(payloads))
    received = [str(each) for each in sorted(payloads)]
    what = f"expected payload {wanted or ''}".strip() if wanted or not received else "expected one payload, or its id"
    found = ", ".join(received) if received else station.advice(delay=0.0)
    raise NoPayload(f"{what} within {timeout_s:g} s, got {found}", received)
