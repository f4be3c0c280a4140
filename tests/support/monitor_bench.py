"""``ross monitor`` on a terminal of its own, and a payload that repeats everything."""

import fcntl
import os
import pty
import re
import select
import socket
import struct
import subprocess
import termios
import threading
import time
from contextlib import contextmanager

from emulated_scene import full
from processes import ROSS
from ross_protocols.mavlink.codec import Encoder, message_of
from ross_protocols.mavlink.tunnel import Wrapper
from ross_protocols.mavlink.values import Heartbeat

MONITOR = (*ROSS, "monitor")
TIMEOUT_S = 30.0  # [s]
ESCAPES = re.compile(rb"\x1b\[[0-9;?]*[A-Za-z]")
HOME = b"\x1b[H"


class Terminal:
    """A pseudo terminal with ``ross monitor`` in it."""

    def __init__(self, file, process):
        self._file, self.process = file, process
        self.data = b""

    def resize(self, columns, rows):
        fcntl.ioctl(self._file, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def type(self, keys):
        os.write(self._file, keys)

    def read(self):
        """Take what it has drawn."""
        while select.select([self._file], [], [], 0.05)[0]:
            try:
                data = os.read(self._file, 65536)
            except OSError:  # it has gone
                return
            self.data += data

    @property
    def screen(self):
        """The latest picture that is whole."""
        self.read()
        pictures = self.data.split(HOME)
        whole = pictures[-2] if len(pictures) > 1 else b""
        return ESCAPES.sub(b"", whole).decode().replace("\r\n", "\n")

    def until(self, seen, seconds=TIMEOUT_S):
        """Wait until the picture is so; return it."""
        end = time.monotonic() + seconds
        while not seen(screen := self.screen):
            assert self.process.poll() is None and time.monotonic() < end, screen or self.data
        return screen

    def shows(self, *words, seconds=TIMEOUT_S):
        return self.until(lambda screen: all(word in screen for word in words), seconds)

    def ended(self):
        """The exit code."""
        end = time.monotonic() + TIMEOUT_S
        while self.process.poll() is None:
            assert time.monotonic() < end, self.data[-2000:]
            self.read()
        self.read()
        return self.process.returncode

    def settings(self):
        return termios.tcgetattr(self._file)


@contextmanager
def terminal(*arguments, size=(80, 24), **more):
    master, slave = pty.openpty()
    environment = {**os.environ, "TERM": "xterm-256color", "PYTHONIOENCODING": "utf-8", **more}
    for name in ("COLUMNS", "LINES", "NO_COLOR", "FORCE_COLOR"):
        environment.pop(name, None) if name not in more else None
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", size[1], size[0], 0, 0))
    command = ["setsid", "--ctty", *MONITOR, *arguments]  # keys that are signals reach it, as in a true terminal
    process = subprocess.Popen(command, stdin=slave, stdout=slave, stderr=slave, env=environment)
    try:
        yield Terminal(master, process)
    finally:
        process.kill()
        process.wait()
        os.close(master)
        os.close(slave)


@contextmanager
def speaking(port, tunnelled=False):
    """A payload that repeats everything, in TUNNEL or not, until the end."""
    encoder, wrapper, over = Encoder(1, 191), Wrapper(1, 191), threading.Event()

    def speak():
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as voice:
            while not over.wait(0.2):
                for value in full(30.0, 3, 1):
                    ours = tunnelled and not isinstance(value, Heartbeat)
                    frame = encoder.encode(wrapper.wrap(value) if ours and _is_ours(value) else value)
                    voice.sendto(frame, ("127.0.0.1", port))

    thread = threading.Thread(target=speak)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def _is_ours(value):
    return message_of(value).get_type().startswith("ROSS_")
