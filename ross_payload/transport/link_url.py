"""Where a link goes, read from its URL."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ross_payload.errors import ConfigError

EXPECTED = "expected udpin:, udpout:, tcp: or tcpin:host:port, or serial:device:baud"
LOOPBACK = "127.0.0.1"
MAX_PORT = 65535

_NETWORK = re.compile(r"(?P<host>\[[^\[\]]*\]|[^:\[\]]*):(?P<port>[^:]*)")


@dataclass(frozen=True, slots=True)
class Udp:
    """A UDP port: ``listen`` there and answer those heard from, or send there."""

    host: str
    port: int
    listen: bool


@dataclass(frozen=True, slots=True)
class Tcp:
    """A TCP port: ``listen`` there for clients, or connect to the server there."""

    host: str
    port: int
    listen: bool


@dataclass(frozen=True, slots=True)
class Serial:
    """A serial device."""

    device: str
    baud: int | None  # None: found by listening


Address = Udp | Tcp | Serial


def parse(url: str) -> Address:
    """Read the URL of a link; an IPv6 host stands in brackets, and an empty host to listen on is the loopback.

    >>> parse("udpout:192.168.1.7:14550")
    Udp(host='192.168.1.7', port=14550, listen=False)
    >>> parse("tcp:[::1]:5760")
    Tcp(host='::1', port=5760, listen=False)
    >>> parse("serial:/dev/serial/by-path/pci-0000:00:14.0:57600")
    Serial(device='/dev/serial/by-path/pci-0000:00:14.0', baud=57600)
    >>> parse("serial:/dev/ttyACM0:auto")
    Serial(device='/dev/ttyACM0', baud=None)

    Raises
    ------
    ConfigError
        When it is anything else; says what was expected and what was got.
    """
    kind, _, rest = url.partition(":")
    if kind == "serial":
        return _serial(url, rest)
    if kind not in ("udpin", "udpout", "tcp", "tcpin"):
        raise ConfigError(f"link '{url}': {EXPECTED}")
    found = _NETWORK.fullmatch(rest)
    if found is None:
        raise ConfigError(f"link '{url}': {EXPECTED}, an IPv6 host in brackets")
    host, port = found["host"].strip("[]"), _number(url, "port", found["port"], MAX_PORT)
    listen = kind.endswith("in")
    if not host and not listen:
        raise ConfigError(f"link '{url}': the host is missing; {EXPECTED}")
    return (Tcp if kind.startswith("tcp") else Udp)(host or LOOPBACK, port, listen)


def tcp_endpoint(text: str, option: str, min_port: int = 1) -> tuple[str, int]:
    """Read ``tcp:HOST:PORT`` of an option that is no link; where port 0 is allowed it means one that is free.

    >>> tcp_endpoint("tcp:[::1]:0", "--listen", min_port=0)
    ('::1', 0)

    Raises
    ------
    ConfigError
        When it is anything else; names the option.
    """
    found = _NETWORK.fullmatch(text.removeprefix("tcp:")) if text.startswith("tcp:") else None
    port = _decimal(found["port"]) if found and found["host"] else None
    if found is None or port is None or not min_port <= port <= MAX_PORT:
        raise ConfigError(f"{option}: expected tcp:HOST:PORT, an IPv6 host in brackets, got '{text}'")
    return found["host"].strip("[]"), port


def host_in_url(host: str) -> str:
    """Write a host as URLs do, an IPv6 address in brackets."""
    return f"[{host}]" if ":" in host else host


def host_and_port(host: str, port: int) -> str:
    """Write a host and a port as URLs do.

    >>> host_and_port("::1", 5010)
    '[::1]:5010'
    """
    return f"{host_in_url(host)}:{port}"


def _serial(url: str, rest: str) -> Serial:
    device, _, baud = rest.rpartition(":")  # a device may have colons in its name
    if not device:
        raise ConfigError(f"link '{url}': {EXPECTED}")
    return Serial(device, None if baud == "auto" else _number(url, "baud", baud, 20_000_000))


def _number(url: str, what: str, text: str, most: int) -> int:
    number = _decimal(text)
    if number is None or not 1 <= number <= most:
        raise ConfigError(f"link '{url}': expected a {what} from 1 to {most}, got '{text}'")
    return number


def _decimal(text: str) -> int | None:
    return int(text) if text.isascii() and text.isdigit() and len(text) < 10 else None
