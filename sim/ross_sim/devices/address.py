"""TCP addresses of options."""

from __future__ import annotations

import re

from ross_payload.errors import ConfigError

_TCP = re.compile(r"tcp:(?P<host>\[[^\[\]]+\]|[^:\[\]]+):(?P<port>\d{1,5})")


def tcp_address(text: str, option: str) -> tuple[str, int]:
    """Return host and port; port 0 means one that is free.

    >>> tcp_address("tcp:[::1]:0", "--listen")
    ('::1', 0)

    Raises
    ------
    ConfigError
        When it is anything else.
    """
    found = _TCP.fullmatch(text)
    if found is None or int(found["port"]) > 65535:
        raise ConfigError(f"{option}: expected tcp:HOST:PORT, an IPv6 host in brackets, got '{text}'")
    return found["host"].strip("[]"), int(found["port"])
