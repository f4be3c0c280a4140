"""Ports of this computer for tests."""

import fcntl
import os
import socket
import tempfile
from contextlib import suppress
from pathlib import Path

FIRST, LAST = 20_000, 32_000  # below those that Linux gives to whoever asks for any (ip_local_port_range)
LATEST = Path(tempfile.gettempdir()) / f"ross-tests-port-{os.getuid()}"  # the one given last, by any process


def free_port(in_a_row: int = 1) -> int:
    """Tell a port of the loopback that nobody has now, with UDP or TCP, and that no test is told soon again.

    What the system gives to whoever asks for any port may be anybody's before the test has begun to use it. Of several
    ``in_a_row`` it is the first: a player of RTP takes the next one, too, for RTCP.
    """
    with LATEST.open("a+") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        file.seek(0)
        port = int(file.read() or FIRST)
        for _ in range(FIRST, LAST):
            port = port + 1 if port < LAST else FIRST
            if all(_is_free(port + n) for n in range(in_a_row)):
                file.truncate(0)
                file.write(str(port + in_a_row - 1))
                return port
    raise AssertionError(f"expected a free port from {FIRST} to {LAST}, got none")


def _is_free(port: int) -> bool:
    with suppress(OSError):
        for kind in (socket.SOCK_DGRAM, socket.SOCK_STREAM):
            with socket.socket(socket.AF_INET, kind) as probe:
                probe.bind(("127.0.0.1", port))
        return True
    return False
