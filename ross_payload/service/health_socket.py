"""How a running payload is, for whoever asks on its computer: a socket in the state folder, answered by the pump.

Each connection is given one line of JSON and closed. A pump that hangs gives none, as it pings no watchdog; nobody who
asks is waited for, and nothing is read.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
import socket
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Self

from ross_payload.bounded_files import parsed_json

NAME = "health"  # of the socket in the state folder
POLL_S = 0.1
CLIENTS = 8  # answered in one poll; the others wait for the next
ANSWER_TIMEOUT_S = 5.0  # for an answer: computing holds up the pump for a small part of it
LONGEST = 65536  # answer [bytes]
ADDRESS_BYTES = 107  # of a socket, unix(7)

log = logging.getLogger(__name__)


class HealthSocket:
    """Answers whoever connects to the socket in a folder; without it, where it cannot be made, all else goes on.

    Parameters
    ----------
    folder
        It must be there; who may enter it may ask.
    values
        What is told, called by `poll`.
    """

    def __init__(self, folder: Path, values: Callable[[], Mapping[str, Any]]) -> None:
        self._folder = folder
        self._values = values
        self._wire: socket.socket | None = None

    def poll(self) -> None:
        """Answer those who have connected; never waits."""
        wire = self._wire  # another thread may close it
        for _ in range(CLIENTS if wire is not None else 0):
            try:
                client, _ = wire.accept()  # type: ignore[union-attr]
            except OSError:  # nobody, or one that has gone again
                return
            with client, contextlib.suppress(OSError):
                client.setblocking(False)
                client.send(json.dumps(self._values()).encode() + b"\n")

    def __enter__(self) -> Self:
        """Make the socket, in place of one that a killed payload has left."""
        wire = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM | socket.SOCK_NONBLOCK)
        try:
            with _address(self._folder) as address:
                (self._folder / NAME).unlink(missing_ok=True)
                wire.bind(address)
            (self._folder / NAME).chmod(0o600)
            wire.listen(CLIENTS)
        except OSError as error:
            wire.close()
            log.warning("%s: %s; `ross health` gets no answer", self._folder / NAME, error.strerror)
        else:
            self._wire = wire
        return self

    def __exit__(self, *_: object) -> None:
        """Remove the socket."""
        if self._wire is not None:
            self._wire.close()
            self._wire = None
            with contextlib.suppress(OSError):
                (self._folder / NAME).unlink(missing_ok=True)


def asked(folder: Path, patience: float = ANSWER_TIMEOUT_S) -> dict[str, Any]:
    """Return what the payload of a state folder tells.

    Raises
    ------
    OSError
        When none answers.
    ValueError
        When the answer is none.
    """
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as wire, _address(folder) as address:
        wire.settimeout(patience)
        wire.connect(address)
        data = b""
        while len(data) < LONGEST and (more := wire.recv(LONGEST)):
            data += more
    values = parsed_json(data)
    if not isinstance(values, dict):
        raise ValueError(f"expected an object, got {type(values).__name__}")
    return values


@contextlib.contextmanager
def _address(folder: Path) -> Iterator[str]:
    """Name the socket in few bytes: folders may be deep."""
    path = folder / NAME
    if len(os.fsencode(path)) <= ADDRESS_BYTES:
        yield str(path)
        return
    handle = os.open(folder, os.O_PATH | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        yield f"/proc/self/fd/{handle}/{NAME}"
    finally:
        os.close(handle)
