"""The audio source ``command:PROGRAM ARGUMENTS``: what a program writes to its standard output, as raw PCM."""

import os
import shlex
import signal
import subprocess
import threading
from contextlib import suppress

import numpy as np

from ross_payload.errors import AudioError, ConfigError, refused_as

LEAVE_S = 2.0  # that a program may take to end once it was asked to
LARGEST = 65536  # of one read [bytes]


class Program:
    """A program that runs: a feed. It hands frames on until it ends or is closed."""

    def __init__(self, command, channels, on_samples):
        with refused_as(AudioError, f"command '{command[0]}': cannot be started"):
            self._process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, start_new_session=True
            )
        self._channels, self._on_samples, self._closing = channels, on_samples, False
        self._thread = threading.Thread(target=self._copy, name="command", daemon=True)
        self._thread.start()

    @property
    def alive(self):
        return self._thread.is_alive()

    def close(self):
        self._closing = True
        self._signal(signal.SIGTERM)
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(LEAVE_S)
        self._thread.join(LEAVE_S)
        self._signal(signal.SIGKILL)  # what is left, also what writes elsewhere
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(LEAVE_S)
        self._thread.join(LEAVE_S)
        if not self._thread.is_alive():
            self._process.stdout.close()

    def _signal(self, number):
        with suppress(ProcessLookupError, PermissionError):  # all have ended, or are somebody else's
            os.killpg(self._process.pid, number)  # also what it has started, as in sh -c "arecord | sox"

    def _copy(self):
        rest, size = b"", 2 * self._channels
        while (data := self._process.stdout.read1(LARGEST)) and not self._closing:
            data = rest + data
            whole = len(data) // size * size
            rest = data[whole:]
            frames = np.frombuffer(data[:whole], "<i2").reshape(-1, self._channels)
            self._on_samples(frames.astype(np.float32) / 32768)


def audio_source(address, services):
    """Make the source; the program starts when it is entered."""
    try:
        command = shlex.split(address)
    except ValueError as error:
        raise ConfigError(f"command: expected a program and its arguments, got '{address}': {error}") from error
    return services.live(lambda on_samples: Program(command, services.wiring.needed, on_samples))
