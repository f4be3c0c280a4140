"""Where the sound of a live world goes: PCM over TCP to any number of listeners, and a FIFO."""

from __future__ import annotations

import fcntl
import os
import select
import stat
from pathlib import Path

from ross_payload.errors import ConfigError, refused_as
from ross_payload.interfaces import Samples
from ross_payload.transport.byte_stream import Stream, write_waiting
from ross_payload.transport.tcp import prepared
from ross_protocols.audio.pcm import WIDTHS, Header, encode, encode_header
from ross_sim.devices.wire_servers import listen

BACKLOG = 30.0  # [s] of sound that waits for a slow listener
PIPE = 4096  # [bytes] that a FIFO holds: what waits in it is heard late


class PcmServer:
    """PCM over TCP: one JSON line that says what comes, then samples from the moment of connecting on.

    Raises
    ------
    LinkError
        When the address cannot be listened on.
    """

    def __init__(self, host: str, port: int, rate: int, form: str) -> None:
        self._header = encode_header(Header(rate, 2, form))
        self._form = form
        self._frame = 2 * WIDTHS[form]
        self._most = round(BACKLOG * rate) * self._frame
        self._listener = listen(host, port)
        self._listener.setblocking(False)
        self._listeners: list[Stream] = []
        self.port: int = self._listener.getsockname()[1]
        self.used = False  # whether anybody ever listened
        self.lost = 0  # samples that a listener did not fetch in time

    def put(self, samples: Samples) -> None:
        """Send a quantum to everybody who listens."""
        self._welcome()
        data = encode(samples.T, self._form)
        for stream in list(self._listeners):
            gone = False
            try:
                stream.append(data)
            except OSError:
                gone = True
            if gone or len(stream.waiting) > self._most:
                self.lost += 0 if gone else len(stream.waiting) // self._frame
                self._listeners.remove(stream)
                stream.close()

    def close(self) -> None:
        """Hang up."""
        for stream in self._listeners:
            stream.close()
        self._listeners.clear()
        self._listener.close()

    def _welcome(self) -> None:
        while select.select([self._listener], [], [], 0)[0]:
            stream = Stream(prepared(self._listener.accept()[0]), empty_is_end=True)
            stream.waiting += self._header
            self._listeners.append(stream)
            self.used = True


class Fifo:
    """Raw PCM into a named pipe, which is made when it does not exist; as a sound card, it waits for nobody.

    Raises
    ------
    ConfigError
        When the path is something else than a pipe, or cannot be made.
    """

    def __init__(self, path: Path, rate: int, form: str) -> None:
        self._form = form
        self._frame = 2 * WIDTHS[form]
        self._most = round(BACKLOG * rate) * self._frame
        self._waiting = bytearray()
        self.lost = 0
        with refused_as(ConfigError, f"--pipe {path}: cannot be made or opened"):
            if not path.exists():
                os.mkfifo(path)
            if not stat.S_ISFIFO(path.stat().st_mode):
                raise ConfigError(f"--pipe {path}: not a named pipe")
            self._file = os.open(path, os.O_RDWR | os.O_NONBLOCK)  # a pipe without a reader could not be opened
            fcntl.fcntl(self._file, fcntl.F_SETPIPE_SZ, PIPE)

    def put(self, samples: Samples) -> None:
        """Write a quantum as far as the pipe takes it; what waits too long is lost, and counted."""
        self._waiting += encode(samples.T, self._form)
        write_waiting(self._file, self._waiting)  # a pipe that is open for reading here never breaks
        over = max(len(self._waiting) - self._most, 0) // self._frame
        del self._waiting[: over * self._frame]
        self.lost += over

    def close(self) -> None:
        """Close the pipe; it stays where it is."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1


AudioOutput = PcmServer | Fifo  # takes the sound, a quantum at a time, and never waits
