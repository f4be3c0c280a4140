"""Where a link goes, read from its URL as a user has written it."""

from __future__ import annotations

from ross_payload.errors import ConfigError
from ross_protocols import address
from ross_protocols.address import LOOPBACK, Address, Serial, Tcp, Udp

__all__ = ["LOOPBACK", "Address", "Serial", "Tcp", "Udp", "parse"]


def parse(url: str) -> Address:
    """Read the URL of a link.

    Raises
    ------
    ConfigError
        When it is none; says what was expected and what was got.
    """
    try:
        return address.parse(url)
    except address.BadAddress as error:
        raise ConfigError(str(error)) from error
