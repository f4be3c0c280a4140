"""What can be listened to: by its URL, a feed of samples that are taken as the clock of who plays asks for them."""

from __future__ import annotations

import http.client
import ipaddress
import urllib.error
import urllib.parse
import urllib.request
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, Self

from ross_payload.bounded_files import read_bounded
from ross_payload.errors import AudioError, ConfigError, reason, refused_as, shown
from ross_payload.interfaces import Samples
from ross_payload.transport.link_url import LOOPBACK, MAX_PORT, tcp_endpoint
from ross_payload.transport.rtp.session_description import L16, LONGEST, OPUS, Media, Session, parsed

EXPECTED = "expected rtp://ADDRESS:PORT, a file or an http address that ends in .sdp, or tcp://HOST:PORT"
SDP_TIMEOUT_S = 5.0  # for a session description over HTTP
RATES = range(4000, 192_001)
DEFAULT_RATE = 16_000


@dataclass(frozen=True, slots=True)
class Progress:
    """How a feed is."""

    playing: bool  # something is heard at the moment
    received: bool  # something came at all
    words: str  # about delay and losses
    ended: bool = False  # the sender said that it is over
    final: bool = False  # nothing can come any more
    silent_s: float = 0.0  # since anything came from the sender


class Feed(Protocol):
    """What is listened to. A context manager."""

    where: str  # in words

    @property
    def rate(self) -> int:
        """Of the samples [Hz]."""

    def read(self, n: int) -> Samples:
        """Return the next ``n`` samples, (n,), zeros where there is nothing; from any thread, never waits."""

    def progress(self, wall: float) -> Progress:
        """Tell how it goes, when the time of day is ``wall`` [s since 1970]."""

    def __enter__(self) -> Self:
        """Begin to listen.

        Raises
        ------
        AudioError
            When there is nothing to listen to, or nowhere.
        """

    def __exit__(self, *exception: object) -> None:
        """Listen no more."""


def source_of(url: str) -> Session | tuple[str, int]:
    """Read what is to be listened to: a stream of RTP, or a server of PCM, (host, port).

    >>> source_of("rtp://:5004?codec=L16&rate=24000").media
    Media(codec='L16', rate=24000, payload_type=96)
    >>> source_of("tcp://192.0.2.7:7000")
    ('192.0.2.7', 7000)

    Raises
    ------
    ConfigError
        When it is anything else, or a session description cannot be read.
    AudioError
        When nobody serves the session description.
    """
    kind, separator, rest = url.partition("://")
    if separator and kind == "rtp":
        return _rtp(url)
    if kind == "tcp":
        return tcp_endpoint(f"tcp:{rest}", url)
    if kind in ("http", "https"):
        return parsed(_fetched(url), url)
    if not separator and url.endswith(".sdp"):
        with refused_as(ConfigError, f"{url}: cannot be read"):
            return parsed(read_bounded(Path(url), LONGEST).decode("utf-8", "replace"), url)
    raise ConfigError(f"{shown(url)}: {EXPECTED}")


def _rtp(url: str) -> Session:
    """Read where and what, with the defaults of the sink ``rtp``."""
    try:
        parts = urllib.parse.urlsplit(url)
        host, port = parts.hostname or LOOPBACK, parts.port
        options = dict(urllib.parse.parse_qsl(parts.query, strict_parsing=bool(parts.query)))
    except ValueError as error:
        raise ConfigError(f"{shown(url)}: {EXPECTED}") from error
    codecs = {each.lower(): each for each in (OPUS, L16)}
    codec = codecs.get(options.pop("codec", OPUS).lower(), "")
    rate = options.pop("rate", str(DEFAULT_RATE))
    number = int(rate) if rate.isascii() and rate.isdigit() and len(rate) < 7 else 0
    if port is None or options or parts.path.strip("/") or not codec or number not in RATES:
        raise ConfigError(
            f"{shown(url)}: expected rtp://ADDRESS:PORT for Opus, or rtp://ADDRESS:PORT?codec=L16&rate=HZ"
        )
    if not port:
        raise ConfigError(f"{shown(url)}: expected a port from 1 to {MAX_PORT}")
    if _of_many(host):
        raise ConfigError(f"{shown(url)}: expected an address of this computer, got one of many; streams go to one")
    return Session(Media.of(codec, number), host, port)


def _of_many(host: str) -> bool:
    """Tell whether it is a multicast address, or broadcast; a name is none."""
    try:
        return (address := ipaddress.ip_address(host)).is_multicast or str(address) == "255.255.255.255"
    except ValueError:
        return False


def _fetched(url: str) -> str:
    try:
        direct = urllib.request.build_opener(urllib.request.ProxyHandler({}))  # a payload is on the same network
        with direct.open(url, timeout=SDP_TIMEOUT_S) as answer:
            return str(answer.read(LONGEST).decode("utf-8", "replace"))
    except urllib.error.HTTPError as error:
        raise ConfigError(f"{url}: no session description there: {error.code} {error.reason}") from error
    except urllib.error.URLError as error:
        why = reason(error.reason) if isinstance(error.reason, OSError) else error.reason
        raise AudioError(f"{url}: no session description: {why}") from error
    except (OSError, ValueError, http.client.HTTPException) as error:
        raise AudioError(f"{shown(url)}: no session description: {reason(error)}") from error
